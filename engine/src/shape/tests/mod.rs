//! Tests of the whole retrieval on simulated and recorded objects.

mod laws;
mod printed;
mod recorded;
pub(super) mod scenes;
mod trials;
