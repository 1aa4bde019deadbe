//! The sensors of the pairs.

use super::beam_pattern::ScanRows;
use super::field_of_view::FieldOfView;
use super::range_error::RangeErrorModel;
use super::ring_scanner;
use super::sensor_setup::SensorSetup;
use crate::evaluate::constants::{
    COARSE_LINES, DRIFT_MM, FIRST_TILT_DEG, FLICKER, LAST_TILT_DEG, LINES, MILD_SIGMA_M,
    URG_REACH_M,
};
use crate::evaluate::seeded_rng::SeededRng;
use patrold_engine::sweep::{FREE_RANGE_M, URG_NOISE};
use patrold_sim::world::NoiseOptions;

/// The sensors of the pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SensorKind {
    /// The recorded URG-04LX.
    Urg,
    /// 1.5 times its noise.
    Urg15,
    /// Twice its noise.
    Urg20,
    /// Independent noise, one sigma a third of the quoted bound.
    Bound,
    /// Biases of surfaces up to the quoted bound, the same in both sweeps.
    Biased,
    /// Gaussian noise of 3 mm.
    Mild,
    /// Ranges of the revisit 15 mm longer or shorter.
    Drift,
    /// 2-20 % of the beams give no return, others in each sweep.
    Flicker,
    /// The revisit has 40-60 lines.
    Coarse,
    /// The beams of the revisit lie between those of the reference.
    Offset,
    /// The held-out ring scanner, on which nothing is tuned.
    Rings,
}

/// Beams of a standard sweep for each beam of a probe: every third step of every second line.
pub(crate) const BEAMS_PER_PROBE: usize = 6;

impl SensorKind {
    /// Those on which parameters may be tuned.
    pub const TUNED: [Self; 10] = [
        Self::Urg,
        Self::Urg15,
        Self::Urg20,
        Self::Bound,
        Self::Biased,
        Self::Mild,
        Self::Drift,
        Self::Flicker,
        Self::Coarse,
        Self::Offset,
    ];

    /// The name on the command line and in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Urg => "urg",
            Self::Urg15 => "urg-1.5",
            Self::Urg20 => "urg-2",
            Self::Bound => "bound",
            Self::Biased => "biased",
            Self::Mild => "mild",
            Self::Drift => "drift",
            Self::Flicker => "flicker",
            Self::Coarse => "coarse",
            Self::Offset => "offset",
            Self::Rings => "rings",
        }
    }

    /// All sensors, the held-out one last.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::TUNED.into_iter().chain([Self::Rings])
    }

    /// One such sensor with random parameters.
    pub fn setup(self, rng: &mut SeededRng) -> SensorSetup {
        match self {
            Self::Rings => ring_scanner::setup(rng),
            _ => self.setup_of(&SensorDraws::new(rng)),
        }
    }

    /// The sensor that [`setup`](Self::setup) gives for `rng`, at another revisit: what differs from visit to visit (noise,
    /// drift, rows) is drawn from `visit`.
    pub fn setup_at_visit(self, rng: &mut SeededRng, visit: &mut SeededRng) -> SensorSetup {
        if self == Self::Rings {
            let (own, other) = (ring_scanner::setup(rng), ring_scanner::setup(visit));
            let [reference_errors, _] = own.errors;
            let [_, visit_errors] = other.errors;
            return SensorSetup {
                errors: [reference_errors, visit_errors],
                seeds: [own.seeds[0], other.seeds[1]],
                ..own
            };
        }
        let (own, other) = (SensorDraws::new(rng), SensorDraws::new(visit));
        self.setup_of(&SensorDraws {
            seeds: [own.seeds[0], other.seeds[1]],
            drift_sign: other.drift_sign,
            coarse_lines: other.coarse_lines,
            offsets: other.offsets,
            ..own
        })
    }

    fn setup_of(self, draws: &SensorDraws) -> SensorSetup {
        let SensorDraws {
            from_deg,
            to_deg,
            seeds,
            surfaces,
            drift_sign: sign,
            lost_share: share,
            coarse_lines: coarse,
            offsets,
        } = *draws;
        let rows = ScanRows {
            from_deg,
            to_deg,
            count: LINES,
            stride: 1,
            row_offset: 0.0,
            step_offset: 0.0,
        };
        let revisit_rows = match self {
            Self::Coarse => ScanRows {
                count: coarse,
                ..rows
            },
            Self::Offset => ScanRows {
                row_offset: offsets.0,
                step_offset: offsets.1,
                ..rows
            },
            _ => rows,
        };
        let errors = |side: usize| {
            let seed = seeds[side];
            let recorded = NoiseOptions::seeded(seed);
            let scaled = |noise_scale| {
                RangeErrorModel::Recorded(NoiseOptions {
                    noise_scale,
                    ..recorded
                })
            };
            match self {
                Self::Urg | Self::Coarse | Self::Offset | Self::Rings => scaled(1.0),
                Self::Urg15 => scaled(1.5),
                Self::Urg20 => scaled(2.0),
                Self::Bound => RangeErrorModel::Bound,
                Self::Biased => RangeErrorModel::Biased { surfaces },
                Self::Mild => RangeErrorModel::Gaussian {
                    sigma_m: MILD_SIGMA_M,
                },
                Self::Drift => RangeErrorModel::Recorded(NoiseOptions {
                    bias_mm: DRIFT_MM * sign * side as f64,
                    ..recorded
                }),
                Self::Flicker => RangeErrorModel::Flickering(recorded, share),
            }
        };
        SensorSetup {
            patterns: [rows.pattern(), revisit_rows.pattern()],
            errors: [errors(0), errors(1)],
            seeds,
            field: FieldOfView::Tilted([from_deg, to_deg]),
            probe: ScanRows {
                count: LINES / 2,
                stride: 3,
                ..rows
            }
            .pattern(),
            reach_m: URG_REACH_M,
            stated_noise: URG_NOISE,
            free_range_m: FREE_RANGE_M,
        }
    }
}

