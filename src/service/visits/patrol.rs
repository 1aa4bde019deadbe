//! A patrol without threads: requests in, what the guard sees out.

use crate::config::Settings;
use crate::devices::lockstep::wires::Devices;
use crate::devices::{Cancel, Station};
use crate::patrol::action::Action;
use crate::patrol::event::{Event, Refusal, Request, Task};
use crate::patrol::machine::{self, Machine};
use crate::service::constants::{TICK, WATCH_PACE};
use crate::service::judge::{Finding, Judged, ReadyReferences, judge};
use crate::service::robot::{Away, Connect, Fault, Notes, Robot};
use crate::service::station::StationConnect;
use crate::store::StoredReference;
use nalgebra::Point3;
use patrold_engine::novelty::Verdict;
use patrold_engine::sweep::RawSweep;
use patrold_sim::emulator::{EmulatedFault, Emulation, EmulationOptions};
use patrold_sim::world::{Scene, Stand, World};
use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// What the guard sees of a visit.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    pub verdict: Verdict,
    pub reason: String,
}

/// A teaching that went before, shared by all patrols: reference and what is made of it.
#[derive(Clone)]
pub struct Taught {
    pub settings: Arc<Settings>,
    pub reference: Arc<StoredReference>,
    pub ready: ReadyReferences,
}

pub struct Patrol {
    pub devices: Devices,
    pub machine: Machine,
    /// What the log of events says.
    pub log: Vec<String>,
    /// How long the last sweep took.
    pub swept: Duration,
    /// How long the head took back after the last sweep.
    pub returned: Option<Duration>,
    /// Sweeps begun.
    pub sweeps: usize,
    connect: StationConnect,
    robot: Option<Box<dyn Robot>>,
    settings: Arc<Settings>,
    ready: ReadyReferences,
    reference: Option<Arc<StoredReference>>,
    raw: Option<RawSweep>,
    judged: Option<Judged>,
    events: VecDeque<Event>,
    done: Option<Result<Seen, Refusal>>,
    requests: u64,
    doubted: Option<u64>,
    watched: Duration,
}

pub fn scene(name: &str) -> Scene {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
    Scene::resolve(name, &load).expect("a shipped scene")
}

pub fn world(name: &str) -> Arc<World> {
    Arc::new(scene(name).build(None).expect("builds"))
}

/// Where the robot of a scene stands, moved by metres forward and left and degrees to the left.
pub fn moved(name: &str, (x_m, y_m, yaw_deg): (f64, f64, f64)) -> Stand {
    let stand = scene(name).map_from_base;
    let place = stand * Point3::new(x_m, y_m, 0.0);
    Stand {
        x_m: place.x,
        y_m: place.y,
        yaw_rad: stand.rotation.euler_angles().2 + yaw_deg.to_radians(),
    }
}

pub fn settings() -> Settings {
    let mut settings = Settings::defaults();
    settings.laser.port = "/dev/pts/laser".to_owned();
    settings.ptu.port = "/dev/pts/pan-tilt".to_owned();
    settings
}

/// The storeroom, taught once.
pub fn taught() -> Taught {
    static TAUGHT: OnceLock<Taught> = OnceLock::new();
    let teach = || {
        let mut patrol = Patrol::new(settings(), EmulationOptions::seeded(1), "storeroom.toml");
        patrol.teach();
        patrol.taught().expect("taught")
    };
    TAUGHT.get_or_init(teach).clone()
}

impl Patrol {
    pub fn new(settings: Settings, options: EmulationOptions, scene_name: &str) -> Self {
        let stand = scene(scene_name).map_from_base;
        let emulation = Emulation::new(options, world(scene_name), stand, Duration::ZERO);
        Self::on(Devices::new(emulation), Arc::new(settings))
    }

    /// One in the storeroom that knows it already, its devices ready.
    pub fn that_knows(taught: &Taught, seed: u64) -> Self {
        let options = EmulationOptions::seeded(seed);
        let mut patrol = Self::new((*taught.settings).clone(), options, "storeroom.toml");
        patrol.ready = taught.ready.clone();
        patrol.reference = Some(Arc::clone(&taught.reference));
        patrol.until_ready(true).expect("ready");
        patrol
    }

