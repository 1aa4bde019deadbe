//! The thread that owns the scanner. Its calls block; each has a deadline that the watchdog enforces.

use super::constants::{
    CONNECT_AND_HOME_LIMIT, IDLE_CHECK_INTERVAL, MAX_TILT_TIME_RATIO, RECOVERY_LIMIT,
    RETURN_TO_START_LIMIT, SEGMENT_LIMIT, STEP_LINE_LIMIT,
};
use super::scanner::{ConnectError, DeviceNoteSink, Scanner, ScannerConnector, ScannerError};
use crate::config::{Settings, SweepMode};
use crate::devices::Cancel;
use link::Clock;
use patrold_engine::sweep::RawSweep;
use serde_json::Value;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Texts are reasons, numbers request ids.
#[derive(Debug)]
pub(super) enum ScannerEvent {
    /// Connected and homed; the description of the devices.
    Ready(Value),
    /// Not connected.
    Failed(String),
    /// Not connected: a device is not plugged in.
    Absent(String),
    /// Disconnected while idle.
    Lost(String),
    /// The head was homed; before the event of the command that did it.
    Homed,
    /// The homing that was asked for is over.
    HomingDone,
    /// The devices are released.
    Closed,
    /// A sweep, and the bytes of the devices where they were recorded.
    Swept(u64, Box<RawSweep>, Option<Vec<u8>>),
    /// How long the head's return to the start took on the devices' clock; `None` where it did not get there.
    Returned(Option<Duration>),
    /// No sweep, and what came of it.
    SweepFailed(u64, ScannerError, Option<Vec<u8>>),
}

enum ScannerCommand {
    Open(Arc<Settings>, Cancel),
    Sweep(u64, Arc<Settings>, Option<String>, Cancel),
    DistrustHead,
    Home(Cancel),
    Close,
}

/// Of the call under way.
type CallDeadline = Arc<Mutex<Option<Instant>>>;

/// Handle of the thread.
pub(super) struct ScannerThread {
    commands: Sender<ScannerCommand>,
    clock: Clock,
    /// Of the last command.
    cancel: Cancel,
    /// Of the last sweep: the head's return may still be under way after the next command was sent.
    sweep_cancel: Cancel,
    call_deadline: CallDeadline,
}

impl ScannerThread {
    pub(super) fn spawn(
        connector: Box<dyn ScannerConnector>,
        clock: Clock,
        notes: DeviceNoteSink,
        on_event: impl FnMut(ScannerEvent) + Send + 'static,
    ) -> std::io::Result<Self> {
        let (commands, inbox) = mpsc::channel();
        let call_deadline = CallDeadline::default();
        let worker = ScannerWorker {
            connector,
            notes,
            clock: clock.clone(),
            scanner: None,
            settings: None,
            call_deadline: Arc::clone(&call_deadline),
            homings: 0,
            on_event,
        };
        thread::Builder::new()
            .name("patrold-scanner".to_owned())
            .spawn(move || worker.run(&inbox))?;
        Ok(Self {
            commands,
            clock,
            cancel: Cancel::new(),
            sweep_cancel: Cancel::new(),
            call_deadline,
        })
    }

    /// Releases the devices if they are open, connects and homes them.
    pub(super) fn open(&mut self, settings: Arc<Settings>) {
        self.cancel = Cancel::new();
        self.send(ScannerCommand::Open(settings, self.cancel.clone()));
    }

    pub(super) fn sweep(&mut self, id: u64, settings: Arc<Settings>, waypoint: Option<String>) {
        self.cancel = Cancel::new();
        self.sweep_cancel = self.cancel.clone();
        self.send(ScannerCommand::Sweep(
            id,
            settings,
            waypoint,
            self.cancel.clone(),
        ));
    }

    /// The head is homed before the next sweep.
    pub(super) fn distrust_head(&self) {
        self.send(ScannerCommand::DistrustHead);
    }

