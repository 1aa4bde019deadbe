//! A look at the devices between two tasks.

use super::Station;
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
}
