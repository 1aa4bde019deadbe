//! A sensor with all its parameters, and its sweeps.

use super::beam_hit::{BeamHit, cast_pattern};
use super::beam_pattern::BeamPattern;
use super::field_of_view::FieldOfView;
use super::range_error::{BeamReading, RangeErrorModel};
use nalgebra::Point3;
use patrold_engine::geometry::{NoiseLaw, Pose, View};
use patrold_sim::world::World;

/// The sensor of one pair. Of two values the first is for the reference, the second for the revisit.
#[derive(Debug, Clone)]
pub struct SensorSetup {
    /// Beams.
    pub patterns: [BeamPattern; 2],
    /// Errors.
    pub errors: [RangeErrorModel; 2],
    /// Seeds of the errors.
    pub seeds: [u64; 2],
    /// Field of view of both.
    pub field: FieldOfView,
    /// A thin pattern over the same field, to estimate what is visible.
    pub probe: BeamPattern,
    /// Metres.
    pub reach_m: f64,
    /// The noise that a sweep states of itself.
    pub stated_noise: NoiseLaw,
    /// Range up to which no return proves free space, metres.
    pub free_range_m: f64,
}

/// A sweep with its ground truth.
#[derive(Debug, Clone)]
pub struct SensorSweep {
    /// Base frame.
    pub view: View,
    /// What the beam of each point truly hit.
    pub hits: Vec<BeamHit>,
}

impl SensorSetup {
    /// The sweep of `world` from a base at `map_from_base`: of the reference (side 0) or the revisit (side 1).
    pub fn sweep(&self, world: &World, map_from_base: &Pose, side: usize) -> SensorSweep {
        let pattern = &self.patterns[side];
        let lines = cast_pattern(world, map_from_base, pattern, self.reach_m);
        let mut view = View::from_points(Vec::new(), pattern.origin());
        view.free_range_m = self.free_range_m;
        view.noise = Some(self.stated_noise);
        view.tilt_axis = pattern.tilt_axis;
        let mut sweep = SensorSweep {
            view,
            hits: Vec::new(),
        };
        for (number, (line, hits)) in pattern.lines.iter().zip(&lines).enumerate() {
            let readings = self.errors[side].read(hits, number, self.seeds[side]);
            let beams = readings.iter().zip(hits).zip(line.directions.iter());
            for ((reading, hit), direction) in beams {
                match (reading, hit) {
                    (BeamReading::Hit(range_m), Some(hit)) if *range_m <= self.reach_m => {
                        let in_sensor = Point3::from(direction.into_inner() * *range_m);
                        sweep.view.points.push(line.base_from_sensor * in_sensor);
                        sweep.hits.push(*hit);
                    }
                    (BeamReading::Unknown, _) => {}
                    _ => {
                        let empty = line.base_from_sensor.rotation * *direction;
                        sweep.view.no_return.push(empty);
                    }
                }
            }
        }
        sweep
    }
}