    /// Homes the head now.
    pub(super) fn home(&mut self) {
        self.cancel = Cancel::new();
        self.send(ScannerCommand::Home(self.cancel.clone()));
    }

    /// Interrupts the last command, and the return after the last sweep.
    pub(super) fn cancel(&self) {
        self.cancel.cancel();
        self.sweep_cancel.cancel();
    }

    /// Releases the devices.
    pub(super) fn close(&self) {
        self.send(ScannerCommand::Close);
    }

    /// Whether a call hangs at `now`.
    pub(super) fn is_overdue(&self, now: Instant) -> bool {
        lock(&self.call_deadline).is_some_and(|until| now > until)
    }

    /// The devices' clock.
    pub(super) fn clock(&self) -> &Clock {
        &self.clock
    }

    fn send(&self, command: ScannerCommand) {
        // The thread lives as long as this handle.
        let _ = self.commands.send(command);
    }
}

fn lock(deadline: &CallDeadline) -> std::sync::MutexGuard<'_, Option<Instant>> {
    deadline.lock().unwrap_or_else(PoisonError::into_inner)
}

struct ScannerWorker<F> {
    connector: Box<dyn ScannerConnector>,
    notes: DeviceNoteSink,
    clock: Clock,
    scanner: Option<Box<dyn Scanner>>,
    /// Of the last connect.
    settings: Option<Arc<Settings>>,
    call_deadline: CallDeadline,
    /// Homings that were reported.
    homings: u64,
    on_event: F,
}

