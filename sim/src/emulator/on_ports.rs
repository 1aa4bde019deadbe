//! The emulated devices on pseudo-terminals (optionally on TCP) in the time of a clock: a thread for each port.

use super::constants::{HELD_RETRY, POLL_INTERVAL};
use super::emulation::Emulation;
use super::error::EmulatorError;
use super::fault::EmulatedFault;
use super::held_output::HeldOutput;
use super::port::{EmulatedPort, TcpPort, open_terminal};
use crate::world::{Pose2d, World};
use link::Clock;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Where the devices are served.
#[derive(Debug, Clone, Default)]
pub struct EmulatorPorts<'a> {
    /// A link to the laser's pseudo-terminal.
    pub laser: Option<&'a Path>,
    /// A link to the head's pseudo-terminal.
    pub head: Option<&'a Path>,
    /// Address on which the laser listens, instead of a pseudo-terminal.
    pub laser_tcp: Option<SocketAddr>,
    /// Address on which the head listens, as behind a serial server, instead of a pseudo-terminal.
    pub head_tcp: Option<SocketAddr>,
}

/// How late the emulation was: virtual time between the instant at which output was due and that at which it was sent.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EmulatorLag {
    /// Outputs.
    pub count: u64,
    /// Mean, seconds.
    pub mean_s: f64,
    /// Maximum, seconds.
    pub max_s: f64,
}

impl EmulatorLag {
    fn add(&mut self, late: Duration) {
        self.count += 1;
        let late_s = late.as_secs_f64();
        self.mean_s += (late_s - self.mean_s) / self.count as f64;
        self.max_s = self.max_s.max(late_s);
    }
}

struct Shared {
    emulation: Mutex<Emulation>,
    lag: Mutex<EmulatorLag>,
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
    // A panic of the other thread is reported by itself; the state that it left is consistent.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Emulator {
    /// Serves `emulation` on its ports.
    ///
    /// # Errors
    /// A port that cannot be opened, or a thread that cannot be started.
    pub fn start(
        emulation: Emulation,
        ports: &EmulatorPorts<'_>,
        clock: Clock,
    ) -> Result<Self, EmulatorError> {
        let shared = Arc::new(Shared {
            emulation: Mutex::new(emulation),
            lag: Mutex::new(EmulatorLag::default()),
            stop: AtomicBool::new(false),
            clock,
        });
        let (laser, laser_port) = match ports.laser_tcp {
            Some(address) => TcpPort::listen(address)?,
            None => open_terminal(ports.laser)?,
        };
        let (head, head_port) = match ports.head_tcp {
            Some(address) => TcpPort::listen(address)?,
            None => open_terminal(ports.head)?,
        };
        let mut emulator = Self {
            shared,
            threads: Vec::new(),
            laser_port,
            head_port,
        };
        emulator.spawn("emulated-laser", laser, DeviceAccess::LASER)?;
        emulator.spawn("emulated-ptu", head, DeviceAccess::HEAD)?;
        Ok(emulator)
    }

    fn spawn(
        &mut self,
        name: &str,
        port: Box<dyn EmulatedPort>,
        device: DeviceAccess,
    ) -> Result<(), EmulatorError> {
        let shared = Arc::clone(&self.shared);
        let thread = thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || serve(&shared, port, &device))
            .map_err(EmulatorError::Thread)?;
        self.threads.push(thread);
        Ok(())
    }

    /// The value for `laser.port`: the link, the terminal, or `tcp:HOST:PORT`.
    pub fn laser_port(&self) -> &str {
        &self.laser_port
    }

    /// The value for `ptu.port`.
    pub fn head_port(&self) -> &str {
        &self.head_port
    }

    /// Puts the robot at `pose` at once.
    pub fn drive_to(&self, pose: Pose2d) {
        locked(&self.shared.emulation).drive_to(pose);
    }

    /// Changes the surroundings.
    pub fn set_world(&self, world: Arc<World>) {
        locked(&self.shared.emulation).set_world(world);
    }

    /// Injects a fault; its time counts from now.
    pub fn inject(&self, fault: EmulatedFault) {
        locked(&self.shared.emulation).inject(fault);
    }

    /// Whether the laser is truly on.
    pub fn laser_on(&self) -> bool {
        locked(&self.shared.emulation).laser_on()
    }

    /// Whether the head truly moves.
    pub fn head_moving(&self) -> bool {
        locked(&self.shared.emulation).head_moving()
    }

    /// The lag since the last call. A mean of several milliseconds of virtual time means that the clock runs too fast for
    /// this machine.
    pub fn take_lag(&self) -> EmulatorLag {
        std::mem::take(&mut *locked(&self.shared.lag))
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A panic in it was reported already.
            let _ = thread.join();
        }
    }
}

