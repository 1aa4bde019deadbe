//! What is known of both devices from what they told: who they are, whether they are there, whether positions count.

use super::error::{Device, DeviceError};
use super::head::HeadEvent;
use super::head_memory::HeadMemory;
use super::port::PortEvent;
use super::port_name::PortName;
use super::power_mark::PowerMark;
use super::wires::Told;
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
    /// Its position was trusted when its port was lost, and nothing has spoilt it since.
    was_trusted: bool,
    mark: PowerMark,
    memory: HeadMemory,
    notes: Sender<DeviceNote>,
}

/// Why a calibration that ended is not believed.
const LIMITS_MOVED: &str =
    "its limits are not where they were before its calibration: is something in its way?";

impl Known {
    pub(super) fn new(
        laser: &PortName,
        head: &PortName,
        home_at_start: bool,
        memory: HeadMemory,
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
            was_trusted: false,
            mark: PowerMark::default(),
            memory,
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

    /// What failed, and not what was being connected meanwhile.
    pub(super) fn failure(&self) -> Option<DeviceError> {
        let laser = self.laser_error.as_ref();
        laser.or(self.head_error.as_ref()).cloned()
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
                if self.head.take().is_some() {
                    self.was_trusted = self.distrust.is_none();
                    self.memory.doubt();
                }
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
            // Who answers will be seen; that it is away is true no more.
            Told::Laser(PortEvent::Opened) => self.laser_error = None,
            Told::Head(PortEvent::Opened) => self.head_error = None,
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
                let first =
                    std::mem::take(&mut self.trust_at_first) && self.memory.may_take_as_found();
                let stand = self.memory.limits_stand(identity);
                let kept_power = self.mark.stands(identity);
                if !kept_power {
                    self.mark = PowerMark::new(identity);
                }
                let as_left = std::mem::take(&mut self.was_trusted) && kept_power && stand;
                self.head = Some((**identity).clone());
                self.head_error = None;
                match (identity.calibration_seen, stand) {
                    (true, true) => self.trust(),
                    (true, false) => self.distrusted(LIMITS_MOVED),
                    (false, _) if as_left => {
                        self.trust();
                        let text = "kept its power: its position stands".to_owned();
                        self.tell(Device::Head, NoteLevel::Info, text);
                    }
                    (false, _) if first => self.distrust = None,
                    (false, _) => {}
                }
            }
            E::HomeDone { pan, tilt } => {
                if let Some(head) = &mut self.head {
                    (head.pan.limits, head.tilt.limits) = (*pan, *tilt);
                }
                if self
                    .head
                    .as_ref()
                    .is_none_or(|h| self.memory.limits_stand(h))
                {
                    self.trust();
                    self.tell(Device::Head, NoteLevel::Info, "homed".to_owned());
                } else {
                    self.distrusted(LIMITS_MOVED);
                }
            }
            E::SpeedSet { axis, steps_per_s } => self.mark.taken(*axis, *steps_per_s),
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

    /// Set speeds by which the head will be known again as one that kept its power; `None`: it is not connected.
    pub(super) fn speeds_to_leave(&self) -> Option<[i32; 2]> {
        self.head.as_ref().map(|head| self.mark.to_leave(head))
    }

    fn trust(&mut self) {
        self.distrust = None;
        self.memory.trust();
    }

    /// A calibration is asked for: until it ends the head is anywhere.
    pub(super) fn begin_homing(&mut self) {
        self.distrust = Some("its calibration did not end");
        self.was_trusted = false;
        self.memory.doubt();
    }

    /// From now on counts stand for nothing, until the next calibration; not in the next station either.
    pub(super) fn distrusted(&mut self, why: &'static str) {
        self.memory.doubt();
        self.was_trusted = false;
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

#[cfg(test)]
mod tests {
    use super::{Known, Told};
    use crate::devices::error::{Device, DeviceError};
    use crate::devices::head::HeadEvent;
    use crate::devices::head_memory::HeadMemory;
    use crate::devices::lockstep::bench::Bench;
    use crate::devices::port::PortEvent;
    use crate::devices::port_name::PortName;
    use ptu::{Axis, Event, HeadIdentity};
    use std::sync::mpsc;
    use std::time::Duration;

    fn known(memory: &HeadMemory) -> Known {
        let port = |device| PortName {
            device,
            name: format!("/dev/{device}"),
            baud: 9600,
            unit: None,
        };
        let (laser, head) = (port(Device::Laser), port(Device::Head));
        Known::new(&laser, &head, false, memory.clone(), mpsc::channel().0)
    }

    fn unit() -> HeadIdentity {
        let bench = Bench::ready(patrold_sim::emulator::EmulationOptions::seeded(1));
        let mut unit = bench.identity.expect("connected");
        unit.calibration_seen = false;
        unit
    }

    fn hear(known: &mut Known, event: Event) {
        known.note(&Told::Head(PortEvent::Device(HeadEvent::Unit(event))));
    }

    fn connected(unit: &HeadIdentity) -> Event {
        Event::Connected(Box::new(unit.clone()))
    }

    fn home_done(unit: &HeadIdentity) -> Event {
        Event::HomeDone {
            pan: unit.pan.limits,
            tilt: unit.tilt.limits,
        }
    }

    #[test]
    fn what_spoilt_the_position_outlives_the_station() {
        let unit = unit();
        for doubt in [
            Event::LimitHit(Axis::Pan),
            Event::CableLost,
            Event::Restarted,
        ] {
            let memory = HeadMemory::default();
            let mut first = known(&memory);
            hear(&mut first, connected(&unit));
            assert!(first.trusted(), "taken as it is found");
            hear(&mut first, doubt.clone());
            drop(first);
            let mut second = known(&memory);
            hear(&mut second, connected(&unit));
            assert!(!second.trusted(), "{doubt:?}");
            hear(&mut second, home_done(&unit));
            assert!(second.trusted());
        }
    }

    #[test]
    fn a_port_lost_or_a_homing_that_did_not_end_outlives_it_too() {
        let unit = unit();
        let error = DeviceError::Cancelled;
        let lost = Told::Head(PortEvent::Lost {
            error,
            retry_in: Duration::ZERO,
        });
        let memory = HeadMemory::default();
        let mut absent = known(&memory);
        absent.note(&lost);
        let mut first = known(&memory);
        hear(&mut first, connected(&unit));
        assert!(
            first.trusted(),
            "a port that was never there spoils nothing"
        );
        first.note(&lost);
        let mut second = known(&memory);
        hear(&mut second, connected(&unit));
        assert!(!second.trusted());

        let memory = HeadMemory::default();
        known(&memory).begin_homing();
        let mut second = known(&memory);
        hear(&mut second, connected(&unit));
        assert!(!second.trusted());
    }

    #[test]
    fn a_head_that_kept_its_power_is_trusted_as_before_its_port_was_lost() {
        let lost = Told::Head(PortEvent::Lost {
            error: DeviceError::Cancelled,
            retry_in: Duration::ZERO,
        });
        let unit = unit();
        let mut kept = unit.clone();
        for spoilt in [false, true] {
            let memory = HeadMemory::default();
            let mut known = known(&memory);
            hear(&mut known, connected(&unit));
            let [pan, tilt] = known.speeds_to_leave().expect("connected");
            for (axis, steps_per_s) in [(Axis::Pan, pan), (Axis::Tilt, tilt)] {
                hear(&mut known, Event::SpeedSet { axis, steps_per_s });
            }
            (kept.pan.speed, kept.tilt.speed) = (pan, tilt);
            if spoilt {
                hear(&mut known, Event::LimitHit(Axis::Pan));
            }
            known.note(&lost);
            assert!(!known.trusted() && memory.is_doubted());
            hear(&mut known, connected(&kept));
            assert_eq!((known.trusted(), memory.is_doubted()), (!spoilt, spoilt));
            known.note(&lost);
            hear(&mut known, connected(&unit));
            assert!(!known.trusted(), "speeds of a power-up");
            hear(&mut known, connected(&kept));
            assert!(!known.trusted(), "nor later");
        }
    }

    #[test]
    fn only_the_first_station_takes_the_head_as_it_is_found() {
        let unit = unit();
        let memory = HeadMemory::default();
        memory.opened();
        let mut second = known(&memory);
        hear(&mut second, connected(&unit));
        assert!(!second.trusted());
    }

    #[test]
    fn a_limit_hit_while_it_connects_is_no_good_start() {
        let mut known = known(&HeadMemory::default());
        hear(&mut known, Event::LimitHit(Axis::Tilt));
        hear(&mut known, connected(&unit()));
        assert!(!known.trusted());
    }

    #[test]
    fn limits_that_moved_with_the_calibration_are_not_believed() {
        let unit = unit();
        let memory = HeadMemory::default();
        let mut known = known(&memory);
        hear(&mut known, connected(&unit));
        let mut calibrated = unit.clone();
        calibrated.pan.limits.max_steps -= 20;
        hear(&mut known, home_done(&calibrated));
        assert!(known.trusted(), "they move by a few counts");
        calibrated.pan.limits.max_steps -= 1;
        hear(&mut known, home_done(&calibrated));
        assert!(!known.trusted() && known.distrust().contains("in its way"));
        calibrated.calibration_seen = true;
        hear(&mut known, connected(&calibrated));
        assert!(!known.trusted(), "nor after a power-up");
        hear(&mut known, home_done(&unit));
        assert!(known.trusted());
    }
}
