//! Laser and head as one object with blocking calls.

mod home;
mod park;
mod record;
mod start_pose;
mod travel;
mod watch;

use self::start_pose::StartPose;
use super::cancel::Cancel;
use super::constants::{CONNECT_LIMIT, DEVICES_READY_LIMIT, HEALTH_LIMIT};
use super::device_links::{DeviceLinks, PortMessage, PortThreads};
use super::device_state::{DeviceNote, DeviceState};
use super::error::{Device, DeviceError};
use super::head::{HeadCommand, HeadEvent};
use super::plan::{HeadFacts, LaserFacts, SweepPlan, SweepRequest};
use super::port::PortEvent;
use super::port_config::{PortConfig, configured_ports};
use super::position_trust::PositionTrust;
use super::recording::{DialogueEnd, DialogueEntryKind, DialogueTap, encode_plan};
use super::report::{DeviceSurvey, DevicesReport, HeadReport, LaserReport};
use super::sweep_run::{PortNames, SweepAction, SweepRun};
use crate::config::{PtuConfig, Settings};
use link::Clock;
use patrold_engine::sweep::RawSweep;
use std::sync::mpsc::Sender;
use std::time::Duration;

/// Laser and head, connected. Dropping it turns the laser off, halts the head and closes both ports within a second.
#[derive(Debug)]
pub struct Station {
    links: Box<dyn DeviceLinks>,
    state: DeviceState,
    laser_port: PortConfig,
    head_port: PortConfig,
    ptu: PtuConfig,
    /// Start of the last successful sweep.
    last_start: Option<StartPose>,
    /// Both devices were connected once.
    was_open: bool,
    /// The dialogue of the last sweep, if it was recorded.
    dialogue: Option<Vec<u8>>,
}

impl Station {
    /// Opens both ports and waits until both devices are connected, also for a head that is calibrating. Does not home: see
    /// [`home_if_needed`](Self::home_if_needed).
    ///
    /// # Errors
    /// The first device that failed; [`DeviceError::Cancelled`].
    pub fn open(
        settings: &Settings,
        clock: Clock,
        notes: Sender<DeviceNote>,
        cancel: &Cancel,
    ) -> Result<Self, DeviceError> {
        Self::open_with_trust(settings, clock, notes, &PositionTrust::default(), cancel)
    }

