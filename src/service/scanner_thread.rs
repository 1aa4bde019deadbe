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
    let segments = match waypoint {
        Some(name) => settings.pans_rad(name).len(),
        None => sweep.pans_rad.len(),
    };
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
mod tests {
    use super::{
        CONNECT_AND_HOME_LIMIT, RETURN_TO_START_LIMIT, ScannerEvent, ScannerThread,
        max_sweep_duration,
    };
    use crate::config::{Settings, SweepMode};
    use crate::devices::Cancel;
    use crate::service::scanner::{
        ConnectError, DeviceNoteSink, Scanner, ScannerConnector, ScannerError,
    };
    use crate::service::visit_tests::empty_sweep::empty_sweep;
    use link::Clock;
    use patrold_engine::sweep::RawSweep;
    use serde_json::Value;
    use std::sync::{Arc, Mutex, mpsc};
    use std::thread;
    use std::time::{Duration, Instant};

    /// Homes in every call that may, and tells how often.
    #[derive(Default)]
    struct CountingScanner(u64);

    impl ScannerConnector for CountingScanner {
        fn connect(
            &mut self,
            _: &Settings,
            _: &DeviceNoteSink,
            _: &Cancel,
        ) -> Result<Box<dyn Scanner>, ConnectError> {
            Ok(Box::new(Self(1)))
        }
    }

    impl Scanner for CountingScanner {
        fn describe(&mut self) -> Value {
            Value::Null
        }

        fn home(&mut self, _: &Cancel) -> Result<(), ScannerError> {
            self.0 += 1;
            Ok(())
        }

        fn homings(&self) -> u64 {
            self.0
        }

        fn sweep(
            &mut self,
            _: &Settings,
            waypoint: Option<&str>,
            _: &Cancel,
        ) -> Result<RawSweep, ScannerError> {
            self.0 += u64::from(waypoint == Some("lost"));
            Err(ScannerError {
                reason: "none here".to_owned(),
                lost: false,
            })
        }
    }

    #[test]
    fn a_homing_is_told_before_what_followed_and_once() {
        let (sender, events) = mpsc::channel();
        let mut thread = ScannerThread::spawn(
            Box::new(CountingScanner::default()),
            Clock::real(),
            DeviceNoteSink::new(|_, _, _| ()),
            move |event| drop(sender.send(event)),
        )
        .expect("a thread");
        let settings = Arc::new(Settings::defaults());
        thread.open(Arc::clone(&settings));
        thread.sweep(1, Arc::clone(&settings), Some("hall".to_owned()));
        thread.sweep(2, settings, Some("lost".to_owned()));
        thread.home();
        use ScannerEvent as E;
        let told: Vec<String> = (0..7)
            .map(|_| match events.recv().expect("the thread runs") {
                E::Homed => "homed".to_owned(),
                E::HomingDone => "homing done".to_owned(),
                E::Ready(_) => "ready".to_owned(),
                E::SweepFailed(id, ..) => format!("sweep {id}"),
                other => format!("{other:?}"),
            })
            .collect();
        assert_eq!(
            told,
            [
                "homed",
                "ready",
                "sweep 1",
                "homed",
                "sweep 2",
                "homed",
                "homing done"
            ]
        );
    }

    /// Its sweep hangs until the sender is dropped.
    struct HangingScanner(Arc<Mutex<mpsc::Receiver<()>>>);

    impl ScannerConnector for HangingScanner {
        fn connect(
            &mut self,
            _: &Settings,
            _: &DeviceNoteSink,
            _: &Cancel,
        ) -> Result<Box<dyn Scanner>, ConnectError> {
            Ok(Box::new(Self(Arc::clone(&self.0))))
        }
    }

    impl Scanner for HangingScanner {
        fn describe(&mut self) -> Value {
            Value::Null
        }

        fn sweep(
            &mut self,
            _: &Settings,
            _: Option<&str>,
            _: &Cancel,
        ) -> Result<RawSweep, ScannerError> {
            let _ = self.0.lock().expect("one thread").recv();
            Err(ScannerError {
                reason: "the read returned".to_owned(),
                lost: true,
            })
        }
    }

