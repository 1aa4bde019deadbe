//! Turns the messages of the service loop into patrol events, and carries out the patrol's actions.

use super::active_request::ActiveRequest;
use super::constants::JUDGE_LIMIT;
use super::judgement::{SweepJudgement, judge_sweep};
use super::later_requests::LaterRequests;
use super::logging::LogLevelHandle;
use super::message::{ServiceMessage, TeachOptions};
use super::message_id;
use super::record_time::record_time_now;
use super::reference_cache::ReferenceCache;
use super::replies::{ReloadReply, ServiceReply, StatusReply};
use super::running_restore::RunningRestore;
use super::scanner_thread::ScannerThread;
use super::storage_watch::StorageWatch;
use super::store_writer::StoreWriter;
use super::systemd::SystemdNotifier;
use super::wall_clock::WallClockMonitor;
use super::work_estimate::{WorkEstimate, planned_sweep};
use crate::config::{LoadedConfig, Settings};
use crate::devices::SweepRequest;
use crate::patrol::action::PatrolAction;
use crate::patrol::event::{PatrolEvent, PatrolRequest, PatrolTask};
use crate::patrol::machine::PatrolMachine;
use crate::patrol::severity::Severity;
use patrold_engine::sweep::RawSweep;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::UnboundedSender;
use tokio::sync::{oneshot, watch};

mod accepting;
mod acknowledging;
mod clients;
mod housekeeping;
mod preparing;
mod requests;
mod scanner_events;
mod storage;
mod reloading;
mod restoring;

/// Threads and channels that the controller acts through.
pub(super) struct Services {
    pub(super) scanner: ScannerThread,
    pub(super) writer: StoreWriter,
    pub(super) systemd: SystemdNotifier,
    /// `None` where another program set up logging.
    pub(super) log: Option<LogLevelHandle>,
    /// Results come back to the loop through it.
    pub(super) inbox: UnboundedSender<ServiceMessage>,
    /// Answer to `GET /status`.
    pub(super) status: watch::Sender<StatusReply>,
}

pub(super) struct Controller {
    services: Services,
    machine: PatrolMachine,
    settings: Arc<Settings>,
    /// Valid configuration that the patrol has not applied yet.
    next_config: Option<Box<LoadedConfig>>,
    /// Clients that wait until it is applied.
    reload_clients: Vec<oneshot::Sender<ReloadReply>>,
    references: ReferenceCache,
    /// Waiting clients by request id.
    reply_channels: HashMap<u64, oneshot::Sender<ServiceReply>>,
    /// Those whose clients do not wait.
    later: LaterRequests,
    /// Of requests that have not begun.
    teach_options: HashMap<u64, TeachOptions>,
    last_request_id: u64,
    active: Option<ActiveRequest>,
    raw_sweep: Option<RawSweep>,
    recorded_reply: Option<ServiceReply>,
    /// When judging or recording began.
    step_started: Instant,
    /// On the devices' clock.
    sweep_started: Duration,
    estimate: WorkEstimate,
    judging: bool,
    overdue: bool,
    retention_due: Instant,
    storage: StorageWatch,
    maintaining: bool,
    maintenance_due: Instant,
    unseen_due: Instant,
    restore: Option<RunningRestore>,
    /// What was last noted of each subject.
    health: HashMap<&'static str, Option<String>>,
    /// The last note of each device.
    device_notes: HashMap<String, String>,
    exited: bool,
    started: Instant,
    wall_clock: WallClockMonitor,
}

impl Controller {
    pub(super) fn start(services: Services, loaded: &LoadedConfig) -> Self {
        let settings = Arc::new(loaded.settings.clone());
        let (machine, first_actions) =
            PatrolMachine::start(settings.ptu.suspect_pan_rad, settings.ptu.suspect_tilt_rad);
        let now = Instant::now();
        let mut controller = Self {
            services,
            machine,
            settings,
            next_config: None,
            reload_clients: Vec::new(),
            references: ReferenceCache::default(),
            reply_channels: HashMap::new(),
            later: LaterRequests::new(jiff::Timestamp::now()),
            teach_options: HashMap::new(),
            last_request_id: 0,
            active: None,
            raw_sweep: None,
            recorded_reply: None,
            step_started: now,
            sweep_started: Duration::ZERO,
            estimate: WorkEstimate::new(),
            judging: false,
            overdue: false,
            retention_due: now,
            storage: StorageWatch::default(),
            maintaining: false,
            maintenance_due: now,
            unseen_due: now,
            restore: None,
            health: HashMap::new(),
            device_notes: HashMap::new(),
            exited: false,
            started: now,
            wall_clock: WallClockMonitor::default(),
        };
        let version = env!("CARGO_PKG_VERSION");
        controller.log_event(
            Severity::Info,
            "service",
            format!("patrold {version} started"),
        );
        controller.keep_configuration(loaded);
        controller.perform(first_actions);
        controller.publish_status();
        controller
    }

    pub(super) fn notify_ready(&self) {
        self.services.systemd.ready();
    }

