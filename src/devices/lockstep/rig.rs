//! A test rig in virtual time: both drivers and both emulated devices.

use crate::config::{PtuConfig, SettingOrigins, Settings, SweepMode};
use crate::devices::device_driver::{DeviceDriver, DriverOutput};
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::{HeadCommand, HeadDriver, HeadEvent};
use crate::devices::laser::LaserDriver;
use crate::devices::plan::{HeadFacts, LaserFacts, SweepPlan, SweepRequest};
use crate::devices::port_config::PortConfig;
use crate::devices::sweep_run::{PortNames, SweepAction, SweepRun};
use patrold_engine::geometry::Mount;
use patrold_engine::sweep::RawSweep;
use patrold_sim::emulator::{Emulation, EmulationOptions};
use patrold_sim::world::{MountGeometry, Scene};
use std::sync::Arc;
use std::time::Duration;

/// A room of 4 m x 3 m x 2.4 m with the floor at z = 0; the head's base is in the middle, 0.4 m high.
pub(crate) const ROOM: &str = "[robot]\nheight_m = 0.4\n[[room]]\nname = \"room\"\ncentre = [0.0, 0.0, 1.2]\nsize = [4.0, 3.0, 2.4]\n";

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum DriverEvent {
    Laser(scip::LaserEvent),
    Head(HeadEvent),
}

pub(crate) struct TestRig {
    pub emulation: Emulation,
    laser: LaserDriver,
    head: HeadDriver,
    pub now: Duration,
    pub identity: Option<ptu::HeadIdentity>,
    pub laser_identity: Option<scip::LaserIdentity>,
}

fn port(device: Device) -> PortConfig {
    PortConfig {
        device,
        name: format!("/dev/pts/{device}"),
        baud: 9600,
        unit: None,
        origins: SettingOrigins::default(),
    }
}

impl TestRig {
    pub(crate) fn new(options: EmulationOptions) -> Self {
        Self::in_scene(options, &Scene::parse(ROOM).expect("a scene"))
    }

    fn in_scene(options: EmulationOptions, scene: &Scene) -> Self {
        let world = Arc::new(scene.build(None).expect("no cloud in it"));
        Self {
            emulation: Emulation::new(options, world, scene.map_from_base, Duration::ZERO),
            laser: LaserDriver::new(&port(Device::Laser), 9600, false),
            head: HeadDriver::new(&port(Device::Head), 9600, false),
            now: Duration::ZERO,
            identity: None,
            laser_identity: None,
        }
    }

    /// Connected and homed, in the middle of [`ROOM`].
    pub(crate) fn ready(options: EmulationOptions) -> Self {
        Self::new(options).connect_and_home()
    }

    /// Connected and homed, in this scene.
    pub(crate) fn ready_in(options: EmulationOptions, scene: &str) -> Self {
        Self::in_scene(options, &Scene::parse(scene).expect("a scene")).connect_and_home()
    }

    /// Connected and homed, in a shipped scene.
    pub(crate) fn ready_in_scene(options: EmulationOptions, scene: &str) -> Self {
        let folder = patrold_test_support::workspace_root().join("config/scenes");
        let load =
            |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
        let scene = Scene::resolve(scene, &load).expect("a shipped scene");
        Self::in_scene(options, &scene).connect_and_home()
    }

    fn connect_and_home(self) -> Self {
        let mut rig = self;
        rig.laser.connect(rig.now);
        rig.head.connect(rig.now);
        while rig.identity.is_none() || rig.laser_identity.is_none() {
            for event in rig.step() {
                match event {
                    DriverEvent::Laser(scip::LaserEvent::Connected(identity)) => {
                        rig.laser_identity = Some(identity);
                    }
                    DriverEvent::Head(HeadEvent::Ptu(ptu::PtuEvent::Connected(identity))) => {
                        rig.identity = Some(*identity);
                    }
                    _ => {}
                }
            }
            assert!(rig.now < Duration::from_secs(30), "not connected");
        }
        rig.head.command(HeadCommand::Home, rig.now);
        let mut homed = false;
        while !homed {
            for event in rig.step() {
                let fault = matches!(
                    &event,
                    DriverEvent::Head(HeadEvent::Ptu(ptu::PtuEvent::Fault(_)))
                );
                assert!(!fault, "homing: {event:?}");
                if let DriverEvent::Head(HeadEvent::Ptu(ptu::PtuEvent::HomeDone { pan, tilt })) =
                    event
                {
                    let identity = rig.identity.as_mut().expect("connected");
                    (identity.pan.limits, identity.tilt.limits) = (pan, tilt);
                    homed = true;
                }
            }
            assert!(rig.now < Duration::from_secs(120), "not homed");
        }
        rig
    }

