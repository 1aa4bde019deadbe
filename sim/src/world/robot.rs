//! Kinematics of the simulated robot: where its beams go at each attitude of the pan-tilt. Independent of the code that
//! turns ranges into points, so that a mistake in either shows.

use super::beam_fan::BeamFan;
use super::cast::Ray;
use nalgebra::{Rotation3, Unit, Vector3};
use patrold_engine::geometry::{Pose, RollPitchYaw};

/// Positions of the axes and the laser in the kinematic chain of sweep-geometry section 2, metres and radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountGeometry {
    /// Pan axis from the base.
    pub pan_origin_m: [f64; 3],
    /// Tilt axis from the pan axis, pan at zero.
    pub tilt_origin_m: [f64; 3],
    /// Mount plate from the tilt axis, tilt at zero.
    pub plate_origin_m: [f64; 3],
    /// Optical centre of the laser from the plate.
    pub laser_xyz_m: [f64; 3],
    /// Rotation of the laser on the plate.
    pub laser_rpy: RollPitchYaw,
}

impl Default for MountGeometry {
    /// The PTU-D46 of the ROS `flir_ptu` model, the laser upright and its scan plane 50 mm over the plate (assumed).
    fn default() -> Self {
        Self {
            pan_origin_m: [0.0, -0.00955, 0.046774],
            tilt_origin_m: [0.0, 0.0, 0.043713],
            plate_origin_m: [0.0, 0.0, 0.039116],
            laser_xyz_m: [0.0, 0.0, 0.05],
            laser_rpy: RollPitchYaw {
                roll_rad: 0.0,
                pitch_rad: 0.0,
                yaw_rad: 0.0,
            },
        }
    }
}

impl MountGeometry {
    /// The tilt axis in the base frame, pan left positive, radians.
    pub fn tilt_axis(&self, pan_rad: f64) -> Unit<Vector3<f64>> {
        Unit::new_unchecked(Vector3::new(-pan_rad.sin(), pan_rad.cos(), 0.0))
    }

    /// Pose of the laser in the base frame. Pan left positive, tilt up positive, radians.
    pub fn base_from_laser(&self, pan_rad: f64, tilt_rad: f64) -> Pose {
        let pan = Rotation3::from_axis_angle(&Vector3::z_axis(), pan_rad);
        let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), -tilt_rad);
        let laser = self.laser_rpy.with_translation(self.laser_xyz_m);
        let joint =
            |m: [f64; 3], r: Rotation3<f64>| Pose::from_parts(Vector3::from(m).into(), r.into());
        joint(self.pan_origin_m, pan)
            * joint(self.tilt_origin_m, tilt)
            * Pose::from(nalgebra::Translation3::from(Vector3::from(
                self.plate_origin_m,
            )))
            * laser
    }
}

/// Azimuth of a step of a URG-04LX in the laser frame, radians, left positive.
pub fn azimuth_rad(step: u32) -> f64 {
    BeamFan::default().azimuth_rad(step)
}

/// Position and direction of a robot on the floor, map frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose2d {
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Left positive, radians.
    pub yaw_rad: f64,
}

/// A robot at its pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulatedRobot {
    /// Pose of the pan-tilt's base.
    pub map_from_base: Pose,
    /// Its pan-tilt and laser.
    pub mount: MountGeometry,
}

impl SimulatedRobot {
    /// Puts it at `pose`; the base keeps its height and stays level.
    pub fn drive_to(&mut self, pose: Pose2d) {
        let height = self.map_from_base.translation.z;
        self.map_from_base = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: pose.yaw_rad,
        }
        .with_translation([pose.x_m, pose.y_m, height]);
    }

    /// Pose of the laser in the map, at this attitude of the pan-tilt in radians.
    pub fn map_from_laser(&self, pan_rad: f64, tilt_rad: f64) -> Pose {
        self.map_from_base * self.mount.base_from_laser(pan_rad, tilt_rad)
    }

    /// The beam of `step` of a URG-04LX in the map, at this attitude of the pan-tilt in radians.
    pub fn beam(&self, step: u32, pan_rad: f64, tilt_rad: f64) -> Ray {
        BeamFan::default().beam(step, &self.map_from_laser(pan_rad, tilt_rad))
    }
}

#[cfg(test)]
mod tests {
    use super::{MountGeometry, Pose2d, SimulatedRobot};
    use nalgebra::Point3;
    use patrold_engine::geometry::{Pose, RollPitchYaw};

    fn close(a: Point3<f64>, b: [f64; 3]) {
        assert!((a - Point3::from(b)).norm() < 1e-6, "{a} is not {b:?}");
    }

    #[test]
    fn the_laser_is_at_the_height_of_the_mount() {
        let at = |pan, tilt| MountGeometry::default().base_from_laser(pan, tilt) * Point3::origin();
        close(at(0.0, 0.0), [0.0, -0.00955, 0.129603 + 0.05]);
        // Tilted up by 90 degrees the laser swings back over the tilt axis; panned left, it follows to the right.
        let half_turn = std::f64::consts::FRAC_PI_2;
        close(at(0.0, half_turn), [-0.089116, -0.00955, 0.090487]);
        close(
            at(half_turn, half_turn),
            [0.0, -0.00955 - 0.089116, 0.090487],
        );
    }

    #[test]
    fn pan_tilt_and_steps_have_their_signs() {
        let robot = SimulatedRobot {
            map_from_base: Pose::identity(),
            mount: MountGeometry::default(),
        };
        let d = |step, pan, tilt| robot.beam(step, pan, tilt).direction;
        assert!((d(384, 0.0, 0.0).x - 1.0).abs() < 1e-12);
        assert!(
            d(384 + 256, 0.0, 0.0).y > 1.0 - 1e-12,
            "rising steps turn left"
        );
        assert!(d(384, 0.1, 0.0).y > 0.0, "pan is left positive");
        assert!(
            (d(384, 0.0, 0.3).z - 0.3f64.sin()).abs() < 1e-12,
            "tilt is up positive"
        );
        assert!(
            d(725, 0.0, 0.3).z < 0.0,
            "beams behind the tilt axis go down when it goes up"
        );
        assert!(
            d(640, 0.0, 0.3).z.abs() < 1e-12,
            "a beam along the tilt axis stays"
        );
    }

    #[test]
    fn a_turned_laser_turns_its_fan() {
        let mount = MountGeometry {
            laser_rpy: RollPitchYaw {
                roll_rad: std::f64::consts::FRAC_PI_2,
                pitch_rad: 0.0,
                yaw_rad: 0.0,
            },
            ..MountGeometry::default()
        };
        let robot = SimulatedRobot {
            map_from_base: Pose::identity(),
            mount,
        };
        assert!((robot.beam(640, 0.0, 0.0).direction.z - 1.0).abs() < 1e-12);
    }

    #[test]
    fn driving_keeps_the_height() {
        let mut robot = SimulatedRobot {
            map_from_base: Pose::translation(0.0, 0.0, 0.4),
            mount: MountGeometry::default(),
        };
        robot.drive_to(Pose2d {
            x_m: 1.0,
            y_m: 2.0,
            yaw_rad: std::f64::consts::FRAC_PI_2,
        });
        close(
            robot.map_from_base * Point3::new(1.0, 0.0, 0.0),
            [1.0, 3.0, 0.4],
        );
    }
}
