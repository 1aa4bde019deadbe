//! How sensors err.

use super::cast::Met;
use super::rings;
use crate::evaluate::draw::Draw;
use crate::world::{NoiseOptions, TrueBeam};
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
    0.01 * range_m.max(1.0)
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