    /// The events of this instant; if there are none, advances to the next one.
    pub(crate) fn step(&mut self) -> Vec<DriverEvent> {
        let mut events = Vec::new();
        self.drain(&mut events);
        if events.is_empty() {
            self.advance(Duration::MAX);
            self.drain(&mut events);
        }
        events
    }

    fn advance(&mut self, until: Duration) {
        let next = [
            self.emulation.next_laser_event(),
            self.emulation.next_head_event(),
            self.laser.deadline(),
            self.head.deadline(),
            Some(until),
        ];
        let next = next.into_iter().flatten().min().unwrap_or(until);
        self.now = self.now.max(next);
        self.emulation.advance(self.now);
        while let Some((_, bytes)) = self.emulation.poll_laser() {
            self.laser.handle_bytes(&bytes, self.now);
        }
        while let Some((_, bytes)) = self.emulation.poll_head() {
            self.head.handle_bytes(&bytes, self.now);
        }
        self.laser.handle_deadline(self.now);
        self.head.handle_deadline(self.now);
    }

    fn drain(&mut self, events: &mut Vec<DriverEvent>) {
        while let Some(output) = self.laser.poll() {
            match output {
                DriverOutput::Send(bytes) => self.emulation.handle_laser_bytes(&bytes, self.now),
                DriverOutput::SetBitRate(bit_s) => self.emulation.set_laser_host_baud(bit_s),
                DriverOutput::Event(event) => events.push(DriverEvent::Laser(event)),
            }
        }
        while let Some(output) = self.head.poll() {
            match output {
                DriverOutput::Send(bytes) => self.emulation.handle_head_bytes(&bytes, self.now),
                DriverOutput::SetBitRate(bit_s) => self.emulation.set_head_host_baud(bit_s),
                DriverOutput::Event(event) => events.push(DriverEvent::Head(event)),
            }
        }
    }

    fn carry_out(&mut self, action: SweepAction, events: &mut Vec<DriverEvent>) {
        match action {
            SweepAction::Laser(command) => self.laser.command(command, self.now),
            SweepAction::Head(command) => self.head.command(command, self.now),
            SweepAction::Note(..) => {}
        }
        self.drain(events);
    }

    pub(crate) fn plan(
        &self,
        request: &SweepRequest,
        ptu: &PtuConfig,
    ) -> Result<SweepPlan, DeviceError> {
        SweepPlan::new(
            request,
            &HeadFacts {
                identity: self.identity.as_ref().expect("connected"),
                settings: ptu,
                port: "ptu",
            },
            LaserFacts::new(self.laser_identity.as_ref().expect("connected")),
        )
    }

    pub(crate) fn request(mode: SweepMode) -> SweepRequest {
        let settings = Settings::defaults();
        let mut request = SweepRequest::new(&settings, None);
        request.mode = mode;
        request.mount = true_mount();
        request
    }

    /// A sweep; `inject` is called before every input with the time since its start.
    pub(crate) fn sweep(
        &mut self,
        request: &SweepRequest,
        mut inject: impl FnMut(&mut Emulation, &mut SweepRun, Duration),
    ) -> Result<RawSweep, DeviceError> {
        let plan = self.plan(request, &Settings::defaults().ptu)?;
        let names = PortNames {
            laser: "laser".to_owned(),
            head: "ptu".to_owned(),
        };
        let started = self.now;
        let mut run = SweepRun::new(plan, names, self.now);
        loop {
            inject(&mut self.emulation, &mut run, self.now - started);
            let mut events = Vec::new();
            while let Some(action) = run.poll_action() {
                self.carry_out(action, &mut events);
            }
            self.drain(&mut events);
            if let Some(outcome) = run.take_outcome() {
                return outcome;
            }
            if events.is_empty() {
                self.advance(run.deadline());
                self.drain(&mut events);
            }
            for event in events {
                match event {
                    DriverEvent::Laser(event) => run.on_laser(event, self.now),
                    DriverEvent::Head(event) => run.on_head(event, self.now),
                }
            }
            run.on_time(self.now);
            assert!(self.now - started < Duration::from_secs(300), "never over");
        }
    }
}

/// The mount of the emulated robot.
pub(crate) fn true_mount() -> Mount {
    let truth = MountGeometry::default();
    Mount::new(
        truth.pan_origin_m,
        truth.tilt_origin_m,
        truth.plate_origin_m,
        truth.laser_xyz_m,
        truth.laser_rpy,
    )
}
