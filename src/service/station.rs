//! The true devices as the service's robot.

use super::robot::{Away, Connect, Fault, Notes, Robot};
use crate::config::Settings;
use crate::devices::{
    Cancel, Device, DeviceError, DeviceNote, HeadMemory, NoteLevel, Station, SweepRequest,
};
use crate::store::Level;
use link::Clock;
use patrold_engine::sweep::RawSweep;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Opens a station: how it comes to its ports is nobody else's concern.
type Open = dyn FnMut(&Settings, mpsc::Sender<DeviceNote>, &HeadMemory, &Cancel) -> Result<Station, DeviceError>
    + Send;

/// Connects the station of the settings.
pub struct StationConnect {
    open: Box<Open>,
    /// A doubt about the head outlives the station that had it: it is homed, whatever the configuration says of the start.
    memory: HeadMemory,
    said: Said,
}

/// The last note of each device: a device that stays away says the same at every attempt, which is no news.
type Said = Arc<Mutex<HashMap<Device, String>>>;

impl StationConnect {
    /// Connects stations that live in the time of `clock`.
    pub fn new(clock: Clock) -> Self {
        Self::over(move |settings, notes, memory, cancel| {
            Station::open_again(settings, clock.clone(), notes, memory, cancel)
        })
    }

    /// Connects what `open` opens.
    pub(super) fn over(
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
            said: Said::default(),
        }
    }
}

impl Connect for StationConnect {
    fn connect(
        &mut self,
        settings: &Settings,
        notes: &Notes,
        cancel: &Cancel,
    ) -> Result<Box<dyn Robot>, Away> {
        let (sender, receiver) = mpsc::channel();
        let (forward, said) = (notes.clone(), Arc::clone(&self.said));
        thread::Builder::new()
            .name("patrold-notes".to_owned())
            .spawn(move || pass_on(&receiver, &forward, &said))
            .map_err(|error| Away {
                reason: format!("no thread for the devices' notes: {error}"),
                absent: false,
            })?;
        let opened = (self.open)(settings, sender, &self.memory, cancel);
        let mut station = opened.map_err(away)?;
        if self.memory.is_doubted() || !station.position_trusted() {
            station.home(cancel).map_err(away)?;
        }
        Ok(Box::new(StationRobot {
            station,
            memory: self.memory.clone(),
            cancel: cancel.clone(),
        }))
    }
}

struct StationRobot {
    station: Station,
    memory: HeadMemory,
    /// Of the order that connected it; who answers is asked as part of that.
    cancel: Cancel,
}

impl Robot for StationRobot {
    fn describe(&mut self) -> Value {
        match self.station.describe(&self.cancel) {
            Ok(report) => json!(report),
            Err(error) => json!({"error": error.to_string()}),
        }
    }

    fn watch(&mut self) -> Result<(), Fault> {
        self.station.watch().map_err(|error| {
            // The next station may take the head as it is found; this one knows better.
            if !self.station.position_trusted() {
                self.memory.doubt();
            }
            Fault {
                reason: error.to_string(),
                lost: true,
            }
        })
    }

    fn resume(&mut self, cancel: &Cancel) -> Result<(), Away> {
        self.station.await_return(cancel).map_err(away)?;
        if self.memory.is_doubted() || !self.station.position_trusted() {
            self.station.home(cancel).map_err(away)?;
        }
        Ok(())
    }

    fn distrust(&mut self) {
        self.station.distrust();
    }

    fn sweep(
        &mut self,
        settings: &Settings,
        waypoint: Option<&str>,
        cancel: &Cancel,
    ) -> Result<RawSweep, Fault> {
        let pans_rad = match waypoint {
            Some(name) => settings.pans_rad(name),
            None => &settings.sweep.pans_rad,
        };
        let request = SweepRequest::new(&settings.sweep, &settings.mount, pans_rad);
        let taken = self
            .be_trusted(cancel)
            .and_then(|()| self.station.sweep(&request, cancel));
        taken.map_err(|error| {
            let lost = is_lost(&error);
            if lost && concerns_head(&error) {
                self.memory.doubt();
            }
            Fault {
                reason: error.to_string(),
                lost,
            }
        })
    }

    fn go_back(&mut self, cancel: &Cancel) -> Option<Duration> {
        // What went wrong is in the notes, and the next sweep meets it again.
        self.station.go_back(cancel).ok().flatten()
    }
}

impl StationRobot {
    /// A head that was plugged in again, or ran into its limit since, is homed before it is believed.
    fn be_trusted(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        if self.station.position_trusted() {
            return Ok(());
        }
        self.station.home(cancel)
    }
}

fn away(error: DeviceError) -> Away {
    Away {
        absent: error.is_absence(),
        reason: error.to_string(),
    }
}

/// Whether the head's position is in doubt after it: what happened to the laser does not move the head.
fn concerns_head(error: &DeviceError) -> bool {
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

/// Whether the devices must be opened and homed anew: after everything but a plan they cannot follow, a sweep whose
/// instants are void, a laser that refuses, and a sweep that was called off. A head that refuses may have a broken axis.
fn is_lost(error: &DeviceError) -> bool {
    match error {
        DeviceError::Refused { device, .. } => *device == Device::Head,
        DeviceError::Cancelled | DeviceError::OutOfReach { .. } | DeviceError::TimerLost { .. } => {
            false
        }
        _ => true,
    }
}

fn pass_on(receiver: &Receiver<DeviceNote>, notes: &Notes, said: &Said) {
    while let Ok(note) = receiver.recv() {
        let news = {
            let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
            said.insert(note.device, note.text.clone()).as_ref() != Some(&note.text)
        };
        if !news {
            continue;
        }
        let level = match note.level {
            NoteLevel::Info => Level::Info,
            NoteLevel::Warn => Level::Warning,
            NoteLevel::Error => Level::Error,
        };
        notes.say(level, &note.device.to_string(), note.text);
    }
}

#[cfg(test)]
mod tests {
    use super::{Said, is_lost, pass_on};
    use crate::devices::{Device, DeviceError, DeviceNote, NoteLevel};
    use crate::service::Notes;
    use std::sync::{Arc, Mutex, mpsc};

    #[test]
    fn a_head_that_refuses_is_homed_again_and_a_laser_is_not_lost_by_it() {
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
    fn what_a_device_says_again_is_no_news() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let take = Arc::clone(&heard);
        let notes = Notes::new(move |_, device, text| {
            take.lock()
                .expect("no panic")
                .push(format!("{device}: {text}"));
        });
        let (sender, receiver) = mpsc::channel();
        for (device, text) in [
            (Device::Laser, "away"),
            (Device::Head, "away"),
            (Device::Laser, "away"),
            (Device::Laser, "here"),
            (Device::Laser, "away"),
        ] {
            let note = DeviceNote {
                device,
                level: NoteLevel::Error,
                text: text.to_owned(),
            };
            sender.send(note).expect("somebody listens");
        }
        drop(sender);
        pass_on(&receiver, &notes, &Said::default());
        let heard = heard.lock().expect("no panic").clone();
        let expected = [
            "laser: away",
            "pan-tilt: away",
            "laser: here",
            "laser: away",
        ];
        assert_eq!(heard, expected);
    }
}
