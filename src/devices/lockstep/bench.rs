//! The bench: both drivers, both twins, one instant.

use crate::config::{PtuSettings, Settings, SweepMode};
use crate::devices::driver::{Driver, Output};
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::{HeadCommand, HeadDriver, HeadEvent};
use crate::devices::laser::LaserDriver;
use crate::devices::plan::{HeadFacts, LaserFacts, SweepPlan, SweepRequest};
use crate::devices::port_name::PortName;
use crate::devices::sweep_run::{PortNames, RunAction, SweepRun};
use patrold_engine::geometry::Mount;
use patrold_engine::sweep::RawSweep;
use patrold_sim::emulator::{Emulation, EmulationOptions};
use patrold_sim::world::{MountGeometry, Scene};
use std::sync::Arc;
use std::time::Duration;

/// A room of 4 m x 3 m x 2.4 m, its floor at z = 0, the head's base in the middle at 0.4 m.
pub const ROOM: &str = "[robot]\nheight_m = 0.4\n[[room]]\nname = \"room\"\ncentre = [0.0, 0.0, 1.2]\nsize = [4.0, 3.0, 2.4]\n";

/// What both drivers told, in order.
#[derive(Debug, Clone, PartialEq)]
pub enum Told {
    Laser(scip::Event),
    Head(HeadEvent),
}

pub struct Bench {
    pub emulation: Emulation,
    laser: LaserDriver,
    head: HeadDriver,
    pub now: Duration,
    pub identity: Option<ptu::HeadIdentity>,
    pub parameters: Option<scip::Parameters>,
}

fn port(device: Device) -> PortName {
    PortName {
        device,
        name: format!("/dev/pts/{device}"),
        baud: 9600,
        unit: None,
    }
}

impl Bench {
    pub fn new(options: EmulationOptions) -> Self {
        Self::within(options, &Scene::parse(ROOM).expect("a scene"))
    }

    fn within(options: EmulationOptions, scene: &Scene) -> Self {
        let world = Arc::new(scene.build(None).expect("no cloud in it"));
        Self {
            emulation: Emulation::new(options, world, scene.map_from_base, Duration::ZERO),
            laser: LaserDriver::new(&port(Device::Laser), 9600, false),
            head: HeadDriver::new(&port(Device::Head), 9600, false),
            now: Duration::ZERO,
            identity: None,
            parameters: None,
        }
    }

    /// Connected and homed, in the middle of [`ROOM`].
    pub fn ready(options: EmulationOptions) -> Self {
        Self::new(options).made_ready()
    }

    /// Connected and homed, in a shipped scene.
    pub fn ready_in(options: EmulationOptions, scene: &str) -> Self {
        let folder = patrold_test_support::workspace_root().join("config/scenes");
        let load =
            |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
        let scene = Scene::resolve(scene, &load).expect("a shipped scene");
        Self::within(options, &scene).made_ready()
    }

    fn made_ready(self) -> Self {
        let mut bench = self;
        bench.laser.connect(bench.now);
        bench.head.connect(bench.now);
        while bench.identity.is_none() || bench.parameters.is_none() {
            for told in bench.go_on() {
                match told {
                    Told::Laser(scip::Event::Connected(identity)) => {
                        bench.parameters = Some(identity.parameters);
                    }
                    Told::Head(HeadEvent::Unit(ptu::Event::Connected(identity))) => {
                        bench.identity = Some(*identity);
                    }
                    _ => {}
                }
            }
            assert!(bench.now < Duration::from_secs(30), "not connected");
        }
        bench.head.command(HeadCommand::Home, bench.now);
        let mut homed = false;
        while !homed {
            for told in bench.go_on() {
                let fault = matches!(&told, Told::Head(HeadEvent::Unit(ptu::Event::Fault(_))));
                assert!(!fault, "homing: {told:?}");
                if let Told::Head(HeadEvent::Unit(ptu::Event::HomeDone { pan, tilt })) = told {
                    let identity = bench.identity.as_mut().expect("connected");
                    (identity.pan.limits, identity.tilt.limits) = (pan, tilt);
                    homed = true;
                }
            }
            assert!(bench.now < Duration::from_secs(120), "not homed");
        }
        bench
    }

    /// Everything that happens at this instant; if nothing does, time passes to the next thing.
    pub fn go_on(&mut self) -> Vec<Told> {
        let mut told = Vec::new();
        self.drain(&mut told);
        if told.is_empty() {
            self.let_time_pass(Duration::MAX);
            self.drain(&mut told);
        }
        told
    }

    fn let_time_pass(&mut self, until: Duration) {
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

    fn drain(&mut self, told: &mut Vec<Told>) {
        while let Some(output) = self.laser.poll() {
            match output {
                Output::Send(bytes) => self.emulation.handle_laser_bytes(&bytes, self.now),
                Output::Event(event) => told.push(Told::Laser(event)),
            }
        }
        while let Some(output) = self.head.poll() {
            match output {
                Output::Send(bytes) => self.emulation.handle_head_bytes(&bytes, self.now),
                Output::Event(event) => told.push(Told::Head(event)),
            }
        }
    }

    fn carry_out(&mut self, action: RunAction, told: &mut Vec<Told>) {
        match action {
            RunAction::Laser(command) => self.laser.command(command, self.now),
            RunAction::Head(command) => self.head.command(command, self.now),
            RunAction::Note(..) => {}
        }
        self.drain(told);
    }

    pub fn plan(
        &self,
        request: &SweepRequest,
        ptu: &PtuSettings,
    ) -> Result<SweepPlan, DeviceError> {
        SweepPlan::new(
            request,
            &HeadFacts {
                identity: self.identity.as_ref().expect("connected"),
                settings: ptu,
                port: "ptu",
            },
            LaserFacts {
                parameters: self.parameters.expect("connected"),
                line_bytes_s: None,
            },
        )
    }

    pub fn request(mode: SweepMode) -> SweepRequest {
        let settings = Settings::defaults();
        let mut request = SweepRequest::new(&settings.sweep, &settings.mount, &[0.0]);
        request.mode = mode;
        request.mount = true_mount();
        request
    }

    /// A sweep; `meddle` is called before every input with the time since its start.
    pub fn sweep(
        &mut self,
        request: &SweepRequest,
        mut meddle: impl FnMut(&mut Emulation, &mut SweepRun, Duration),
    ) -> Result<RawSweep, DeviceError> {
        let plan = self.plan(request, &Settings::defaults().ptu)?;
        let names = PortNames {
            laser: "laser".to_owned(),
            head: "ptu".to_owned(),
        };
        let started = self.now;
        let mut run = SweepRun::new(plan, names, self.now);
        loop {
            meddle(&mut self.emulation, &mut run, self.now - started);
            let mut told = Vec::new();
            while let Some(action) = run.poll_action() {
                self.carry_out(action, &mut told);
            }
            self.drain(&mut told);
            if let Some(outcome) = run.take_outcome() {
                return outcome;
            }
            if told.is_empty() {
                self.let_time_pass(run.deadline());
                self.drain(&mut told);
            }
            for event in told {
                match event {
                    Told::Laser(event) => run.on_laser(event, self.now),
                    Told::Head(event) => run.on_head(event, self.now),
                }
            }
            run.on_time(self.now);
            assert!(self.now - started < Duration::from_secs(300), "never over");
        }
    }
}

/// The mount that the twin's world has.
pub fn true_mount() -> Mount {
    let truth = MountGeometry::default();
    Mount::new(
        truth.pan_origin_m,
        truth.tilt_origin_m,
        truth.plate_origin_m,
        truth.laser_xyz_m,
        truth.laser_rpy,
    )
}
