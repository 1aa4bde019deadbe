//! The state of both devices, from their messages: identities and errors. What happens to the head is handed to
//! [`PositionTrust`].

use super::device_links::PortMessage;
use super::error::{Device, DeviceError};
use super::head::HeadEvent;
use super::port::PortEvent;
use super::port_config::PortConfig;
use super::position_trust::{PositionTrust, TrustEvent};
use crate::patrol::severity::Severity;
use ptu::HeadIdentity;
use scip::LaserIdentity;
use std::sync::mpsc::Sender;

/// An event of a device, for the log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceNote {
    /// Source of the event.
    pub device: Device,
    /// For the level of the log line.
    pub severity: Severity,
    /// What happened, without the device's name; one line.
    pub text: String,
}

/// The state of both devices.
#[derive(Debug)]
pub(crate) struct DeviceState {
    laser: Option<LaserIdentity>,
    head: Option<HeadIdentity>,
    laser_error: Option<DeviceError>,
    head_error: Option<DeviceError>,
    ports: (String, String),
    /// Trust the position at the first connection without homing.
    trust_as_found: bool,
    trust: PositionTrust,
    notes: Sender<DeviceNote>,
}

impl DeviceState {
    pub(super) fn new(
        laser: &PortConfig,
        head: &PortConfig,
        home_at_start: bool,
        trust: PositionTrust,
        notes: Sender<DeviceNote>,
    ) -> Self {
        Self {
            laser: None,
            head: None,
            laser_error: None,
            head_error: None,
            ports: (laser.name.clone(), head.name.clone()),
            trust_as_found: !home_at_start,
            trust,
            notes,
        }
    }

    /// For laser and head.
    pub(super) fn connected_or_failed(&self) -> (bool, bool) {
        (
            self.laser.is_some() || self.laser_error.is_some(),
            self.head.is_some() || self.head_error.is_some(),
        )
    }

    pub(super) fn has_failed(&self) -> bool {
        self.laser_error.is_some() || self.head_error.is_some()
    }

    /// Why each device is not connected: laser, head.
    pub(super) fn failures(&self) -> (Option<DeviceError>, Option<DeviceError>) {
        (self.laser().err(), self.head().err())
    }

    /// The error of a failed device; not of one that is connecting.
    pub(super) fn failure(&self) -> Option<DeviceError> {
        let laser = self.laser_error.as_ref();
        laser.or(self.head_error.as_ref()).cloned()
    }

    pub(super) fn laser(&self) -> Result<&LaserIdentity, DeviceError> {
        let error = || not_connected(Device::Laser, &self.ports.0, self.laser_error.as_ref());
        self.laser.as_ref().ok_or_else(error)
    }

    pub(super) fn head(&self) -> Result<&HeadIdentity, DeviceError> {
        let error = || not_connected(Device::Head, &self.ports.1, self.head_error.as_ref());
        self.head.as_ref().ok_or_else(error)
    }

    pub(super) fn is_position_trusted(&self) -> bool {
        self.head.is_some() && self.trust.is_trusted()
    }

