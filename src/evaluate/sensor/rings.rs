//! A sensor unlike the others, held out: a head that spins about the upright axis and nods in rings, reaches 15 m, errs
//! by 1 % of the range beam by beam and by a scale of its own each time, and sees between two things at their edges.

use super::cast::Met;
use super::law::{Law, Reading};
use super::pattern::{Line, Pattern};
use super::setting::{Field, Setting};
use crate::evaluate::draw::Draw;
use crate::geometry::{NoiseLaw, Pose};
use nalgebra::{Unit, Vector3};
use std::sync::Arc;

/// Reach, metres.
const REACH_M: f64 = 15.0;
/// Range up to which nothing coming back proves free space, metres.
const FREE_M: f64 = 10.0;
/// One sigma as a share of the range.
const SIGMA: f64 = 0.01;
/// Most that one sweep's ranges are all too long or short, as a share of the range.
const SCALE: f64 = 0.002;
/// Jump between neighbours that is an edge, metres, and the share of edges with a range in between.
const EDGE: (f64, f64) = (0.2, 0.3);
/// Elevation of the lowest and highest ring, and half the width of a ring, degrees.
const FIELD_DEG: (f64, f64, f64) = (-40.0, 30.0, 135.0);
/// Angle between beams and between rings, degrees.
const APART_DEG: f64 = 0.5;
/// Height of the head over the base, metres.
const HEAD_M: f64 = 0.18;

/// One such sensor.
pub fn setting(draw: &mut Draw) -> Setting {
    let seeds = [draw.seed(), draw.seed()];
    let law = |draw: &mut Draw| Law::Rings {
        scale: 1.0 + draw.within(-SCALE, SCALE),
    };
    Setting {
        patterns: [pattern(1, 1), pattern(1, 1)],
        laws: [law(draw), law(draw)],
        seeds,
        field: Field::Rings([FIELD_DEG.0, FIELD_DEG.1, FIELD_DEG.2]),
        probe: pattern(2, 3),
        reach_m: REACH_M,
        stated: NoiseLaw {
            at_zero_m: 0.0,
            per_m: SIGMA,
        },
        free_range_m: FREE_M,
    }
}

/// Every so many rings, and in them every so many beams.
fn pattern(ring_stride: usize, beam_stride: usize) -> Pattern {
    let steps = |from: f64, to: f64, stride: usize| {
        let count = ((to - from) / APART_DEG).round() as usize;
        (0..=count)
            .step_by(stride)
            .map(move |i| (from + APART_DEG * i as f64).to_radians())
    };
    let beams: Vec<f64> = steps(-FIELD_DEG.2, FIELD_DEG.2, beam_stride).collect();
    let ring = |elevation: f64| {
        let (up, level) = elevation.sin_cos();
        let beam = |azimuth: &f64| {
            let (sin, cos) = azimuth.sin_cos();
            Unit::new_normalize(Vector3::new(level * cos, level * sin, up))
        };
        Line {
            base_from_sensor: Pose::translation(0.0, 0.0, HEAD_M),
            directions: Arc::new(beams.iter().map(beam).collect()),
        }
    };
    Pattern {
        lines: steps(FIELD_DEG.0, FIELD_DEG.1, ring_stride)
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
        let (mixes, share, side) = (draw.chance(EDGE.1), draw.within(0.1, 0.9), draw.count(0, 1));
        if let [Some(a), Some(b)] = pair
            && (a - b).abs() > EDGE.0
            && mixes
            && let Some(range) = between.get_mut(i + side)
        {
            *range = Some(a + share * (b - a));
        }
    }
    between
        .into_iter()
        .map(|range| {
            let error = 1.0 + SIGMA * draw.normal();
            range.map_or(Reading::Nothing, |r| Reading::Hit(r * scale * error))
        })
        .collect()
}
