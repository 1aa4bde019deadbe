//! The emulated devices on pseudo-terminals (the laser on TCP if wanted), in the time of a clock: a thread per port, and
//! one measure of how late they are.

use super::constants::EMULATOR_LOOK;
use super::emulation::Emulation;
use super::end::{End, Socket, terminal};
use super::fault::EmulatedFault;
use crate::world::{Stand, World};
use link::Clock;
use link::LinkError;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Where the devices shall hang.
#[derive(Debug, Clone, Default)]
pub struct EmulatorPorts<'a> {
    /// A link to the laser's pseudo-terminal.
    pub laser: Option<&'a Path>,
    /// A link to the head's pseudo-terminal.
    pub head: Option<&'a Path>,
    /// The laser listens here instead of on a pseudo-terminal.
    pub laser_tcp: Option<SocketAddr>,
}

/// How late the emulation was: virtual time between the instant something was due and the instant it was done.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Lag {
    /// How often something was due.
    pub count: u64,
    /// Mean, seconds.
    pub mean_s: f64,
    /// Worst, seconds.
    pub worst_s: f64,
}

impl Lag {
    fn note(&mut self, late: Duration) {
        self.count += 1;
        let late_s = late.as_secs_f64();
        self.mean_s += (late_s - self.mean_s) / self.count as f64;
        self.worst_s = self.worst_s.max(late_s);
    }
}

/// Why the emulator cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// A pseudo-terminal or its link.
    #[error(transparent)]
    Terminal(#[from] LinkError),
    /// The TCP address.
    #[error("{address}: {source}")]
    Listen {
        /// Which address.
        address: SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
    /// A thread.
    #[error("no thread for the emulator: {0}")]
    Thread(std::io::Error),
}

struct Shared {
    emulation: Mutex<Emulation>,
    lag: Mutex<Lag>,
    stop: AtomicBool,
    clock: Clock,
}

/// Both devices, running until dropped; dropping removes the links.
pub struct Emulator {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    laser_port: String,
    head_port: String,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A panic in the other thread is told by itself; what it left is whole.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Emulator {
    /// Hangs `emulation` on its ports and lets it run.
    ///
    /// # Errors
    /// [`EmulatorError`].
    pub fn start(
        emulation: Emulation,
        ports: &EmulatorPorts<'_>,
        clock: Clock,
    ) -> Result<Self, EmulatorError> {
        let shared = Arc::new(Shared {
            emulation: Mutex::new(emulation),
            lag: Mutex::new(Lag::default()),
            stop: AtomicBool::new(false),
            clock,
        });
        let (laser, laser_port) = match ports.laser_tcp {
            Some(address) => Socket::listen(address)?,
            None => terminal(ports.laser)?,
        };
        let (head, head_port) = terminal(ports.head)?;
        let mut emulator = Self {
            shared,
            threads: Vec::new(),
            laser_port,
            head_port,
        };
        emulator.spawn("emulated-laser", laser, Side::LASER)?;
        emulator.spawn("emulated-ptu", head, Side::HEAD)?;
        Ok(emulator)
    }

    fn spawn(&mut self, name: &str, end: Box<dyn End>, side: Side) -> Result<(), EmulatorError> {
        let shared = Arc::clone(&self.shared);
        let thread = thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || serve(&shared, end, &side))
            .map_err(EmulatorError::Thread)?;
        self.threads.push(thread);
        Ok(())
    }

    /// What `laser.port` should say: the link, the terminal, or `tcp:HOST:PORT`.
    pub fn laser_port(&self) -> &str {
        &self.laser_port
    }

    /// What `ptu.port` should say.
    pub fn head_port(&self) -> &str {
        &self.head_port
    }

    /// Puts the robot elsewhere.
    pub fn drive_to(&self, stand: Stand) {
        locked(&self.shared.emulation).drive_to(stand);
    }

    /// Changes what stands around.
    pub fn set_world(&self, world: Arc<World>) {
        locked(&self.shared.emulation).set_world(world);
    }

    /// Sets a fault.
    pub fn inject(&self, fault: EmulatedFault) {
        locked(&self.shared.emulation).inject(fault);
    }

    /// Whether the laser is on, in truth.
    pub fn laser_on(&self) -> bool {
        locked(&self.shared.emulation).laser_on()
    }

    /// Whether the head moves, in truth.
    pub fn head_moving(&self) -> bool {
        locked(&self.shared.emulation).head_moving()
    }

    /// How late it was since the last call. A mean of several milliseconds of virtual time means that the clock runs too
    /// fast for this machine.
    pub fn take_lag(&self) -> Lag {
        std::mem::take(&mut *locked(&self.shared.lag))
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A panic in there was told already.
            let _ = thread.join();
        }
    }
}

/// Bytes of a device and when they came.
type Arrival = (Duration, Vec<u8>);

/// Which half of the emulation a thread serves.
struct Side {
    plug: fn(&Emulation) -> (bool, Option<&Path>),
    handle: fn(&mut Emulation, &[u8], Duration),
    poll: fn(&mut Emulation) -> Option<Arrival>,
    next: fn(&Emulation) -> Option<Duration>,
}

impl Side {
    const LASER: Self = Self {
        plug: |emulation| (emulation.laser_plugged_in(), emulation.laser_link()),
        handle: Emulation::handle_laser_bytes,
        poll: Emulation::poll_laser,
        next: Emulation::next_laser_event,
    };
    const HEAD: Self = Self {
        plug: |emulation| (emulation.head_plugged_in(), emulation.head_link()),
        handle: Emulation::handle_head_bytes,
        poll: Emulation::poll_head,
        next: Emulation::next_head_event,
    };
}

fn serve(shared: &Shared, mut end: Box<dyn End>, side: &Side) {
    let mut buffer = [0; 4096];
    let mut due = Duration::ZERO;
    while !shared.stop.load(Ordering::Relaxed) {
        let patience = shared.clock.wall(due.saturating_sub(shared.clock.now()));
        // A line that fails (the system out of terminals) is as one nobody holds: the device does not care.
        let heard = match end.wait(patience.min(EMULATOR_LOOK)) {
            Ok(()) => end.read(&mut buffer).unwrap_or(0),
            Err(_) => 0,
        };
        let mut emulation = locked(&shared.emulation);
        let now = shared.clock.now();
        if heard > 0 {
            (side.handle)(&mut emulation, buffer.get(..heard).unwrap_or_default(), now);
        }
        emulation.advance(now);
        let mut late = None;
        let mut out = Vec::new();
        while let Some((at, bytes)) = (side.poll)(&mut emulation) {
            late = late.max(Some(now.saturating_sub(at)));
            out.extend(bytes);
        }
        due = (side.next)(&emulation).unwrap_or(Duration::MAX);
        let (plugged_in, link) = (side.plug)(&emulation);
        match (plugged_in, end.is_plugged_in()) {
            (false, true) => end.hang_up(),
            // Where it cannot come back (its name is taken), it tries again at the next look.
            (true, false) => drop(end.plug_in(link)),
            _ => {}
        }
        drop(emulation);
        if !out.is_empty() {
            // As above.
            let _ = end.write(&out);
        }
        if let Some(late) = late {
            locked(&shared.lag).note(late);
        }
    }
}
