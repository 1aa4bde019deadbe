//! The thread of one port: blocking reads, timestamps on arrival, the driver, reopening after an error.

#[cfg(test)]
mod serve_tests;

use super::constants::{
    ABSENT_REOPEN_PAUSE, CLOSE_LIMIT, COMMAND_WRITE_LIMIT, INITIAL_REOPEN_PAUSE, MAX_REOPEN_PAUSE,
    READ_BUSY, READ_IDLE,
};
use super::device_driver::{DeviceDriver, DriverOutput};
use super::error::DeviceError;
use super::port_config::{OpenAttempt, PortConfig};
use super::recording::{DialogueTap, RecordedDriver};
use link::Clock;
use link::Link;
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PortEvent<E> {
    /// The port is open; the device is connecting.
    Opened,
    /// An event of the driver.
    Device(E),
    /// The port is closed and will be reopened.
    Lost {
        error: DeviceError,
        retry_in: Duration,
    },
}

/// What a port thread is asked to do.
#[derive(Debug)]
pub(super) enum PortRequest<C> {
    /// A command for the driver.
    Command(C),
    /// The driver is to join this recording.
    Record(DialogueTap),
}

/// Handle of a port thread. Dropping it stops the device and closes the port.
#[derive(Debug)]
pub(crate) struct Port<D: DeviceDriver> {
    requests: Sender<PortRequest<D::Command>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl<D: DeviceDriver> Port<D> {
    /// Starts the thread. Each event goes to `send_event` with its time; the thread ends when that returns false.
    ///
    /// # Errors
    /// [`DeviceError::NoThread`].
    pub(super) fn spawn(
        config: PortConfig,
        clock: Clock,
        send_event: impl FnMut(PortEvent<D::Event>, Duration) -> bool + Send + 'static,
    ) -> Result<Self, DeviceError>
    where
        D: 'static,
    {
        let device = config.device;
        let (requests, inbox) = mpsc::channel();
        let stop = Arc::new(AtomicBool::new(false));
        let runner = PortRunner::<D, _> {
            port: config,
            clock,
            requests: inbox,
            stop: Arc::clone(&stop),
            send_event,
            backoff: INITIAL_REOPEN_PAUSE,
            connected: false,
            baud_found: false,
            last_good: None,
            found_baud: 0,
        };
        let thread = thread::Builder::new()
            .name(format!("patrold-{device}"))
            .spawn(move || runner.run())
            .map_err(|error| DeviceError::NoThread {
                device,
                detail: error.to_string(),
            })?;
        Ok(Self {
            requests,
            stop,
            thread: Some(thread),
        })
    }

    /// Queues a command; it is carried out within [`READ_IDLE`]. Commands to a closed port are dropped.
    pub(super) fn send(&self, command: D::Command) {
        self.request(PortRequest::Command(command));
    }

    /// Lets the driver join a recording once it has taken all commands sent before.
    pub(super) fn record(&self, tap: DialogueTap) {
        self.request(PortRequest::Record(tap));
    }

    fn request(&self, request: PortRequest<D::Command>) {
        // An ended thread takes none.
        let _ = self.requests.send(request);
    }

    /// Starts stopping the device; [`Drop`] waits for it. Lets several ports close at the same time.
    pub(super) fn start_closing(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl<D: DeviceDriver> Drop for Port<D> {
    fn drop(&mut self) {
        self.start_closing();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread was printed already.
            let _ = thread.join();
        }
    }
}

struct PortRunner<D: DeviceDriver, F> {
    port: PortConfig,
    clock: Clock,
    requests: Receiver<PortRequest<D::Command>>,
    stop: Arc<AtomicBool>,
    send_event: F,
    backoff: Duration,
    connected: bool,
    /// A line rate worked once: silence is no reason to search for another quickly.
    baud_found: bool,
    /// The attempt that worked last.
    last_good: Option<OpenAttempt>,
    /// Line rate at which the port was opened last, bit/s.
    found_baud: u32,
}

enum ServeEnd {
    /// The handle was dropped, or nobody receives events.
    Stopped,
    /// The device or its port failed.
    Failed(DeviceError),
}

impl<D: DeviceDriver, F: FnMut(PortEvent<D::Event>, Duration) -> bool> PortRunner<D, F> {
    fn run(mut self) {
        while !self.stopped() {
            // After replugging, node and kind of line may be different.
            let error = match self.port.attempts() {
                Ok(attempts) => match self.try_attempts(attempts) {
                    Some(error) => error,
                    None => return,
                },
                Err(error) => error,
            };
            let max_pause = if error.is_absence() {
                ABSENT_REOPEN_PAUSE
            } else {
                MAX_REOPEN_PAUSE
            };
            let retry_in = self.backoff.min(max_pause);
            if !self.send(PortEvent::Lost { error, retry_in }) {
                return;
            }
            self.backoff = (self.backoff * 2).min(MAX_REOPEN_PAUSE);
            self.pause(retry_in);
        }
    }

    /// Tries the attempts in order, starting with the last good one, until one has served a connected device. Returns why
    /// that ended, or the most specific error of all attempts. `None`: stopped.
    fn try_attempts(&mut self, mut attempts: Vec<OpenAttempt>) -> Option<DeviceError> {
        OpenAttempt::begin_with(&mut attempts, self.last_good.as_ref());
        let probing = attempts.len() > 1 && !self.baud_found;
        let mut reported: Option<DeviceError> = None;
        let mut ruled_out_nodes = HashSet::new();
        let mut garbage_heard = false;
        for attempt in attempts {
            if ruled_out_nodes.contains(&attempt.node)
                || (attempt.is_of_other_device && !garbage_heard)
            {
                continue;
            }
            self.connected = false;
            let end = match attempt.open() {
                Ok(link) => self.serve(link, attempt.baud, probing),
                Err(error) => ServeEnd::Failed(self.port.error(error)),
            };
            let ServeEnd::Failed(error) = end else {
                return None;
            };
            if self.connected {
                self.last_good = Some(attempt);
                return Some(error);
            }
            garbage_heard |= matches!(
                error,
                DeviceError::WrongDevice {
                    readable: false,
                    ..
                }
            );
            if !self.port.tries_other_rates(&error) {
                ruled_out_nodes.insert(attempt.node);
            }
            if reported
                .as_ref()
                .is_none_or(|t| t.specificity() <= error.specificity())
            {
                reported = Some(error);
            }
            if self.stopped() {
                return None;
            }
        }
        reported
    }

    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn send(&mut self, event: PortEvent<D::Event>) -> bool {
        let now = self.clock.now();
        (self.send_event)(event, now)
    }

    fn pause(&self, duration: Duration) {
        let until = self.clock.now() + duration;
        while !self.stopped() && self.clock.now() < until {
            let left = self.clock.wall_time(until.saturating_sub(self.clock.now()));
            thread::sleep(left.min(READ_IDLE));
        }
    }

    fn serve(&mut self, mut link: Box<dyn Link>, baud: u32, probing: bool) -> ServeEnd {
        self.found_baud = baud;
        let mut driver = RecordedDriver::<D>::new(&self.port, baud, probing);
        // Drop requests queued before the port was open.
        while self.requests.try_recv().is_ok() {}
        driver.connect(self.clock.now());
        if !self.send(PortEvent::Opened) {
            return ServeEnd::Stopped;
        }
        let mut buffer = [0; 4096];
        // A paced clock stops while this thread is late.
        let pacer = self.clock.pacer();
        loop {
            pacer.mark();
            if let Err(end) = self.process_outputs(&mut driver, &mut *link) {
                return end;
            }
            if self.stopped() {
                self.stop_device(&mut driver, &mut *link);
                return ServeEnd::Stopped;
            }
            match link.read(
                &mut buffer,
                self.read_timeout(&driver).min(pacer.max_wait()),
            ) {
                Ok(0) => {}
                Ok(count) => {
                    let now = self.clock.now();
                    driver.handle_bytes(buffer.get(..count).unwrap_or_default(), now);
                    // The outputs of one input before the next input.
                    if let Err(end) = self.process_outputs(&mut driver, &mut *link) {
                        return end;
                    }
                }
                Err(error) => {
                    return ServeEnd::Failed(self.port.error(error));
                }
            }
            driver.handle_deadline(self.clock.now());
            while let Ok(request) = self.requests.try_recv() {
                if let Err(end) = self.process_outputs(&mut driver, &mut *link) {
                    return end;
                }
                match request {
                    PortRequest::Command(command) => driver.command(command, self.clock.now()),
                    PortRequest::Record(tap) => driver.record(tap),
                }
            }
        }
    }

    /// How long the next read may block.
    fn read_timeout(&self, driver: &RecordedDriver<D>) -> Duration {
        match driver.deadline() {
            None => READ_IDLE,
            Some(deadline) => {
                let left = self
                    .clock
                    .wall_time(deadline.saturating_sub(self.clock.now()));
                left.min(READ_BUSY)
            }
        }
    }

    /// Writes the bytes and reports the events of the driver.
    fn process_outputs(
        &mut self,
        driver: &mut RecordedDriver<D>,
        link: &mut dyn Link,
    ) -> Result<(), ServeEnd> {
        while let Some(output) = driver.poll() {
            match output {
                DriverOutput::Send(bytes) => {
                    if let Err(error) = link.write_all(&bytes, COMMAND_WRITE_LIMIT) {
                        return Err(ServeEnd::Failed(self.port.error(error)));
                    }
                }
                DriverOutput::SetBitRate(bit_s) => {
                    if let Err(error) = link.set_baud(bit_s) {
                        return Err(ServeEnd::Failed(self.port.error(error)));
                    }
                }
                DriverOutput::Event(event) => {
                    if D::keeps_bit_rate(&event) {
                        // Not asked for again.
                        self.port.baud = self.found_baud;
                    }
                    if let Some(error) = D::fault(&event, &self.port) {
                        // Write first: a driver that gives up still turns its laser off.
                        flush(driver, link);
                        return Err(ServeEnd::Failed(error));
                    }
                    self.connected |= D::is_connected(&event);
                    self.baud_found |= self.connected;
                    if D::is_sign_of_life(&event) {
                        self.backoff = INITIAL_REOPEN_PAUSE;
                    }
                    if !self.send(PortEvent::Device(event)) {
                        self.stop.store(true, Ordering::Relaxed);
                    }
                }
            }
        }
        Ok(())
    }

    /// Laser off, head halted, if the device still responds.
    fn stop_device(&mut self, driver: &mut RecordedDriver<D>, link: &mut dyn Link) {
        let until = Instant::now() + CLOSE_LIMIT;
        let mut buffer = [0; 4096];
        driver.stop(self.clock.now());
        loop {
            while let Some(output) = driver.poll() {
                match output {
                    DriverOutput::Send(bytes) => {
                        if link.write_all(&bytes, CLOSE_LIMIT).is_err() {
                            return;
                        }
                    }
                    DriverOutput::Event(event) if D::is_stopped(&event) => return,
                    DriverOutput::Event(_) | DriverOutput::SetBitRate(_) => {}
                }
            }
            if Instant::now() >= until {
                return;
            }
            match link.read(&mut buffer, READ_BUSY) {
                Ok(count) => {
                    driver.handle_bytes(buffer.get(..count).unwrap_or_default(), self.clock.now());
                }
                Err(_) => return,
            }
            driver.handle_deadline(self.clock.now());
        }
    }
}

/// Writes the remaining bytes of the driver without waiting for replies.
fn flush<D: DeviceDriver>(driver: &mut RecordedDriver<D>, link: &mut dyn Link) {
    while let Some(output) = driver.poll() {
        if let DriverOutput::Send(bytes) = output {
            let _ = link.write_all(&bytes, COMMAND_WRITE_LIMIT);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{INITIAL_REOPEN_PAUSE, PortEvent, PortRunner};
    use crate::config::SettingOrigins;
    use crate::devices::error::{Device, DeviceError, PortError};
    use crate::devices::laser::LaserDriver;
    use crate::devices::lockstep::rig::ROOM;
    use crate::devices::port_config::{OpenAttempt, PortConfig};
    use link::Clock;
    use patrold_sim::emulator::{Emulation, EmulationOptions};
    use patrold_sim::emulator::{Emulator, EmulatorPorts};
    use patrold_sim::world::Scene;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::sync::mpsc;

    fn laser(serial: &str, clock: &Clock) -> Emulator {
        let mut options = EmulationOptions::seeded(1);
        options.laser.profile.serial = serial.to_owned();
        let scene = Scene::parse(ROOM).expect("a scene");
        let world = Arc::new(scene.build(None).expect("no cloud in it"));
        let emulation = Emulation::new(options, world, scene.map_from_base, clock.now());
        Emulator::start(emulation, &EmulatorPorts::default(), clock.clone()).expect("terminals")
    }

    /// How these attempts end, how many ports were opened, and the serial number found.
    fn run_attempts(
        attempts: &[(&str, u32)],
        clock: &Clock,
    ) -> (Option<DeviceError>, usize, Option<String>) {
        let (mut opened, mut found) = (0, None);
        let send_event = |event, _| match event {
            PortEvent::Device(scip::LaserEvent::Connected(identity)) => {
                found = Some(identity.serial);
                false
            }
            PortEvent::Opened => {
                opened += 1;
                true
            }
            _ => true,
        };
        let mut runner = PortRunner::<LaserDriver, _> {
            port: PortConfig {
                device: Device::Laser,
                name: "usb:15d1:0000".to_owned(),
                baud: 115_200,
                unit: Some("H0706400".to_owned()),
                origins: SettingOrigins::default(),
            },
            clock: clock.clone(),
            requests: mpsc::channel().1,
            stop: Arc::new(AtomicBool::new(false)),
            send_event,
            backoff: INITIAL_REOPEN_PAUSE,
            connected: false,
            baud_found: false,
            last_good: None,
            found_baud: 0,
        };
        let attempts = attempts.iter().map(|(node, baud)| OpenAttempt {
            node: (*node).to_owned(),
            baud: *baud,
            is_of_other_device: false,
        });
        let ended = runner.try_attempts(attempts.collect());
        (ended, opened, found)
    }

    #[test]
    fn absent_ports_and_other_units_are_skipped() {
        let clock = Clock::paced(20.0);
        let (other, right) = (laser("H0900001", &clock), laser("H0706400", &clock));
        let others = [
            ("/dev/no-such-port", 115_200),
            ("/dev/no-such-port", 19_200),
            (other.laser_port(), 115_200),
            (other.laser_port(), 19_200),
        ];
        let (ended, opened, found) = run_attempts(
            &[&others[..], &[(right.laser_port(), 9600)]].concat(),
            &clock,
        );
        assert_eq!((ended, opened), (None, 2), "the other once, at one rate");
        assert_eq!(found.as_deref(), Some("H0706400"));

        let (ended, opened, _) = run_attempts(&others, &clock);
        assert_eq!(opened, 1);
        let Some(DeviceError::OtherUnit { got, .. }) = ended else {
            panic!("{ended:?}");
        };
        assert_eq!(got, "H0900001");
        // Whatever came last: a port that is absent says less than another unit.
        let (ended, ..) = run_attempts(&[others[2], others[0]], &clock);
        assert!(
            matches!(ended, Some(DeviceError::OtherUnit { .. })),
            "{ended:?}"
        );
        let (ended, ..) = run_attempts(&others[..2], &clock);
        let Some(DeviceError::Port { source, .. }) = ended else {
            panic!("{ended:?}");
        };
        assert!(matches!(source, PortError::NoSuchPort(_)));
    }
}
