//! Checks of the devices between two tasks.

use super::Station;
use crate::devices::cancel::Cancel;
use crate::devices::constants::{DEVICES_READY_LIMIT, RECONNECT_WAIT};
use crate::devices::error::DeviceError;

impl Station {
    /// Processes messages that arrived meanwhile; does not wait.
    ///
    /// # Errors
    /// A device is not connected.
    pub fn check_connected(&mut self) -> Result<(), DeviceError> {
        self.process_pending();
        self.state.laser()?;
        self.state.head()?;
        Ok(())
    }

    /// Waits for lost devices to reconnect: briefly for an absent one, as long as at opening for one that is connecting. Does
    /// not change the trust in the position.
    ///
    /// # Errors
    /// A device is still lost; [`DeviceError::Cancelled`].
    pub fn await_return(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        let started = self.links.now();
        loop {
            match self.check_connected() {
                Ok(()) => return Ok(()),
                _ if cancel.is_cancelled() => return Err(DeviceError::Cancelled),
                Err(error) => {
                    let waited = self.links.now().saturating_sub(started);
                    let is_absent = self.state.has_failed() && waited >= RECONNECT_WAIT;
                    if is_absent || waited >= DEVICES_READY_LIMIT {
                        return Err(self.state.failure().unwrap_or(error));
                    }
                }
            }
            self.next_message(started + DEVICES_READY_LIMIT);
        }
    }

    /// The sweep does not fit the reference at the head's angles: the position is not trusted until the head is homed.
    pub fn distrust_position(&mut self) {
        self.state.contradict("its angles do not fit the scene");
    }
}