impl<F: FnMut(ScannerEvent)> ScannerWorker<F> {
    fn run(mut self, inbox: &Receiver<ScannerCommand>) {
        loop {
            let command = match inbox.recv_timeout(IDLE_CHECK_INTERVAL) {
                Ok(command) => Some(command),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            let event = match command {
                None => self.check_connected(),
                Some(command) => self.execute(command),
            };
            self.report_homing();
            if let Some(event) = event {
                (self.on_event)(event);
            }
        }
    }

    fn report_homing(&mut self) {
        let Some(homings) = self.scanner.as_ref().map(|scanner| scanner.homings()) else {
            return;
        };
        if homings != self.homings {
            self.homings = homings;
            (self.on_event)(ScannerEvent::Homed);
        }
    }

    fn execute(&mut self, command: ScannerCommand) -> Option<ScannerEvent> {
        match command {
            ScannerCommand::Open(settings, cancel) => self.open(settings, &cancel),
            ScannerCommand::Sweep(id, settings, waypoint, cancel) => {
                let event = self.sweep(id, &settings, waypoint.as_deref(), &cancel);
                let swept = matches!(event, ScannerEvent::Swept(..));
                self.report_homing();
                // Before the return: the sweep is judged meanwhile.
                (self.on_event)(event);
                if !swept {
                    return None;
                }
                let duration = self.return_to_start(&cancel);
                (self.on_event)(ScannerEvent::Returned(duration));
                // Reports devices that were lost during the return.
                self.check_connected()
            }
            ScannerCommand::DistrustHead => {
                self.scanner.as_mut()?.distrust_head();
                None
            }
            ScannerCommand::Home(cancel) => self.home(&cancel),
            ScannerCommand::Close => {
                self.scanner = None;
                Some(ScannerEvent::Closed)
            }
        }
    }

    fn check_connected(&mut self) -> Option<ScannerEvent> {
        let error = self
            .scanner
            .as_mut()?
            .check_connected()
            .err()
            .filter(|e| e.lost)?;
        Some(ScannerEvent::Lost(error.reason))
    }

    /// No event where it was cancelled: another command follows.
    fn open(&mut self, settings: Arc<Settings>, cancel: &Cancel) -> Option<ScannerEvent> {
        self.start_call(CONNECT_AND_HOME_LIMIT);
        let event = match self.resume_or_connect(settings, cancel) {
            Ok(description) => ScannerEvent::Ready(description),
            Err(ConnectError { reason, absent }) if absent => ScannerEvent::Absent(reason),
            Err(ConnectError { reason, .. }) => ScannerEvent::Failed(reason),
        };
        self.end_call();
        (!cancel.is_cancelled()).then_some(event)
    }

    /// A scanner that lost one device keeps the other, and its state.
    fn resume_or_connect(
        &mut self,
        settings: Arc<Settings>,
        cancel: &Cancel,
    ) -> Result<Value, ConnectError> {
        let same = |old: &Arc<Settings>| old.laser == settings.laser && old.ptu == settings.ptu;
        if let Some(scanner) = self
            .scanner
            .as_mut()
            .filter(|_| self.settings.as_ref().is_some_and(same))
        {
            match scanner.resume(cancel) {
                Ok(()) => return Ok(scanner.describe()),
                Err(error) if error.absent || cancel.is_cancelled() => return Err(error),
                Err(_) => {}
            }
        }
        self.scanner = None;
        let mut scanner = self.connector.connect(&settings, &self.notes, cancel)?;
        let description = scanner.describe();
        (self.scanner, self.settings) = (Some(scanner), Some(settings));
        Ok(description)
    }

    fn sweep(
        &mut self,
        id: u64,
        settings: &Settings,
        waypoint: Option<&str>,
        cancel: &Cancel,
    ) -> ScannerEvent {
        self.start_call(max_sweep_duration(settings, waypoint));
        let result = match &mut self.scanner {
            Some(scanner) => scanner.sweep(settings, waypoint, cancel),
            None => Err(ScannerError {
                reason: "the devices are not open".to_owned(),
                lost: true,
            }),
        };
        self.end_call();
        let dialogue = self.scanner.as_mut().and_then(|s| s.take_dialogue());
        match result {
            Ok(raw_sweep) => ScannerEvent::Swept(id, Box::new(raw_sweep), dialogue),
            Err(error) => ScannerEvent::SweepFailed(id, error, dialogue),
        }
    }

    /// No event where it was cancelled: another command follows.
    fn home(&mut self, cancel: &Cancel) -> Option<ScannerEvent> {
        self.start_call(CONNECT_AND_HOME_LIMIT);
        let homed = self.scanner.as_mut().map(|scanner| scanner.home(cancel));
        self.end_call();
        match homed {
            _ if cancel.is_cancelled() => None,
            Some(Ok(())) => Some(ScannerEvent::HomingDone),
            Some(Err(error)) => Some(ScannerEvent::Failed(error.reason)),
            None => Some(ScannerEvent::Lost("the devices are not open".to_owned())),
        }
    }

    fn return_to_start(&mut self, cancel: &Cancel) -> Option<Duration> {
        self.start_call(RETURN_TO_START_LIMIT);
        let duration = self
            .scanner
            .as_mut()
            .and_then(|scanner| scanner.return_to_start(cancel));
        self.end_call();
        duration
    }

    fn start_call(&self, limit: Duration) {
        *lock(&self.call_deadline) = Some(Instant::now() + self.clock.wall_time(limit));
    }

    fn end_call(&self) {
        *lock(&self.call_deadline) = None;
    }
}

/// On the devices' clock.
pub(super) fn max_sweep_duration(settings: &Settings, waypoint: Option<&str>) -> Duration {
    let sweep = &settings.sweep;
    let segments = settings.pans_rad(waypoint).len();
    let span_rad = (sweep.tilt_to_rad - sweep.tilt_from_rad).abs();
    let tilting = match sweep.mode {
        SweepMode::Continuous => {
            Duration::try_from_secs_f64(MAX_TILT_TIME_RATIO * span_rad / sweep.speed_rad_s)
        }
        SweepMode::Step => Duration::try_from_secs_f64(
            STEP_LINE_LIMIT.as_secs_f64() * (span_rad / sweep.step_rad + 1.0),
        ),
    };
    let segment = tilting.unwrap_or(Duration::ZERO) + SEGMENT_LIMIT;
    RECOVERY_LIMIT + segment * u32::try_from(segments).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests;
