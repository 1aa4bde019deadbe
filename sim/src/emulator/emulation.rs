//! The two devices and their surroundings in one virtual time: bytes and instants in, bytes out. Pure.
//!
//! The emulated laser asks for a revolution when it has ended; by then the emulated head has passed those instants and
//! remembers where it pointed at each beam.

use super::constants::MAX_TIME_STEP;
use super::fault::EmulatedFault;
use super::plug::{Plug, PlugEvent};
use crate::world::{
    BeamFan, MountGeometry, NoiseOptions, Pose2d, SimulatedLaser, SimulatedRobot, World,
};
use scip::emulator::RangeSource;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Options of both emulated devices.
#[derive(Debug, Clone)]
pub struct EmulationOptions {
    /// The laser.
    pub laser: scip::emulator::LaserOptions,
    /// The head.
    pub head: ptu::emulator::HeadOptions,
    /// True geometry of the mount.
    pub mount: MountGeometry,
    /// Errors of the ranges.
    pub noise: NoiseOptions,
}

impl EmulationOptions {
    /// A URG-04LX after power-up on USB, a calibrated D46-17 at zero, the default mount; everything random from one seed.
    pub fn seeded(seed: u64) -> Self {
        Self {
            laser: scip::emulator::LaserOptions {
                seed,
                ..scip::emulator::LaserOptions::default()
            },
            head: ptu::emulator::HeadOptions {
                seed,
                ..ptu::emulator::HeadOptions::default()
            },
            mount: MountGeometry::default(),
            noise: NoiseOptions::seeded(seed),
        }
    }
}

/// Both emulated devices in one world.
#[derive(Debug)]
pub struct Emulation {
    laser: scip::emulator::EmulatedLaser,
    head: ptu::emulator::EmulatedHead,
    laser_plug: Plug,
    head_plug: Plug,
    scanner: SimulatedLaser,
    now: Duration,
    revolutions: Option<Vec<(Duration, f64)>>,
}

