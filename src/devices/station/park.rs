//! Laying both devices to rest at the end of the work.

use super::Station;
use super::travel::Stance;
use crate::devices::cancel::Cancel;
use crate::devices::error::DeviceError;
use crate::devices::head::HeadCommand;
use crate::devices::laser::LaserCommand;
use ptu::{Axis, AxisIdentity};

impl Station {
    /// Lays everything to rest: laser off, head to 0, 0 if its position is trusted (else halted), hold power low.
    ///
    /// # Errors
    /// The head is not connected, or stalls.
    pub fn park(&mut self) -> Result<(), DeviceError> {
        self.catch_up();
        self.wires.laser(LaserCommand::Stop);
        if !self.known.trusted() {
            self.wires.head(HeadCommand::Halt);
            self.wires.head(HeadCommand::HoldLow);
            return Ok(());
        }
        let (pan, tilt) = {
            let identity = self.known.head()?;
            (identity.pan, identity.tilt)
        };
        self.wires.head(HeadCommand::HoldLow);
        let speed = |axis: &AxisIdentity| {
            let most = axis.speed_max.max(axis.speed_min);
            axis.base_speed.clamp(axis.speed_min, most)
        };
        let rest = Stance {
            steps: [0, 0],
            steps_per_s: [speed(&pan), speed(&tilt)],
        };
        self.travel(&rest, &Cancel::new())?;
        self.leave_mark();
        Ok(())
    }

    /// Sets speeds that tell, should the port be lost, whether the head kept its power meanwhile. Every move sets its own.
    pub(super) fn leave_mark(&mut self) {
        if let Some([pan, tilt]) = self.known.speeds_to_leave() {
            self.wires.head(HeadCommand::SetSpeed(Axis::Pan, pan));
            self.wires.head(HeadCommand::SetSpeed(Axis::Tilt, tilt));
        }
    }
}
