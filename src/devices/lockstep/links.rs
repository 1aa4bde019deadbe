//! The station's links in virtual time: both drivers against both emulated devices, without threads or sleeping. Ports are
//! lost and reopened as by their threads. Several stations can use the same devices one after the other.

use crate::config::SettingOrigins;
use crate::devices::constants::{
    ABSENT_REOPEN_PAUSE, CANCEL_CHECK, CLOSE_LIMIT, INITIAL_REOPEN_PAUSE, MAX_REOPEN_PAUSE,
};
use crate::devices::device_driver::{DeviceDriver, DriverOutput};
use crate::devices::device_links::{DeviceLinks, PortMessage};
use crate::devices::error::{Device, DeviceError, PortError};
use crate::devices::head::{HeadCommand, HeadDriver};
use crate::devices::laser::{LaserCommand, LaserDriver};
use crate::devices::port::PortEvent;
use crate::devices::port_config::PortConfig;
use crate::devices::recording::{DialogueTap, RecordedDriver};
use patrold_sim::emulator::Emulation;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The emulated devices, the time, and the drivers on their ports. Clones share all of it.
#[derive(Debug, Clone)]
pub(crate) struct EmulatedDevices(Arc<Mutex<EmulatedState>>);

#[derive(Debug)]
struct EmulatedState {
    emulation: Emulation,
    now: Duration,
    laser: Option<VirtualPort<LaserDriver>>,
    head: Option<VirtualPort<HeadDriver>>,
    messages: VecDeque<PortMessage>,
    schedule: Schedule,
}

/// Changes of the emulation, in order of time.
#[derive(Default)]
struct Schedule(VecDeque<(Duration, ScheduledAction)>);

type ScheduledAction = Box<dyn FnOnce(&mut Emulation) + Send>;

impl std::fmt::Debug for Schedule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} scheduled", self.0.len())
    }
}

/// What a driver does to its line.
enum LineInput<'a> {
    Bytes(&'a [u8]),
    BitRate(u32),
}

/// A port: open with its driver, or closed until `open_at`.
#[derive(Debug)]
struct VirtualPort<D> {
    name: PortConfig,
    driver: Option<RecordedDriver<D>>,
    open_at: Duration,
    backoff: Duration,
}

impl<D: DeviceDriver> VirtualPort<D> {
    fn new(device: Device, now: Duration) -> Self {
        Self {
            name: PortConfig {
                device,
                name: format!("/dev/pts/{device}"),
                baud: 9600,
                unit: None,
                origins: SettingOrigins::default(),
            },
            driver: None,
            open_at: now,
            backoff: INITIAL_REOPEN_PAUSE,
        }
    }

    fn deadline(&self) -> Option<Duration> {
        match &self.driver {
            Some(driver) => driver.deadline(),
            None => Some(self.open_at),
        }
    }

    fn close(&mut self, error: DeviceError, now: Duration) -> PortEvent<D::Event> {
        let max_pause = if error.is_absence() {
            ABSENT_REOPEN_PAUSE
        } else {
            MAX_REOPEN_PAUSE
        };
        let retry_in = self.backoff.min(max_pause);
        self.driver = None;
        self.open_at = now + retry_in;
        self.backoff = (2 * self.backoff).min(MAX_REOPEN_PAUSE);
        PortEvent::Lost { error, retry_in }
    }

    /// Opens or loses the port, depending on whether it is plugged in.
    fn update_plug(&mut self, is_in: bool, now: Duration) -> Option<PortEvent<D::Event>> {
        let port_error = |source| DeviceError::Port {
            device: self.name.device,
            setting: self.name.setting(),
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
                let mut driver = RecordedDriver::new(&self.name, self.name.baud, false);
                driver.connect(now);
                self.driver = Some(driver);
                Some(PortEvent::Opened)
            }
            _ => None,
        }
    }

    /// Passes on the driver's bytes and events. A fault closes the port after the last bytes.
    fn drain(
        &mut self,
        now: Duration,
        mut send: impl FnMut(LineInput<'_>),
        mut report: impl FnMut(PortEvent<D::Event>),
    ) {
        let mut end = None;
        while let Some(output) = self.driver.as_mut().and_then(RecordedDriver::poll) {
            match output {
                DriverOutput::Send(bytes) => send(LineInput::Bytes(&bytes)),
                DriverOutput::SetBitRate(bit_s) => send(LineInput::BitRate(bit_s)),
                DriverOutput::Event(_) if end.is_some() => {}
                DriverOutput::Event(event) => {
                    if D::is_sign_of_life(&event) {
                        self.backoff = INITIAL_REOPEN_PAUSE;
                    }
                    end = D::fault(&event, &self.name);
                    if end.is_none() {
                        report(PortEvent::Device(event));
                    }
                }
            }
        }
        if let Some(error) = end {
            report(self.close(error, now));
        }
    }
}

