//! Errors of a real URG-04LX: noise, plateaus, dropouts, mixed pixels at edges.

use super::constants::{
    CODE_NOTHING, CODE_TOO_NEAR, DARK_REFLECTANCE, DROPOUT_CHANCE, DROPOUT_CODES, EDGE_JUMP_MM,
    EMPTY_CODES, FADING, FRESH_CORRELATION, FULL_SIGMA_COS, GRAZING_COS, HOLD_CHANCE,
    HOLD_LIMIT_SIGMA, MAX_RANGE_MM, MAX_SIGMA_GROWTH, MIN_RANGE_MM, MIXED_MARGIN, MIXED_SHARE,
    SIGMA_LINE, SIGMA_MM,
};
use patrold_engine::geometry::NoiseLaw;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::time::Duration;

/// The error model of the simulated sensor. The same options, instant and truth give the same values on any machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseOptions {
    /// Another seed is another sensor.
    pub seed: u64,
    /// Multiplies the range noise; 0 also ends its plateaus.
    pub noise_scale: f64,
    /// Multiplies the probabilities of a dropout and of codes other than 0 in empty beams.
    pub code_scale: f64,
    /// Multiplies the share of edges with a mixed pixel.
    pub mixed_scale: f64,
    /// Added to every range, millimetres.
    pub bias_mm: f64,
    /// Warm-up drift, millimetres: approached from 0 with the time constant `drift_time_s`; no source has a figure.
    pub drift_mm: f64,
    /// Time constant of the drift, seconds.
    pub drift_time_s: f64,
    /// Least and greatest range that the sensor reports, millimetres (`DMIN`, `DMAX`).
    pub reach_mm: [f64; 2],
}

impl Default for NoiseOptions {
    fn default() -> Self {
        Self {
            seed: 0,
            noise_scale: 1.0,
            code_scale: 1.0,
            mixed_scale: 1.0,
            bias_mm: 0.0,
            drift_mm: 0.0,
            drift_time_s: 600.0,
            reach_mm: [MIN_RANGE_MM, MAX_RANGE_MM],
        }
    }
}

/// The truth about one beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueBeam {
    /// Metres.
    pub range_m: f64,
    /// 1 square, 0 grazing.
    pub cos_incidence: f64,
    /// 0 (never seen) to 1.
    pub reflectance: f64,
}

/// The random numbers of one beam, drawn in this order whatever it hits: a changed object leaves the noise of the others
/// as it was.
struct BeamDraws {
    fresh: f64,
    hold: f64,
    dropout: f64,
    code: f64,
    mixed: f64,
    between: f64,
}

impl NoiseOptions {
    /// The sensor as recorded, with this seed.
    pub fn seeded(seed: u64) -> Self {
        Self {
            seed,
            ..Self::default()
        }
    }

    /// A sensor whose only error is rounding to millimetres.
    pub fn ideal() -> Self {
        Self {
            noise_scale: 0.0,
            code_scale: 0.0,
            mixed_scale: 0.0,
            ..Self::default()
        }
    }

    /// The range noise as a linear law.
    pub fn law(&self) -> NoiseLaw {
        let (at_zero_m, per_m) = SIGMA_LINE;
        NoiseLaw {
            at_zero_m: at_zero_m * self.noise_scale,
            per_m: per_m * self.noise_scale,
        }
    }

