//! Looks at the devices between two tasks, and what follows from one.

use super::Station;
use crate::devices::cancel::Cancel;
use crate::devices::constants::{OPEN_LIMIT, RETURN_LIMIT};
use crate::devices::error::DeviceError;

impl Station {
    /// Takes note of what the devices told while nothing was asked of them; returns at once.
    ///
    /// # Errors
    /// A device that is not connected now.
    pub fn watch(&mut self) -> Result<(), DeviceError> {
        self.catch_up();
        self.known.laser()?;
        self.known.head()?;
        Ok(())
    }

    /// Waits for devices that went away and are connected anew by their ports: not long for one that is not there, as
    /// long as at opening for one that is being connected. What it says of positions stays as it is.
    ///
    /// # Errors
    /// Who is still away, and why; [`DeviceError::Cancelled`] soon after `cancel` was set.
    pub fn await_return(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        let begun = self.wires.now();
        loop {
            match self.watch() {
                Ok(()) => return Ok(()),
                _ if cancel.is_cancelled() => return Err(DeviceError::Cancelled),
                Err(error) => {
                    let waited = self.wires.now().saturating_sub(begun);
                    let away = self.known.has_failed() && waited >= RETURN_LIMIT;
                    if away || waited >= OPEN_LIMIT {
                        return Err(self.known.failure().unwrap_or(error));
                    }
                }
            }
            self.next(begun + OPEN_LIMIT);
        }
    }

    /// The scene says that the head's counts do not stand for angles: from now on they do not, until it is homed.
    pub fn distrust(&mut self) {
        self.known.distrusted("its angles do not fit the scene");
    }
}
