//! What is known of both devices from what they told: who they are, whether they are there, whether positions count.

use super::error::{Device, DeviceError};
use super::head::HeadEvent;
use super::port::PortEvent;
use super::port_name::PortName;
use super::station::Told;
use ptu::HeadIdentity;
use scip::Identity;
use std::sync::mpsc::Sender;

/// How much a note matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoteLevel {
    /// For the record.
    Info,
    /// Something was lost or repaired.
    Warn,
    /// A device is gone.
    Error,
}

/// Something a device did, for the log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceNote {
    /// Which device.
    pub device: Device,
    /// How much it matters.
    pub level: NoteLevel,
    /// One line.
    pub text: String,
}

/// The state of both devices.
#[derive(Debug)]
pub(super) struct Known {
    laser: Option<Identity>,
    head: Option<HeadIdentity>,
    laser_error: Option<DeviceError>,
    head_error: Option<DeviceError>,
    ports: (String, String),
    /// Why the head's position is not trusted; `None`: it is.
    distrust: Option<&'static str>,
    /// The head is taken as it is found, once.
    trust_at_first: bool,
    notes: Sender<DeviceNote>,
}

impl Known {
    pub(super) fn new(
        laser: &PortName,
        head: &PortName,
        home_at_start: bool,
        notes: Sender<DeviceNote>,
    ) -> Self {
        Self {
            laser: None,
            head: None,
            laser_error: None,
            head_error: None,
            ports: (laser.name.clone(), head.name.clone()),
            distrust: Some("it was not homed since it was connected"),
            trust_at_first: !home_at_start,
            notes,
        }
    }

    /// Whether each device is known or has failed.
    pub(super) fn settled(&self) -> (bool, bool) {
        (
            self.laser.is_some() || self.laser_error.is_some(),
            self.head.is_some() || self.head_error.is_some(),
        )
    }

    pub(super) fn has_failed(&self) -> bool {
        self.laser_error.is_some() || self.head_error.is_some()
    }

    /// Why either is not known.
    pub(super) fn failures(&self) -> (Option<DeviceError>, Option<DeviceError>) {
        (self.laser().err(), self.head().err())
    }

    pub(super) fn laser(&self) -> Result<&Identity, DeviceError> {
        let away = || away(Device::Laser, &self.ports.0, self.laser_error.as_ref());
        self.laser.as_ref().ok_or_else(away)
    }

    pub(super) fn head(&self) -> Result<&HeadIdentity, DeviceError> {
        let away = || away(Device::Head, &self.ports.1, self.head_error.as_ref());
        self.head.as_ref().ok_or_else(away)
    }

    pub(super) fn trusted(&self) -> bool {
        self.head.is_some() && self.distrust.is_none()
    }

    pub(super) fn distrust(&self) -> &'static str {
        self.distrust.unwrap_or("it is not connected")
    }

    pub(super) fn warn(&self, device: Device, text: String) {
        self.tell(device, NoteLevel::Warn, text);
    }

    fn tell(&self, device: Device, level: NoteLevel, text: String) {
        // Whoever does not listen does not want to know.
        let _ = self.notes.send(DeviceNote {
            device,
            level,
            text,
        });
    }

    pub(super) fn note(&mut self, told: &Told) {
        match told {
            Told::Laser(PortEvent::Lost { error, retry_in }) => {
                self.laser = None;
                self.lost(Device::Laser, error, retry_in.as_secs_f64());
                self.laser_error = Some(error.clone());
            }
            Told::Head(PortEvent::Lost { error, retry_in }) => {
                self.head = None;
                self.distrust = Some("its port was lost in between");
                self.lost(Device::Head, error, retry_in.as_secs_f64());
                self.head_error = Some(error.clone());
            }
            Told::Laser(PortEvent::Device(scip::Event::Connected(identity))) => {
                let text = format!(
                    "{} {} firmware {} on {}",
                    identity.product, identity.serial, identity.firmware, self.ports.0
                );
                self.tell(Device::Laser, NoteLevel::Info, text);
                self.laser = Some(identity.clone());
                self.laser_error = None;
            }
            Told::Laser(PortEvent::Device(_)) => {}
            Told::Head(PortEvent::Device(HeadEvent::Unit(event))) => self.note_head(event),
            Told::Head(PortEvent::Device(HeadEvent::NotTaken(_))) => {}
        }
    }

    fn note_head(&mut self, event: &ptu::Event) {
        use ptu::Event as E;
        match event {
            E::Connected(identity) => {
                let text = format!("{} on {}", identity.version, self.ports.1);
                self.tell(Device::Head, NoteLevel::Info, text);
                let first = std::mem::take(&mut self.trust_at_first);
                if first || identity.calibration_seen {
                    self.distrust = None;
                }
                self.head = Some((**identity).clone());
                self.head_error = None;
            }
            E::HomeDone { pan, tilt } => {
                if let Some(head) = &mut self.head {
                    (head.pan.limits, head.tilt.limits) = (*pan, *tilt);
                }
                self.distrust = None;
                self.tell(Device::Head, NoteLevel::Info, "homed".to_owned());
            }
            E::LimitHit(_) => self.distrusted("an axis ran into its limit"),
            E::CableLost => self.distrusted("the cable to the head came off"),
            E::EchoReturned | E::VerboseReturned | E::Restarted => {
                self.head = None;
                self.distrusted("the unit restarted in between");
            }
            E::Fault(_) => self.distrusted("its calibration failed"),
            _ => {}
        }
    }

    /// From now on counts stand for nothing, until the next calibration.
    pub(super) fn distrusted(&mut self, why: &'static str) {
        self.distrust = Some(why);
        self.warn(Device::Head, format!("position not trusted: {why}"));
    }

    fn lost(&self, device: Device, error: &DeviceError, retry_s: f64) {
        let text = format!("{error}; opening it again in {retry_s:.1} s");
        self.tell(device, NoteLevel::Error, text);
    }
}

fn away(device: Device, port: &str, error: Option<&DeviceError>) -> DeviceError {
    error.cloned().unwrap_or_else(|| DeviceError::NotConnected {
        device,
        port: port.to_owned(),
        detail: "it is being connected".to_owned(),
    })
}
