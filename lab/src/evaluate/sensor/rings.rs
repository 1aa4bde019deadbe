//! A sensor unlike the others, held out: a head that spins about the upright axis and nods in rings, reaches 15 m, errs
//! by 1 % of the range beam by beam and by a scale of its own each time, and sees between two things at their edges.

use super::cast::Met;
use super::law::{Law, Reading};
use super::pattern::{Line, Pattern};
use super::setting::{Field, Setting};
use crate::evaluate::constants::{
    RINGS_APART_DEG, RINGS_EDGE, RINGS_FIELD_DEG, RINGS_FREE_M, RINGS_HEAD_M, RINGS_REACH_M,
    RINGS_SCALE, RINGS_SIGMA,
};
use crate::evaluate::draw::Draw;
use nalgebra::{Unit, Vector3};
use patrold_engine::geometry::{NoiseLaw, Pose};
use std::sync::Arc;

/// One such sensor.
pub fn setting(draw: &mut Draw) -> Setting {
    let seeds = [draw.seed(), draw.seed()];
    let law = |draw: &mut Draw| Law::Rings {
        scale: 1.0 + draw.within(-RINGS_SCALE, RINGS_SCALE),
    };
    Setting {
        patterns: [pattern(1, 1), pattern(1, 1)],
        laws: [law(draw), law(draw)],
        seeds,
        field: Field::Rings([RINGS_FIELD_DEG.0, RINGS_FIELD_DEG.1, RINGS_FIELD_DEG.2]),
        probe: pattern(2, 3),
        reach_m: RINGS_REACH_M,
        stated: NoiseLaw {
            at_zero_m: 0.0,
            per_m: RINGS_SIGMA,
        },
        free_range_m: RINGS_FREE_M,
    }
}

/// Every so many rings, and in them every so many beams.
fn pattern(ring_stride: usize, beam_stride: usize) -> Pattern {
    let steps = |from: f64, to: f64, stride: usize| {
        let count = ((to - from) / RINGS_APART_DEG).round() as usize;
        (0..=count)
            .step_by(stride)
            .map(move |i| (from + RINGS_APART_DEG * i as f64).to_radians())
    };
    let beams: Vec<f64> = steps(-RINGS_FIELD_DEG.2, RINGS_FIELD_DEG.2, beam_stride).collect();
    let ring = |elevation: f64| {
        let (up, level) = elevation.sin_cos();
        let beam = |azimuth: &f64| {
            let (sin, cos) = azimuth.sin_cos();
            Unit::new_normalize(Vector3::new(level * cos, level * sin, up))
        };
        Line {
            base_from_sensor: Pose::translation(0.0, 0.0, RINGS_HEAD_M),
            directions: Arc::new(beams.iter().map(beam).collect()),
        }
    };
    Pattern {
        lines: steps(RINGS_FIELD_DEG.0, RINGS_FIELD_DEG.1, ring_stride)
            .map(ring)
            .collect(),
        tilt_axis: None,
    }
}

/// What one ring reads.
pub fn read(met: &[Option<Met>], scale: f64, draw: &mut Draw) -> Vec<Reading> {
    let truth: Vec<Option<f64>> = met.iter().map(|m| m.map(|m| m.range_m)).collect();
    let mut between = truth.clone();
    for (i, pair) in truth.windows(2).enumerate() {
        let (mixes, share, side) = (
            draw.chance(RINGS_EDGE.1),
            draw.within(0.1, 0.9),
            draw.count(0, 1),
        );
        if let [Some(a), Some(b)] = pair
            && (a - b).abs() > RINGS_EDGE.0
            && mixes
            && let Some(range) = between.get_mut(i + side)
        {
            *range = Some(a + share * (b - a));
        }
    }
    between
        .into_iter()
        .map(|range| {
            let error = 1.0 + RINGS_SIGMA * draw.normal();
            range.map_or(Reading::Nothing, |r| Reading::Hit(r * scale * error))
        })
        .collect()
}
