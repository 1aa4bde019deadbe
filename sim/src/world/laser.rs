//! The simulated laser: one revolution in the units of the sensor.

use super::beam_fan::BeamFan;
use super::cast::{Ray, World};
use super::constants::CODE_NO_STEP;
use super::noise::{NoiseOptions, TrueBeam};
use super::robot::SimulatedRobot;
use std::sync::Arc;
use std::time::Duration;

/// A laser on a robot in a world. Change its fields between revolutions to move the robot, its surroundings, or the
/// errors of the sensor.
#[derive(Debug, Clone)]
pub struct SimulatedLaser {
    /// Its surroundings.
    pub world: Arc<World>,
    /// The robot that carries it.
    pub robot: SimulatedRobot,
    /// Its beams.
    pub fan: BeamFan,
    /// Its errors.
    pub noise: NoiseOptions,
}

impl SimulatedLaser {
    /// One revolution from step 0 at `start`, a full turn lasting `period`: `out[n]` is the value of step n, millimetres or
    /// a code below 20. Every beam is cast at its own instant `start + n period / ARES`, at the pan and tilt (radians)
    /// that `attitude_at` returns for it. Steps that the sensor does not measure have code 19.
    pub fn revolve(
        &mut self,
        start: Duration,
        period: Duration,
        attitude_at: &dyn Fn(Duration) -> (f64, f64),
        out: &mut [u32],
    ) {
        let fan = self.fan;
        let truth: Vec<Option<TrueBeam>> = (fan.first_step..=fan.last_step)
            .map(|step| {
                let at = start + period * step / fan.steps_per_turn.max(1);
                let (pan_rad, tilt_rad) = attitude_at(at);
                let map_from_laser = self.robot.map_from_laser(pan_rad, tilt_rad);
                let ray = fan.beam(step, &map_from_laser);
                true_beam(&self.world, &ray, self.noise.reach_mm[1]).map(|(beam, _)| beam)
            })
            .collect();
        out.fill(CODE_NO_STEP);
        let values = self.noise.measure(&truth, start);
        for (out, value) in out.iter_mut().skip(fan.first_step as usize).zip(values) {
            *out = value;
        }
    }
}

/// What a beam hits within the reach of the sensor, and the index of the object.
pub(super) fn true_beam(world: &World, ray: &Ray, reach_mm: f64) -> Option<(TrueBeam, usize)> {
    let hit = world.cast(ray, reach_mm / 1000.0)?;
    let beam = TrueBeam {
        range_m: hit.range_m,
        cos_incidence: hit.cos_incidence,
        reflectance: world.reflectance_of(hit.object),
    };
    Some((beam, hit.object))
}

#[cfg(test)]
mod tests {
    use super::SimulatedLaser;
    use crate::world::{BeamFan, MountGeometry, NoiseOptions, Scene, SimulatedRobot};
    use std::sync::Arc;
    use std::time::Duration;

    const PERIOD: Duration = Duration::from_millis(100);

    fn room(noise: NoiseOptions) -> SimulatedLaser {
        let text = "[robot]\nheight_m = 0.5\n[[room]]\ncentre = [0, 0, 1.5]\nsize = [4, 6, 3]\n";
        let scene = Scene::parse(text).expect("a good scene");
        SimulatedLaser {
            world: Arc::new(scene.build(None).expect("no cloud")),
            robot: SimulatedRobot {
                map_from_base: scene.map_from_base,
                mount: MountGeometry::default(),
            },
            fan: BeamFan::default(),
            noise,
        }
    }

    #[test]
    fn a_head_at_rest_measures_the_walls_at_their_ranges() {
        let mut out = [7; 769];
        room(NoiseOptions::ideal()).revolve(Duration::ZERO, PERIOD, &|_| (0.0, 0.0), &mut out);
        assert_eq!((out[0], out[43], out[726], out[768]), (19, 19, 19, 19));
        assert_eq!(out[384], 2000);
        // Left and right walls at y = +-3, the pan axis 9.55 mm to the right.
        assert_eq!(out[384 + 256], 3010);
        assert_eq!(out[384 - 256], 2990);
        // 45 degrees ahead hits the front wall.
        assert_eq!(out[384 + 128], (2000.0 * 2f64.sqrt()).round() as u32);
    }

    #[test]
    fn every_beam_has_its_own_instant() {
        // The head pans against the mirror at its speed: every beam looks where step 0 does at the start.
        let turn = |t: Duration| {
            (
                -std::f64::consts::TAU * t.as_secs_f64() / PERIOD.as_secs_f64(),
                0.0,
            )
        };
        let mut out = [0; 769];
        let mut laser = room(NoiseOptions::ideal());
        laser.revolve(Duration::ZERO, PERIOD, &turn, &mut out);
        // -135 degrees: the back wall, 2 m away.
        let first = out[44];
        assert!(
            (f64::from(first) - 2000.0 * 2f64.sqrt()).abs() < 2.0,
            "{first}"
        );
        assert!(out[44..=725].iter().all(|r| r.abs_diff(first) <= 1));
    }

    #[test]
    fn the_same_instant_gives_the_same_values() {
        let at = |ms, seed| {
            let mut out = [0; 769];
            room(NoiseOptions::seeded(seed)).revolve(
                Duration::from_millis(ms),
                PERIOD,
                &|_| (0.0, 0.1),
                &mut out,
            );
            out
        };
        assert_eq!(at(300, 1), at(300, 1));
        assert_ne!(at(300, 1), at(400, 1));
        assert_ne!(at(300, 1), at(300, 2));
    }

    #[test]
    fn another_sensor_has_its_own_steps_and_reach() {
        let text = "[robot]\nheight_m = 0.5\n[[room]]\ncentre = [0, 0, 1.5]\nsize = [40, 6, 3]\n";
        let scene = Scene::parse(text).expect("a good scene");
        let mut utm = SimulatedLaser {
            world: Arc::new(scene.build(None).expect("no cloud")),
            robot: SimulatedRobot {
                map_from_base: scene.map_from_base,
                mount: MountGeometry::default(),
            },
            fan: BeamFan {
                steps_per_turn: 1440,
                front_step: 540,
                first_step: 0,
                last_step: 1080,
            },
            noise: NoiseOptions {
                reach_mm: [23.0, 60_000.0],
                ..NoiseOptions::ideal()
            },
        };
        let mut out = [7; 1081];
        utm.revolve(
            Duration::ZERO,
            Duration::from_millis(25),
            &|_| (0.0, 0.0),
            &mut out,
        );
        assert_eq!(out[540], 20_000);
        assert_eq!((out[540 + 360], out[540 - 360]), (3010, 2990));
        assert!(out.iter().all(|range| *range >= 23));
    }
}
