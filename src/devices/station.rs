//! Both devices as one object with blocking calls, for the service and the command line.

mod home;
mod park;
mod travel;
mod watch;

use self::travel::Stance;
use super::cancel::Cancel;
use super::constants::{BITS_PER_BYTE, CONNECT_LIMIT, HEALTH_LIMIT, OPEN_LIMIT};
use super::error::{Device, DeviceError};
use super::head::{HeadCommand, HeadEvent};
use super::head_memory::HeadMemory;
use super::known::{DeviceNote, Known};
use super::plan::{HeadFacts, LaserFacts, SweepPlan, SweepRequest};
use super::port::PortEvent;
use super::port_name::{Line, PortName, ports};
use super::report::{DevicesReport, HeadReport, LaserReport};
use super::sweep_run::{PortNames, RunAction, SweepRun};
use super::wires::{PortThreads, Told, Wires};
use crate::config::{PtuSettings, Settings};
use link::Clock;
use patrold_engine::sweep::RawSweep;
use std::sync::mpsc::Sender;
use std::time::Duration;

/// Laser and head, connected. Dropping it turns the laser off, halts the head and closes both ports within a second.
#[derive(Debug)]
pub struct Station {
    wires: Box<dyn Wires>,
    known: Known,
    laser_port: PortName,
    head_port: PortName,
    ptu: PtuSettings,
    /// Where the last sweep that succeeded began.
    begun_at: Option<Stance>,
}

impl Station {
    /// Opens both ports and waits until both devices are known; the head may be found calibrating, which is waited for.
    /// It does not home: see [`position_trusted`](Self::position_trusted).
    ///
    /// # Errors
    /// The first device that cannot be had, with what to do; [`DeviceError::Cancelled`] soon after `cancel` was set.
    pub fn open(
        settings: &Settings,
        clock: Clock,
        notes: Sender<DeviceNote>,
        cancel: &Cancel,
    ) -> Result<Self, DeviceError> {
        Self::open_again(settings, clock, notes, &HeadMemory::default(), cancel)
    }

