//! From the configured offsets to the kinematic chain (sweep-geometry section 2).

use super::settings::MountConfig;
use patrold_engine::geometry::{Mount, RollPitchYaw};

impl MountConfig {
    /// The chain from base to laser.
    pub fn chain(&self) -> Mount {
        let [roll_rad, pitch_rad, yaw_rad] = self.laser_rpy_rad;
        Mount::new(
            self.pan_axis_m,
            self.tilt_axis_m,
            self.plate_m,
            self.laser_m,
            RollPitchYaw {
                roll_rad,
                pitch_rad,
                yaw_rad,
            },
        )
    }
}
