//! Calibrating the head.

use super::Station;
use crate::devices::cancel::Cancel;
use crate::devices::constants::HOME_LIMIT;
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::{HeadCommand, HeadEvent, head_error};
use crate::devices::port::PortEvent;
use crate::devices::wires::Told;

impl Station {
    /// Calibrates the head: both axes go to all their stops, up to a minute.
    ///
    /// # Errors
    /// The head's failure; [`DeviceError::Cancelled`], where the head ends its calibration by itself at 0, 0, for it
    /// hears nothing until then.
    pub fn home(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        self.be_connected(cancel)?;
        self.known.begin_homing();
        self.wires.head(HeadCommand::Home);
        let until = self.wires.now() + HOME_LIMIT;
        while self.wires.now() < until {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            match self.next(until) {
                Some(Told::Head(PortEvent::Lost { error, .. })) => return Err(error),
                Some(Told::Head(PortEvent::Device(HeadEvent::Unit(event)))) => match event {
                    ptu::Event::HomeDone { .. } => {
                        self.leave_mark();
                        return self.check_trust();
                    }
                    ptu::Event::Fault(error) => {
                        return Err(head_error(&error, &self.head_port.name));
                    }
                    ptu::Event::Restarted
                    | ptu::Event::EchoReturned
                    | ptu::Event::VerboseReturned => {
                        return Err(DeviceError::PositionLost {
                            port: self.head_port.name.clone(),
                            detail: "the unit restarted while it was homing".to_owned(),
                        });
                    }
                    _ => {}
                },
                _ => {}
            }
        }
        Err(DeviceError::Overdue {
            device: Device::Head,
            port: self.head_port.name.clone(),
            what: "homing",
            limit_s: HOME_LIMIT.as_secs(),
        })
    }
}