    pub(super) fn distrust_reason(&self) -> &'static str {
        self.trust.reason()
    }

    /// The position is unknown until the calibration ends.
    pub(super) fn homing_started(&self) {
        self.trust.note(TrustEvent::HomingStarted);
    }

    /// Nobody watches the head from now on.
    pub(super) fn closed(&self, was_open: bool) {
        self.trust.note(TrustEvent::StationClosed { was_open });
    }

    /// Counts are no angles until the next calibration.
    pub(super) fn contradict(&self, why: &'static str) {
        self.trust.note(TrustEvent::Contradicted(why));
        self.warn_of_distrust();
    }

    fn warn_of_distrust(&self) {
        let text = format!("position not trusted: {}", self.trust.reason());
        self.warn(Device::Head, text);
    }

    pub(super) fn warn(&self, device: Device, text: String) {
        self.send_note(device, Severity::Warning, text);
    }

    fn send_note(&self, device: Device, severity: Severity, text: String) {
        // The receiver may be gone.
        let _ = self.notes.send(DeviceNote {
            device,
            severity,
            text,
        });
    }

    pub(super) fn handle_message(&mut self, message: &PortMessage) {
        match message {
            PortMessage::Laser(PortEvent::Lost { error, retry_in }) => {
                self.laser = None;
                self.send_lost_note(Device::Laser, error, retry_in.as_secs_f64());
                self.laser_error = Some(error.clone());
            }
            PortMessage::Head(PortEvent::Lost { error, retry_in }) => {
                self.head = None;
                self.trust.note(TrustEvent::PortLost);
                self.send_lost_note(Device::Head, error, retry_in.as_secs_f64());
                self.head_error = Some(error.clone());
            }
            PortMessage::Laser(PortEvent::Device(scip::LaserEvent::Connected(identity))) => {
                let text = format!(
                    "{} {} firmware {} on {}",
                    identity.product, identity.serial, identity.firmware, self.ports.0
                );
                self.send_note(Device::Laser, Severity::Info, text);
                self.laser = Some(identity.clone());
                self.laser_error = None;
            }
            // The port is back; the device is connecting.
            PortMessage::Laser(PortEvent::Opened) => self.laser_error = None,
            PortMessage::Head(PortEvent::Opened) => self.head_error = None,
            PortMessage::Laser(PortEvent::Device(scip::LaserEvent::BitRateKept { wanted })) => {
                self.warn(Device::Laser, bit_rate_kept(*wanted));
            }
            PortMessage::Laser(PortEvent::Device(_)) => {}
            PortMessage::Head(PortEvent::Device(HeadEvent::Ptu(event))) => {
                self.handle_head_event(event)
            }
            PortMessage::Head(PortEvent::Device(HeadEvent::Rejected(_))) => {}
        }
    }

    fn handle_head_event(&mut self, event: &ptu::PtuEvent) {
        use ptu::PtuEvent as E;
        match event {
            E::Connected(identity) => {
                let text = format!("{} on {}", identity.version, self.ports.1);
                self.send_note(Device::Head, Severity::Info, text);
                let was_out_of_sight = self.trust.is_out_of_sight();
                let was_trusted = was_out_of_sight || self.trust.is_trusted();
                self.trust.connected(identity, self.trust_as_found);
                self.head = Some((**identity).clone());
                self.head_error = None;
                let is_trusted = self.trust.is_trusted();
                if !is_trusted && (was_trusted || identity.calibration_seen) {
                    self.warn_of_distrust();
                }
                if was_out_of_sight && is_trusted {
                    let text = "kept its power; its position is trusted".to_owned();
                    self.send_note(Device::Head, Severity::Info, text);
                }
            }
            E::HomeDone { pan, tilt } => {
                if let Some(head) = &mut self.head {
                    (head.pan.limits, head.tilt.limits) = (*pan, *tilt);
                }
                self.trust.home_done(self.head.as_ref());
                if self.trust.is_trusted() {
                    self.send_note(Device::Head, Severity::Info, "homed".to_owned());
                } else {
                    self.warn_of_distrust();
                }
            }
            E::SpeedSet { axis, steps_per_s } => self.trust.record_speed(*axis, *steps_per_s),
            E::LimitHit(_) => self.contradict("an axis ran into its limit"),
            E::CableLost => self.contradict("the cable to the head came off"),
            E::EchoReturned | E::VerboseReturned | E::Restarted => {
                self.head = None;
                self.contradict("the unit restarted in between");
            }
            E::Fault(_) => self.contradict("its calibration failed"),
            _ => {}
        }
    }

    /// Speed settings that show later whether the head kept its power; `None`: not connected.
    pub(super) fn marker_speeds(&self) -> Option<[i32; 2]> {
        self.head
            .as_ref()
            .map(|head| self.trust.marker_speeds(head))
    }

    fn send_lost_note(&self, device: Device, error: &DeviceError, retry_s: f64) {
        let text = format!("{error}; reopening in {retry_s:.1} s");
        self.send_note(device, Severity::Error, text);
    }
}

fn bit_rate_kept(wanted_bit_s: u32) -> String {
    format!(
        "does not take {wanted_bit_s} bit/s and keeps its rate: its sweeps are planned for that"
    )
}

