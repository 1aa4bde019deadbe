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

impl Station {
    /// The scene says that the head's counts do not stand for angles: from now on they do not, until it is homed.
    pub fn distrust(&mut self) {
        self.known.distrusted("its angles do not fit the scene");
    }
}
