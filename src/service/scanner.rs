//! Interface to the scanner: laser and pan-tilt together. `station_scanner` has the real one; tests bring their own.

use crate::config::Settings;
use crate::devices::Cancel;
use crate::patrol::severity::Severity;
use patrold_engine::sweep::RawSweep;
use serde_json::Value;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

/// Connected and homed devices. Dropping it turns the laser off, stops the head and closes the ports.
pub trait Scanner: Send {
    /// Models, serial numbers and firmware as JSON for the status.
    fn describe(&mut self) -> Value;

    /// Checks that idle devices still respond; returns at once.
    ///
    /// # Errors
    /// They must be opened again.
    fn check_connected(&mut self) -> Result<(), ScannerError> {
        Ok(())
    }

    /// The head's angles are wrong: home it before the next sweep.
    fn distrust_head(&mut self) {}

    /// Homes the head; blocks for up to a minute.
    ///
    /// # Errors
    /// It was not homed.
    fn home(&mut self, _cancel: &Cancel) -> Result<(), ScannerError> {
        Ok(())
    }

    /// How often the head was homed, whoever asked for it.
    fn homings(&self) -> u64 {
        0
    }

    /// Waits until disconnected devices are back, and homes the head if its position is not trusted. Blocks.
    ///
    /// # Errors
    /// They are not back. Unless merely absent, they must be connected again.
    fn resume(&mut self, _cancel: &Cancel) -> Result<(), ConnectError> {
        Err(ConnectError {
            reason: "not resumable, connect again".to_owned(),
            absent: false,
        })
    }

    /// Takes a sweep; blocks until it is done.
    ///
    /// # Errors
    /// There is no sweep; the laser is off and the head has stopped.
    fn sweep(
        &mut self,
        settings: &Settings,
        waypoint: Option<&str>,
        cancel: &Cancel,
    ) -> Result<RawSweep, ScannerError>;

    /// The bytes of both devices during the last sweep, also of one that failed, as docs/recording.md has them; `None` where they
    /// were not recorded.
    fn take_dialogue(&mut self) -> Option<Vec<u8>> {
        None
    }

    /// Moves the head back to the start of the last sweep; blocks. Gives the duration on the devices' clock, `None` where
    /// the head did not get there.
    fn return_to_start(&mut self, _cancel: &Cancel) -> Option<Duration> {
        None
    }
}

/// The devices could not be connected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConnectError {
    /// One line: device, what happened, what to do.
    pub reason: String,
    /// A device is not plugged in: trying again soon costs nothing and moves nothing.
    pub absent: bool,
}

/// Connected devices failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScannerError {
    /// One line: device, what happened, what to do.
    pub reason: String,
    /// The devices must be opened and homed again before the next sweep.
    pub lost: bool,
}

/// Connects the devices, again after each loss.
pub trait ScannerConnector: Send {
    /// Connects and homes the devices; blocks until they are ready. Their notes go to `notes`, now and later.
    ///
    /// # Errors
    /// They are absent, do not answer as expected, or `cancel` was set.
    fn connect(
        &mut self,
        settings: &Settings,
        notes: &DeviceNoteSink,
        cancel: &Cancel,
    ) -> Result<Box<dyn Scanner>, ConnectError>;
}

/// Receives the devices' notes for the event log.
#[derive(Clone)]
pub struct DeviceNoteSink(Arc<NoteHandler>);

type NoteHandler = dyn Fn(Severity, &str, String) + Send + Sync;

impl DeviceNoteSink {
    /// `handler` gets severity, device and text of each note.
    pub fn new(handler: impl Fn(Severity, &str, String) + Send + Sync + 'static) -> Self {
        Self(Arc::new(handler))
    }

    /// Passes a note on.
    pub fn report(&self, severity: Severity, device: &str, text: String) {
        (self.0)(severity, device, text);
    }
}

impl fmt::Debug for DeviceNoteSink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("DeviceNoteSink")
    }
}