    pub(super) fn has_exited(&self) -> bool {
        self.exited
    }

    pub(super) fn handle_message(&mut self, message: ServiceMessage) {
        self.drop_disconnected_clients();
        let event = match message {
            ServiceMessage::Scanner(event) => self.scanner_event(event),
            ServiceMessage::Request(request) => return self.accept_request(request),
            ServiceMessage::RequestState(id, client) => return self.report_request(&id, client),
            ServiceMessage::CancelRequest(id, client) => return self.cancel_request(&id, client),
            ServiceMessage::Prepared(id, found) => {
                let found = found.map(|basis| {
                    if let Some(active) = self.active.as_mut().filter(|a| a.request.id == id) {
                        active.basis = basis.map(Arc::from);
                    }
                });
                PatrolEvent::Prepared(id, found)
            }
            ServiceMessage::Judged(id, judgement) => {
                let result = judgement.finding.as_ref().map(|_| ()).map_err(Clone::clone);
                let spent_ms = self.step_ms();
                if self.active.as_ref().is_some_and(|a| a.request.id == id) {
                    self.note_health("sweep", judgement.sweep_fault.as_deref());
                }
                if let Some(active) = self.active.as_mut().filter(|a| a.request.id == id) {
                    self.judging = false;
                    active.timing.judge += spent_ms;
                    if let Some(reason) = judgement.suspected_lost_steps {
                        active.repeated_sweep = true;
                        return self.handle(PatrolEvent::LostStepsSuspected(id, reason));
                    }
                    let seen = judgement.turn.clone();
                    active.judgement = Some(*judgement);
                    if let Some(seen) = seen {
                        self.handle(PatrolEvent::ViewTurned(seen));
                    }
                }
                PatrolEvent::Judged(id, result)
            }
            ServiceMessage::Recorded(id, result) => {
                let result = result.map_err(|refusal| refusal.to_string());
                PatrolEvent::Recorded(id, result.map(|reply| self.recorded_reply = Some(reply)))
            }
            ServiceMessage::ConfigRead(Ok(loaded), client) => {
                let change = self.settings_change(&loaded.settings);
                self.next_config = Some(loaded);
                self.reload_clients.extend(client);
                PatrolEvent::Reload(Ok(change))
            }
            ServiceMessage::ConfigRead(Err(errors), client) => {
                let mistakes: Vec<String> = errors.iter().map(ToString::to_string).collect();
                self.refuse_reload(mistakes.clone(), client);
                PatrolEvent::Reload(Err(mistakes))
            }
            ServiceMessage::Storage(report) => return self.report_storage(&report),
            ServiceMessage::Acknowledge(request, reply_to) => {
                return self.acknowledge(request, reply_to);
            }
            ServiceMessage::Accept(request, client) => return self.accept(request, client),
            ServiceMessage::AcceptPrepared(prepared, request, client) => {
                return self.store_acceptance(*prepared, request, client);
            }
            ServiceMessage::Restore(from, client) => return self.restore(from, client),
            ServiceMessage::RestoreStep(step) => return self.restore_step(*step),
            ServiceMessage::HealthUnwritten(subject) => {
                self.health.remove(subject);
                return;
            }
            // The loop reads the files and sends what they have.
            ServiceMessage::ReloadRequested(_) => return,
            ServiceMessage::Note(severity, device, text) => {
                return self.log_note(severity, device, text);
            }
        };
        self.handle(event);
    }

    pub(super) fn tick(&mut self) {
        self.tick_at(Instant::now());
    }

    fn tick_at(&mut self, now: Instant) {
        self.drop_disconnected_clients();
        self.watch_clock();
        self.handle(PatrolEvent::Tick);
        let judging_overdue =
            self.judging && now.saturating_duration_since(self.step_started) > JUDGE_LIMIT;
        let overdue = judging_overdue
            || self.services.scanner.is_overdue(now)
            || self.services.writer.is_overdue(now);
        if overdue && !self.overdue {
            let phase = self.machine.phase();
            tracing::error!("{phase} timed out; watchdog notifications stopped");
        }
        self.overdue = overdue;
        if !overdue {
            self.services.systemd.feed_watchdog();
        }
        if now >= self.unseen_due {
            self.note_unseen();
        }
        let may_delete = self.restore.is_none() && self.machine.current().is_none();
        if now >= self.retention_due && may_delete {
            self.apply_retention();
        }
        self.replace_store_if_idle();
        self.maintain_storage(now);
    }

    pub(super) fn stop(&mut self) {
        self.services.systemd.stopping();
        self.services.writer.skip_optional();
        self.handle(PatrolEvent::Shutdown);
    }

    /// Writes everything submitted to disk; gives up after `limit`.
    pub(super) fn finish(mut self, limit: Duration) {
        if !self.exited {
            let text = "the devices did not stop in time; service ended without them";
            self.log_event(Severity::Error, "service", text.to_owned());
        }
        self.log_event(Severity::Info, "service", "patrold stopped".to_owned());
        self.write_held_visits();
        if !self.services.writer.finish(limit) {
            tracing::error!("flush timed out; the last records may be lost");
        }
    }

