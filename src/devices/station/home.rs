//! Homing (calibrating) the head.

use super::Station;
use crate::devices::cancel::Cancel;
use crate::devices::constants::HOME_LIMIT;
use crate::devices::device_links::PortMessage;
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::{HeadCommand, HeadEvent, head_error};
use crate::devices::port::PortEvent;
use ptu::PtuEvent;
use std::time::Duration;

impl Station {
    /// Homes the head unless its counts are known to be angles.
    ///
    /// # Errors
    /// As [`home`](Self::home).
    pub fn home_if_needed(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        self.process_pending();
        if self.state.is_position_trusted() {
            return Ok(());
        }
        self.home(cancel)
    }

    /// Homes the head: its modes are set anew, then both axes drive to all their stops; up to a minute. Whatever mode another
    /// program, or a fault, left the head in, it obeys afterwards.
    ///
    /// # Errors
    /// A failure of the head; [`DeviceError::Cancelled`]: the head ignores commands until it has finished at 0, 0.
    pub fn home(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        self.wait_connected(cancel)?;
        self.state.homing_started();
        let until = self.links.now() + HOME_LIMIT;
        self.links.send_head(HeadCommand::SetUp);
        self.await_homing(until, cancel, &|event| {
            matches!(event, PtuEvent::Connected(_))
        })?;
        self.links.send_head(HeadCommand::Home);
        self.await_homing(until, cancel, &|event| {
            matches!(event, PtuEvent::HomeDone { .. })
        })?;
        self.set_power_marker();
        self.check_trust()
    }

    fn await_homing(
        &mut self,
        until: Duration,
        cancel: &Cancel,
        is_done: &dyn Fn(&PtuEvent) -> bool,
    ) -> Result<(), DeviceError> {
        while self.links.now() < until {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            match self.next_message(until) {
                Some(PortMessage::Head(PortEvent::Lost { error, .. })) => return Err(error),
                Some(PortMessage::Head(PortEvent::Device(HeadEvent::Ptu(event)))) => match event {
                    event if is_done(&event) => return Ok(()),
                    PtuEvent::Fault(error) => {
                        return Err(head_error(
                            &error,
                            &self.head_port.name,
                            &self.head_port.setting(),
                        ));
                    }
                    PtuEvent::Restarted | PtuEvent::EchoReturned | PtuEvent::VerboseReturned => {
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