impl EmulatedState {
    fn drain(&mut self) {
        let (now, emulation, messages) = (self.now, &mut self.emulation, &mut self.messages);
        if let Some(line) = &mut self.laser {
            let seen = line.update_plug(emulation.laser_plugged_in(), now);
            messages.extend(seen.map(PortMessage::Laser));
            line.drain(
                now,
                |input| match input {
                    LineInput::Bytes(bytes) => emulation.handle_laser_bytes(bytes, now),
                    LineInput::BitRate(bit_s) => emulation.set_laser_host_baud(bit_s),
                },
                |event| messages.push_back(PortMessage::Laser(event)),
            );
        }
        if let Some(line) = &mut self.head {
            let seen = line.update_plug(emulation.head_plugged_in(), now);
            messages.extend(seen.map(PortMessage::Head));
            line.drain(
                now,
                |input| match input {
                    LineInput::Bytes(bytes) => emulation.handle_head_bytes(bytes, now),
                    LineInput::BitRate(bit_s) => emulation.set_head_host_baud(bit_s),
                },
                |event| messages.push_back(PortMessage::Head(event)),
            );
        }
    }

    /// One step of time, no further than `until`.
    fn step(&mut self, until: Duration) {
        let next = [
            self.emulation.next_laser_event(),
            self.emulation.next_head_event(),
            self.laser.as_ref().and_then(VirtualPort::deadline),
            self.head.as_ref().and_then(VirtualPort::deadline),
            self.schedule.0.front().map(|(at, _)| *at),
            Some(until),
        ];
        let next = next.into_iter().flatten().min().unwrap_or(until);
        self.now = self.now.max(next);
        let now = self.now;
        self.emulation.advance(now);
        while self.schedule.0.front().is_some_and(|(at, _)| *at <= now) {
            if let Some((_, action)) = self.schedule.0.pop_front() {
                action(&mut self.emulation);
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

    fn advance(&mut self, until: Duration) {
        self.drain();
        while self.now < until {
            self.step(until);
        }
    }
}

impl EmulatedDevices {
    pub(crate) fn new(emulation: Emulation) -> Self {
        Self(Arc::new(Mutex::new(EmulatedState {
            now: emulation.now(),
            emulation,
            laser: None,
            head: None,
            messages: VecDeque::new(),
            schedule: Schedule::default(),
        })))
    }

    fn state(&self) -> MutexGuard<'_, EmulatedState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn now(&self) -> Duration {
        self.state().now
    }

    /// Advances the time.
    pub(crate) fn advance(&self, time: Duration) {
        let mut state = self.state();
        let until = state.now + time;
        state.advance(until);
    }

    pub(crate) fn with_emulation<T>(&self, change: impl FnOnce(&mut Emulation) -> T) -> T {
        let mut state = self.state();
        let now = state.now;
        state.emulation.advance(now);
        change(&mut state.emulation)
    }

    /// Schedules a change of the emulation; call in order of time.
    pub(crate) fn schedule(
        &self,
        after: Duration,
        action: impl FnOnce(&mut Emulation) + Send + 'static,
    ) {
        let mut state = self.state();
        let at = state.now + after;
        state.schedule.0.push_back((at, Box::new(action)));
    }

    /// Links of a new station.
    pub(crate) fn links(&self) -> Box<dyn DeviceLinks> {
        let mut state = self.state();
        let now = state.now;
        state.laser = Some(VirtualPort::new(Device::Laser, now));
        state.head = Some(VirtualPort::new(Device::Head, now));
        state.messages.clear();
        drop(state);
        Box::new(EmulatedLinks(self.clone()))
    }
}

#[derive(Debug)]
struct EmulatedLinks(EmulatedDevices);

impl DeviceLinks for EmulatedLinks {
    fn now(&self) -> Duration {
        self.0.now()
    }

    fn send_laser(&mut self, command: LaserCommand) {
        let mut state = self.0.state();
        let now = state.now;
        if let Some(driver) = state.laser.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.command(command, now);
        }
        state.drain();
    }

    fn send_head(&mut self, command: HeadCommand) {
        let mut state = self.0.state();
        let now = state.now;
        if let Some(driver) = state.head.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.command(command, now);
        }
        state.drain();
    }

    fn recv(&mut self, until: Duration) -> Option<PortMessage> {
        let mut state = self.0.state();
        state.drain();
        let until = until.min(state.now + CANCEL_CHECK);
        while state.messages.is_empty() && state.now < until {
            state.step(until);
        }
        state.messages.pop_front()
    }

    fn try_recv(&mut self) -> Option<PortMessage> {
        let mut state = self.0.state();
        state.drain();
        state.messages.pop_front()
    }

    fn record(&mut self, tap: &DialogueTap) {
        let mut state = self.0.state();
        if let Some(driver) = state.laser.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.record(tap.clone());
        }
        if let Some(driver) = state.head.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.record(tap.clone());
        }
        state.drain();
    }
}

impl Drop for EmulatedLinks {
    fn drop(&mut self) {
        let mut state = self.0.state();
        let now = state.now;
        if let Some(driver) = state.laser.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.stop(now);
        }
        if let Some(driver) = state.head.as_mut().and_then(|line| line.driver.as_mut()) {
            driver.stop(now);
        }
        state.advance(now + CLOSE_LIMIT);
        (state.laser, state.head) = (None, None);
        state.messages.clear();
    }
}