/// Output of a device: its instant and bytes.
type TimedBytes = (Duration, Vec<u8>);

/// The functions of the emulation for the device that a thread serves.
struct DeviceAccess {
    plug: fn(&Emulation) -> (bool, Option<&Path>),
    handle: fn(&mut Emulation, &[u8], Duration),
    poll: fn(&mut Emulation) -> Option<TimedBytes>,
    next: fn(&Emulation) -> Option<Duration>,
    set_host_baud: fn(&mut Emulation, u32),
}

impl DeviceAccess {
    const LASER: Self = Self {
        plug: |emulation| (emulation.laser_plugged_in(), emulation.laser_link()),
        handle: Emulation::handle_laser_bytes,
        poll: Emulation::poll_laser,
        next: Emulation::next_laser_event,
        set_host_baud: Emulation::set_laser_host_baud,
    };
    const HEAD: Self = Self {
        plug: |emulation| (emulation.head_plugged_in(), emulation.head_link()),
        handle: Emulation::handle_head_bytes,
        poll: Emulation::poll_head,
        next: Emulation::next_head_event,
        set_host_baud: Emulation::set_head_host_baud,
    };
}

fn serve(shared: &Shared, mut port: Box<dyn EmulatedPort>, device: &DeviceAccess) {
    let mut buffer = [0; 4096];
    let mut due = Duration::ZERO;
    let mut held = HeldOutput::default();
    let pacer = shared.clock.pacer();
    while !shared.stop.load(Ordering::Relaxed) {
        let timeout = shared
            .clock
            .wall_time(due.saturating_sub(shared.clock.now()));
        let timeout = if held.bytes().is_empty() {
            timeout.min(POLL_INTERVAL).min(pacer.max_wait())
        } else {
            HELD_RETRY
        };
        // A port that fails (no terminals left) is as one without a client: the device goes on.
        let received = match port.wait(timeout) {
            Ok(()) => port.read(&mut buffer).unwrap_or(0),
            Err(_) => 0,
        };
        let mut emulation = locked(&shared.emulation);
        let now = shared.clock.now();
        if let Some(baud) = port.client_baud() {
            (device.set_host_baud)(&mut emulation, baud);
        }
        if received > 0 {
            let bytes = buffer.get(..received).unwrap_or_default();
            (device.handle)(&mut emulation, bytes, now);
        }
        emulation.advance(now);
        let mut late = None;
        while held.has_room()
            && let Some((at, bytes)) = (device.poll)(&mut emulation)
        {
            late = late.max(Some(now.saturating_sub(at)));
            held.add(&bytes);
        }
        due = (device.next)(&emulation).unwrap_or(Duration::MAX);
        let (plugged_in, link) = (device.plug)(&emulation);
        match (plugged_in, port.is_plugged_in()) {
            (false, true) => {
                port.hang_up();
                held.clear();
            }
            // Where it fails (its name is taken), the next round tries again.
            (true, false) => drop(port.plug_in(link)),
            _ => {}
        }
        drop(emulation);
        if !held.bytes().is_empty() {
            // A port that fails, as above.
            let count = port.write(held.bytes()).unwrap_or(0);
            held.taken(count);
        }
        if let Some(late) = late {
            locked(&shared.lag).add(late);
        }
        pacer.mark();
    }
}
