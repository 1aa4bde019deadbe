//! How well a pose is known.

use super::normal_equations::{MatchedPoint, Matrix8, NormalEquations, Vector8};
use super::settings::RegistrationSettings;
use crate::geometry::constants::{CORRELATED_POINTS, MIN_NOISE_M2};
use nalgebra::{Matrix6, Vector3};

/// The matches of one block, whose cells err together.
pub(super) struct MatchBlock {
    equations: NormalEquations,
    /// Weighted sum of the derivatives.
    derivatives: Vector8,
    /// Weighted sum of the heights, metres.
    heights: f64,
}

impl MatchBlock {
    pub(super) fn new() -> Self {
        Self {
            equations: NormalEquations::new(),
            derivatives: Vector8::zeros(),
            heights: 0.0,
        }
    }

    pub(super) fn add(&mut self, point: &MatchedPoint, gate_m: f64) {
        let weight = point.weight(gate_m);
        self.equations.add(point, gate_m);
        self.derivatives += point.derivative() * weight;
        self.heights += weight * point.height_m;
    }
}

/// Covariance of the pose (translation, rotation vector) from the `blocks` of a view. Along directions
/// that the surfaces do not fix no step was made: there the prior alone counts. `shift` is the way between the sensors, metres: an
/// error of scale that both visits share changes it.
pub(super) fn covariance(
    blocks: &[MatchBlock],
    shift: &Vector3<f64>,
    settings: &RegistrationSettings,
) -> Matrix6<f64> {
    let all = blocks
        .iter()
        .map(|block| &block.equations)
        .fold(NormalEquations::new(), NormalEquations::merged);
    let sd = [
        settings.prior_sd_m,
        settings.prior_sd_m,
        settings.prior_sd_m,
        settings.prior_sd_rad,
        settings.prior_sd_rad,
        settings.prior_sd_rad,
        settings.drift_sd_m,
        settings.drift_sd_per_m,
    ];
    let variances = Vector8::from(sd.map(|s| s * s));
    let prior = Matrix8::from_diagonal(&variances.map(|v| 1.0 / v));
    let [own_m2, common_m2] = error_variances(blocks);
    // What the step weighs the heights by, against the prior of the drift.
    let scale = all.effective_points() / all.weight.max(1e-9) / all.noise_m2();
    let (basis, free, _) = all.basis(settings);
    let spread = basis.try_inverse().and_then(|back| {
        let mut fixed = Matrix8::identity();
        for i in (0..6).filter(|i| !free[*i]) {
            fixed[(i, i)] = 0.0;
        }
        // Takes out the part along directions that are not fixed, in the pose's own coordinates.
        let keep = back.transpose() * fixed * basis.transpose();
        let mut errors = all.full() * (own_m2 * CORRELATED_POINTS);
        for block in blocks {
            errors += block.derivatives * block.derivatives.transpose() * common_m2;
        }
        let information = keep * (all.full() * scale) * keep.transpose();
        let errors = keep * (errors * (scale * scale)) * keep.transpose();
        let known = (information + prior).try_inverse()?;
        Some(known * (errors + prior) * known)
    });
    let mut pose: Matrix6<f64> = spread
        .unwrap_or_else(|| Matrix8::from_diagonal(&variances))
        .fixed_view::<6, 6>(0, 0)
        .into_owned();
    let scale_m2 = shift.norm_squared() * settings.scale_sd * settings.scale_sd;
    for i in 0..3 {
        pose[(i, i)] += scale_m2;
    }
    pose
}

/// Variances of the heights, square metres: of a cell by itself, and of what all cells of a block share (one-way analysis of
/// variance with blocks as groups).
fn error_variances(blocks: &[MatchBlock]) -> [f64; 2] {
    let matched = || blocks.iter().filter(|b| b.equations.weight > 0.0);
    let (count, cells) = matched().fold((0.0, 0.0), |(n, w), b| (n + 1.0, w + b.equations.weight));
    let between: f64 = matched()
        .map(|b| b.heights.powi(2) / b.equations.weight)
        .sum();
    let total: f64 = matched().map(|b| b.equations.residual2).sum();
    let own_m2 = ((total - between) / (cells - count).max(1.0)).max(MIN_NOISE_M2);
    // The eight unknowns take as many differences between blocks out of the heights.
    let lost = count / (count - 8.0).max(1.0);
    let common_m2 = (between * lost - count * own_m2) / cells.max(1.0);
    [own_m2, common_m2.max(0.0)]
}
