//! What one view contributes to d_GMM.

use super::{PreparedView, Visibility};
use crate::geometry::DriftTransform;

/// A view with its visibility from the other view, and its segments.
pub(super) struct ComparedView<'a> {
    pub prepared: &'a PreparedView,
    pub reference_from_own: DriftTransform,
    /// Of each point, as the other view saw it.
    pub visibility: &'a [Visibility],
    /// Point indices of each segment that is a novelty.
    pub segments: &'a [Vec<usize>],
}
