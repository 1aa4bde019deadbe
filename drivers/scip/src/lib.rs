//! Hokuyo SCIP 2.0, sans-IO: bytes and instants in, actions out.

pub mod twin;
