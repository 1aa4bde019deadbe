//! The real devices as a [`Scanner`].

use super::scanner::{ConnectError, DeviceNoteSink, Scanner, ScannerConnector, ScannerError};
use crate::config::Settings;
use crate::devices::{Cancel, Device, DeviceError, DeviceNote, HeadMemory, Station, SweepRequest};
use link::Clock;
use patrold_engine::sweep::RawSweep;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Opens a station: on real ports, or on emulated ones in tests.
type OpenStation = dyn FnMut(&Settings, mpsc::Sender<DeviceNote>, &HeadMemory, &Cancel) -> Result<Station, DeviceError>
    + Send;

/// Opens a [`Station`] on the ports of the settings.
pub struct StationConnector {
    open: Box<OpenStation>,
    memory: HeadMemory,
    last_notes: LastNotes,
}

/// An absent device gives the same note at every attempt; repetitions are dropped.
type LastNotes = Arc<Mutex<HashMap<Device, String>>>;

impl StationConnector {
    /// The devices run on `clock`.
    pub fn new(clock: Clock) -> Self {
        Self::with_open(move |settings, notes, memory, cancel| {
            Station::open_with_memory(settings, clock.clone(), notes, memory, cancel)
        })
    }

    pub(super) fn with_open(
        open: impl FnMut(
            &Settings,
            mpsc::Sender<DeviceNote>,
            &HeadMemory,
            &Cancel,
        ) -> Result<Station, DeviceError>
        + Send
        + 'static,
    ) -> Self {
        Self {
            open: Box::new(open),
            memory: HeadMemory::default(),
            last_notes: LastNotes::default(),
        }
    }
}

impl ScannerConnector for StationConnector {
    fn connect(
        &mut self,
        settings: &Settings,
        notes: &DeviceNoteSink,
        cancel: &Cancel,
    ) -> Result<Box<dyn Scanner>, ConnectError> {
        let (sender, receiver) = mpsc::channel();
        let (sink, last_notes) = (notes.clone(), Arc::clone(&self.last_notes));
        thread::Builder::new()
            .name("patrold-notes".to_owned())
            .spawn(move || forward_notes(&receiver, &sink, &last_notes))
            .map_err(|error| ConnectError {
                reason: format!("cannot start a thread for the devices' notes: {error}"),
                absent: false,
            })?;
        let opened = (self.open)(settings, sender, &self.memory, cancel);
        let mut station = opened.map_err(connect_error)?;
        if self.memory.is_doubted() || !station.position_trusted() {
            station.home(cancel).map_err(connect_error)?;
        }
        Ok(Box::new(StationScanner {
            station,
            memory: self.memory.clone(),
            cancel: cancel.clone(),
        }))
    }
}

struct StationScanner {
    station: Station,
    memory: HeadMemory,
    /// Of the connect command; describing belongs to it.
    cancel: Cancel,
}

impl Scanner for StationScanner {
    fn describe(&mut self) -> Value {
        match self.station.describe(&self.cancel) {
            Ok(report) => json!(report),
            Err(error) => json!({"error": error.to_string()}),
        }
    }

    fn check_connected(&mut self) -> Result<(), ScannerError> {
        self.station.check_connected().map_err(|error| {
            // Otherwise the next station may trust the position as found.
            if !self.station.position_trusted() {
                self.memory.set_doubted();
            }
            ScannerError {
                reason: error.to_string(),
                lost: true,
            }
        })
    }

    fn resume(&mut self, cancel: &Cancel) -> Result<(), ConnectError> {
        self.station.await_return(cancel).map_err(connect_error)?;
        if self.memory.is_doubted() || !self.station.position_trusted() {
            self.station.home(cancel).map_err(connect_error)?;
        }
        Ok(())
    }

    fn distrust_head(&mut self) {
        self.station.distrust_position();
    }

    fn sweep(
        &mut self,
        settings: &Settings,
        waypoint: Option<&str>,
        cancel: &Cancel,
    ) -> Result<RawSweep, ScannerError> {
        let pans_rad = match waypoint {
            Some(name) => settings.pans_rad(name),
            None => &settings.sweep.pans_rad,
        };
        let request = SweepRequest::new(&settings.sweep, &settings.mount, pans_rad);
        let swept = self
            .home_if_untrusted(cancel)
            .and_then(|()| self.station.sweep(&request, cancel));
        swept.map_err(|error| {
            let lost = is_lost(&error);
            if lost && puts_head_in_doubt(&error) {
                self.memory.set_doubted();
            }
            ScannerError {
                reason: error.to_string(),
                lost,
            }
        })
    }

