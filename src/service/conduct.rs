//! The conductor: turns what reaches the loop into events for the patrol, and carries out the patrol's actions.

use super::constants::JUDGE_LIMIT;
use super::judge::{Judged, ReadyReferences, judge};
use super::ledger::Ledger;
use super::logging::LogLevel;
use super::message::{Ask, Message};
use super::replies::{Reply, StatusReply};
use super::robot_thread::{RobotEvent, RobotThread};
use super::stamp::stamp_now;
use super::steady::SteadyWall;
use super::systemd::Systemd;
use super::work::{Work, refusal};
use crate::config::{Loaded, Settings};
use crate::patrol::action::{Action, Weight};
use crate::patrol::event::{Event, Request, Task};
use crate::patrol::machine::Machine;
use crate::store::Level;
use patrold_engine::sweep::RawSweep;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::UnboundedSender;
use tokio::sync::{oneshot, watch};

mod answers;
mod upkeep;

/// What the conductor works with.
pub struct Hands {
    /// The robot's thread.
    pub robot: RobotThread,
    /// The writer's thread.
    pub ledger: Ledger,
    /// The line to systemd.
    pub systemd: Systemd,
    /// Changes how much is logged, where this process logs.
    pub log: Option<LogLevel>,
    /// Where outcomes go back to the loop.
    pub inbox: UnboundedSender<Message>,
    /// What the socket says about the service.
    pub status: watch::Sender<StatusReply>,
}

/// The conductor.
pub struct Conductor {
    hands: Hands,
    machine: Machine,
    settings: Arc<Settings>,
    next: Option<Box<Loaded>>,
    ready: ReadyReferences,
    answers: HashMap<u64, oneshot::Sender<Reply>>,
    requests: u64,
    work: Option<Work>,
    raw: Option<RawSweep>,
    outcome: Option<Reply>,
    began: Instant,
    sweep_began: Duration,
    judging: bool,
    overdue: bool,
    retention_due: Instant,
    exited: bool,
    started: Instant,
    wall: SteadyWall,
}

impl Conductor {
    /// Begins the patrol.
    pub fn start(hands: Hands, settings: Arc<Settings>) -> Self {
        let (machine, first) = Machine::start();
        let now = Instant::now();
        let mut conductor = Self {
            hands,
            machine,
            settings,
            next: None,
            ready: ReadyReferences::default(),
            answers: HashMap::new(),
            requests: 0,
            work: None,
            raw: None,
            outcome: None,
            began: now,
            sweep_began: Duration::ZERO,
            judging: false,
            overdue: false,
            retention_due: now,
            exited: false,
            started: now,
            wall: SteadyWall::default(),
        };
        let version = env!("CARGO_PKG_VERSION");
        conductor.note(Level::Info, "service", format!("patrold {version} started"));
        conductor.perform(first);
        conductor.tell_status();
        conductor
    }

    /// Says that the service answers from now on.
    pub fn announce(&self) {
        self.hands.systemd.ready();
    }

    /// Whether the patrol has ended.
    pub fn has_exited(&self) -> bool {
        self.exited
    }

    /// Deals with one message.
    pub fn take(&mut self, message: Message) {
        self.look_for_askers();
        let event = match message {
            Message::Robot(event) => self.robot_event(event),
            Message::Ask(ask) => self.asked(ask),
            Message::Prepared(id, found) => {
                let found = found.map(|stored| {
                    if let Some(work) = self.work.as_mut().filter(|w| w.request.id == id) {
                        work.reference = Some(Arc::new(stored));
                    }
                });
                Event::Prepared(id, found)
            }
            Message::Judged(id, judged) => {
                let result = judged.finding.as_ref().map(|_| ()).map_err(Clone::clone);
                let spent = self.lap_ms();
                if let Some(work) = self.work.as_mut().filter(|w| w.request.id == id) {
                    self.judging = false;
                    work.timing.judge += spent;
                    if let Some(reason) = judged.doubt {
                        work.swept_again = true;
                        return self.handle(Event::Doubted(id, reason));
                    }
                    work.judged = Some(judged);
                }
                Event::Judged(id, result)
            }
            Message::Recorded(id, result) => {
                let result = result.map_err(|refusal| refusal.to_string());
                Event::Recorded(id, result.map(|reply| self.outcome = Some(reply)))
            }
            Message::Reread(Ok(loaded)) => {
                let change = self.change(&loaded.settings);
                self.next = Some(loaded);
                Event::Reload(Ok(change))
            }
            Message::Reread(Err(mistakes)) => {
                Event::Reload(Err(mistakes.iter().map(ToString::to_string).collect()))
            }
            Message::Note(level, device, text) => return self.note(level, &device, text),
        };
        self.handle(event);
    }

