//! The sensors that pairs are taken with, and their sweeps.

use super::cast::{Met, cast};
use super::law::{Law, Reading};
use super::pattern::{Pattern, Rows, looks_at};
use super::rings;
use crate::evaluate::constants::{
    COARSE_LINES, DRIFT_MM, FLICKER, FROM_DEG, LINES, MILD_SIGMA_M, TO_DEG, URG_REACH_M,
};
use crate::evaluate::draw::Draw;
use nalgebra::{Point3, Vector3};
use patrold_engine::geometry::{NoiseLaw, Pose, View};
use patrold_engine::sweep::{FREE_RANGE_M, URG_NOISE};
use patrold_sim::world::{NoiseOptions, World};

/// A sensor by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sensor {
    /// The recorded URG-04LX.
    Urg,
    /// 1.5 times its noise.
    Urg15,
    /// Twice its noise.
    Urg20,
    /// A third of the makers' bound as independent sigma.
    Bound,
    /// Biases up to the makers' bound, shared by both sweeps.
    Biased,
    /// Gaussian noise of 3 mm.
    Mild,
    /// Ranges of the revisit 15 mm longer or shorter.
    Drift,
    /// 2-20 % of the beams lose their target, other ones every time.
    Flicker,
    /// The revisit has 40-60 lines.
    Coarse,
    /// The revisit's beams pass between the reference's.
    Offset,
    /// The sensor that nothing is tuned on.
    Rings,
}

/// Where a sensor looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Field {
    /// A line scanner tilted between these angles, degrees.
    Tilted([f64; 2]),
    /// Rings between these elevations, so far to either side, degrees.
    Rings([f64; 3]),
}

impl Field {
    /// Whether it looks into this direction of the base frame.
    pub fn holds(&self, direction: &Vector3<f64>) -> bool {
        match self {
            Self::Tilted(tilts_deg) => looks_at(direction, *tilts_deg),
            Self::Rings([low, high, side]) => {
                let level = direction.x.hypot(direction.y);
                let elevation = direction.z.atan2(level).to_degrees();
                let azimuth = direction.y.atan2(direction.x).to_degrees();
                elevation > *low && elevation < *high && azimuth.abs() < *side
            }
        }
    }
}

/// Beams of a standard sweep for each beam of a probe: every third step of every second line.
pub const BEAMS_PER_PROBE: usize = 6;

/// A sensor as one pair has it.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Beams of the reference and of the revisit.
    pub patterns: [Pattern; 2],
    /// How each of them errs.
    pub laws: [Law; 2],
    /// Seeds of what is drawn anew each time.
    pub seeds: [u64; 2],
    /// Where both look.
    pub field: Field,
    /// A thin pattern over the same field, for questions about what can be seen.
    pub probe: Pattern,
    /// Reach, metres.
    pub reach_m: f64,
    /// What a sweep states of its own noise.
    pub stated: NoiseLaw,
    /// Range up to which nothing coming back proves free space, metres.
    pub free_range_m: f64,
}

/// A sweep with its truth.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// What it saw, base frame.
    pub view: View,
    /// What each point's beam truly met.
    pub met: Vec<Met>,
}

impl Sensor {
    /// Those that anything may be tuned on.
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

    /// Its word on the command line and in tables.
    pub fn word(self) -> &'static str {
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

    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::TUNED.into_iter().chain([Self::Rings])
    }

    /// One such sensor, with what chance leaves open.
    pub fn setting(self, draw: &mut Draw) -> Setting {
        if self == Self::Rings {
            return rings::setting(draw);
        }
        let from_deg = draw.within(FROM_DEG.0, FROM_DEG.1);
        let to_deg = draw.within(TO_DEG.0, TO_DEG.1);
        let rows = Rows {
            from_deg,
            to_deg,
            count: LINES,
            stride: 1,
            row_offset: 0.0,
            step_offset: 0.0,
        };
        let seeds = [draw.seed(), draw.seed()];
        let surfaces = draw.seed();
        let sign = draw.sign();
        let (share, coarse) = (
            draw.within(FLICKER.0, FLICKER.1),
            draw.count(COARSE_LINES.0, COARSE_LINES.1),
        );
        let offsets = (draw.within(-0.5, 0.5), draw.within(-0.5, 0.5));
        let again = match self {
            Self::Coarse => Rows {
                count: coarse,
                ..rows
            },
            Self::Offset => Rows {
                row_offset: offsets.0,
                step_offset: offsets.1,
                ..rows
            },
            _ => rows,
        };
        let law = |side: usize| {
            let seed = seeds[side];
            let plain = NoiseOptions::seeded(seed);
            let scaled = |noise_scale| {
                Law::Recorded(NoiseOptions {
                    noise_scale,
                    ..plain
                })
            };
            match self {
                Self::Urg | Self::Coarse | Self::Offset | Self::Rings => scaled(1.0),
                Self::Urg15 => scaled(1.5),
                Self::Urg20 => scaled(2.0),
                Self::Bound => Law::Bound,
                Self::Biased => Law::Biased { surfaces },
                Self::Mild => Law::Plain {
                    sigma_m: MILD_SIGMA_M,
                },
                Self::Drift => Law::Recorded(NoiseOptions {
                    bias_mm: DRIFT_MM * sign * side as f64,
                    ..plain
                }),
                Self::Flicker => Law::Flickering(plain, share),
            }
        };
        Setting {
            patterns: [rows.pattern(), again.pattern()],
            laws: [law(0), law(1)],
            seeds,
            field: Field::Tilted([from_deg, to_deg]),
            probe: Rows {
                count: LINES / 2,
                stride: 3,
                ..rows
            }
            .pattern(),
            reach_m: URG_REACH_M,
            stated: URG_NOISE,
            free_range_m: FREE_RANGE_M,
        }
    }
}

impl Setting {
    /// The sweep of `world` from a base at `map_from_base`: of the reference (side 0) or the revisit (side 1).
    pub fn sweep(&self, world: &World, map_from_base: &Pose, side: usize) -> Sweep {
        let pattern = &self.patterns[side];
        let lines = cast(world, map_from_base, pattern, self.reach_m);
        let mut view = View::bare(Vec::new(), pattern.origin());
        view.free_range_m = self.free_range_m;
        view.noise = Some(self.stated);
        view.tilt_axis = pattern.tilt_axis;
        let mut sweep = Sweep {
            view,
            met: Vec::new(),
        };
        for (number, (line, met)) in pattern.lines.iter().zip(&lines).enumerate() {
            let readings = self.laws[side].read(met, number, self.seeds[side]);
            for ((reading, met), direction) in readings.iter().zip(met).zip(line.directions.iter())
            {
                match (reading, met) {
                    (Reading::Hit(range_m), Some(met)) if *range_m <= self.reach_m => {
                        let there = Point3::from(direction.into_inner() * *range_m);
                        sweep.view.points.push(line.base_from_sensor * there);
                        sweep.met.push(*met);
                    }
                    (Reading::Unknown, _) => {}
                    _ => {
                        let away = line.base_from_sensor.rotation * *direction;
                        sweep.view.no_return.push(away);
                    }
                }
            }
        }
        sweep
    }
}