    fn take_dialogue(&mut self) -> Option<Vec<u8>> {
        self.station.take_dialogue()
    }

    fn return_to_start(&mut self, cancel: &Cancel) -> Option<Duration> {
        // A failure is in the notes, and the next sweep meets it again.
        self.station.return_to_start(cancel).ok().flatten()
    }
}

impl StationScanner {
    fn home_if_untrusted(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        if self.station.position_trusted() {
            return Ok(());
        }
        self.station.home(cancel)
    }
}

fn connect_error(error: DeviceError) -> ConnectError {
    ConnectError {
        absent: error.is_absence(),
        reason: error.to_string(),
    }
}

/// Whether the head's position is in doubt after `error`.
fn puts_head_in_doubt(error: &DeviceError) -> bool {
    use DeviceError as E;
    match error {
        E::Port { device, .. }
        | E::Silent { device, .. }
        | E::WrongDevice { device, .. }
        | E::OtherUnit { device, .. }
        | E::Fault { device, .. }
        | E::NotConnected { device, .. }
        | E::Overdue { device, .. }
        | E::Refused { device, .. }
        | E::NoThread { device, .. } => *device == Device::Head,
        E::TimerLost { .. } | E::Cancelled | E::OutOfReach { .. } => false,
        E::PositionLost { .. } | E::Stalled { .. } => true,
    }
}

/// Whether the devices must be opened and homed again. Not after a plan out of reach, a sweep without valid times, a laser
/// that refuses a command, or a cancelled sweep. A head that refuses one may have a broken axis.
fn is_lost(error: &DeviceError) -> bool {
    match error {
        DeviceError::Refused { device, .. } => *device == Device::Head,
        DeviceError::Cancelled | DeviceError::OutOfReach { .. } | DeviceError::TimerLost { .. } => {
            false
        }
        _ => true,
    }
}

fn forward_notes(receiver: &Receiver<DeviceNote>, sink: &DeviceNoteSink, last_notes: &LastNotes) {
    while let Ok(note) = receiver.recv() {
        let repeated = {
            let mut last = last_notes.lock().unwrap_or_else(PoisonError::into_inner);
            last.insert(note.device, note.text.clone()).as_ref() == Some(&note.text)
        };
        if !repeated {
            sink.report(note.severity, &note.device.to_string(), note.text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LastNotes, forward_notes, is_lost};
    use crate::devices::{Device, DeviceError, DeviceNote};
    use crate::patrol::severity::Severity;
    use crate::service::DeviceNoteSink;
    use std::sync::{Arc, Mutex, mpsc};

    #[test]
    fn a_refused_command_loses_the_head_but_not_the_laser() {
        let refused = |device| DeviceError::Refused {
            device,
            port: "/dev/x".to_owned(),
            command: "TP100".to_owned(),
            detail: "Axis Error".to_owned(),
        };
        assert!(is_lost(&refused(Device::Head)));
        assert!(!is_lost(&refused(Device::Laser)));
        assert!(!is_lost(&DeviceError::Cancelled));
    }

    #[test]
    fn repeated_notes_of_a_device_are_dropped() {
        let forwarded = Arc::new(Mutex::new(Vec::new()));
        let list = Arc::clone(&forwarded);
        let sink = DeviceNoteSink::new(move |_, device, text| {
            list.lock()
                .expect("no panic")
                .push(format!("{device}: {text}"));
        });
        let (sender, receiver) = mpsc::channel();
        for (device, text) in [
            (Device::Laser, "absent"),
            (Device::Head, "absent"),
            (Device::Laser, "absent"),
            (Device::Laser, "connected"),
            (Device::Laser, "absent"),
        ] {
            let note = DeviceNote {
                device,
                severity: Severity::Error,
                text: text.to_owned(),
            };
            sender.send(note).expect("the receiver exists");
        }
        drop(sender);
        forward_notes(&receiver, &sink, &LastNotes::default());
        let forwarded = forwarded.lock().expect("no panic").clone();
        let expected = [
            "laser: absent",
            "pan-tilt: absent",
            "laser: connected",
            "laser: absent",
        ];
        assert_eq!(forwarded, expected);
    }
}