    /// Time has passed.
    pub fn tick(&mut self) {
        self.look_for_askers();
        let wall = jiff::Timestamp::now();
        self.wall.look(self.started.elapsed(), wall);
        self.handle(Event::Tick);
        let too_long = self.judging && self.began.elapsed() > JUDGE_LIMIT;
        let overdue = too_long || self.hands.robot.is_overdue() || self.hands.ledger.is_overdue();
        if overdue && !self.overdue {
            let phase = self.machine.phase();
            tracing::error!("{phase} takes longer than it can; the watchdog is not fed any more");
        }
        self.overdue = overdue;
        if !overdue {
            self.hands.systemd.alive();
        }
        if Instant::now() >= self.retention_due && self.machine.in_hand().is_none() {
            self.retain();
        }
    }

    /// The configuration is about to be read again.
    pub fn reloading(&self) {
        self.hands.systemd.reloading();
    }

    /// The service shall end.
    pub fn stop(&mut self) {
        self.hands.systemd.stopping();
        self.hands.ledger.hurry();
        self.handle(Event::Shutdown);
    }

    /// Ends: everything asked of the writer is on disk when this returns, unless the disk takes longer than `limit`.
    pub fn finish(mut self, limit: Duration) {
        if !self.exited {
            let text = "the devices did not come to rest in time; ended without them";
            self.note(Level::Error, "service", text.to_owned());
        }
        self.note(Level::Info, "service", "patrold stopped".to_owned());
        if !self.hands.ledger.finish(limit) {
            tracing::error!("the disk did not take everything in time; ended without it");
        }
    }

    fn handle(&mut self, event: Event) {
        let now = self.hands.robot.clock().now();
        let actions = self.machine.handle(now, event);
        // First the status, so that whoever has an answer never sees an older one.
        self.tell_status();
        self.perform(actions);
    }

    fn robot_event(&mut self, event: RobotEvent) -> Event {
        match event {
            RobotEvent::Ready(identity) => {
                self.hands
                    .status
                    .send_modify(|status| status.devices.identity = identity);
                Event::DevicesReady
            }
            RobotEvent::Failed(reason) => Event::DevicesFailed(reason),
            RobotEvent::Absent(reason) => Event::DevicesAbsent(reason),
            RobotEvent::Lost(reason) => Event::DevicesLost(reason),
            RobotEvent::Closed => Event::DevicesClosed,
            RobotEvent::Swept(id, raw) => {
                let spent = self
                    .hands
                    .robot
                    .clock()
                    .now()
                    .saturating_sub(self.sweep_began);
                if let Some(work) = self.work.as_mut().filter(|w| w.request.id == id) {
                    work.timing.sweep += spent.as_secs_f64() * 1e3;
                    self.raw = Some(*raw);
                }
                Event::SweepDone(id)
            }
            RobotEvent::Returned(took) => {
                let return_ms = took.map(|took| took.as_secs_f64() * 1e3);
                self.hands
                    .status
                    .send_modify(|status| status.devices.return_ms = return_ms);
                // Nothing follows from it.
                Event::Tick
            }
            RobotEvent::SweepFailed(id, fault) => Event::SweepFailed {
                id,
                reason: fault.reason,
                lost: fault.lost,
            },
        }
    }

    fn asked(&mut self, ask: Ask) -> Event {
        self.requests += 1;
        let id = self.requests;
        self.answers.insert(id, ask.answer);
        Event::Requested(Request {
            id,
            task: ask.task,
            waypoint: ask.waypoint,
        })
    }

