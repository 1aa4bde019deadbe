//! How sensors err.

use super::cast::Met;
use super::rings;
use crate::evaluate::constants::BOUND;
use crate::evaluate::draw::Draw;
use patrold_sim::world::{NoiseOptions, TrueBeam};
use std::time::Duration;

/// What a beam says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// Something at this range, metres.
    Hit(f64),
    /// Nothing came back.
    Nothing,
    /// Some other code: unknown.
    Unknown,
}

/// The makers' bound of a range's error, metres: 10 mm below 1 m, 1 % above.
fn bound_m(range_m: f64) -> f64 {
    BOUND * range_m.max(1.0)
}

/// A way to err.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// As the recorded URG-04LX does.
    Recorded(NoiseOptions),
    /// Independent, a third of the makers' bound as one sigma.
    Bound,
    /// A bias of each thing's surface, up to the makers' bound and the same in every sweep of this seed, and a sixth of
    /// the bound as repeatability.
    Biased {
        /// Seed of the biases.
        surfaces: u64,
    },
    /// Independent, of this many metres whatever the range.
    Plain {
        /// One sigma, metres.
        sigma_m: f64,
    },
    /// As the held-out sensor does, with all ranges of a sweep scaled.
    Rings {
        /// The scale.
        scale: f64,
    },
    /// As recorded, and this share of the beams with a target gives nothing back.
    Flickering(NoiseOptions, f64),
}

impl Law {
    /// What line number `line` reads of what it meets.
    pub fn read(&self, met: &[Option<Met>], line: usize, seed: u64) -> Vec<Reading> {
        let mut draw = Draw::new(seed, line as u64);
        match self {
            Self::Recorded(options) => recorded(options, met, line),
            Self::Flickering(options, share) => {
                let mut readings = recorded(options, met, line);
                for reading in &mut readings {
                    let lost = draw.chance(*share);
                    if lost && matches!(reading, Reading::Hit(_)) {
                        *reading = Reading::Nothing;
                    }
                }
                readings
            }
            Self::Rings { scale } => rings::read(met, *scale, &mut draw),
            Self::Bound => each(met, |m| bound_m(m.range_m) / 3.0 * draw.normal()),
            Self::Biased { surfaces } => each(met, |m| {
                let bias = Draw::new(*surfaces, m.object as u64).within(-1.0, 1.0);
                bound_m(m.range_m) * (bias + draw.normal() / 6.0)
            }),
            Self::Plain { sigma_m } => each(met, |_| sigma_m * draw.normal()),
        }
    }
}

fn recorded(options: &NoiseOptions, met: &[Option<Met>], line: usize) -> Vec<Reading> {
    const PERIOD_MS: u64 = 100;
    const LEAST_MM: u32 = 20;
    let beams: Vec<Option<TrueBeam>> = met
        .iter()
        .map(|m| {
            m.map(|m| TrueBeam {
                range_m: m.range_m,
                cos_incidence: m.cos_incidence,
                reflectance: m.reflectance,
            })
        })
        .collect();
    let start = Duration::from_millis(PERIOD_MS * line as u64);
    let values = options.measure(&beams, start);
    let reading = |value: u32| match value {
        0 => Reading::Nothing,
        code if code < LEAST_MM => Reading::Unknown,
        range_mm => Reading::Hit(f64::from(range_mm) / 1e3),
    };
    values.into_iter().map(reading).collect()
}

/// Every met range with an error, in whole millimetres.
fn each(met: &[Option<Met>], mut error_m: impl FnMut(&Met) -> f64) -> Vec<Reading> {
    const LEAST_M: f64 = 0.02;
    met.iter()
        .map(|m| match m {
            None => Reading::Nothing,
            Some(m) => {
                let range_m = ((m.range_m + error_m(m)) * 1e3).round() / 1e3;
                if range_m < LEAST_M {
                    Reading::Unknown
                } else {
                    Reading::Hit(range_m)
                }
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Law, Met, Reading};
    use nalgebra::Point3;
    use patrold_sim::world::NoiseOptions;

    const WALL_M: f64 = 3.0;

    fn wall(object: usize) -> Vec<Option<Met>> {
        let met = Met {
            range_m: WALL_M,
            cos_incidence: 1.0,
            reflectance: 0.5,
            object,
            at: Point3::origin(),
        };
        vec![Some(met); 4000]
    }

    /// Mean and standard deviation of the errors, metres, and the share of beams that give nothing back.
    fn figures(readings: &[Reading]) -> (f64, f64, f64) {
        let errors: Vec<f64> = readings
            .iter()
            .filter_map(|r| match r {
                Reading::Hit(range_m) => Some(range_m - WALL_M),
                _ => None,
            })
            .collect();
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n;
        let nothing = readings.iter().filter(|r| **r == Reading::Nothing).count();
        (
            mean,
            variance.sqrt(),
            nothing as f64 / readings.len() as f64,
        )
    }

    #[test]
    fn each_law_errs_by_what_it_says() {
        let of = |law: Law, seed| figures(&law.read(&wall(2), 5, seed));
        let (mean, sigma, nothing) = of(Law::Bound, 1);
        assert!(mean.abs() < 5e-4 && (sigma - 0.010).abs() < 5e-4 && nothing == 0.0);
        let (mean, sigma, _) = of(Law::Plain { sigma_m: 0.003 }, 1);
        assert!(mean.abs() < 3e-4 && (sigma - 0.003).abs() < 2e-4);
        let (mean, sigma, _) = of(Law::Rings { scale: 1.002 }, 1);
        assert!((mean - 0.006).abs() < 2e-3 && (sigma - 0.03).abs() < 2e-3);
        let (_, _, nothing) = of(Law::Flickering(NoiseOptions::seeded(1), 0.1), 1);
        assert!((nothing - 0.1).abs() < 0.02, "{nothing}");
    }

    #[test]
    fn a_bias_is_a_surfaces_own_and_stays_between_sweeps() {
        let law = Law::Biased { surfaces: 9 };
        let mean = |object, seed| figures(&law.read(&wall(object), 5, seed)).0;
        assert!((mean(1, 1) - mean(1, 2)).abs() < 5e-4);
        assert!((0..20).all(|object| mean(object, 1).abs() < 0.031));
        assert!((0..20).any(|object| (mean(object, 1) - mean(1, 1)).abs() > 0.01));
    }
}