    fn on(devices: Devices, settings: Arc<Settings>) -> Self {
        let wires = devices.clone();
        let connect = StationConnect::over(move |settings, notes, memory, cancel| {
            Station::open_over(wires.wires(), settings, notes, memory, cancel)
        });
        let (machine, first) = Machine::start();
        let mut patrol = Self {
            watched: devices.now(),
            devices,
            machine,
            log: Vec::new(),
            swept: Duration::ZERO,
            returned: None,
            sweeps: 0,
            connect,
            robot: None,
            settings,
            ready: ReadyReferences::default(),
            reference: None,
            raw: None,
            judged: None,
            events: VecDeque::new(),
            done: None,
            requests: 0,
            doubted: None,
        };
        patrol.perform(first);
        patrol
    }

    pub fn inject(&self, fault: &str) {
        let fault: EmulatedFault = fault.parse().expect("a fault");
        self.devices.with(|emulation| emulation.inject(fault));
    }

    /// Time passes for the devices alone until both plugs are in.
    pub fn until_plugged_in(&self) {
        while !self
            .devices
            .with(|e| e.laser_plugged_in() && e.head_plugged_in())
        {
            self.devices.pass(TICK);
        }
    }

    pub fn taught(&self) -> Option<Taught> {
        Some(Taught {
            settings: Arc::clone(&self.settings),
            reference: self.reference.clone()?,
            ready: self.ready.clone(),
        })
    }

    pub fn is_ready(&self) -> bool {
        *self.machine.devices() == machine::Devices::Ready
    }

    /// Idle time, as the loop and the robot's thread pass it.
    pub fn idle(&mut self, time: Duration) {
        let until = self.devices.now() + time;
        while self.devices.now() < until {
            self.turn();
        }
    }

    /// Idle until the devices are (or are not) ready; how long it took, at most a minute or two.
    pub fn until_ready(&mut self, ready: bool) -> Option<Duration> {
        let begun = self.devices.now();
        while self.is_ready() != ready {
            if self.devices.now() - begun > Duration::from_secs(200) {
                return None;
            }
            self.turn();
        }
        Some(self.devices.now() - begun)
    }

    pub fn teach(&mut self) {
        self.ask(Task::Teach).expect("taught");
    }

    pub fn visit(&mut self) -> Seen {
        self.ask(Task::Visit).expect("a visit is always recorded")
    }

    fn ask(&mut self, task: Task) -> Result<Seen, Refusal> {
        self.requests += 1;
        self.events.push_back(Event::Requested(Request {
            id: self.requests,
            task,
            waypoint: "hall".to_owned(),
        }));
        loop {
            self.turn();
            if let Some(done) = self.done.take() {
                return done;
            }
        }
    }

    /// One turn of the loop.
    fn turn(&mut self) {
        let event = self.events.pop_front().unwrap_or_else(|| {
            self.devices.pass(TICK);
            self.watch();
            self.events.pop_front().unwrap_or(Event::Tick)
        });
        let actions = self.machine.handle(self.devices.now(), event);
        self.perform(actions);
    }

    /// The look of the robot's thread at idle devices.
    fn watch(&mut self) {
        if self.devices.now() < self.watched + WATCH_PACE {
            return;
        }
        self.watched = self.devices.now();
        self.lost_meanwhile();
    }

    fn lost_meanwhile(&mut self) {
        let seen = self.robot.as_mut().and_then(|robot| robot.watch().err());
        if let Some(fault) = seen.filter(|fault| fault.lost) {
            self.events.push_back(Event::DevicesLost(fault.reason));
        }
    }

