//! A patrol in virtual time and without threads: requests in, verdicts out.

mod scanner_calls;

pub(super) use super::scenes::{displaced_pose, scene, world};
use super::stored_reference::stored_reference;
use crate::alarm::Incident;
use crate::config::Settings;
use crate::devices::lockstep::links::EmulatedDevices;
use crate::devices::{Cancel, Station};
use crate::patrol::action::PatrolAction;
use crate::patrol::event::{PatrolEvent, PatrolRequest, PatrolTask, RefusalReason};
use crate::patrol::machine::{self, PatrolMachine};
use crate::service::constants::TICK;
use crate::service::judgement::{
    SweepFinding, SweepJudgement, VisitBasis, VisitFinding, judge_sweep,
};
use crate::service::reference_cache::ReferenceCache;
use crate::service::scanner::{ConnectError, Scanner, ScannerError};
use crate::service::scanner_thread::max_sweep_duration;
use crate::service::station_scanner::StationConnector;
use crate::store::StoredReference;
use patrold_engine::novelty::Verdict;
use patrold_engine::sweep::RawSweep;
use patrold_sim::emulator::{EmulatedFault, Emulation, EmulationOptions};
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct VisitResult {
    pub(super) verdict: Verdict,
    pub(super) reason: String,
}

/// A reference that several patrols share.
#[derive(Clone)]
pub(super) struct TaughtReference {
    pub(super) settings: Arc<Settings>,
    pub(super) reference: Arc<StoredReference>,
    pub(super) cache: ReferenceCache,
}

pub(super) struct VirtualPatrol {
    pub(super) devices: EmulatedDevices,
    pub(super) machine: PatrolMachine,
    pub(super) event_log: Vec<String>,
    /// Of the last sweep.
    pub(super) sweep_duration: Duration,
    /// Of the return after the last sweep.
    pub(super) return_duration: Option<Duration>,
    pub(super) sweep_count: usize,
    /// Known at the waypoint.
    pub(super) incidents: Vec<Incident>,
    /// Of the last visit.
    pub(super) finding: Option<VisitFinding>,
    connector: StationConnector,
    scanner: Option<Box<dyn Scanner>>,
    settings: Arc<Settings>,
    references: ReferenceCache,
    taught: HashMap<String, Arc<StoredReference>>,
    /// Where the robot says it stands.
    waypoint: String,
    raw_sweep: Option<RawSweep>,
    judgement: Option<SweepJudgement>,
    events: VecDeque<PatrolEvent>,
    result: Option<Result<VisitResult, RefusalReason>>,
    last_request_id: u64,
    repeated_request: Option<u64>,
    last_idle_check: Duration,
    /// Homings that the patrol knows of.
    pub(super) homings: u64,
}

pub(super) fn settings() -> Settings {
    let mut settings = Settings::defaults();
    settings.laser.port = "/dev/pts/laser".to_owned();
    settings.ptu.port = "/dev/pts/pan-tilt".to_owned();
    settings
}

/// The storeroom, taught once.
pub(super) fn taught_storeroom() -> TaughtReference {
    static TAUGHT: OnceLock<TaughtReference> = OnceLock::new();
    let teach = || {
        let mut patrol =
            VirtualPatrol::new(settings(), EmulationOptions::seeded(1), "storeroom.toml");
        patrol.teach();
        patrol.reference().expect("taught")
    };
    TAUGHT.get_or_init(teach).clone()
}

impl VirtualPatrol {
    pub(super) fn new(settings: Settings, options: EmulationOptions, scene_name: &str) -> Self {
        let map_from_base = scene(scene_name).map_from_base;
        let emulation = Emulation::new(options, world(scene_name), map_from_base, Duration::ZERO);
        Self::with_devices(EmulatedDevices::new(emulation), Arc::new(settings))
    }

    /// In the storeroom, with its reference and ready devices.
    pub(super) fn with_reference(taught: &TaughtReference, seed: u64) -> Self {
        let options = EmulationOptions::seeded(seed);
        let mut patrol = Self::new((*taught.settings).clone(), options, "storeroom.toml");
        patrol.references = taught.cache.clone();
        let reference = Arc::clone(&taught.reference);
        patrol.taught.insert(patrol.waypoint.clone(), reference);
        patrol.until_ready(true).expect("ready");
        patrol
    }

