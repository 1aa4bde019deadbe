//! Error models of ranges.

use super::beam_hit::BeamHit;
use crate::evaluate::constants::{
    MIN_RANGE_MM, QUOTED_BOUND, RINGS_EDGE, RINGS_SIGMA, SCAN_PERIOD_MS,
};
use crate::evaluate::seeded_rng::SeededRng;
use patrold_sim::world::{NoiseOptions, TrueBeam};
use std::time::Duration;

/// The reading of a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BeamReading {
    /// A range, metres.
    Hit(f64),
    /// No return.
    Nothing,
    /// Any other code: unknown.
    Unknown,
}

/// The quoted bound of a range error, metres: 10 mm below 1 m, 1 % above.
fn bound_m(range_m: f64) -> f64 {
    QUOTED_BOUND * range_m.max(1.0)
}

/// An error model of ranges.
#[derive(Debug, Clone, PartialEq)]
pub enum RangeErrorModel {
    /// The recorded URG-04LX.
    Recorded(NoiseOptions),
    /// Independent, one sigma a third of the quoted bound.
    Bound,
    /// A bias of each object's surface up to the quoted bound, the same in every sweep of this seed, and independent
    /// noise, one sigma a sixth of the bound.
    Biased {
        /// Seed of the biases.
        surfaces: u64,
    },
    /// Independent of range and of each other.
    Gaussian {
        /// One sigma, metres.
        sigma_m: f64,
    },
    /// The held-out ring scanner, all ranges of a sweep scaled.
    Rings { scale: f64 },
    /// The recorded one, and this share of the beams with a target gives no return.
    Flickering(NoiseOptions, f64),
}

impl RangeErrorModel {
    /// The readings of line number `line`.
    pub fn read(&self, hits: &[Option<BeamHit>], line: usize, seed: u64) -> Vec<BeamReading> {
        let mut rng = SeededRng::new(seed, line as u64);
        match self {
            Self::Recorded(options) => recorded(options, hits, line),
            Self::Flickering(options, share) => {
                let mut readings = recorded(options, hits, line);
                for reading in &mut readings {
                    let lost = rng.chance(*share);
                    if lost && matches!(reading, BeamReading::Hit(_)) {
                        *reading = BeamReading::Nothing;
                    }
                }
                readings
            }
            Self::Rings { scale } => rings(hits, *scale, &mut rng),
            Self::Bound => with_error(hits, |m| bound_m(m.range_m) / 3.0 * rng.normal()),
            Self::Biased { surfaces } => with_error(hits, |m| {
                let bias = SeededRng::new(*surfaces, m.object as u64).uniform(-1.0, 1.0);
                bound_m(m.range_m) * (bias + rng.normal() / 6.0)
            }),
            Self::Gaussian { sigma_m } => with_error(hits, |_| sigma_m * rng.normal()),
        }
    }
}

fn recorded(options: &NoiseOptions, hits: &[Option<BeamHit>], line: usize) -> Vec<BeamReading> {
    let beams: Vec<Option<TrueBeam>> = hits
        .iter()
        .map(|m| {
            m.map(|m| TrueBeam {
                range_m: m.range_m,
                cos_incidence: m.cos_incidence,
                reflectance: m.reflectance,
            })
        })
        .collect();
    let start = Duration::from_millis(SCAN_PERIOD_MS * line as u64);
    let values = options.measure(&beams, start);
    let reading = |value: u32| match value {
        0 => BeamReading::Nothing,
        code if code < MIN_RANGE_MM => BeamReading::Unknown,
        range_mm => BeamReading::Hit(f64::from(range_mm) / 1e3),
    };
    values.into_iter().map(reading).collect()
}

/// Every true range with an error, in whole millimetres.
fn with_error(
    hits: &[Option<BeamHit>],
    mut error_m: impl FnMut(&BeamHit) -> f64,
) -> Vec<BeamReading> {
    let min_range_m = f64::from(MIN_RANGE_MM) / 1e3;
    hits.iter()
        .map(|m| match m {
            None => BeamReading::Nothing,
            Some(m) => {
                let range_m = ((m.range_m + error_m(m)) * 1e3).round() / 1e3;
                if range_m < min_range_m {
                    BeamReading::Unknown
                } else {
                    BeamReading::Hit(range_m)
                }
            }
        })
        .collect()
}

