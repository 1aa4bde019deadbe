//! The station's wires in virtual time: both drivers against both twins, ports that are lost and opened anew as their
//! threads would, no thread and no sleep. Several stations, one after the other, hang on the same devices.

use crate::devices::constants::{ABSENT_RETRY, BACKOFF, CANCEL_CHECK, CLOSE_LIMIT};
use crate::devices::driver::{Driver, Output};
use crate::devices::error::{Device, DeviceError, PortError};
use crate::devices::head::{HeadCommand, HeadDriver};
use crate::devices::laser::{LaserCommand, LaserDriver};
use crate::devices::port::PortEvent;
use crate::devices::port_name::PortName;
use crate::devices::wires::{Told, Wires};
use patrold_sim::emulator::Emulation;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The emulated devices, the time, and whatever hangs on their ports now. Copies share all of it.
#[derive(Debug, Clone)]
pub struct Devices(Arc<Mutex<Core>>);

#[derive(Debug)]
struct Core {
    emulation: Emulation,
    now: Duration,
    laser: Option<Line<LaserDriver>>,
    head: Option<Line<HeadDriver>>,
    told: VecDeque<Told>,
    later: Later,
}

/// What happens to the world, and when; in order of time.
#[derive(Default)]
struct Later(VecDeque<(Duration, Happen)>);

type Happen = Box<dyn FnOnce(&mut Emulation) + Send>;

impl std::fmt::Debug for Later {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} to come", self.0.len())
    }
}

/// One port: open with its driver, or closed until an instant.
#[derive(Debug)]
struct Line<D> {
    name: PortName,
    driver: Option<D>,
    open_at: Duration,
    backoff: Duration,
}

impl<D: Driver> Line<D> {
    fn new(device: Device, now: Duration) -> Self {
        Self {
            name: PortName {
                device,
                name: format!("/dev/pts/{device}"),
                baud: 9600,
                unit: None,
            },
            driver: None,
            open_at: now,
            backoff: BACKOFF.0,
        }
    }

    /// When it wants to be looked at.
    fn deadline(&self) -> Option<Duration> {
        match &self.driver {
            Some(driver) => driver.deadline(),
            None => Some(self.open_at),
        }
    }

    fn close(&mut self, error: DeviceError, now: Duration) -> PortEvent<D::Event> {
        let most = if error.is_absence() {
            ABSENT_RETRY
        } else {
            BACKOFF.1
        };
        let retry_in = self.backoff.min(most);
        self.driver = None;
        self.open_at = now + retry_in;
        self.backoff = (2 * self.backoff).min(BACKOFF.1);
        PortEvent::Lost { error, retry_in }
    }

    /// Opens or loses the port, as its plug has it.
    fn look(&mut self, is_in: bool, now: Duration) -> Option<PortEvent<D::Event>> {
        let port_error = |source| DeviceError::Port {
            device: self.name.device,
            source,
        };
        match (&self.driver, is_in) {
            (Some(_), false) => {
                let gone = format!("{} has gone", self.name.name);
                Some(self.close(port_error(PortError::Gone(gone)), now))
            }
            (None, false) if now >= self.open_at => {
                let absent = format!("no device at {}", self.name.name);
                Some(self.close(port_error(PortError::NoSuchPort(absent)), now))
            }
            (None, true) if now >= self.open_at => {
                let mut driver = D::new(&self.name, self.name.baud, false);
                driver.connect(now);
                self.driver = Some(driver);
                Some(PortEvent::Opened)
            }
            _ => None,
        }
    }

    /// The driver's outputs: bytes through `send`, events told. A fault closes the port after the last words.
    fn drain(
        &mut self,
        now: Duration,
        mut send: impl FnMut(&[u8]),
        mut tell: impl FnMut(PortEvent<D::Event>),
    ) {
        let mut end = None;
        while let Some(output) = self.driver.as_mut().and_then(Driver::poll) {
            match output {
                Output::Send(bytes) => send(&bytes),
                Output::Event(_) if end.is_some() => {}
                Output::Event(event) => {
                    if D::is_proof_of_life(&event) {
                        self.backoff = BACKOFF.0;
                    }
                    end = D::fault(&event, &self.name);
                    if end.is_none() {
                        tell(PortEvent::Device(event));
                    }
                }
            }
        }
        if let Some(error) = end {
            tell(self.close(error, now));
        }
    }
}