    fn handle(&mut self, event: PatrolEvent) {
        let now = self.services.scanner.clock().now();
        let actions = self.machine.handle(now, event);
        // Before the replies: a client that has its reply never reads an older status.
        self.publish_status();
        self.perform(actions);
    }

    fn perform(&mut self, actions: Vec<PatrolAction>) {
        for action in actions {
            match action {
                PatrolAction::OpenDevices => self.services.scanner.open(Arc::clone(&self.settings)),
                PatrolAction::CancelDevices => self.services.scanner.cancel(),
                PatrolAction::CloseDevices => self.services.scanner.close(),
                PatrolAction::DistrustHead => self.services.scanner.distrust_head(),
                PatrolAction::HomeHead => self.services.scanner.home(),
                PatrolAction::Prepare(request) => self.prepare(request),
                PatrolAction::StartSweep(request) => self.start_sweep(request),
                PatrolAction::Judge(request) => self.judge(&request),
                PatrolAction::Record(request) => self.record(request, None),
                PatrolAction::RecordNotObserved(request, reason) => {
                    self.record(request, Some(reason))
                }
                PatrolAction::Reply(request) => self.reply(&request),
                PatrolAction::Refuse(request, refusal) => {
                    let (task, waypoint) = (request.task.as_str(), &request.waypoint);
                    tracing::warn!(MESSAGE_ID = message_id::REQUEST_REFUSED, WAYPOINT = %waypoint, "{task} {waypoint}: {refusal}");
                    self.teach_options.remove(&request.id);
                    self.send_reply(request.id, ServiceReply::Refused(refusal));
                }
                PatrolAction::Abandon(request) => self.abandon(&request),
                PatrolAction::ApplySettings => self.apply_settings(),
                PatrolAction::KeepSettings(errors) => self.keep_settings(&errors),
                PatrolAction::LogEvent(severity, text) => self.log_patrol(severity, text),
                PatrolAction::Exit => self.exited = true,
            }
        }
    }

    fn active_for(&mut self, request: PatrolRequest) -> ActiveRequest {
        match self.active.take() {
            Some(active) if active.request.id == request.id => active,
            _ => {
                let teach = self.teach_options.remove(&request.id).unwrap_or_default();
                ActiveRequest::new(request, Arc::clone(&self.settings), teach)
            }
        }
    }

    fn start_sweep(&mut self, request: PatrolRequest) {
        let waypoint = (request.task != PatrolTask::Sweep).then(|| request.waypoint.clone());
        let mut active = self.active_for(request);
        active.settings = Arc::clone(&self.settings);
        let clock = self.services.scanner.clock();
        self.sweep_started = clock.now();
        let planned = planned_sweep(
            &SweepRequest::new(&active.settings, waypoint.as_deref()),
            clock,
        );
        self.estimate.start_sweep(planned);
        self.services
            .scanner
            .sweep(active.request.id, Arc::clone(&active.settings), waypoint);
        self.active = Some(active);
    }

    fn judge(&mut self, request: &PatrolRequest) {
        let (Some(active), Some(raw)) = (&self.active, self.raw_sweep.take()) else {
            // Unreachable as long as the patrol asks for a sweep first.
            let lost = PatrolEvent::Judged(request.id, Err("the sweep was lost".to_owned()));
            return self.handle(lost);
        };
        let (id, task, waypoint) = (request.id, request.task, request.waypoint.clone());
        let basis = active.basis.clone();
        let repeated = active.repeated_sweep;
        let settings = Arc::clone(&active.settings);
        let (references, inbox) = (self.references.clone(), self.services.inbox.clone());
        self.step_started = Instant::now();
        self.judging = true;
        let judging = tokio::task::spawn_blocking(move || {
            let basis = basis.as_deref();
            judge_sweep(
                task,
                &waypoint,
                &raw,
                repeated,
                basis,
                &settings,
                &references,
            )
        });
        tokio::spawn(async move {
            let judgement = judging
                .await
                .unwrap_or_else(SweepJudgement::from_join_error);
            send(&inbox, ServiceMessage::Judged(id, Box::new(judgement)));
        });
    }

    fn record(&mut self, request: PatrolRequest, not_observed: Option<String>) {
        let id = request.id;
        let active = self.active_for(request);
        let inbox = self.services.inbox.clone();
        self.judging = false;
        self.step_started = Instant::now();
        self.services.writer.submit(
            move |ledger| active.record(ledger, not_observed.as_deref(), &record_time_now()),
            move |result| send(&inbox, ServiceMessage::Recorded(id, result)),
        );
    }

    fn step_ms(&self) -> f64 {
        self.step_started.elapsed().as_secs_f64() * 1e3
    }
}

#[cfg(test)]
mod tests;

fn send(inbox: &UnboundedSender<ServiceMessage>, message: ServiceMessage) {
    // The loop may have ended before the sender.
    let _ = inbox.send(message);
}
