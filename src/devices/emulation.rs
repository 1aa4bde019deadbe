//! The two devices and what stands around them, in one virtual time: bytes and instants in, bytes out. Pure.
//!
//! The laser's twin asks for a revolution when it has ended; by then the head's twin has passed that instant and
//! remembers where it pointed at each beam's own.

use super::constants::EMULATION_PIECE;
use super::emulated_fault::EmulatedFault;
use crate::world::{Lookaround, MountGeometry, NoiseOptions, Robot, Stand, World};
use scip::twin::Surroundings;
use std::sync::Arc;
use std::time::Duration;

/// What the emulated devices are.
#[derive(Debug, Clone)]
pub struct EmulationOptions {
    /// The laser.
    pub laser: scip::twin::TwinOptions,
    /// The head.
    pub head: ptu::twin::TwinOptions,
    /// How the robot carries the laser, in truth.
    pub mount: MountGeometry,
    /// How the laser's ranges err.
    pub noise: NoiseOptions,
}

impl EmulationOptions {
    /// A URG-04LX after power-up on USB, a D46-17 that stands calibrated at zero, the default mount; every kind of
    /// chance from one seed.
    pub fn seeded(seed: u64) -> Self {
        Self {
            laser: scip::twin::TwinOptions {
                seed,
                ..scip::twin::TwinOptions::default()
            },
            head: ptu::twin::TwinOptions {
                seed,
                ..ptu::twin::TwinOptions::default()
            },
            mount: MountGeometry::default(),
            noise: NoiseOptions::seeded(seed),
        }
    }
}

/// Both twins in one world.
#[derive(Debug)]
pub struct Emulation {
    laser: scip::twin::Twin,
    head: ptu::twin::Twin,
    around: Lookaround,
    now: Duration,
}

impl Emulation {
    /// Both devices with their power on, the robot standing at `map_from_base`.
    pub fn new(
        options: EmulationOptions,
        world: Arc<World>,
        map_from_base: crate::geometry::Pose,
        now: Duration,
    ) -> Self {
        Self {
            laser: scip::twin::Twin::new(options.laser, now),
            head: ptu::twin::Twin::new(options.head, now),
            around: Lookaround {
                world,
                robot: Robot {
                    pose: map_from_base,
                    mount: options.mount,
                },
                noise: options.noise,
            },
            now,
        }
    }

    /// Bytes for the laser.
    pub fn handle_laser_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.advance(now);
        self.laser.handle_bytes(bytes, self.now);
    }

    /// Bytes for the head.
    pub fn handle_head_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.advance(now);
        self.head.handle_bytes(bytes, self.now);
    }

    /// Lets time pass. Long spans go in pieces, so that the head's memory always covers the laser's last turns.
    pub fn advance(&mut self, now: Duration) {
        let now = now.max(self.now);
        loop {
            self.now = now.min(self.now + EMULATION_PIECE);
            self.head.advance(self.now);
            let mut view = View {
                around: &mut self.around,
                head: &self.head,
            };
            self.laser.advance(self.now, &mut view);
            if self.now == now {
                return;
            }
        }
    }

    /// What has come from the laser: when, and the bytes.
    pub fn poll_laser(&mut self) -> Option<(Duration, Vec<u8>)> {
        self.laser.poll_output().map(|out| (out.at, out.bytes))
    }

    /// What has come from the head.
    pub fn poll_head(&mut self) -> Option<(Duration, Vec<u8>)> {
        self.head.poll_output().map(|out| (out.at, out.bytes))
    }

    /// When the laser has something next.
    pub fn next_laser_event(&self) -> Option<Duration> {
        self.laser.next_event()
    }

    /// When the head has something next.
    pub fn next_head_event(&self) -> Option<Duration> {
        self.head.next_event()
    }

    /// The latest instant it was told of.
    pub fn now(&self) -> Duration {
        self.now
    }

    /// Puts the robot elsewhere, at once.
    pub fn drive_to(&mut self, stand: Stand) {
        self.around.robot.drive_to(stand);
    }

    /// Changes what stands around; the robot stays where it is.
    pub fn set_world(&mut self, world: Arc<World>) {
        self.around.world = world;
    }

    /// Sets a fault.
    pub fn inject(&mut self, fault: EmulatedFault) {
        match fault {
            EmulatedFault::Laser(spec) => self.laser.inject(spec),
            EmulatedFault::Head(spec) => self.head.inject(spec),
        }
    }

    /// Whether the laser is on, in truth.
    pub fn laser_on(&self) -> bool {
        self.laser.laser_on()
    }

    /// Whether an axis of the head moves, in truth.
    pub fn head_moving(&self) -> bool {
        self.head.moving()
    }

    /// Pan and tilt in truth, radians.
    pub fn attitude_rad(&self) -> (f64, f64) {
        attitude_at(&self.head, self.now)
    }
}

fn attitude_at(head: &ptu::twin::Twin, at: Duration) -> (f64, f64) {
    let (pan_deg, tilt_deg) = head.true_degrees_at(at);
    (pan_deg.to_radians(), tilt_deg.to_radians())
}

/// The world from where the head points.
struct View<'a> {
    around: &'a mut Lookaround,
    head: &'a ptu::twin::Twin,
}

impl Surroundings for View<'_> {
    fn revolve(&mut self, start: Duration, period: Duration, out: &mut [u32]) {
        let head = self.head;
        self.around
            .revolve(start, period, &|at| attitude_at(head, at), out);
    }
}