    /// One revolution that began at `start`: millimetres or a code below 20 for every true beam (`None`: nothing within
    /// reach), the beams in the order of rising, neighbouring steps.
    pub fn measure(&self, truth: &[Option<TrueBeam>], start: Duration) -> Vec<u32> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        // 584 years of nanoseconds fit; later instants share their noise.
        rng.set_stream(u64::try_from(start.as_nanos()).unwrap_or(u64::MAX));
        let mut noise: f64 = rng.sample(StandardNormal);
        let draws: Vec<BeamDraws> = truth
            .iter()
            .map(|_| {
                let own: f64 = rng.sample(StandardNormal);
                noise = FRESH_CORRELATION * noise + (1.0 - FRESH_CORRELATION.powi(2)).sqrt() * own;
                BeamDraws {
                    fresh: noise,
                    hold: rng.random(),
                    dropout: rng.random(),
                    code: rng.random(),
                    mixed: rng.random(),
                    between: rng.random(),
                }
            })
            .collect();
        let ranges_mm = self.with_mixed_pixels(truth, &draws);
        let offset_mm = self.offset_mm(start);
        let mut held: Option<f64> = None;
        let values = truth.iter().zip(&ranges_mm).zip(&draws);
        values
            .map(|((beam, range_mm), draws)| {
                let (Some(beam), Some(range_mm)) = (beam, range_mm) else {
                    held = None;
                    return draw_code(&EMPTY_CODES, draws.code, self.code_scale);
                };
                if draws.dropout < self.dropout_probability(beam) {
                    return draw_code(&DROPOUT_CODES, draws.code, 1.0);
                }
                let sigma = self.noise_scale * sigma_mm(*range_mm, beam.cos_incidence);
                let own = range_mm + offset_mm + sigma * draws.fresh;
                let value = match held {
                    Some(held)
                        if draws.hold < HOLD_CHANCE
                            && (own - held).abs() <= HOLD_LIMIT_SIGMA * sigma =>
                    {
                        held
                    }
                    _ => own.round(),
                };
                held = Some(value);
                if value > self.reach_mm[1] {
                    CODE_NOTHING
                } else if value < self.reach_mm[0] {
                    CODE_TOO_NEAR
                } else {
                    value as u32
                }
            })
            .collect()
    }

    /// True ranges in millimetres, with a mixed pixel at a share of the edges.
    fn with_mixed_pixels(
        &self,
        truth: &[Option<TrueBeam>],
        draws: &[BeamDraws],
    ) -> Vec<Option<f64>> {
        let mut ranges: Vec<Option<f64>> = truth
            .iter()
            .map(|beam| {
                beam.filter(|b| b.reflectance > 0.0)
                    .map(|b| b.range_m * 1000.0)
            })
            .collect();
        let unmixed = ranges.clone();
        let edges = unmixed.windows(2).zip(draws).enumerate();
        for (i, (pair, draws)) in edges {
            let &[Some(a), Some(b)] = pair else { continue };
            if (a - b).abs() <= EDGE_JUMP_MM || draws.mixed >= MIXED_SHARE * self.mixed_scale {
                continue;
            }
            // The beam on either side of the edge may be the mixed one.
            let side = usize::from(draws.mixed * 2.0 >= MIXED_SHARE * self.mixed_scale);
            let share = MIXED_MARGIN + (1.0 - 2.0 * MIXED_MARGIN) * draws.between;
            if let Some(range) = ranges.get_mut(i + side) {
                *range = Some(a + share * (b - a));
            }
        }
        ranges
    }

    fn offset_mm(&self, start: Duration) -> f64 {
        if self.drift_mm == 0.0 {
            return self.bias_mm;
        }
        let grown = 1.0 - (-start.as_secs_f64() / self.drift_time_s.max(1e-9)).exp();
        self.bias_mm + self.drift_mm * grown
    }

    /// Probability that the beam gives a code although it hits an object.
    fn dropout_probability(&self, beam: &TrueBeam) -> f64 {
        let grazing = (1.0 - beam.cos_incidence / GRAZING_COS).clamp(0.0, 1.0);
        let dark = (1.0 - beam.reflectance / DARK_REFLECTANCE).clamp(0.0, 1.0);
        let (from_mm, max) = FADING;
        let faded = (beam.range_m * 1000.0 - from_mm) / (self.reach_mm[1] - from_mm);
        let kept = (1.0 - DROPOUT_CHANCE)
            * (1.0 - grazing)
            * (1.0 - dark)
            * (1.0 - max * faded.clamp(0.0, 1.0));
        self.code_scale * (1.0 - kept)
    }
}

/// Standard deviation of a range, millimetres.
fn sigma_mm(range_mm: f64, cos_incidence: f64) -> f64 {
    let mut below = SIGMA_MM[0];
    let mut sigma = None;
    for above in SIGMA_MM {
        if range_mm <= above.0 {
            let share = if above.0 > below.0 {
                (range_mm - below.0) / (above.0 - below.0)
            } else {
                1.0
            };
            sigma = Some(below.1 + share.clamp(0.0, 1.0) * (above.1 - below.1));
            break;
        }
        below = above;
    }
    let growth = (FULL_SIGMA_COS / cos_incidence.max(1e-9)).clamp(1.0, MAX_SIGMA_GROWTH);
    sigma.unwrap_or(below.1) * growth
}

/// The code that `draw` (0..1) picks; the codes after the first get `scale` times their share, the first the rest.
fn draw_code(shares: &[(u32, f64)], draw: f64, scale: f64) -> u32 {
    let mut rest = draw;
    for (code, share) in shares.iter().skip(1) {
        rest -= share * scale;
        if rest < 0.0 {
            return *code;
        }
    }
    shares.first().map_or(CODE_NOTHING, |(code, _)| *code)
}

#[cfg(test)]
mod tests;