    #[test]
    fn a_hanging_call_is_overdue_until_it_returns() {
        let (release, hang) = mpsc::channel();
        let (sender, events) = mpsc::channel();
        let mut thread = ScannerThread::spawn(
            Box::new(HangingScanner(Arc::new(Mutex::new(hang)))),
            Clock::real(),
            DeviceNoteSink::new(|_, _, _| ()),
            move |event| drop(sender.send(event)),
        )
        .expect("a thread");
        let settings = Arc::new(Settings::defaults());
        thread.open(Arc::clone(&settings));
        let ready = events.recv().expect("the thread runs");
        assert!(matches!(ready, ScannerEvent::Ready(_)), "{ready:?}");
        let soon = Instant::now();
        let late = soon + max_sweep_duration(&settings, None) + Duration::from_secs(60);
        assert!(!thread.is_overdue(late), "no call");
        thread.sweep(1, settings, None);
        while !thread.is_overdue(late) {
            thread::yield_now();
        }
        assert!(!thread.is_overdue(soon), "not yet");
        // Cancelling does not end the read: only systemd's watchdog does.
        thread.cancel();
        assert!(thread.is_overdue(late));
        drop(release);
        let failed = events.recv().expect("the thread runs");
        assert!(
            matches!(failed, ScannerEvent::SweepFailed(1, ..)),
            "{failed:?}"
        );
        assert!(!thread.is_overdue(late));
    }

    #[test]
    fn max_sweep_duration_grows_with_segments_and_lines() {
        let mut settings = Settings::defaults();
        // 90 s of recovery and homing, twice the 12 s that 60 deg at 5 deg/s take, 60 s for the segment.
        assert_eq!(max_sweep_duration(&settings, None).as_secs(), 174);
        settings.sweep.pans_rad = vec![0.0, 1.0];
        assert_eq!(max_sweep_duration(&settings, Some("hall")).as_secs(), 258);
        // 90 s, and twice 3 s for each of 3 lines and 60 s.
        settings.sweep.mode = SweepMode::Step;
        (settings.sweep.tilt_from_rad, settings.sweep.tilt_to_rad) = (-0.25, 0.75);
        settings.sweep.step_rad = 0.5;
        assert_eq!(max_sweep_duration(&settings, None).as_secs(), 228);
        settings.sweep.step_rad = 0.25;
        assert_eq!(max_sweep_duration(&settings, None).as_secs(), 240);
    }

    /// What a scripted scanner was asked, in order; each call waits for leave, so that it can be seen under way.
    #[derive(Clone)]
    struct Scripted {
        calls: mpsc::Sender<&'static str>,
        leave: Arc<Mutex<mpsc::Receiver<()>>>,
    }

    impl Scripted {
        fn call(&self, name: &'static str) {
            self.calls.send(name).expect("the test listens");
            self.leave
                .lock()
                .expect("one thread")
                .recv()
                .expect("leave");
        }
    }

    impl ScannerConnector for Scripted {
        fn connect(
            &mut self,
            _: &Settings,
            _: &DeviceNoteSink,
            _: &Cancel,
        ) -> Result<Box<dyn Scanner>, ConnectError> {
            self.call("connect");
            Ok(Box::new(self.clone()))
        }
    }

    impl Scanner for Scripted {
        fn describe(&mut self) -> Value {
            Value::from("both")
        }

        fn distrust_head(&mut self) {
            self.call("distrust");
        }

        fn resume(&mut self, _: &Cancel) -> Result<(), ConnectError> {
            self.call("resume");
            Ok(())
        }

        fn sweep(
            &mut self,
            settings: &Settings,
            waypoint: Option<&str>,
            _: &Cancel,
        ) -> Result<RawSweep, ScannerError> {
            assert_eq!(
                (waypoint, settings.ptu.port.as_str()),
                (Some("hall"), "/dev/b")
            );
            self.call("sweep");
            Ok(empty_sweep())
        }

        fn take_dialogue(&mut self) -> Option<Vec<u8>> {
            Some(b"said".to_vec())
        }

        fn return_to_start(&mut self, _: &Cancel) -> Option<Duration> {
            self.call("return");
            Some(Duration::from_secs(7))
        }
    }

    /// A thread with a scripted scanner, and the four ends that the test holds.
    struct Watched {
        thread: ScannerThread,
        calls: mpsc::Receiver<&'static str>,
        leave: mpsc::Sender<()>,
        events: mpsc::Receiver<ScannerEvent>,
    }