/// The random parameters of a sensor.
#[derive(Debug, Clone, Copy)]
struct SensorDraws {
    /// Tilt of the first row, degrees.
    from_deg: f64,
    /// Tilt of the last row, degrees.
    to_deg: f64,
    /// Of the noise: reference, revisit.
    seeds: [u64; 2],
    /// Of the biases of surfaces.
    surfaces: u64,
    drift_sign: f64,
    /// Share of beams that give no return.
    lost_share: f64,
    /// Lines of a coarse revisit.
    coarse_lines: usize,
    /// Shift of the revisit's rows and beams.
    offsets: (f64, f64),
}

impl SensorDraws {
    fn new(rng: &mut SeededRng) -> Self {
        // Fields are drawn in this order: another would give other pairs for the same seed.
        Self {
            from_deg: rng.uniform(FIRST_TILT_DEG.0, FIRST_TILT_DEG.1),
            to_deg: rng.uniform(LAST_TILT_DEG.0, LAST_TILT_DEG.1),
            seeds: [rng.seed(), rng.seed()],
            surfaces: rng.seed(),
            drift_sign: rng.sign(),
            lost_share: rng.uniform(FLICKER.0, FLICKER.1),
            coarse_lines: rng.integer(COARSE_LINES.0, COARSE_LINES.1),
            offsets: (rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::SensorKind;
    use crate::evaluate::seeded_rng::SeededRng;

    #[test]
    fn another_visit_has_the_same_sensor_with_other_noise() {
        for kind in SensorKind::all() {
            let own = || SeededRng::new(4, 0);
            let setup = kind.setup(&mut own());
            let visit = |stream| kind.setup_at_visit(&mut own(), &mut SeededRng::new(4, stream));
            let (first, second) = (visit(1), visit(2));
            for other in [&first, &second] {
                assert_eq!(other.errors[0], setup.errors[0], "{kind:?}");
                assert_eq!(other.seeds[0], setup.seeds[0], "{kind:?}");
                assert_eq!(other.patterns[0].origin(), setup.patterns[0].origin());
                assert_ne!(other.seeds[1], setup.seeds[1], "{kind:?}");
            }
            assert_ne!(first.seeds[1], second.seeds[1], "{kind:?}");
            // Biases belong to the surfaces of the place.
            if kind == SensorKind::Biased {
                assert_eq!(first.errors, setup.errors);
            }
        }
    }
}