    fn perform(&mut self, actions: Vec<Action>) {
        for action in actions {
            match action {
                Action::OpenDevices => {
                    let event = match self.resume_or_connect() {
                        Ok(()) => Event::DevicesReady,
                        Err(Away { reason, absent }) if absent => Event::DevicesAbsent(reason),
                        Err(Away { reason, .. }) => Event::DevicesFailed(reason),
                    };
                    self.events.push_back(event);
                }
                Action::Prepare(request) => {
                    self.events.push_back(Event::Prepared(request.id, Ok(())));
                }
                Action::DistrustHead => {
                    if let Some(robot) = &mut self.robot {
                        robot.distrust();
                    }
                }
                Action::StartSweep(request) => self.sweep(&request),
                Action::Judge(request) => self.judge(&request),
                Action::Record(request) => {
                    self.done = Some(Ok(self.found()));
                    self.events.push_back(Event::Recorded(request.id, Ok(())));
                }
                Action::RecordNotObserved(request, reason) => {
                    self.done = Some(Ok(Seen {
                        verdict: Verdict::NotObserved,
                        reason,
                    }));
                    self.events.push_back(Event::Recorded(request.id, Ok(())));
                }
                Action::Refuse(_, refusal) => self.done = Some(Err(refusal)),
                Action::Note(_, text) => self.log.push(text),
                Action::Reply(_) => {}
                other => panic!("not played here: {other:?}"),
            }
        }
    }

    /// As the robot's thread does it.
    fn resume_or_connect(&mut self) -> Result<(), Away> {
        let cancel = Cancel::new();
        if let Some(robot) = &mut self.robot {
            match robot.resume(&cancel) {
                Ok(()) => return Ok(()),
                Err(away) if away.absent => return Err(away),
                Err(_) => {}
            }
        }
        self.robot = None;
        let notes = Notes::new(|_, _, _| ());
        let mut robot = self.connect.connect(&self.settings, &notes, &cancel)?;
        robot.describe();
        self.robot = Some(robot);
        Ok(())
    }

    fn sweep(&mut self, request: &Request) {
        self.sweeps += 1;
        let begun = self.devices.now();
        let taken = match &mut self.robot {
            Some(robot) => robot.sweep(&self.settings, Some("hall"), &Cancel::new()),
            None => Err(Fault {
                reason: "the devices are not open".to_owned(),
                lost: true,
            }),
        };
        self.swept = self.devices.now() - begun;
        let longest = super::super::robot_thread::longest_sweep(&self.settings, Some("hall"));
        assert!(
            self.devices.now() - begun < longest,
            "the watchdog would bite"
        );
        let id = request.id;
        match taken {
            Ok(raw) => {
                self.raw = Some(raw);
                self.events.push_back(Event::SweepDone(id));
                let back = self.robot.as_mut().map(|r| r.go_back(&Cancel::new()));
                self.returned = back.flatten();
                self.lost_meanwhile();
            }
            Err(fault) => self.events.push_back(Event::SweepFailed {
                id,
                reason: fault.reason,
                lost: fault.lost,
            }),
        }
    }

    fn judge(&mut self, request: &Request) {
        let raw = self.raw.take().expect("swept");
        let judged = judge(
            request.task,
            "hall",
            &raw,
            self.doubted == Some(request.id),
            self.reference.as_deref(),
            &self.settings,
            &self.ready,
        );
        let result = judged.finding.as_ref().map(|_| ()).map_err(Clone::clone);
        if let Some(reason) = judged.doubt {
            self.doubted = Some(request.id);
            return self.events.push_back(Event::Doubted(request.id, reason));
        }
        self.judged = Some(judged);
        self.events.push_back(Event::Judged(request.id, result));
    }

    /// What the record of the judged sweep says; a reference is kept.
    fn found(&mut self) -> Seen {
        let judged = self.judged.take().expect("judged");
        match (judged.finding, judged.kept) {
            (Ok(Finding::Visit(judgement)), _) => Seen {
                verdict: judgement.verdict,
                reason: judgement.report.reason,
            },
            (Ok(Finding::Reference(mixture)), Some(kept)) => {
                self.reference = Some(Arc::new(StoredReference {
                    id: 1,
                    version: 1,
                    view: kept.view,
                    mixture,
                    engine: self.settings.engine_json(),
                    seed: self.settings.mixture.seed,
                }));
                Seen {
                    verdict: Verdict::Quiet,
                    reason: "taught".to_owned(),
                }
            }
            (other, _) => panic!("nothing to record: {other:?}"),
        }
    }
}
