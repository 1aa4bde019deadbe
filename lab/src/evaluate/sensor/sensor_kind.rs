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
        if self == Self::Rings {
            return ring_scanner::setup(rng);
        }
        let from_deg = rng.uniform(FIRST_TILT_DEG.0, FIRST_TILT_DEG.1);
        let to_deg = rng.uniform(LAST_TILT_DEG.0, LAST_TILT_DEG.1);
        let rows = ScanRows {
            from_deg,
            to_deg,
            count: LINES,
            stride: 1,
            row_offset: 0.0,
            step_offset: 0.0,
        };
        let seeds = [rng.seed(), rng.seed()];
        let surfaces = rng.seed();
        let sign = rng.sign();
        let (share, coarse) = (
            rng.uniform(FLICKER.0, FLICKER.1),
            rng.integer(COARSE_LINES.0, COARSE_LINES.1),
        );
        let offsets = (rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5));
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
