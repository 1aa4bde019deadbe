//! Homing (calibrating) the head.

use super::Station;
use crate::devices::cancel::Cancel;
use crate::devices::constants::HOME_LIMIT;
use crate::devices::device_links::PortMessage;
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::{HeadCommand, HeadEvent, head_error};
use crate::devices::port::PortEvent;

impl Station {
    /// Homes the head: both axes drive to all their stops, up to a minute.
    ///
    /// # Errors
    /// A failure of the head; [`DeviceError::Cancelled`]: the head ignores commands until it has finished at 0, 0.
    pub fn home(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        self.wait_connected(cancel)?;
        self.state.homing_started();
        self.links.send_head(HeadCommand::Home);
        let until = self.links.now() + HOME_LIMIT;
        while self.links.now() < until {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            match self.next_message(until) {
                Some(PortMessage::Head(PortEvent::Lost { error, .. })) => return Err(error),
                Some(PortMessage::Head(PortEvent::Device(HeadEvent::Ptu(event)))) => match event {
                    ptu::PtuEvent::HomeDone { .. } => {
                        self.set_power_marker();
                        return self.check_trust();
                    }
                    ptu::PtuEvent::Fault(error) => {
                        return Err(head_error(&error, &self.head_port.name));
                    }
                    ptu::PtuEvent::Restarted
                    | ptu::PtuEvent::EchoReturned
                    | ptu::PtuEvent::VerboseReturned => {
                        return Err(DeviceError::PositionLost {
                            port: self.head_port.name.clone(),
                            detail: "the unit restarted while homing".to_owned(),
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
