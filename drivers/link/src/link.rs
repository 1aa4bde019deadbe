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

    fn name(&self) -> &str {
        (**self).name()
    }
}
