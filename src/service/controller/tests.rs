//! The links of the loop, stepped on one thread: what it is told becomes health incidents, a second sweep, a fed watchdog.

use super::{Controller, Services};
use crate::config::Settings;
use crate::config::load;
use crate::devices::Cancel;
use crate::patrol::event::PatrolTask;
use crate::service::constants::{JUDGE_LIMIT, STORE_WRITE_LIMIT, WALL_CLOCK_STABLE_FOR};
use crate::service::judgement::SweepJudgement;
use crate::service::message::{ClientRequest, ReplyTo, ServiceMessage, TeachOptions};
use crate::service::replies::{ServiceReply, StatusReply};
use crate::service::scanner::{
    ConnectError, DeviceNoteSink, Scanner, ScannerConnector, ScannerError,
};
use crate::service::scanner_thread::{ScannerEvent, ScannerThread};
use crate::service::store_writer::StoreWriter;
use crate::service::systemd::SystemdNotifier;
use crate::service::visit_tests::empty_sweep::empty_sweep;
use crate::store::{DiskSpace, Ledger, RetryResult, StorageReport, Store};
use link::Clock;
use patrold_engine::sweep::RawSweep;
use serde_json::Value;
use std::sync::mpsc;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::sync::{oneshot, watch};

mod accepting;
mod hand_over;
mod health;
mod links;
mod reload;
mod timers;

const TIMEOUT: Duration = Duration::from_secs(60);

/// Connects at once; its sweep hangs until it is cancelled.
struct HangingScanner;

impl ScannerConnector for HangingScanner {
    fn connect(
        &mut self,
        _: &Settings,
        _: &DeviceNoteSink,
        _: &Cancel,
    ) -> Result<Box<dyn Scanner>, ConnectError> {
        Ok(Box::new(Self))
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
        cancel: &Cancel,
    ) -> Result<RawSweep, ScannerError> {
        while !cancel.is_cancelled() {
            std::thread::yield_now();
        }
        Err(ScannerError {
            reason: "cancelled".to_owned(),
            lost: false,
        })
    }
}

/// A controller whose messages are given by hand.
struct Stepped {
    dir: tempfile::TempDir,
    controller: Controller,
    /// What its threads send; nobody passes it on.
    messages: UnboundedReceiver<ServiceMessage>,
    clients: Vec<oneshot::Receiver<ServiceReply>>,
}

impl Stepped {
    fn new(more: &str) -> Self {
        let dir = tempfile::tempdir().expect("temp dir");
        let (store, file) = (dir.path().join("store"), dir.path().join("patrold.toml"));
        std::fs::write(&file, format!("store.dir = {store:?}\n{more}")).expect("written");
        let loaded = load(Some(&file), &[]).expect("valid");
        let ledger = Ledger::new(Store::open(&store).expect("opens"));
        let (inbox, mut messages) = unbounded_channel();
        let events = inbox.clone();
        let notes = DeviceNoteSink::new(|_, _, _| ());
        let on_event = move |event| drop(events.send(ServiceMessage::Scanner(event)));
        let scanner =
            ScannerThread::spawn(Box::new(HangingScanner), Clock::real(), notes, on_event);
        let services = Services {
            scanner: scanner.expect("a thread"),
            writer: StoreWriter::spawn(ledger).expect("a thread"),
            systemd: SystemdNotifier::with_watchdog(),
            log: None,
            inbox,
            status: watch::channel(StatusReply::default()).0,
        };
        let controller = Controller::start(services, &loaded);
        // The scanner's thread has nothing to do from here on.
        let is_ready = |message: &ServiceMessage| {
            matches!(message, ServiceMessage::Scanner(ScannerEvent::Ready(_)))
        };
        while !messages
            .blocking_recv()
            .is_some_and(|message| is_ready(&message))
        {}
        Self {
            dir,
            controller,
            messages,
            clients: Vec::new(),
        }
    }

    fn store_dir(&self) -> std::path::PathBuf {
        self.dir.path().join("store")
    }

    fn scanner(&mut self, event: ScannerEvent) {
        self.controller
            .handle_message(ServiceMessage::Scanner(event));
    }

    /// Requests a visit of the hall; returns its number.
    fn visit(&mut self) -> u64 {
        self.request(PatrolTask::Visit, TeachOptions::default())
    }

    /// Requests something at the hall; returns its number.
    fn request(&mut self, task: PatrolTask, teach: TeachOptions) -> u64 {
        let (reply_to, reply) = oneshot::channel();
        self.clients.push(reply);
        let request = ClientRequest {
            task,
            waypoint: "hall".to_owned(),
            teach,
            reply_to: ReplyTo::Client(reply_to),
        };
        self.controller
            .handle_message(ServiceMessage::Request(request));
        self.controller.last_request_id
    }

    /// A visit whose sweep is under way; returns its number.
    fn sweeping(&mut self) -> u64 {
        self.scanner(ScannerEvent::Ready(Value::Null));
        let id = self.visit();
        self.controller
            .handle_message(ServiceMessage::Prepared(id, Ok(None)));
        assert_eq!(self.controller.machine.phase(), "sweeping");
        id
    }

    /// Takes the next message of this kind from its threads, and drops those before it.
    fn next(&mut self, is_wanted: impl Fn(&ServiceMessage) -> bool) -> ServiceMessage {
        loop {
            let message = self.messages.blocking_recv().expect("its threads run");
            if is_wanted(&message) {
                return message;
            }
        }
    }

    /// Passes on that the outcome of a request is on disk.
    fn recorded(&mut self) {
        let message = self.next(|message| matches!(message, ServiceMessage::Recorded(..)));
        self.controller.handle_message(message);
    }

    /// What the last client got.
    fn reply(&mut self) -> ServiceReply {
        let mut client = self.clients.pop().expect("a client");
        client.try_recv().expect("a reply")
    }

    /// Until everything that was submitted is written.
    fn settle(&self) {
        let (sender, written) = mpsc::channel();
        let done = move |()| sender.send(()).expect("awaited");
        self.controller.services.writer.submit(|_| (), done);
        written.recv_timeout(TIMEOUT).expect("written");
    }

    /// Subjects and reasons of the health incidents that stand, the oldest first.
    fn health(&self) -> Vec<(String, String)> {
        self.settle();
        let store = Store::open_for_reading(&self.store_dir()).expect("readable");
        let rows = store.health(true, 100).expect("health");
        rows.into_iter()
            .rev()
            .map(|row| (row.subject, row.reason))
            .collect()
    }

    fn events(&self) -> Vec<String> {
        self.settle();
        let store = Store::open_for_reading(&self.store_dir()).expect("readable");
        let rows = store.events(100).expect("events");
        rows.into_iter().map(|row| row.text).collect()
    }
}

fn judgement(sweep_fault: Option<&str>) -> Box<SweepJudgement> {
    Box::new(SweepJudgement {
        assembled: None,
        unassembled_raw: None,
        finding: Err(sweep_fault.unwrap_or("no reference at hand").to_owned()),
        turn: None,
        suspected_lost_steps: None,
        sweep_fault: sweep_fault.map(str::to_owned),
        made_anew: None,
    })
}
