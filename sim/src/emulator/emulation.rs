//! The two devices and what stands around them, in one virtual time: bytes and instants in, bytes out. Pure.
//!
//! The laser's twin asks for a revolution when it has ended; by then the head's twin has passed that instant and
//! remembers where it pointed at each beam's own.

use super::constants::EMULATION_PIECE;
use super::fault::EmulatedFault;
use super::plug::{Plug, PlugEvent};
use crate::world::{BeamFan, Lookaround, MountGeometry, NoiseOptions, Robot, Stand, World};
use scip::twin::Surroundings;
use std::path::Path;
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
    laser_plug: Plug,
    head_plug: Plug,
    around: Lookaround,
    now: Duration,
    turns: Option<Vec<(Duration, f64)>>,
}

impl Emulation {
    /// Both devices with their power on, the robot standing at `map_from_base`.
    pub fn new(
        options: EmulationOptions,
        world: Arc<World>,
        map_from_base: patrold_engine::geometry::Pose,
        now: Duration,
    ) -> Self {
        let profile = &options.laser.profile;
        let fan = BeamFan {
            steps_per_turn: profile.steps_per_revolution,
            front_step: profile.front_step,
            first_step: profile.first_step,
            last_step: profile.last_step,
        };
        let noise = NoiseOptions {
            reach_mm: [profile.min_range_mm, profile.max_range_mm].map(f64::from),
            ..options.noise
        };
        Self {
            laser: scip::twin::Twin::new(options.laser, now),
            head: ptu::twin::Twin::new(options.head, now),
            laser_plug: Plug::default(),
            head_plug: Plug::default(),
            around: Lookaround {
                world,
                robot: Robot {
                    pose: map_from_base,
                    mount: options.mount,
                },
                fan,
                noise,
            },
            now,
            turns: None,
        }
    }

    /// Bytes for the laser.
    pub fn handle_laser_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.advance(now);
        if self.laser_plug.is_in() {
            self.laser.handle_bytes(bytes, self.now);
        }
    }

    /// Bytes for the head.
    pub fn handle_head_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.advance(now);
        if self.head_plug.is_in() {
            self.head.handle_bytes(bytes, self.now);
        }
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
                turns: self.turns.as_mut(),
            };
            self.laser.advance(self.now, &mut view);
            self.move_plugs();
            if self.now == now {
                return;
            }
        }
    }

    /// Lets the plugs be pulled and put in. What a device says to nobody is lost.
    fn move_plugs(&mut self) {
        while let Some(event) = self.laser_plug.happen(self.now) {
            let restarts = event == PlugEvent::PutIn { power_back: true };
            if restarts || event == (PlugEvent::Pulled { power_lost: true }) {
                self.laser.power_cycle(self.now);
            }
        }
        while let Some(event) = self.head_plug.happen(self.now) {
            match event {
                PlugEvent::Pulled { power_lost: true } => self.head.power_off(self.now),
                PlugEvent::PutIn { power_back: true } => self.head.power_cycle(self.now),
                _ => {}
            }
        }
        if !self.laser_plug.is_in() {
            while self.laser.poll_output().is_some() {}
        }
        if !self.head_plug.is_in() {
            while self.head.poll_output().is_some() {}
        }
    }

    /// Whether the laser's port is there.
    pub fn laser_plugged_in(&self) -> bool {
        self.laser_plug.is_in()
    }

    /// Whether the head's port is there.
    pub fn head_plugged_in(&self) -> bool {
        self.head_plug.is_in()
    }

    /// The link under which the laser came back, if it was another.
    pub fn laser_link(&self) -> Option<&Path> {
        self.laser_plug.link()
    }

    /// The link under which the head came back, if it was another.
    pub fn head_link(&self) -> Option<&Path> {
        self.head_plug.link()
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
        earlier(self.laser.next_event(), self.laser_plug.next_event())
    }

    /// When the head has something next.
    pub fn next_head_event(&self) -> Option<Duration> {
        earlier(self.head.next_event(), self.head_plug.next_event())
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

    /// Sets a fault; its time counts from now.
    pub fn inject(&mut self, fault: EmulatedFault) {
        match fault.given_at(self.now) {
            EmulatedFault::Laser(spec) => self.laser.inject(spec),
            EmulatedFault::Head(spec) => self.head.inject(spec),
            EmulatedFault::LaserUnplugged(unplug) => self.laser_plug.add(unplug),
            EmulatedFault::HeadUnplugged(unplug) => self.head_plug.add(unplug),
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

    /// Records every revolution of the laser's mirror from now on, for [`Emulation::turns`].
    pub fn record_turns(&mut self) {
        self.turns.get_or_insert_default();
    }

    /// The recorded revolutions: when each began, and the true tilt as the mirror looked straight ahead, radians.
    pub fn turns(&self) -> &[(Duration, f64)] {
        self.turns.as_deref().unwrap_or_default()
    }

    /// Pan and tilt in truth, radians.
    pub fn attitude_rad(&self) -> (f64, f64) {
        attitude_at(&self.head, self.now)
    }
}

fn earlier(a: Option<Duration>, b: Option<Duration>) -> Option<Duration> {
    [a, b].into_iter().flatten().min()
}

fn attitude_at(head: &ptu::twin::Twin, at: Duration) -> (f64, f64) {
    let (pan_deg, tilt_deg) = head.true_degrees_at(at);
    (pan_deg.to_radians(), tilt_deg.to_radians())
}

/// The world from where the head points.
struct View<'a> {
    around: &'a mut Lookaround,
    head: &'a ptu::twin::Twin,
    turns: Option<&'a mut Vec<(Duration, f64)>>,
}

impl Surroundings for View<'_> {
    fn revolve(&mut self, start: Duration, period: Duration, out: &mut [u32]) {
        let head = self.head;
        if let Some(turns) = &mut self.turns {
            let fan = self.around.fan;
            let ahead = start + period * fan.front_step / fan.steps_per_turn.max(1);
            turns.push((start, attitude_at(head, ahead).1));
        }
        self.around
            .revolve(start, period, &|at| attitude_at(head, at), out);
    }
}