fn not_connected(device: Device, port: &str, error: Option<&DeviceError>) -> DeviceError {
    error.cloned().unwrap_or_else(|| DeviceError::NotConnected {
        device,
        port: port.to_owned(),
        detail: "connecting".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::{DeviceNote, DeviceState, PortMessage};
    use crate::config::SettingOrigins;
    use crate::devices::error::{Device, DeviceError};
    use crate::devices::head::HeadEvent;
    use crate::devices::lockstep::rig::TestRig;
    use crate::devices::port::PortEvent;
    use crate::devices::port_config::PortConfig;
    use crate::devices::position_trust::PositionTrust;
    use crate::patrol::severity::Severity;
    use ptu::{Axis, HeadIdentity, PtuEvent};
    use std::sync::mpsc;
    use std::time::Duration;

    fn port(device: Device) -> PortConfig {
        PortConfig {
            device,
            name: format!("/dev/{device}"),
            baud: 9600,
            unit: None,
            origins: SettingOrigins::default(),
        }
    }

    fn state_with(trust: &PositionTrust, notes: mpsc::Sender<DeviceNote>) -> DeviceState {
        let (laser, head) = (port(Device::Laser), port(Device::Head));
        DeviceState::new(&laser, &head, false, trust.clone(), notes)
    }

    fn unheard() -> mpsc::Sender<DeviceNote> {
        mpsc::channel().0
    }

    fn unit() -> HeadIdentity {
        let rig = TestRig::ready(patrold_sim::emulator::EmulationOptions::seeded(1));
        let mut unit = rig.identity.expect("connected");
        unit.calibration_seen = false;
        unit
    }

    fn receive(state: &mut DeviceState, event: PtuEvent) {
        state.handle_message(&PortMessage::Head(PortEvent::Device(HeadEvent::Ptu(event))));
    }

    fn connected(unit: &HeadIdentity) -> PtuEvent {
        PtuEvent::Connected(Box::new(unit.clone()))
    }

    fn home_done(unit: &HeadIdentity) -> PtuEvent {
        PtuEvent::HomeDone {
            pan: unit.pan.limits,
            tilt: unit.tilt.limits,
        }
    }

    #[test]
    fn a_laser_that_keeps_its_bit_rate_is_a_warning() {
        let (sender, notes) = mpsc::channel();
        let mut state = state_with(&PositionTrust::default(), sender);
        let kept = scip::LaserEvent::BitRateKept { wanted: 500_000 };
        state.handle_message(&PortMessage::Laser(PortEvent::Device(kept)));
        let note = notes.try_recv().expect("a note");
        assert_eq!(
            (note.device, note.severity),
            (Device::Laser, Severity::Warning)
        );
        assert!(note.text.contains("500000 bit/s"), "{}", note.text);
        assert!(notes.try_recv().is_err(), "only one");
    }

    #[test]
    fn distrust_outlives_the_station() {
        let unit = unit();
        for event in [
            PtuEvent::LimitHit(Axis::Pan),
            PtuEvent::CableLost,
            PtuEvent::Restarted,
        ] {
            let trust = PositionTrust::default();
            let mut first = state_with(&trust, unheard());
            receive(&mut first, connected(&unit));
            assert!(first.is_position_trusted(), "trusted as found");
            receive(&mut first, event.clone());
            drop(first);
            let mut second = state_with(&trust, unheard());
            receive(&mut second, connected(&unit));
            assert!(!second.is_position_trusted(), "{event:?}");
            receive(&mut second, home_done(&unit));
            assert!(second.is_position_trusted());
        }
    }

    #[test]
    fn a_unit_that_restarted_is_neither_connected_nor_trusted() {
        let unit = unit();
        for event in [
            PtuEvent::Restarted,
            PtuEvent::EchoReturned,
            PtuEvent::VerboseReturned,
        ] {
            let mut state = state_with(&PositionTrust::default(), unheard());
            receive(&mut state, connected(&unit));
            assert!(state.head().is_ok() && state.is_position_trusted());
            receive(&mut state, event.clone());
            assert!(state.head().is_err(), "{event:?}");
            receive(&mut state, connected(&unit));
            assert!(!state.is_position_trusted(), "{event:?}");
            assert!(state.distrust_reason().contains("restarted"), "{event:?}");
        }
    }

    #[test]
    fn a_device_is_connecting_connected_or_failed() {
        let rig = TestRig::ready(patrold_sim::emulator::EmulationOptions::seeded(1));
        let laser = rig.laser_identity.expect("connected");
        let head = connected(&unit());
        let error = DeviceError::Cancelled;
        let retry_in = Duration::ZERO;
        let laser_lost = PortMessage::Laser(PortEvent::Lost {
            error: error.clone(),
            retry_in,
        });
        let head_lost = PortMessage::Head(PortEvent::Lost {
            error: error.clone(),
            retry_in,
        });
        let mut state = state_with(&PositionTrust::default(), unheard());
        assert_eq!(state.connected_or_failed(), (false, false));
        let laser = PortMessage::Laser(PortEvent::Device(scip::LaserEvent::Connected(laser)));
        state.handle_message(&laser);
        assert_eq!(state.connected_or_failed(), (true, false));
        receive(&mut state, head.clone());
        assert_eq!(state.connected_or_failed(), (true, true));
        assert!(!state.has_failed() && state.failures() == (None, None));
        state.handle_message(&laser_lost);
        assert_eq!(state.connected_or_failed(), (true, true));
        assert!(state.has_failed() && state.laser().is_err() && state.head().is_ok());
        // The port is back: the device is connecting.
        state.handle_message(&PortMessage::Laser(PortEvent::Opened));
        assert_eq!(state.connected_or_failed(), (false, true));
        assert_eq!(state.failure(), None);
        state.handle_message(&head_lost);
        assert_eq!(state.failure(), Some(error));
        state.handle_message(&PortMessage::Head(PortEvent::Opened));
        assert_eq!(state.connected_or_failed(), (false, false));
        // Each is connected without its port being reported open.
        state.handle_message(&laser_lost);
        state.handle_message(&head_lost);
        state.handle_message(&laser);
        receive(&mut state, head);
        assert!(!state.has_failed());
    }

    #[test]
    fn a_position_that_was_never_trusted_is_no_news() {
        let unit = unit();
        let (notes, heard) = mpsc::channel();
        let mut state = state_with(&PositionTrust::default(), notes);
        state.trust_as_found = false;
        let warnings = || {
            let notes: Vec<_> = heard.try_iter().collect();
            let warned = |note: &&DeviceNote| note.severity == Severity::Warning;
            notes.iter().filter(warned).count()
        };
        receive(&mut state, connected(&unit));
        assert_eq!((state.is_position_trusted(), warnings()), (false, 0));
        receive(&mut state, home_done(&unit));
        assert_eq!((state.is_position_trusted(), warnings()), (true, 0));
        // A new one without its marks lost its power.
        receive(&mut state, connected(&unit));
        assert_eq!((state.is_position_trusted(), warnings()), (false, 1));
        receive(&mut state, connected(&unit));
        assert_eq!(warnings(), 0);
    }

    #[test]
    fn only_a_head_that_was_out_of_sight_is_reported_to_have_kept_its_power() {
        let unit = unit();
        let (notes, heard) = mpsc::channel();
        let mut state = state_with(&PositionTrust::default(), notes);
        let kept_notes = || {
            let kept = |note: &DeviceNote| note.text.contains("kept its power");
            heard.try_iter().filter(kept).count()
        };
        receive(&mut state, connected(&unit));
        assert_eq!((state.is_position_trusted(), kept_notes()), (true, 0));
        let [pan, tilt] = state.marker_speeds().expect("connected");
        let mut marked = unit.clone();
        (marked.pan.speed, marked.tilt.speed) = (pan, tilt);
        for (axis, limits) in [(Axis::Pan, unit.pan), (Axis::Tilt, unit.tilt)] {
            let steps_per_s = if axis == Axis::Pan { pan } else { tilt };
            assert!((limits.speed_min..=limits.speed_max).contains(&steps_per_s));
            receive(&mut state, PtuEvent::SpeedSet { axis, steps_per_s });
        }
        let lost = PortMessage::Head(PortEvent::Lost {
            error: DeviceError::Cancelled,
            retry_in: Duration::ZERO,
        });
        for (found, kept) in [(&marked, 1), (&unit, 0)] {
            state.handle_message(&lost);
            receive(&mut state, connected(found));
            assert_eq!(
                (state.is_position_trusted(), kept_notes()),
                (kept == 1, kept)
            );
        }
    }

    #[test]
    fn distrust_after_a_lost_port_or_unfinished_homing_outlives_the_station() {
        let unit = unit();
        let error = DeviceError::Cancelled;
        let lost = PortMessage::Head(PortEvent::Lost {
            error,
            retry_in: Duration::ZERO,
        });
        let trust = PositionTrust::default();
        let mut absent = state_with(&trust, unheard());
        absent.handle_message(&lost);
        let mut first = state_with(&trust, unheard());
        receive(&mut first, connected(&unit));
        assert!(
            first.is_position_trusted(),
            "a port that was never open changes nothing"
        );
        first.handle_message(&lost);
        let mut second = state_with(&trust, unheard());
        receive(&mut second, connected(&unit));
        assert!(!second.is_position_trusted());

        let trust = PositionTrust::default();
        state_with(&trust, unheard()).homing_started();
        let mut second = state_with(&trust, unheard());
        receive(&mut second, connected(&unit));
        assert!(!second.is_position_trusted());
    }

    #[test]
    fn a_head_that_kept_its_power_is_trusted_as_before_its_port_was_lost() {
        let lost = PortMessage::Head(PortEvent::Lost {
            error: DeviceError::Cancelled,
            retry_in: Duration::ZERO,
        });
        let unit = unit();
        let mut kept = unit.clone();
        for limit_hit in [false, true] {
            let trust = PositionTrust::default();
            let mut state = state_with(&trust, unheard());
            receive(&mut state, connected(&unit));
            let [pan, tilt] = state.marker_speeds().expect("connected");
            for (axis, steps_per_s) in [(Axis::Pan, pan), (Axis::Tilt, tilt)] {
                receive(&mut state, PtuEvent::SpeedSet { axis, steps_per_s });
            }
            (kept.pan.speed, kept.tilt.speed) = (pan, tilt);
            if limit_hit {
                receive(&mut state, PtuEvent::LimitHit(Axis::Pan));
            }
            state.handle_message(&lost);
            assert!(!state.is_position_trusted() && !trust.is_trusted());
            receive(&mut state, connected(&kept));
            assert_eq!(
                (state.is_position_trusted(), trust.is_trusted()),
                (!limit_hit, !limit_hit)
            );
            state.handle_message(&lost);
            receive(&mut state, connected(&unit));
            assert!(!state.is_position_trusted(), "speeds of a power-up");
            receive(&mut state, connected(&kept));
            assert!(!state.is_position_trusted(), "nor later");
        }
    }

    #[test]
    fn only_the_first_station_trusts_the_head_as_found() {
        let unit = unit();
        let trust = PositionTrust::default();
        let mut first = state_with(&trust, unheard());
        receive(&mut first, connected(&unit));
        first.closed(false);
        let mut next = state_with(&trust, unheard());
        receive(&mut next, connected(&unit));
        assert!(
            next.is_position_trusted(),
            "one that never opened moved nothing"
        );
        next.closed(true);
        let mut second = state_with(&trust, unheard());
        receive(&mut second, connected(&unit));
        assert!(!second.is_position_trusted());
    }

    #[test]
    fn a_limit_hit_while_connecting_prevents_trust() {
        let mut state = state_with(&PositionTrust::default(), unheard());
        receive(&mut state, PtuEvent::LimitHit(Axis::Tilt));
        receive(&mut state, connected(&unit()));
        assert!(!state.is_position_trusted());
    }

    #[test]
    fn a_calibration_that_moves_the_limits_is_not_trusted() {
        let unit = unit();
        let trust = PositionTrust::default();
        let mut state = state_with(&trust, unheard());
        receive(&mut state, connected(&unit));
        let mut calibrated = unit.clone();
        calibrated.pan.limits.max_steps -= 20;
        receive(&mut state, home_done(&calibrated));
        assert!(state.is_position_trusted(), "they move by a few counts");
        calibrated.pan.limits.max_steps -= 1;
        receive(&mut state, home_done(&calibrated));
        assert!(!state.is_position_trusted() && state.distrust_reason().contains("in its way"));
        calibrated.calibration_seen = true;
        receive(&mut state, connected(&calibrated));
        assert!(!state.is_position_trusted(), "nor after a power-up");
        receive(&mut state, home_done(&unit));
        assert!(state.is_position_trusted());
    }
}