impl Emulation {
    /// Both devices powered on, the robot at `map_from_base`.
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
            laser: scip::emulator::EmulatedLaser::new(options.laser, now),
            head: ptu::emulator::EmulatedHead::new(options.head, now),
            laser_plug: Plug::default(),
            head_plug: Plug::default(),
            scanner: SimulatedLaser {
                world,
                robot: SimulatedRobot {
                    map_from_base,
                    mount: options.mount,
                },
                fan,
                noise,
            },
            now,
            revolutions: None,
        }
    }

    /// Takes bytes that were sent to the laser.
    pub fn handle_laser_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.advance(now);
        if self.laser_plug.is_plugged_in() {
            self.laser.handle_bytes(bytes, self.now);
        }
    }

    /// Takes bytes that were sent to the head.
    pub fn handle_head_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.advance(now);
        if self.head_plug.is_plugged_in() {
            self.head.handle_bytes(bytes, self.now);
        }
    }

    /// Advances time, long spans in steps: the motion that the head remembers covers the last revolutions of the laser.
    pub fn advance(&mut self, now: Duration) {
        let now = now.max(self.now);
        loop {
            self.now = now.min(self.now + MAX_TIME_STEP);
            self.head.advance(self.now);
            let mut mounted = HeadMountedLaser {
                scanner: &mut self.scanner,
                head: &self.head,
                revolutions: self.revolutions.as_mut(),
            };
            self.laser.advance(self.now, &mut mounted);
            self.apply_plug_events();
            if self.now == now {
                return;
            }
        }
    }

    /// Unplugs and plugs in what is due; the output of an unplugged device is lost.
    fn apply_plug_events(&mut self) {
        while let Some(event) = self.laser_plug.poll_event(self.now) {
            let restarts = event == PlugEvent::PluggedIn { power_back: true };
            if restarts || event == (PlugEvent::Unplugged { power_lost: true }) {
                self.laser.power_cycle(self.now);
            }
        }
        while let Some(event) = self.head_plug.poll_event(self.now) {
            match event {
                PlugEvent::Unplugged { power_lost: true } => self.head.power_off(self.now),
                PlugEvent::PluggedIn { power_back: true } => self.head.power_cycle(self.now),
                _ => {}
            }
        }
        if !self.laser_plug.is_plugged_in() {
            while self.laser.poll_output().is_some() {}
        }
        if !self.head_plug.is_plugged_in() {
            while self.head.poll_output().is_some() {}
        }
    }

    /// Whether the port of the laser exists.
    pub fn laser_plugged_in(&self) -> bool {
        self.laser_plug.is_plugged_in()
    }

    /// Whether the port of the head exists.
    pub fn head_plugged_in(&self) -> bool {
        self.head_plug.is_plugged_in()
    }

    /// The link under which the laser returned, if it was another.
    pub fn laser_link(&self) -> Option<&Path> {
        self.laser_plug.link()
    }

    /// The link under which the head returned, if it was another.
    pub fn head_link(&self) -> Option<&Path> {
        self.head_plug.link()
    }

    /// The next output of the laser: its instant and bytes.
    pub fn poll_laser(&mut self) -> Option<(Duration, Vec<u8>)> {
        self.laser.poll_output().map(|out| (out.at, out.bytes))
    }

    /// The next output of the head.
    pub fn poll_head(&mut self) -> Option<(Duration, Vec<u8>)> {
        self.head.poll_output().map(|out| (out.at, out.bytes))
    }

    /// When the laser has to be served next.
    pub fn next_laser_event(&self) -> Option<Duration> {
        earlier(self.laser.next_event(), self.laser_plug.next_event())
    }

    /// When the head has to be served next.
    pub fn next_head_event(&self) -> Option<Duration> {
        earlier(self.head.next_event(), self.head_plug.next_event())
    }

    /// The host has its end of the laser's line at this rate, bit/s.
    pub fn set_laser_host_baud(&mut self, baud: u32) {
        self.laser.set_host_baud(baud);
    }

    /// The host has its end of the head's line at this rate, bit/s.
    pub fn set_head_host_baud(&mut self, baud: u32) {
        self.head.set_host_baud(Some(baud));
    }

    /// The instant that it has advanced to.
    pub fn now(&self) -> Duration {
        self.now
    }

    /// Puts the robot at `pose` at once.
    pub fn drive_to(&mut self, pose: Pose2d) {
        self.scanner.robot.drive_to(pose);
    }

    /// Changes the surroundings; the robot keeps its pose.
    pub fn set_world(&mut self, world: Arc<World>) {
        self.scanner.world = world;
    }

    /// Injects a fault; its time counts from now.
    pub fn inject(&mut self, fault: EmulatedFault) {
        match fault.counted_from(self.now) {
            EmulatedFault::Laser(spec) => self.laser.inject(spec),
            EmulatedFault::Head(spec) => self.head.inject(spec),
            EmulatedFault::LaserUnplugged(unplug) => self.laser_plug.add(unplug),
            EmulatedFault::HeadUnplugged(unplug) => self.head_plug.add(unplug),
        }
    }

    /// Whether the laser is truly on.
    pub fn laser_on(&self) -> bool {
        self.laser.laser_on()
    }

    /// Whether an axis of the head truly moves.
    pub fn head_moving(&self) -> bool {
        self.head.moving()
    }

    /// Records every revolution of the mirror from now on, for [`Emulation::revolutions`].
    pub fn record_revolutions(&mut self) {
        self.revolutions.get_or_insert_default();
    }

    /// The recorded revolutions: when each began, and the true tilt when the mirror pointed straight ahead, radians.
    pub fn revolutions(&self) -> &[(Duration, f64)] {
        self.revolutions.as_deref().unwrap_or_default()
    }

    /// True pan and tilt, radians.
    pub fn attitude_rad(&self) -> (f64, f64) {
        attitude_at(&self.head, self.now)
    }
}

fn earlier(a: Option<Duration>, b: Option<Duration>) -> Option<Duration> {
    [a, b].into_iter().flatten().min()
}

fn attitude_at(head: &ptu::emulator::EmulatedHead, at: Duration) -> (f64, f64) {
    let (pan_deg, tilt_deg) = head.true_degrees_at(at);
    (pan_deg.to_radians(), tilt_deg.to_radians())
}

/// The laser at the attitudes of the head.
struct HeadMountedLaser<'a> {
    scanner: &'a mut SimulatedLaser,
    head: &'a ptu::emulator::EmulatedHead,
    revolutions: Option<&'a mut Vec<(Duration, f64)>>,
}

impl RangeSource for HeadMountedLaser<'_> {
    fn fill_revolution(&mut self, start: Duration, period: Duration, out: &mut [u32]) {
        let head = self.head;
        if let Some(revolutions) = &mut self.revolutions {
            let fan = self.scanner.fan;
            let ahead = start + period * fan.front_step / fan.steps_per_turn.max(1);
            revolutions.push((start, attitude_at(head, ahead).1));
        }
        self.scanner
            .revolve(start, period, &|at| attitude_at(head, at), out);
    }
}