    fn with_devices(devices: EmulatedDevices, settings: Arc<Settings>) -> Self {
        let links = devices.clone();
        let connector = StationConnector::with_open(move |settings, notes, trust, cancel| {
            Station::open_with_links(links.links(), settings, notes, trust, cancel)
        });
        let (machine, first_actions) =
            PatrolMachine::start(settings.ptu.suspect_pan_rad, settings.ptu.suspect_tilt_rad);
        let mut patrol = Self {
            last_idle_check: devices.now(),
            homings: 0,
            devices,
            machine,
            event_log: Vec::new(),
            sweep_duration: Duration::ZERO,
            return_duration: None,
            sweep_count: 0,
            incidents: Vec::new(),
            finding: None,
            connector,
            scanner: None,
            settings,
            references: ReferenceCache::default(),
            taught: HashMap::new(),
            waypoint: "hall".to_owned(),
            raw_sweep: None,
            judgement: None,
            events: VecDeque::new(),
            result: None,
            last_request_id: 0,
            repeated_request: None,
        };
        patrol.perform(first_actions);
        patrol
    }

    pub(super) fn inject(&self, fault: &str) {
        let fault: EmulatedFault = fault.parse().expect("a fault");
        self.devices
            .with_emulation(|emulation| emulation.inject(fault));
    }

    /// Only the devices run meanwhile.
    pub(super) fn until_plugged_in(&self) {
        while !self
            .devices
            .with_emulation(|e| e.laser_plugged_in() && e.head_plugged_in())
        {
            self.devices.advance(TICK);
        }
    }

    pub(super) fn reference(&self) -> Option<TaughtReference> {
        Some(TaughtReference {
            settings: Arc::clone(&self.settings),
            reference: Arc::clone(self.taught.get(&self.waypoint)?),
            cache: self.references.clone(),
        })
    }

    pub(super) fn is_ready(&self) -> bool {
        *self.machine.devices() == machine::DeviceAvailability::Ready
    }

    pub(super) fn idle(&mut self, time: Duration) {
        let until = self.devices.now() + time;
        while self.devices.now() < until {
            self.step();
        }
    }

    /// Idles until the devices are ready, or not ready any more, and gives the time it took; `None` after 200 s.
    pub(super) fn until_ready(&mut self, ready: bool) -> Option<Duration> {
        let start = self.devices.now();
        while self.is_ready() != ready {
            if self.devices.now() - start > Duration::from_secs(200) {
                return None;
            }
            self.step();
        }
        Some(self.devices.now() - start)
    }

    /// Knows this reference, too.
    pub(super) fn know(&mut self, waypoint: &str, taught: &TaughtReference) {
        let reference = Arc::clone(&taught.reference);
        self.taught.insert(waypoint.to_owned(), reference);
    }

    /// The next requests are for this waypoint.
    pub(super) fn stand_at(&mut self, waypoint: &str) {
        self.waypoint = waypoint.to_owned();
    }

    pub(super) fn teach(&mut self) {
        self.run_request(PatrolTask::Teach).expect("taught");
    }

    pub(super) fn visit(&mut self) -> VisitResult {
        self.run_request(PatrolTask::Visit)
            .expect("a visit is always recorded")
    }

    fn run_request(&mut self, task: PatrolTask) -> Result<VisitResult, RefusalReason> {
        self.last_request_id += 1;
        self.events.push_back(PatrolEvent::Requested(PatrolRequest {
            id: self.last_request_id,
            task,
            waypoint: self.waypoint.clone(),
        }));
        loop {
            self.step();
            if let Some(result) = self.result.take() {
                return result;
            }
        }
    }

    /// One pass of the service loop.
    fn step(&mut self) {
        let event = self.events.pop_front().unwrap_or_else(|| {
            self.devices.advance(TICK);
            self.check_idle_devices();
            self.events.pop_front().unwrap_or(PatrolEvent::Tick)
        });
        let actions = self.machine.handle(self.devices.now(), event);
        self.perform(actions);
    }

