//! Parking: both devices stopped at the end of the work.

use super::Station;
use super::start_pose::StartPose;
use crate::devices::cancel::Cancel;
use crate::devices::error::DeviceError;
use crate::devices::head::HeadCommand;
use crate::devices::laser::LaserCommand;
use ptu::{Axis, AxisIdentity};

impl Station {
    /// Laser off, head to 0, 0 if its position is trusted (else halted), hold power low.
    ///
    /// # Errors
    /// The head is not connected, or stalls.
    pub fn park(&mut self) -> Result<(), DeviceError> {
        self.process_pending();
        self.links.send_laser(LaserCommand::Stop);
        if !self.state.is_position_trusted() {
            self.links.send_head(HeadCommand::Halt);
            self.links.send_head(HeadCommand::LowerHoldPower);
            return Ok(());
        }
        let (pan, tilt) = {
            let identity = self.state.head()?;
            (identity.pan, identity.tilt)
        };
        self.links.send_head(HeadCommand::LowerHoldPower);
        let speed = |axis: &AxisIdentity| {
            let speed_max = axis.speed_max.max(axis.speed_min);
            axis.base_speed.clamp(axis.speed_min, speed_max)
        };
        let zero = StartPose {
            steps: [0, 0],
            steps_per_s: [speed(&pan), speed(&tilt)],
        };
        self.move_to_pose(&zero, &Cancel::new())?;
        self.set_power_marker();
        Ok(())
    }

    /// Sets speeds that show after a loss of the port whether the head kept its power. Every move sets its own speeds.
    pub(super) fn set_power_marker(&mut self) {
        if let Some([pan, tilt]) = self.state.marker_speeds() {
            self.links.send_head(HeadCommand::SetSpeed(Axis::Pan, pan));
            self.links
                .send_head(HeadCommand::SetSpeed(Axis::Tilt, tilt));
        }
    }
}
