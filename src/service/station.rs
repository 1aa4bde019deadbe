//! The true devices as the service's robot.

use super::robot::{Connect, Fault, Notes, Robot};
use crate::config::Settings;
use crate::devices::{
    Cancel, Clock, Device, DeviceError, DeviceNote, NoteLevel, Station, SweepRequest,
};
use crate::store::Level;
use crate::sweep::RawSweep;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// Connects the station of the settings.
pub struct StationConnect {
    clock: Clock,
    /// A sweep failed since the head was homed: it is homed again, whatever the configuration says of the start.
    doubtful: Arc<AtomicBool>,
    said: Said,
}

/// The last note of each device: a device that stays away says the same at every attempt, which is no news.
type Said = Arc<Mutex<HashMap<Device, String>>>;

impl StationConnect {
    /// Connects stations that live in the time of `clock`.
    pub fn new(clock: Clock) -> Self {
        Self {
            clock,
            doubtful: Arc::default(),
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
    ) -> Result<Box<dyn Robot>, String> {
        let told = |error: DeviceError| error.to_string();
        let (sender, receiver) = mpsc::channel();
        let (forward, said) = (notes.clone(), Arc::clone(&self.said));
        thread::Builder::new()
            .name("patrold-notes".to_owned())
            .spawn(move || pass_on(&receiver, &forward, &said))
            .map_err(|error| format!("no thread for the devices' notes: {error}"))?;
        let mut station = Station::open(settings, self.clock.clone(), sender).map_err(told)?;
        if self.doubtful.load(Ordering::Relaxed) || !station.position_trusted() {
            station.home(cancel).map_err(told)?;
            self.doubtful.store(false, Ordering::Relaxed);
        }
        Ok(Box::new(StationRobot {
            station,
            doubtful: Arc::clone(&self.doubtful),
        }))
    }
}

struct StationRobot {
    station: Station,
    doubtful: Arc<AtomicBool>,
}

impl Robot for StationRobot {
    fn describe(&mut self) -> Value {
        match self.station.describe() {
            Ok(report) => json!(report),
            Err(error) => json!({"error": error.to_string()}),
        }
    }

    fn watch(&mut self) -> Result<(), Fault> {
        self.station.watch().map_err(|error| {
            // The next station may take the head as it is found; this one knows better.
            if !self.station.position_trusted() {
                self.doubtful.store(true, Ordering::Relaxed);
            }
            Fault {
                reason: error.to_string(),
                lost: true,
            }
        })
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
            if lost {
                self.doubtful.store(true, Ordering::Relaxed);
            }
            Fault {
                reason: error.to_string(),
                lost,
            }
        })
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

/// Whether the devices must be opened and homed anew: after everything but a plan they cannot follow, a sweep whose
/// instants are void, and a sweep that was called off.
fn is_lost(error: &DeviceError) -> bool {
    !matches!(
        error,
        DeviceError::Cancelled
            | DeviceError::OutOfReach { .. }
            | DeviceError::Refused { .. }
            | DeviceError::TimerLost { .. }
    )
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
    use super::{Said, pass_on};
    use crate::devices::{Device, DeviceNote, NoteLevel};
    use crate::service::Notes;
    use std::sync::{Arc, Mutex, mpsc};

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
