//! The held-out sensor, unlike the others: a spinning head whose rings lie at even elevations, with a reach of 15 m, 1 %
//! noise, a scale error of each sweep, and mixed ranges at edges.

use super::beam_pattern::{BeamLine, BeamPattern};
use super::field_of_view::FieldOfView;
use super::range_error::RangeErrorModel;
use super::sensor_setup::SensorSetup;
use crate::evaluate::constants::{
    RINGS_FIELD_DEG, RINGS_FREE_M, RINGS_HEAD_M, RINGS_REACH_M, RINGS_SCALE, RINGS_SIGMA,
    RINGS_STEP_DEG,
};
use crate::evaluate::seeded_rng::SeededRng;
use nalgebra::{Unit, Vector3};
use patrold_engine::geometry::{NoiseLaw, Pose};
use std::sync::Arc;

/// The sensor with random parameters.
pub(crate) fn setup(rng: &mut SeededRng) -> SensorSetup {
    let seeds = [rng.seed(), rng.seed()];
    let errors = |rng: &mut SeededRng| RangeErrorModel::Rings {
        scale: 1.0 + rng.uniform(-RINGS_SCALE, RINGS_SCALE),
    };
    SensorSetup {
        patterns: [pattern(1, 1), pattern(1, 1)],
        errors: [errors(rng), errors(rng)],
        seeds,
        field: FieldOfView::Rings([RINGS_FIELD_DEG.0, RINGS_FIELD_DEG.1, RINGS_FIELD_DEG.2]),
        probe: pattern(2, 3),
        reach_m: RINGS_REACH_M,
        stated_noise: NoiseLaw {
            at_zero_m: 0.0,
            per_m: RINGS_SIGMA,
        },
        free_range_m: RINGS_FREE_M,
    }
}

/// Every `ring_stride`-th ring, and in it every `beam_stride`-th beam.
fn pattern(ring_stride: usize, beam_stride: usize) -> BeamPattern {
    let steps = |from: f64, to: f64, stride: usize| {
        let count = ((to - from) / RINGS_STEP_DEG).round() as usize;
        (0..=count)
            .step_by(stride)
            .map(move |i| (from + RINGS_STEP_DEG * i as f64).to_radians())
    };
    let beams: Vec<f64> = steps(-RINGS_FIELD_DEG.2, RINGS_FIELD_DEG.2, beam_stride).collect();
    let ring = |elevation: f64| {
        let (up, level) = elevation.sin_cos();
        let beam = |azimuth: &f64| {
            let (sin, cos) = azimuth.sin_cos();
            Unit::new_normalize(Vector3::new(level * cos, level * sin, up))
        };
        BeamLine {
            base_from_sensor: Pose::translation(0.0, 0.0, RINGS_HEAD_M),
            directions: Arc::new(beams.iter().map(beam).collect()),
        }
    };
    BeamPattern {
        lines: steps(RINGS_FIELD_DEG.0, RINGS_FIELD_DEG.1, ring_stride)
            .map(ring)
            .collect(),
        tilt_axis: None,
    }
}
