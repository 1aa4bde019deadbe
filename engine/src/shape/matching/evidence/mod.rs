//! Evidence of the points for or against a fitted class beyond its cost.

pub(super) mod faces;
pub(super) mod hidden_box;
pub(super) mod residuals;