    impl Watched {
        fn new() -> Self {
            let (calls, called) = mpsc::channel();
            let (leave, leaves) = mpsc::channel();
            let (sender, events) = mpsc::channel();
            let leaves = Arc::new(Mutex::new(leaves));
            let connector = Box::new(Scripted {
                calls,
                leave: leaves,
            });
            let notes = DeviceNoteSink::new(|_, _, _| ());
            let on_event = move |event| drop(sender.send(event));
            let thread = ScannerThread::spawn(connector, Clock::real(), notes, on_event);
            Self {
                thread: thread.expect("a thread"),
                calls: called,
                leave,
                events,
            }
        }

        /// The next call is this one, and is overdue after its own limit and not before; then it returns.
        fn passes(&self, before: Instant, call: &str, limit: Option<Duration>) {
            assert_eq!(self.calls.recv(), Ok(call));
            let after = Instant::now();
            let second = Duration::from_secs(1);
            let far = Duration::from_secs(1_000_000);
            match limit {
                Some(limit) => {
                    assert!(!self.thread.is_overdue(before + limit), "{call}: not yet");
                    assert!(self.thread.is_overdue(after + limit + second), "{call}");
                }
                None => assert!(!self.thread.is_overdue(after + far), "{call}"),
            }
            self.leave.send(()).expect("it waits");
        }
    }

    #[test]
    fn each_call_has_its_own_limit_and_its_result_is_handed_on() {
        let mut watched = Watched::new();
        let mut settings = Settings::defaults();
        settings.ptu.port = "/dev/b".to_owned();
        let settings = Arc::new(settings);
        let before = Instant::now();
        watched.thread.open(Arc::clone(&settings));
        watched.passes(before, "connect", Some(CONNECT_AND_HOME_LIMIT));
        let ready = watched.events.recv().expect("an event");
        assert!(
            matches!(ready, ScannerEvent::Ready(ref both) if both == "both"),
            "{ready:?}"
        );

        let before = Instant::now();
        let hall = Some("hall".to_owned());
        watched.thread.sweep(5, Arc::clone(&settings), hall);
        let limit = max_sweep_duration(&settings, Some("hall"));
        watched.passes(before, "sweep", Some(limit));
        let swept = watched.events.recv().expect("an event");
        let said = |said: &Option<Vec<u8>>| said.as_deref() == Some(b"said");
        assert!(
            matches!(swept, ScannerEvent::Swept(5, _, ref d) if said(d)),
            "{swept:?}"
        );
        watched.passes(before, "return", Some(RETURN_TO_START_LIMIT));
        let returned = watched.events.recv().expect("an event");
        let took = matches!(returned, ScannerEvent::Returned(Some(took)) if took.as_secs() == 7);
        assert!(took, "{returned:?}");

        watched.thread.distrust_head();
        watched.passes(Instant::now(), "distrust", None);
        // The same devices are kept, those of other settings are connected anew.
        let before = Instant::now();
        watched.thread.open(Arc::clone(&settings));
        watched.passes(before, "resume", Some(CONNECT_AND_HOME_LIMIT));
        assert!(matches!(watched.events.recv(), Ok(ScannerEvent::Ready(_))));
        for change in [
            |other: &mut Settings| other.laser.port = "/dev/c".to_owned(),
            |other: &mut Settings| other.ptu.port = "/dev/c".to_owned(),
        ] {
            let mut other = (*settings).clone();
            change(&mut other);
            let before = Instant::now();
            watched.thread.open(Arc::new(other));
            watched.passes(before, "connect", Some(CONNECT_AND_HOME_LIMIT));
            assert!(matches!(watched.events.recv(), Ok(ScannerEvent::Ready(_))));
            watched.thread.open(Arc::clone(&settings));
            watched.passes(before, "connect", Some(CONNECT_AND_HOME_LIMIT));
            assert!(matches!(watched.events.recv(), Ok(ScannerEvent::Ready(_))));
        }
        watched.thread.close();
        assert!(matches!(watched.events.recv(), Ok(ScannerEvent::Closed)));
        watched.thread.sweep(6, settings, None);
        let none = watched.events.recv().expect("an event");
        assert!(
            matches!(none, ScannerEvent::SweepFailed(6, ref e, None) if e.lost),
            "{none:?}"
        );
    }
}
