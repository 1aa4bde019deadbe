//! Where a surface ends: lengths by maximum likelihood of its edges.

pub(super) mod edges;
pub(in crate::shape) mod lengths;