    /// As [`open`](Self::open), with the `trust` of former stations: only the first opened station may trust the position as
    /// found.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_with_trust(
        settings: &Settings,
        clock: Clock,
        notes: Sender<DeviceNote>,
        trust: &PositionTrust,
        cancel: &Cancel,
    ) -> Result<Self, DeviceError> {
        let (laser, head) = configured_ports(settings);
        let links = Box::new(PortThreads::spawn(laser, head, clock)?);
        Self::open_with_links(links, settings, notes, trust, cancel)
    }

    /// As [`open_with_trust`](Self::open_with_trust), over existing links.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub(crate) fn open_with_links(
        links: Box<dyn DeviceLinks>,
        settings: &Settings,
        notes: Sender<DeviceNote>,
        trust: &PositionTrust,
        cancel: &Cancel,
    ) -> Result<Self, DeviceError> {
        let mut station = Self::with_links(links, settings, notes, trust);
        station.wait_for_both(false, cancel)?;
        if let Some(error) = station.state.failure() {
            return Err(error);
        }
        match station.state.failures() {
            (Some(error), _) | (None, Some(error)) => Err(error),
            (None, None) => {
                station.was_open = true;
                Ok(station)
            }
        }
    }

    /// The device on each port, or its error, and how a sweep on them differs from the configured one.
    ///
    /// # Errors
    /// [`DeviceError::NoThread`] and [`DeviceError::Cancelled`] only.
    pub fn survey(
        settings: &Settings,
        clock: Clock,
        notes: Sender<DeviceNote>,
        cancel: &Cancel,
    ) -> Result<DeviceSurvey, DeviceError> {
        let (laser, head) = configured_ports(settings);
        let links = Box::new(PortThreads::spawn(laser, head, clock)?);
        let mut station = Self::with_links(links, settings, notes, &PositionTrust::default());
        station.wait_for_both(true, cancel)?;
        let (laser, head) = station.state.failures();
        let laser = laser.map_or_else(|| station.laser_report(), Err);
        let ptu = head.map_or_else(|| station.head_report(cancel), Err);
        let request = SweepRequest::new(settings, None);
        let sweep_notes = match (&laser, &ptu) {
            (Ok(_), Ok(_)) => match station.plan(&request) {
                Ok(plan) => plan.notes,
                Err(error) => vec![error.to_string()],
            },
            _ => Vec::new(),
        };
        Ok(DeviceSurvey {
            laser,
            ptu,
            sweep_notes,
        })
    }

    fn with_links(
        links: Box<dyn DeviceLinks>,
        settings: &Settings,
        notes: Sender<DeviceNote>,
        trust: &PositionTrust,
    ) -> Self {
        let (laser_port, head_port) = configured_ports(settings);
        let state = DeviceState::new(
            &laser_port,
            &head_port,
            settings.ptu.home_at_start,
            trust.clone(),
            notes,
        );
        Self {
            links,
            state,
            laser_port,
            head_port,
            ptu: settings.ptu.clone(),
            last_start: None,
            was_open: false,
            dialogue: None,
        }
    }

    /// Until both are connected or one has failed; with `each`, until each is connected or has failed.
    fn wait_for_both(&mut self, each: bool, cancel: &Cancel) -> Result<(), DeviceError> {
        let until = self.links.now() + DEVICES_READY_LIMIT;
        while self.links.now() < until {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            let (laser, head) = self.state.connected_or_failed();
            let failed = self.state.has_failed();
            if (laser && head) || (failed && !each) {
                return Ok(());
            }
            self.next_message(until);
        }
        Ok(())
    }

    /// Waits for the next message and updates the state; `None`: nothing arrived within the interval of cancellation checks.
    fn next_message(&mut self, until: Duration) -> Option<PortMessage> {
        let message = self.links.recv(until)?;
        self.state.handle_message(&message);
        Some(message)
    }

    /// Processes the messages that have arrived.
    fn process_pending(&mut self) {
        while let Some(message) = self.links.try_recv() {
            self.state.handle_message(&message);
        }
    }

    /// Identity and health of both devices. Reads supply voltage and temperatures of the head.
    ///
    /// # Errors
    /// A device is not connected; [`DeviceError::Cancelled`].
    pub fn describe(&mut self, cancel: &Cancel) -> Result<DevicesReport, DeviceError> {
        self.wait_connected(cancel)?;
        Ok(DevicesReport {
            laser: self.laser_report()?,
            ptu: self.head_report(cancel)?,
        })
    }

    fn laser_report(&mut self) -> Result<LaserReport, DeviceError> {
        let identity = self.state.laser()?;
        Ok(LaserReport::new(&self.laser_port.name, identity))
    }

    fn head_report(&mut self, cancel: &Cancel) -> Result<HeadReport, DeviceError> {
        self.links.send_head(HeadCommand::QueryHealth);
        let until = self.links.now() + HEALTH_LIMIT;
        let mut health = None;
        while self.links.now() < until {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            match self.next_message(until) {
                Some(PortMessage::Head(PortEvent::Device(HeadEvent::Ptu(
                    ptu::PtuEvent::Health(got),
                )))) => {
                    health = Some(got);
                    break;
                }
                // The unit does not report its health.
                Some(PortMessage::Head(PortEvent::Device(HeadEvent::Ptu(
                    ptu::PtuEvent::Refused { .. },
                )))) => break,
                _ => {}
            }
        }
        let trusted = self.state.is_position_trusted();
        let identity = self.state.head()?;
        Ok(HeadReport::new(
            &self.head_port.name,
            identity,
            health.as_ref(),
            trusted,
        ))
    }

    /// Takes one sweep. The laser is off and the head has stopped when this returns, also after an error.
    ///
    /// # Errors
    /// A device is not connected or failed, the position is not trusted, or angles are out of reach;
    /// [`DeviceError::Cancelled`].
    pub fn sweep(
        &mut self,
        request: &SweepRequest,
        cancel: &Cancel,
    ) -> Result<RawSweep, DeviceError> {
        self.wait_connected(cancel)?;
        self.check_trust()?;
        let plan = self.plan(request)?;
        for text in &plan.notes {
            self.state.warn(Device::Head, text.clone());
        }
        let names = PortNames {
            laser: self.laser_port.name.clone(),
            head: self.head_port.name.clone(),
        };
        let start = StartPose::of_sweep(&plan);
        let encoded_plan = encode_plan(&plan, &names);
        let (began_at, tap) = self.begin_recording()?;
        let mut run = SweepRun::new(plan, names, began_at);
        let outcome = self.run_sweep(&mut run, &tap, cancel);
        let end = match &outcome {
            Ok(_) => DialogueEnd::Complete,
            Err(error) => DialogueEnd::Failed(error.to_string()),
        };
        self.dialogue = tap.finish(&encoded_plan, end);
        if let Err(error) = &outcome {
            self.note_failed_move(error);
        }
        self.last_start = start.filter(|_| outcome.is_ok());
        outcome
    }

    fn run_sweep(
        &mut self,
        run: &mut SweepRun,
        tap: &DialogueTap,
        cancel: &Cancel,
    ) -> Result<RawSweep, DeviceError> {
        use DialogueEntryKind as Kind;
        loop {
            self.process_actions(run);
            if let Some(outcome) = run.take_outcome() {
                return outcome;
            }
            if cancel.is_cancelled() {
                let now = self.links.now();
                tap.note_sweep(Device::Laser, &Kind::Cancelled, now);
                run.cancel(now);
                self.process_actions(run);
            }
            let message = self.next_message(run.deadline());
            let now = self.links.now();
            match message {
                Some(PortMessage::Laser(PortEvent::Device(event))) => {
                    tap.note_sweep(Device::Laser, &Kind::EventHandled, now);
                    run.on_laser(event, now);
                }
                Some(PortMessage::Head(PortEvent::Device(event))) => {
                    tap.note_sweep(Device::Head, &Kind::EventHandled, now);
                    run.on_head(event, now);
                }
                Some(PortMessage::Laser(PortEvent::Lost { error, .. })) => {
                    tap.note_sweep(Device::Laser, &Kind::PortLost, now);
                    run.on_lost(Device::Laser, error, now);
                }
                Some(PortMessage::Head(PortEvent::Lost { error, .. })) => {
                    tap.note_sweep(Device::Head, &Kind::PortLost, now);
                    run.on_lost(Device::Head, error, now);
                }
                Some(
                    PortMessage::Laser(PortEvent::Opened) | PortMessage::Head(PortEvent::Opened),
                )
                | None => {}
            }
            if now >= run.deadline() {
                tap.note_sweep(Device::Laser, &Kind::SweepDeadline, now);
                run.on_time(now);
            }
        }
    }

    /// A move that did not go as commanded leaves the axis anywhere.
    fn note_failed_move(&self, error: &DeviceError) {
        if let Some(why) = error.contradicts_position() {
            self.state.contradict(why);
        }
    }

    fn check_trust(&self) -> Result<(), DeviceError> {
        if self.state.is_position_trusted() {
            return Ok(());
        }
        Err(DeviceError::PositionLost {
            port: self.head_port.name.clone(),
            detail: self.state.distrust_reason().to_owned(),
        })
    }

    fn process_actions(&mut self, run: &mut SweepRun) {
        while let Some(action) = run.poll_action() {
            match action {
                SweepAction::Laser(command) => self.links.send_laser(command),
                SweepAction::Head(command) => self.links.send_head(command),
                SweepAction::Note(device, text) => self.state.warn(device, text),
            }
        }
    }

    fn plan(&mut self, request: &SweepRequest) -> Result<SweepPlan, DeviceError> {
        let laser = LaserFacts::new(self.state.laser()?);
        SweepPlan::new(
            request,
            &HeadFacts {
                identity: self.state.head()?,
                settings: &self.ptu,
                port: &self.head_port.name,
            },
            laser,
        )
    }

    /// Waits until both devices are connected.
    fn wait_connected(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        self.process_pending();
        let until = self.links.now() + CONNECT_LIMIT;
        loop {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            if self.state.laser().is_ok() && self.state.head().is_ok() {
                return Ok(());
            }
            if self.links.now() >= until {
                self.state.laser()?;
                self.state.head()?;
                return Ok(());
            }
            self.next_message(until);
        }
    }
}

impl Drop for Station {
    fn drop(&mut self) {
        self.process_pending();
        self.state.closed(self.was_open);
    }
}
