//! The thread of one port: blocking reads, bytes stamped as they come, the driver inside, the port opened anew.

use super::constants::{ABSENT_RETRY, BACKOFF, CLOSE_LIMIT, READ_BUSY, READ_IDLE, WRITE_LIMIT};
use super::driver::{Driver, Output};
use super::error::DeviceError;
use super::port_name::{PortName, Try};
use link::Clock;
use link::Link;
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// What the thread tells.
#[derive(Debug, Clone, PartialEq)]
pub enum PortEvent<E> {
    /// The port is open; the device is being connected.
    Opened,
    /// The driver's word.
    Device(E),
    /// The port is closed; it will be opened again after the pause.
    Lost {
        /// Why.
        error: DeviceError,
        /// The pause.
        retry_in: Duration,
    },
}

/// A running port. Dropping it brings the device to rest and closes the port.
#[derive(Debug)]
pub struct Port<D: Driver> {
    commands: Sender<D::Command>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl<D: Driver> Port<D> {
    /// Starts the thread. Every event goes through `tell`; it says whether anybody still listens.
    ///
    /// # Errors
    /// [`DeviceError::NoThread`].
    pub fn spawn(
        name: PortName,
        clock: Clock,
        tell: impl FnMut(PortEvent<D::Event>, Duration) -> bool + Send + 'static,
    ) -> Result<Self, DeviceError>
    where
        D: 'static,
    {
        let device = name.device;
        let (commands, inbox) = mpsc::channel();
        let stop = Arc::new(AtomicBool::new(false));
        let runner = Runner::<D, _> {
            name,
            clock,
            inbox,
            stop: Arc::clone(&stop),
            tell,
            backoff: BACKOFF.0,
            connected: false,
            found: false,
            right: None,
        };
        let thread = thread::Builder::new()
            .name(format!("patrold-{device}"))
            .spawn(move || runner.run())
            .map_err(|error| DeviceError::NoThread {
                device,
                detail: error.to_string(),
            })?;
        Ok(Self {
            commands,
            stop,
            thread: Some(thread),
        })
    }

    /// Hands a command over; it is taken within [`READ_IDLE`]. While the port is closed commands are dropped.
    pub fn send(&self, command: D::Command) {
        // The thread ends only with this handle or its listener.
        let _ = self.commands.send(command);
    }

    /// Begins to close: the device goes to rest while others do too. [`Drop`] waits for it.
    pub fn begin_close(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl<D: Driver> Drop for Port<D> {
    fn drop(&mut self) {
        self.begin_close();
        if let Some(thread) = self.thread.take() {
            // A panic in there was told on standard error; there is no more to do.
            let _ = thread.join();
        }
    }
}

struct Runner<D: Driver, F> {
    name: PortName,
    clock: Clock,
    inbox: Receiver<D::Command>,
    stop: Arc<AtomicBool>,
    tell: F,
    backoff: Duration,
    connected: bool,
    /// A rate was found once: silence is then no reason to look for another soon.
    found: bool,
    /// Where and how the device was found the last time.
    right: Option<Try>,
}

/// How much an error says of where the device is: silence at a wrong rate says nothing.
fn telling(error: &DeviceError) -> u8 {
    match error {
        DeviceError::OtherUnit { .. } => 2,
        DeviceError::Port { .. } => 1,
        _ => 0,
    }
}

/// How serving ended.
enum End {
    /// The handle is gone, or nobody listens.
    Stopped,
    /// The device or its port failed.
    Failed(DeviceError),
}

impl<D: Driver, F: FnMut(PortEvent<D::Event>, Duration) -> bool> Runner<D, F> {
    fn run(mut self) {
        while !self.stopped() {
            // The line may be another node and another kind after it was plugged in again.
            let error = match self.name.tries() {
                Ok(tries) => match self.round(tries) {
                    Some(error) => error,
                    None => return,
                },
                Err(error) => error,
            };
            let most = if error.is_absence() {
                ABSENT_RETRY
            } else {
                BACKOFF.1
            };
            let retry_in = self.backoff.min(most);
            if !self.tell(PortEvent::Lost { error, retry_in }) {
                return;
            }
            self.backoff = (self.backoff * 2).min(BACKOFF.1);
            self.pause(retry_in);
        }
    }

    /// One of `tries` after the other, the one that was right the last time first, until one served a device that is known;
    /// why it ended, or the most telling reason why none did. `None`: stopped.
    fn round(&mut self, mut tries: Vec<Try>) -> Option<DeviceError> {
        let right = tries
            .iter()
            .position(|this| Some(this) == self.right.as_ref());
        tries.rotate_left(right.unwrap_or(0));
        let probing = tries.len() > 1 && !self.found;
        let mut told: Option<DeviceError> = None;
        let mut settled = HashSet::new();
        for this in tries {
            if settled.contains(&this.node) {
                continue;
            }
            self.connected = false;
            let end = match this.open(self.name.device) {
                Ok(link) => self.serve(link, this.baud, probing),
                Err(error) => End::Failed(error),
            };
            let End::Failed(error) = end else { return None };
            if self.connected {
                self.right = Some(this);
                return Some(error);
            }
            // A port that cannot be opened, and a unit that was understood, are the same at every rate.
            if telling(&error) > 0 {
                settled.insert(this.node);
            }
            if told.as_ref().is_none_or(|t| telling(t) <= telling(&error)) {
                told = Some(error);
            }
            if self.stopped() {
                return None;
            }
        }
        told
    }

    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn tell(&mut self, event: PortEvent<D::Event>) -> bool {
        let now = self.clock.now();
        (self.tell)(event, now)
    }

    fn pause(&self, duration: Duration) {
        let until = self.clock.now() + duration;
        while !self.stopped() && self.clock.now() < until {
            let left = self.clock.wall(until.saturating_sub(self.clock.now()));
            thread::sleep(left.min(READ_IDLE));
        }
    }

    fn serve(&mut self, mut link: Box<dyn Link>, baud: u32, probing: bool) -> End {
        let mut driver = D::new(&self.name, baud, probing);
        // What was asked of the port's former life means nothing now.
        while self.inbox.try_recv().is_ok() {}
        driver.connect(self.clock.now());
        if !self.tell(PortEvent::Opened) {
            return End::Stopped;
        }
        let mut buffer = [0; 4096];
        loop {
            if let Err(end) = self.carry_out(&mut driver, &mut *link) {
                return end;
            }
            if self.stopped() {
                self.lay_to_rest(&mut driver, &mut *link);
                return End::Stopped;
            }
            match link.read(&mut buffer, self.patience(&driver)) {
                Ok(0) => {}
                Ok(count) => {
                    let now = self.clock.now();
                    driver.handle_bytes(buffer.get(..count).unwrap_or_default(), now);
                }
                Err(error) => {
                    return End::Failed(DeviceError::Port {
                        device: self.name.device,
                        source: error.into(),
                    });
                }
            }
            driver.handle_deadline(self.clock.now());
            while let Ok(command) = self.inbox.try_recv() {
                // Outputs of one input first, then the next input.
                if let Err(end) = self.carry_out(&mut driver, &mut *link) {
                    return end;
                }
                driver.command(command, self.clock.now());
            }
        }
    }

    /// How long the next read may block.
    fn patience(&self, driver: &D) -> Duration {
        match driver.deadline() {
            None => READ_IDLE,
            Some(deadline) => {
                let left = self.clock.wall(deadline.saturating_sub(self.clock.now()));
                left.min(READ_BUSY)
            }
        }
    }

    /// Carries out everything the driver wants.
    fn carry_out(&mut self, driver: &mut D, link: &mut dyn Link) -> Result<(), End> {
        while let Some(output) = driver.poll() {
            match output {
                Output::Send(bytes) => {
                    if let Err(error) = link.write_all(&bytes, WRITE_LIMIT) {
                        return Err(End::Failed(DeviceError::Port {
                            device: self.name.device,
                            source: error.into(),
                        }));
                    }
                }
                Output::Event(event) => {
                    if let Some(error) = D::fault(&event, &self.name) {
                        // Last words first: a driver that gives up still turns its laser off.
                        flush(driver, link);
                        return Err(End::Failed(error));
                    }
                    self.connected |= D::is_connected(&event);
                    self.found |= self.connected;
                    if D::is_proof_of_life(&event) {
                        self.backoff = BACKOFF.0;
                    }
                    if !self.tell(PortEvent::Device(event)) {
                        self.stop.store(true, Ordering::Relaxed);
                    }
                }
            }
        }
        Ok(())
    }

    /// Laser off, head halted, as far as the device still listens.
    fn lay_to_rest(&mut self, driver: &mut D, link: &mut dyn Link) {
        let until = Instant::now() + CLOSE_LIMIT;
        let mut buffer = [0; 4096];
        driver.rest(self.clock.now());
        loop {
            while let Some(output) = driver.poll() {
                match output {
                    Output::Send(bytes) => {
                        if link.write_all(&bytes, CLOSE_LIMIT).is_err() {
                            return;
                        }
                    }
                    Output::Event(event) if D::is_rest(&event) => return,
                    Output::Event(_) => {}
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

/// Writes what the driver still wants sent; nobody waits for answers.
fn flush<D: Driver>(driver: &mut D, link: &mut dyn Link) {
    while let Some(output) = driver.poll() {
        if let Output::Send(bytes) = output {
            let _ = link.write_all(&bytes, WRITE_LIMIT);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BACKOFF, PortEvent, Runner};
    use crate::devices::error::{Device, DeviceError, PortError};
    use crate::devices::laser::LaserDriver;
    use crate::devices::lockstep::bench::ROOM;
    use crate::devices::port_name::{PortName, Try};
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

    /// How a round of these tries ends; how often a port was opened, and whom it found.
    fn round(tries: &[(&str, u32)], clock: &Clock) -> (Option<DeviceError>, usize, Option<String>) {
        let (mut opened, mut found) = (0, None);
        let tell = |event, _| match event {
            PortEvent::Device(scip::Event::Connected(identity)) => {
                found = Some(identity.serial);
                false
            }
            PortEvent::Opened => {
                opened += 1;
                true
            }
            _ => true,
        };
        let mut runner = Runner::<LaserDriver, _> {
            name: PortName {
                device: Device::Laser,
                name: "usb:15d1:0000".to_owned(),
                baud: 115_200,
                unit: Some("H0706400".to_owned()),
            },
            clock: clock.clone(),
            inbox: mpsc::channel().1,
            stop: Arc::new(AtomicBool::new(false)),
            tell,
            backoff: BACKOFF.0,
            connected: false,
            found: false,
            right: None,
        };
        let tries = tries.iter().map(|(node, baud)| Try {
            node: (*node).to_owned(),
            baud: *baud,
        });
        let ended = runner.round(tries.collect());
        (ended, opened, found)
    }

    #[test]
    fn a_round_passes_over_what_cannot_be_opened_and_who_is_not_the_one() {
        let clock = Clock::scaled(20.0);
        let (other, right) = (laser("H0900001", &clock), laser("H0706400", &clock));
        let others = [
            ("/dev/no-such-port", 115_200),
            ("/dev/no-such-port", 19_200),
            (other.laser_port(), 115_200),
            (other.laser_port(), 19_200),
        ];
        let (ended, opened, found) = round(
            &[&others[..], &[(right.laser_port(), 9600)]].concat(),
            &clock,
        );
        assert_eq!((ended, opened), (None, 2), "the other once, at one rate");
        assert_eq!(found.as_deref(), Some("H0706400"));

        let (ended, opened, _) = round(&others, &clock);
        assert_eq!(opened, 1);
        let Some(DeviceError::OtherUnit { got, .. }) = ended else {
            panic!("{ended:?}");
        };
        assert_eq!(got, "H0900001");
        let (ended, ..) = round(&others[..2], &clock);
        let Some(DeviceError::Port { source, .. }) = ended else {
            panic!("{ended:?}");
        };
        assert!(matches!(source, PortError::NoSuchPort(_)));
    }
}
