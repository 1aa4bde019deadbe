//! The real devices as a [`Scanner`].

use super::scanner::{ConnectError, DeviceNoteSink, Scanner, ScannerConnector, ScannerError};
use crate::config::Settings;
use crate::devices::{
    Cancel, Device, DeviceError, DeviceNote, PositionTrust, Station, SweepRequest,
};
use link::Clock;
use patrold_engine::sweep::RawSweep;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Opens a station: on real ports, or on emulated ones in tests.
type OpenStation = dyn FnMut(
        &Settings,
        mpsc::Sender<DeviceNote>,
        &PositionTrust,
        &Cancel,
    ) -> Result<Station, DeviceError>
    + Send;

/// Opens a [`Station`] on the ports of the settings.
pub struct StationConnector {
    open: Box<OpenStation>,
    trust: PositionTrust,
    last_notes: LastNotes,
}

/// An absent device gives the same note at every attempt; repetitions are dropped.
type LastNotes = Arc<Mutex<HashMap<Device, String>>>;

impl StationConnector {
    /// The devices run on `clock`.
    pub fn new(clock: Clock) -> Self {
        Self::with_open(move |settings, notes, trust, cancel| {
            Station::open_with_trust(settings, clock.clone(), notes, trust, cancel)
        })
    }

    pub(super) fn with_open(
        open: impl FnMut(
            &Settings,
            mpsc::Sender<DeviceNote>,
            &PositionTrust,
            &Cancel,
        ) -> Result<Station, DeviceError>
        + Send
        + 'static,
    ) -> Self {
        Self {
            open: Box::new(open),
            trust: PositionTrust::default(),
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
        let forwarding = thread::Builder::new()
            .name("patrold-notes".to_owned())
            .spawn(move || forward_notes(&receiver, &sink, &last_notes))
            .map_err(|error| ConnectError {
                reason: format!("cannot start a thread for the devices' notes: {error}"),
                absent: false,
            })?;
        let opened = (self.open)(settings, sender, &self.trust, cancel);
        let mut station = opened.map_err(|error| {
            // The notes come before the failure that they explain; nothing sends any more.
            let _ = forwarding.join();
            connect_error(error)
        })?;
        station.home_if_needed(cancel).map_err(connect_error)?;
        Ok(Box::new(StationScanner {
            station,
            trust: self.trust.clone(),
            cancel: cancel.clone(),
        }))
    }
}

struct StationScanner {
    station: Station,
    trust: PositionTrust,
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
        self.station
            .check_connected()
            .map_err(|error| ScannerError {
                reason: error.to_string(),
                lost: true,
            })
    }

    fn resume(&mut self, cancel: &Cancel) -> Result<(), ConnectError> {
        self.station.await_return(cancel).map_err(connect_error)?;
        self.station.home_if_needed(cancel).map_err(connect_error)
    }

    fn home(&mut self, cancel: &Cancel) -> Result<(), ScannerError> {
        self.station.home(cancel).map_err(|error| ScannerError {
            reason: error.to_string(),
            lost: is_lost(&error),
        })
    }

    fn homings(&self) -> u64 {
        self.trust.homings()
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
        let request = SweepRequest::new(settings, waypoint);
        let swept = self
            .station
            .home_if_needed(cancel)
            .and_then(|()| self.station.sweep(&request, cancel));
        swept.map_err(|error| ScannerError {
            reason: error.to_string(),
            lost: is_lost(&error),
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

fn connect_error(error: DeviceError) -> ConnectError {
    ConnectError {
        absent: error.is_absence(),
        reason: error.to_string(),
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
            sink.report(note.severity, note.device.section(), note.text);
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
            "ptu: absent",
            "laser: connected",
            "laser: absent",
        ];
        assert_eq!(forwarded, expected);
    }
}