impl Core {
    fn drain(&mut self) {
        let (now, emulation, told) = (self.now, &mut self.emulation, &mut self.told);
        if let Some(line) = &mut self.laser {
            let seen = line.look(emulation.laser_plugged_in(), now);
            told.extend(seen.map(Told::Laser));
            line.drain(
                now,
                |bytes| emulation.handle_laser_bytes(bytes, now),
                |event| told.push_back(Told::Laser(event)),
            );
        }
        if let Some(line) = &mut self.head {
            let seen = line.look(emulation.head_plugged_in(), now);
            told.extend(seen.map(Told::Head));
            line.drain(
                now,
                |bytes| emulation.handle_head_bytes(bytes, now),
                |event| told.push_back(Told::Head(event)),
            );
        }
    }

    /// One step of time, no further than `until`.
    fn step(&mut self, until: Duration) {
        let next = [
            self.emulation.next_laser_event(),
            self.emulation.next_head_event(),
            self.laser.as_ref().and_then(Line::deadline),
            self.head.as_ref().and_then(Line::deadline),
            self.later.0.front().map(|(at, _)| *at),
            Some(until),
        ];
        let next = next.into_iter().flatten().min().unwrap_or(until);
        self.now = self.now.max(next);
        let now = self.now;
        self.emulation.advance(now);
        while self.later.0.front().is_some_and(|(at, _)| *at <= now) {
            if let Some((_, happen)) = self.later.0.pop_front() {
                happen(&mut self.emulation);
            }
        }
        while let Some((_, bytes)) = self.emulation.poll_laser() {
            if let Some(driver) = self.laser.as_mut().and_then(|line| line.driver.as_mut()) {
                driver.handle_bytes(&bytes, now);
            }
        }
        while let Some((_, bytes)) = self.emulation.poll_head() {
            if let Some(driver) = self.head.as_mut().and_then(|line| line.driver.as_mut()) {
                driver.handle_bytes(&bytes, now);
            }
        }
        if let Some(driver) = self.laser.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.handle_deadline(now);
        }
        if let Some(driver) = self.head.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.handle_deadline(now);
        }
        self.drain();
    }

    fn pass(&mut self, until: Duration) {
        self.drain();
        while self.now < until {
            self.step(until);
        }
    }
}

impl Devices {
    pub fn new(emulation: Emulation) -> Self {
        Self(Arc::new(Mutex::new(Core {
            now: emulation.now(),
            emulation,
            laser: None,
            head: None,
            told: VecDeque::new(),
            later: Later::default(),
        })))
    }

    fn core(&self) -> MutexGuard<'_, Core> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn now(&self) -> Duration {
        self.core().now
    }

    /// Lets so much time pass.
    pub fn pass(&self, time: Duration) {
        let mut core = self.core();
        let until = core.now + time;
        core.pass(until);
    }

    pub fn with<T>(&self, meddle: impl FnOnce(&mut Emulation) -> T) -> T {
        let mut core = self.core();
        let now = core.now;
        core.emulation.advance(now);
        meddle(&mut core.emulation)
    }

    /// Does this to the world in so much time; to be told in the order of time.
    pub fn later(&self, after: Duration, happen: impl FnOnce(&mut Emulation) + Send + 'static) {
        let mut core = self.core();
        let at = core.now + after;
        core.later.0.push_back((at, Box::new(happen)));
    }

    /// Wires of a new station.
    pub fn wires(&self) -> Box<dyn Wires> {
        let mut core = self.core();
        let now = core.now;
        core.laser = Some(Line::new(Device::Laser, now));
        core.head = Some(Line::new(Device::Head, now));
        core.told.clear();
        drop(core);
        Box::new(Hung(self.clone()))
    }
}

/// What a station holds of the devices.
#[derive(Debug)]
struct Hung(Devices);

impl Wires for Hung {
    fn now(&self) -> Duration {
        self.0.now()
    }

    fn laser(&mut self, command: LaserCommand) {
        let mut core = self.0.core();
        let now = core.now;
        if let Some(driver) = core.laser.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.command(command, now);
        }
        core.drain();
    }

    fn head(&mut self, command: HeadCommand) {
        let mut core = self.0.core();
        let now = core.now;
        if let Some(driver) = core.head.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.command(command, now);
        }
        core.drain();
    }

    fn next(&mut self, until: Duration) -> Option<Told> {
        let mut core = self.0.core();
        core.drain();
        let until = until.min(core.now + CANCEL_CHECK);
        while core.told.is_empty() && core.now < until {
            core.step(until);
        }
        core.told.pop_front()
    }

    fn heard(&mut self) -> Option<Told> {
        self.0.core().told.pop_front()
    }
}

impl Drop for Hung {
    fn drop(&mut self) {
        let mut core = self.0.core();
        let now = core.now;
        if let Some(driver) = core.laser.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.rest(now);
        }
        if let Some(driver) = core.head.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.rest(now);
        }
        core.pass(now + CLOSE_LIMIT);
        (core.laser, core.head) = (None, None);
        core.told.clear();
    }
}