    /// As [`open`](Self::open), with what former stations left in `memory`: a doubt of theirs stays one, and only the
    /// first station that opened takes the head as it is found.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_again(
        settings: &Settings,
        clock: Clock,
        notes: Sender<DeviceNote>,
        memory: &HeadMemory,
        cancel: &Cancel,
    ) -> Result<Self, DeviceError> {
        let (laser, head) = ports(settings);
        let wires = Box::new(PortThreads::spawn(laser, head, clock)?);
        Self::open_over(wires, settings, notes, memory, cancel)
    }

    /// As [`open_again`](Self::open_again), over wires that are there already.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub(crate) fn open_over(
        wires: Box<dyn Wires>,
        settings: &Settings,
        notes: Sender<DeviceNote>,
        memory: &HeadMemory,
        cancel: &Cancel,
    ) -> Result<Self, DeviceError> {
        let mut station = Self::begin(wires, settings, notes, memory);
        station.wait_for_both(false, cancel)?;
        if let Some(error) = station.known.failure() {
            return Err(error);
        }
        match station.known.failures() {
            (Some(error), _) | (None, Some(error)) => Err(error),
            (None, None) => {
                memory.opened();
                Ok(station)
            }
        }
    }

    /// Who answers on the two ports, each by itself: one device's failure does not hide the other.
    ///
    /// # Errors
    /// Only [`DeviceError::NoThread`] and [`DeviceError::Cancelled`]; what is wrong with a device stands in its place.
    #[allow(
        clippy::type_complexity,
        reason = "two answers, each with its own way to fail"
    )]
    pub fn survey(
        settings: &Settings,
        clock: Clock,
        notes: Sender<DeviceNote>,
        cancel: &Cancel,
    ) -> Result<
        (
            Result<LaserReport, DeviceError>,
            Result<HeadReport, DeviceError>,
        ),
        DeviceError,
    > {
        let (laser, head) = ports(settings);
        let wires = Box::new(PortThreads::spawn(laser, head, clock)?);
        let mut station = Self::begin(wires, settings, notes, &HeadMemory::default());
        station.wait_for_both(true, cancel)?;
        let (laser, head) = station.known.failures();
        Ok((
            laser.map_or_else(|| station.laser_report(), Err),
            head.map_or_else(|| station.head_report(cancel), Err),
        ))
    }

    fn begin(
        wires: Box<dyn Wires>,
        settings: &Settings,
        notes: Sender<DeviceNote>,
        memory: &HeadMemory,
    ) -> Self {
        let (laser_port, head_port) = ports(settings);
        let known = Known::new(
            &laser_port,
            &head_port,
            settings.ptu.home_at_start,
            memory.clone(),
            notes,
        );
        Self {
            wires,
            known,
            laser_port,
            head_port,
            ptu: settings.ptu.clone(),
            begun_at: None,
        }
    }

    /// Until both are known or one (`each`: both) failed.
    fn wait_for_both(&mut self, each: bool, cancel: &Cancel) -> Result<(), DeviceError> {
        let until = self.wires.now() + OPEN_LIMIT;
        while self.wires.now() < until {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            let (laser, head) = self.known.settled();
            let failed = self.known.has_failed();
            if (laser && head) || (failed && !each) {
                return Ok(());
            }
            self.next(until);
        }
        Ok(())
    }

    /// The next event, taken note of; `None` if none came within the time between two looks at a cancelled flag.
    fn next(&mut self, until: Duration) -> Option<Told> {
        let told = self.wires.next(until)?;
        self.known.note(&told);
        Some(told)
    }

    /// Takes note of what came while nobody asked.
    fn catch_up(&mut self) {
        while let Some(told) = self.wires.heard() {
            self.known.note(&told);
        }
    }

    /// Whether the head's counts stand for angles: after a calibration seen to end, or from the beginning where the
    /// configuration says not to home; never after a limit was hit, the unit restarted or its port was lost.
    pub fn position_trusted(&mut self) -> bool {
        self.catch_up();
        self.known.trusted()
    }

    /// Who both devices are and how they are. Asks the head for supply and temperature.
    ///
    /// # Errors
    /// A device that is not connected, or does not answer; [`DeviceError::Cancelled`] soon after `cancel` was set.
    pub fn describe(&mut self, cancel: &Cancel) -> Result<DevicesReport, DeviceError> {
        self.be_connected(cancel)?;
        Ok(DevicesReport {
            laser: self.laser_report()?,
            ptu: self.head_report(cancel)?,
        })
    }

    fn laser_report(&mut self) -> Result<LaserReport, DeviceError> {
        let identity = self.known.laser()?;
        Ok(LaserReport::new(&self.laser_port.name, identity))
    }

    fn head_report(&mut self, cancel: &Cancel) -> Result<HeadReport, DeviceError> {
        self.wires.head(HeadCommand::QueryHealth);
        let until = self.wires.now() + HEALTH_LIMIT;
        let mut health = None;
        while self.wires.now() < until {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            match self.next(until) {
                Some(Told::Head(PortEvent::Device(HeadEvent::Unit(ptu::Event::Health(got))))) => {
                    health = Some(got);
                    break;
                }
                // A unit that does not tell.
                Some(Told::Head(PortEvent::Device(HeadEvent::Unit(ptu::Event::Refused {
                    ..
                })))) => break,
                _ => {}
            }
        }
        let trusted = self.known.trusted();
        let identity = self.known.head()?;
        Ok(HeadReport::new(
            &self.head_port.name,
            identity,
            health.as_ref(),
            trusted,
        ))
    }

    /// One sweep. Whatever ends it, the laser is off and the head stands when this returns.
    ///
    /// # Errors
    /// Why there is none; [`DeviceError::Cancelled`] soon after `cancel` was set.
    pub fn sweep(
        &mut self,
        request: &SweepRequest,
        cancel: &Cancel,
    ) -> Result<RawSweep, DeviceError> {
        self.be_connected(cancel)?;
        self.check_trust()?;
        let plan = self.plan(request)?;
        for text in &plan.notes {
            self.known.warn(Device::Head, text.clone());
        }
        let names = PortNames {
            laser: self.laser_port.name.clone(),
            head: self.head_port.name.clone(),
        };
        let begins_at = Stance::before(&plan);
        let mut run = SweepRun::new(plan, names, self.wires.now());
        loop {
            self.carry_out(&mut run);
            if let Some(outcome) = run.take_outcome() {
                if matches!(outcome, Err(DeviceError::Stalled { .. })) {
                    self.known.distrusted("an axis stalled");
                }
                self.begun_at = begins_at.filter(|_| outcome.is_ok());
                return outcome;
            }
            if cancel.is_cancelled() {
                run.cancel(self.wires.now());
                self.carry_out(&mut run);
            }
            let told = self.next(run.deadline());
            let now = self.wires.now();
            match told {
                Some(Told::Laser(PortEvent::Device(event))) => run.on_laser(event, now),
                Some(Told::Head(PortEvent::Device(event))) => run.on_head(event, now),
                Some(Told::Laser(PortEvent::Lost { error, .. })) => {
                    run.on_lost(Device::Laser, error, now);
                }
                Some(Told::Head(PortEvent::Lost { error, .. })) => {
                    run.on_lost(Device::Head, error, now);
                }
                Some(Told::Laser(PortEvent::Opened) | Told::Head(PortEvent::Opened)) | None => {}
            }
            run.on_time(now);
        }
    }

    fn check_trust(&self) -> Result<(), DeviceError> {
        if self.known.trusted() {
            return Ok(());
        }
        Err(DeviceError::PositionLost {
            port: self.head_port.name.clone(),
            detail: self.known.distrust().to_owned(),
        })
    }

    fn carry_out(&mut self, run: &mut SweepRun) {
        while let Some(action) = run.poll_action() {
            match action {
                RunAction::Laser(command) => self.wires.laser(command),
                RunAction::Head(command) => self.wires.head(command),
                RunAction::Note(device, text) => self.known.warn(device, text),
            }
        }
    }

    fn plan(&mut self, request: &SweepRequest) -> Result<SweepPlan, DeviceError> {
        let parameters = self.known.laser()?.parameters;
        // On RS-232 the rate in use may be another one of the search; the configured one is what people meant.
        let paced = self.laser_port.line() == Line::Rs232;
        let line_bytes_s = paced.then_some(self.laser_port.baud / BITS_PER_BYTE);
        SweepPlan::new(
            request,
            &HeadFacts {
                identity: self.known.head()?,
                settings: &self.ptu,
                port: &self.head_port.name,
            },
            LaserFacts {
                parameters,
                line_bytes_s,
            },
        )
    }

    /// Both connected, if need be after a wait.
    fn be_connected(&mut self, cancel: &Cancel) -> Result<(), DeviceError> {
        self.catch_up();
        let until = self.wires.now() + CONNECT_LIMIT;
        loop {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            if self.known.laser().is_ok() && self.known.head().is_ok() {
                return Ok(());
            }
            if self.wires.now() >= until {
                self.known.laser()?;
                self.known.head()?;
                return Ok(());
            }
            self.next(until);
        }
    }
}

impl Drop for Station {
    fn drop(&mut self) {
        // What nobody asked about is remembered all the same.
        self.catch_up();
    }
}
