//! Takes two views and their mixtures, gives what changed (paper section III.C, Algorithm 1).

mod model;

pub use model::{Kind, Novelty, Verdict};
