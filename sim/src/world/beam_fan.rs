//! The directions that a laser measures in one revolution of its mirror.

use super::cast::Ray;
use super::constants::{FIRST_STEP, FRONT_STEP, LAST_STEP, STEPS_PER_TURN};
use nalgebra::{Point3, Unit, Vector3};
use patrold_engine::geometry::Pose;

/// The steps of one revolution, as the sensor reports them by `PP`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BeamFan {
    /// Steps of a full revolution (`ARES`).
    pub steps_per_turn: u32,
    /// The step straight ahead (`AFRT`).
    pub front_step: u32,
    /// First step that measures (`AMIN`).
    pub first_step: u32,
    /// Last step that measures (`AMAX`).
    pub last_step: u32,
}

impl Default for BeamFan {
    /// A URG-04LX.
    fn default() -> Self {
        Self {
            steps_per_turn: STEPS_PER_TURN,
            front_step: FRONT_STEP,
            first_step: FIRST_STEP,
            last_step: LAST_STEP,
        }
    }
}

impl BeamFan {
    /// Azimuth of a step in the laser frame, radians, left positive.
    pub fn azimuth_rad(&self, step: u32) -> f64 {
        (f64::from(step) - f64::from(self.front_step)) * std::f64::consts::TAU
            / f64::from(self.steps_per_turn.max(1))
    }

    /// Direction of a step in the laser frame.
    pub(super) fn direction(&self, step: u32) -> Unit<Vector3<f64>> {
        let azimuth = self.azimuth_rad(step);
        Unit::new_unchecked(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0))
    }

    /// The beam of `step` of a laser at this pose in the map.
    pub(super) fn beam(&self, step: u32, map_from_laser: &Pose) -> Ray {
        Ray {
            origin: map_from_laser * Point3::origin(),
            direction: map_from_laser.rotation * self.direction(step),
        }
    }
}
