//! Laying both devices to rest at the end of the work.

use super::Station;
use crate::devices::constants::STEP_LIMIT;
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::{HeadCommand, HeadEvent};
use crate::devices::laser::LaserCommand;
use crate::devices::port::PortEvent;
use crate::devices::wires::Told;
use ptu::Axis;

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
        for (name, axis) in [(Axis::Pan, &pan), (Axis::Tilt, &tilt)] {
            let speed = axis
                .base_speed
                .clamp(axis.speed_min, axis.speed_max.max(axis.speed_min));
            self.wires.head(HeadCommand::SetSpeed(name, speed));
            self.wires.head(HeadCommand::MoveTo(name, 0));
        }
        for axis in [Axis::Pan, Axis::Tilt] {
            self.wait_at_zero(axis)?;
        }
        self.wires.head(HeadCommand::Watch(None));
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

    fn wait_at_zero(&mut self, wanted: Axis) -> Result<(), DeviceError> {
        self.wires.head(HeadCommand::Watch(Some(wanted)));
        let until = self.wires.now() + STEP_LIMIT;
        while self.wires.now() < until {
            match self.next(until) {
                Some(Told::Head(PortEvent::Lost { error, .. })) => return Err(error),
                Some(Told::Head(PortEvent::Device(HeadEvent::Unit(ptu::Event::Position {
                    axis,
                    steps: 0,
                    ..
                }))))
                    if axis == wanted =>
                {
                    return Ok(());
                }
                _ => {}
            }
        }
        self.wires.head(HeadCommand::Watch(None));
        self.wires.head(HeadCommand::Halt);
        Err(DeviceError::Overdue {
            device: Device::Head,
            port: self.head_port.name.clone(),
            what: "parking",
            limit_s: STEP_LIMIT.as_secs(),
        })
    }
}
