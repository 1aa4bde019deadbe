//! The events of the thread where a scanner hangs, homes, or is cancelled.

use super::{
    CONNECT_AND_HOME_LIMIT, RETURN_TO_START_LIMIT, ScannerEvent, ScannerThread, max_sweep_duration,
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

/// Homes when connected, when asked to, and before a sweep at `lost`; counts its homings.
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