    fn perform(&mut self, actions: Vec<Action>) {
        for action in actions {
            match action {
                Action::OpenDevices => self.hands.robot.open(Arc::clone(&self.settings)),
                Action::CancelDevices => self.hands.robot.cancel(),
                Action::CloseDevices => self.hands.robot.close(),
                Action::DistrustHead => self.hands.robot.distrust(),
                Action::Prepare(request) => self.prepare(request),
                Action::StartSweep(request) => self.start_sweep(request),
                Action::Judge(request) => self.judge(&request),
                Action::Record(request) => self.record(request, None),
                Action::RecordNotObserved(request, reason) => self.record(request, Some(reason)),
                Action::Reply(request) => self.reply(&request),
                Action::Refuse(request, refusal) => {
                    let (task, waypoint) = (request.task.word(), &request.waypoint);
                    tracing::warn!(WAYPOINT = %waypoint, "{task} {waypoint}: {refusal}");
                    self.answer(request.id, Reply::Refused(refusal));
                }
                Action::Drop(request) => self.forget(&request),
                Action::ApplySettings => self.apply(),
                Action::KeepSettings(mistakes) => self.keep(&mistakes),
                Action::Note(weight, text) => {
                    let level = match weight {
                        Weight::Info => Level::Info,
                        Weight::Warning => Level::Warning,
                        Weight::Error => Level::Error,
                    };
                    self.note(level, "devices", text);
                }
                Action::Exit => self.exited = true,
            }
        }
    }

    /// The work gathered for this request so far.
    fn work_for(&mut self, request: Request) -> Work {
        match self.work.take() {
            Some(work) if work.request.id == request.id => work,
            _ => Work::new(request, Arc::clone(&self.settings)),
        }
    }

    fn prepare(&mut self, request: Request) {
        let (id, waypoint) = (request.id, request.waypoint.clone());
        self.work = Some(self.work_for(request));
        let inbox = self.hands.inbox.clone();
        self.hands.ledger.ask(
            move |store| store.reference(&waypoint).map_err(refusal),
            move |found| send(&inbox, Message::Prepared(id, found)),
        );
    }

    fn start_sweep(&mut self, request: Request) {
        let waypoint = (request.task != Task::Sweep).then(|| request.waypoint.clone());
        let mut work = self.work_for(request);
        work.settings = Arc::clone(&self.settings);
        self.sweep_began = self.hands.robot.clock().now();
        self.hands
            .robot
            .sweep(work.request.id, Arc::clone(&work.settings), waypoint);
        self.work = Some(work);
    }

    fn judge(&mut self, request: &Request) {
        let (Some(work), Some(raw)) = (&self.work, self.raw.take()) else {
            // The sweep comes before its judgement, so both are there; without them there is no verdict.
            let lost = Event::Judged(request.id, Err("the sweep was lost".to_owned()));
            return self.handle(lost);
        };
        let (id, task, waypoint) = (request.id, request.task, request.waypoint.clone());
        let reference = work.reference.clone();
        let again = work.swept_again;
        let settings = Arc::clone(&work.settings);
        let (ready, inbox) = (self.ready.clone(), self.hands.inbox.clone());
        self.began = Instant::now();
        self.judging = true;
        let judging = tokio::task::spawn_blocking(move || {
            let reference = reference.as_deref();
            judge(task, &waypoint, &raw, again, reference, &settings, &ready)
        });
        tokio::spawn(async move {
            let judged = judging.await.unwrap_or_else(Judged::broken);
            send(&inbox, Message::Judged(id, judged));
        });
    }

    fn record(&mut self, request: Request, instead: Option<String>) {
        let id = request.id;
        let work = self.work_for(request);
        let inbox = self.hands.inbox.clone();
        self.judging = false;
        self.began = Instant::now();
        self.hands.ledger.ask(
            move |store| work.record(store, instead.as_deref(), &stamp_now()),
            move |result| send(&inbox, Message::Recorded(id, result)),
        );
    }

    fn lap_ms(&self) -> f64 {
        self.began.elapsed().as_secs_f64() * 1e3
    }
}

fn send(inbox: &UnboundedSender<Message>, message: Message) {
    // The loop may have ended before its helpers.
    let _ = inbox.send(message);
}