/// The readings of one ring: mixed at edges, all scaled, each with independent noise.
fn rings(hits: &[Option<BeamHit>], scale: f64, rng: &mut SeededRng) -> Vec<BeamReading> {
    let truth: Vec<Option<f64>> = hits.iter().map(|h| h.map(|h| h.range_m)).collect();
    let mut mixed = truth.clone();
    for (i, pair) in truth.windows(2).enumerate() {
        let (mixes, share, side) = (
            rng.chance(RINGS_EDGE.1),
            rng.uniform(0.1, 0.9),
            rng.integer(0, 1),
        );
        if let [Some(a), Some(b)] = pair
            && (a - b).abs() > RINGS_EDGE.0
            && mixes
            && let Some(range) = mixed.get_mut(i + side)
        {
            *range = Some(a + share * (b - a));
        }
    }
    mixed
        .into_iter()
        .map(|range| {
            let error = 1.0 + RINGS_SIGMA * rng.normal();
            range.map_or(BeamReading::Nothing, |r| {
                BeamReading::Hit(r * scale * error)
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{BeamHit, BeamReading, RangeErrorModel};
    use nalgebra::Point3;
    use patrold_sim::world::NoiseOptions;

    const WALL_M: f64 = 3.0;

    fn wall(object: usize) -> Vec<Option<BeamHit>> {
        let hit = BeamHit {
            range_m: WALL_M,
            cos_incidence: 1.0,
            reflectance: 0.5,
            object,
            at: Point3::origin(),
        };
        vec![Some(hit); 4000]
    }

    /// Mean and standard deviation of the errors, metres, and the share of beams without return.
    fn statistics(readings: &[BeamReading]) -> (f64, f64, f64) {
        let errors: Vec<f64> = readings
            .iter()
            .filter_map(|r| match r {
                BeamReading::Hit(range_m) => Some(range_m - WALL_M),
                _ => None,
            })
            .collect();
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n;
        let nothing = readings
            .iter()
            .filter(|r| **r == BeamReading::Nothing)
            .count();
        (
            mean,
            variance.sqrt(),
            nothing as f64 / readings.len() as f64,
        )
    }

    #[test]
    fn each_model_has_its_stated_errors() {
        let of = |model: RangeErrorModel, seed| statistics(&model.read(&wall(2), 5, seed));
        let (mean, sigma, nothing) = of(RangeErrorModel::Bound, 1);
        assert!(mean.abs() < 5e-4 && (sigma - 0.010).abs() < 5e-4 && nothing == 0.0);
        let (mean, sigma, _) = of(RangeErrorModel::Gaussian { sigma_m: 0.003 }, 1);
        assert!(mean.abs() < 3e-4 && (sigma - 0.003).abs() < 2e-4);
        let (mean, sigma, _) = of(RangeErrorModel::Rings { scale: 1.002 }, 1);
        assert!((mean - 0.006).abs() < 2e-3 && (sigma - 0.03).abs() < 2e-3);
        let (_, _, nothing) = of(RangeErrorModel::Flickering(NoiseOptions::seeded(1), 0.1), 1);
        assert!((nothing - 0.1).abs() < 0.02, "{nothing}");
    }

    #[test]
    fn each_surface_has_a_bias_that_stays_between_sweeps() {
        let model = RangeErrorModel::Biased { surfaces: 9 };
        let mean = |object, seed| statistics(&model.read(&wall(object), 5, seed)).0;
        assert!((mean(1, 1) - mean(1, 2)).abs() < 5e-4);
        assert!((0..20).all(|object| mean(object, 1).abs() < 0.031));
        assert!((0..20).any(|object| (mean(object, 1) - mean(1, 1)).abs() > 0.01));
    }
}