    fn perform(&mut self, actions: Vec<PatrolAction>) {
        for action in actions {
            match action {
                PatrolAction::HomeHead => {
                    let scanner = self.scanner.as_mut().expect("ready");
                    let event = match scanner.home(&Cancel::new()) {
                        Ok(()) => PatrolEvent::HomingDone,
                        Err(error) => PatrolEvent::DevicesFailed(error.reason),
                    };
                    self.report_homing();
                    self.events.push_back(event);
                }
                PatrolAction::OpenDevices => {
                    let event = match self.resume_or_connect() {
                        Ok(()) => PatrolEvent::DevicesReady,
                        Err(ConnectError { reason, absent }) if absent => {
                            PatrolEvent::DevicesAbsent(reason)
                        }
                        Err(ConnectError { reason, .. }) => PatrolEvent::DevicesFailed(reason),
                    };
                    self.report_homing();
                    self.events.push_back(event);
                }
                PatrolAction::Prepare(request) => {
                    self.events
                        .push_back(PatrolEvent::Prepared(request.id, Ok(())));
                }
                PatrolAction::DistrustHead => {
                    if let Some(scanner) = &mut self.scanner {
                        scanner.distrust_head();
                    }
                }
                PatrolAction::StartSweep(request) => self.sweep(&request),
                PatrolAction::Judge(request) => self.judge(&request),
                PatrolAction::Record(request) => {
                    self.result = Some(Ok(self.recorded_result()));
                    self.events
                        .push_back(PatrolEvent::Recorded(request.id, Ok(())));
                }
                PatrolAction::RecordNotObserved(request, reason) => {
                    self.result = Some(Ok(VisitResult {
                        verdict: Verdict::NotObserved,
                        reason,
                    }));
                    self.events
                        .push_back(PatrolEvent::Recorded(request.id, Ok(())));
                }
                PatrolAction::Refuse(_, refusal) => self.result = Some(Err(refusal)),
                PatrolAction::LogEvent(_, text) => self.event_log.push(text),
                PatrolAction::Reply(_) => {}
                other => panic!("not implemented here: {other:?}"),
            }
        }
    }

    fn sweep(&mut self, request: &PatrolRequest) {
        self.sweep_count += 1;
        let start = self.devices.now();
        let swept = match &mut self.scanner {
            Some(scanner) => scanner.sweep(&self.settings, Some(&self.waypoint), &Cancel::new()),
            None => Err(ScannerError {
                reason: "the devices are not open".to_owned(),
                lost: true,
            }),
        };
        self.sweep_duration = self.devices.now() - start;
        assert!(
            self.sweep_duration < max_sweep_duration(&self.settings, Some(&self.waypoint)),
            "the watchdog would end the service"
        );
        self.report_homing();
        let id = request.id;
        match swept {
            Ok(raw_sweep) => {
                self.raw_sweep = Some(raw_sweep);
                self.events.push_back(PatrolEvent::SweepDone(id));
                let scanner = self.scanner.as_mut();
                self.return_duration = scanner.and_then(|s| s.return_to_start(&Cancel::new()));
                self.report_lost_devices();
            }
            Err(error) => self.events.push_back(PatrolEvent::SweepFailed {
                id,
                reason: error.reason,
                lost: error.lost,
            }),
        }
    }

    fn judge(&mut self, request: &PatrolRequest) {
        let raw_sweep = self.raw_sweep.take().expect("swept");
        let judgement = judge_sweep(
            request.task,
            &self.waypoint,
            &raw_sweep,
            self.repeated_request == Some(request.id),
            self.basis().as_ref(),
            &self.settings,
            &self.references,
        );
        let result = judgement.finding.as_ref().map(|_| ()).map_err(Clone::clone);
        if let Some(reason) = judgement.suspected_lost_steps {
            self.repeated_request = Some(request.id);
            return self
                .events
                .push_back(PatrolEvent::LostStepsSuspected(request.id, reason));
        }
        if let Some(seen) = judgement.turn.clone() {
            self.events.push_back(PatrolEvent::ViewTurned(seen));
        }
        self.judgement = Some(judgement);
        self.events
            .push_back(PatrolEvent::Judged(request.id, result));
    }

    fn basis(&self) -> Option<VisitBasis> {
        Some(VisitBasis {
            reference: (**self.taught.get(&self.waypoint)?).clone(),
            incidents: self.incidents.clone(),
        })
    }

    /// A taught reference is kept for the visits that follow.
    fn recorded_result(&mut self) -> VisitResult {
        let judgement = self.judgement.take().expect("judged");
        match (judgement.finding, judgement.assembled) {
            (Ok(SweepFinding::Visit(finding)), _) => {
                let result = VisitResult {
                    verdict: finding.verdict,
                    reason: finding.report.reason.clone(),
                };
                self.finding = Some(*finding);
                result
            }
            (Ok(SweepFinding::Reference(gamma)), Some(sweep)) => {
                let reference = stored_reference(&self.settings, sweep.view, gamma, &self.waypoint);
                self.taught
                    .insert(self.waypoint.clone(), Arc::new(reference));
                VisitResult {
                    verdict: Verdict::Quiet,
                    reason: "taught".to_owned(),
                }
            }
            (other, _) => panic!("nothing to record: {other:?}"),
        }
    }
}
