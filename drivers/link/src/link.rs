//! What every transport offers.

use crate::LinkError;
use std::time::Duration;

/// A byte pipe to one device: blocking, with a time limit on every call.
pub trait Link: Send {
    /// Reads what has arrived, waiting at most `timeout` for the first byte. 0 means that nothing came in time.
    ///
    /// # Errors
    /// [`LinkError::Disconnected`] if the device or its adapter has gone, [`LinkError::Io`] for the rest.
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError>;

    /// Writes all of `bytes` within `timeout`.
    ///
    /// # Errors
    /// [`LinkError::TimedOut`] if only a part was written in time (it states how many bytes),
    /// [`LinkError::Disconnected`] if the device has gone, [`LinkError::Io`] for the rest.
    fn write_all(&mut self, bytes: &[u8], timeout: Duration) -> Result<(), LinkError>;

    /// Changes the line rate, bit/s. Does nothing where there is none.
    ///
    /// # Errors
    /// [`LinkError::Io`] if the port does not support it, [`LinkError::Disconnected`] if it is gone.
    fn set_baud(&mut self, _baud: u32) -> Result<(), LinkError> {
        Ok(())
    }

    /// The path or address the link was opened with, for messages.
    fn name(&self) -> &str;
}

impl<L: Link + ?Sized> Link for Box<L> {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        (**self).read(buffer, timeout)
    }

    fn write_all(&mut self, bytes: &[u8], timeout: Duration) -> Result<(), LinkError> {
        (**self).write_all(bytes, timeout)
    }

    fn set_baud(&mut self, baud: u32) -> Result<(), LinkError> {
        (**self).set_baud(baud)
    }

    fn name(&self) -> &str {
        (**self).name()
    }
}
