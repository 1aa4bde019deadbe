//! Directed Perception PTU-D46, sans-IO: bytes and instants in, actions out.

pub mod twin;
