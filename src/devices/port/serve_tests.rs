//! What one opening of a port leaves to the next, with a driver whose events are the letters of its port's name.

use super::{INITIAL_REOPEN_PAUSE, PortEvent, PortRequest, PortRunner, ServeEnd};
use crate::config::SettingOrigins;
use crate::devices::device_driver::{DeviceDriver, DriverOutput};
use crate::devices::error::{Device, DeviceError};
use crate::devices::port_config::{OpenAttempt, PortConfig};
use crate::devices::recording::{
    DialogueEnd, DialogueEntryKind, DialogueError, DialogueTap, SweepDialogue,
};
use link::{Clock, Link, LinkError};
use std::collections::VecDeque;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;
use std::time::Duration;

const CONNECTED: char = 'c';
const SIGN_OF_LIFE: char = 'l';
const KEEPS_BIT_RATE: char = 'k';
const FAULT: char = 'f';
/// A command was taken.
const COMMANDED: char = '!';

#[derive(Debug)]
struct LetterDriver(VecDeque<char>);

impl DeviceDriver for LetterDriver {
    type Command = ();
    type Event = char;

    fn new(port: &PortConfig, _baud: u32, _probing: bool) -> Self {
        Self(port.name.chars().collect())
    }
    fn connect(&mut self, _now: Duration) {}
    fn command(&mut self, (): (), _now: Duration) {
        self.0.push_back(COMMANDED);
    }
    fn handle_bytes(&mut self, _bytes: &[u8], _now: Duration) {}
    fn handle_deadline(&mut self, _now: Duration) {}
    fn deadline(&self) -> Option<Duration> {
        None
    }
    fn poll(&mut self) -> Option<DriverOutput<char>> {
        self.0.pop_front().map(DriverOutput::Event)
    }
    fn idle_state(&self) -> Option<Vec<u8>> {
        self.0.is_empty().then(Vec::new)
    }
    fn resumed(_state: &[u8]) -> Result<Self, DialogueError> {
        Ok(Self(VecDeque::new()))
    }
    fn is_sign_of_life(event: &char) -> bool {
        *event == SIGN_OF_LIFE
    }
    fn keeps_bit_rate(event: &char) -> bool {
        *event == KEEPS_BIT_RATE
    }
    fn is_connected(event: &char) -> bool {
        *event == CONNECTED
    }
    fn fault(event: &char, _port: &PortConfig) -> Option<DeviceError> {
        (*event == FAULT).then_some(DeviceError::Cancelled)
    }
    fn stop(&mut self, _now: Duration) {}
    fn is_stopped(_event: &char) -> bool {
        true
    }
}

/// Nothing comes, then the device is unplugged.
#[derive(Debug)]
struct UnpluggedLink(u32);

impl Link for UnpluggedLink {
    fn read(&mut self, _buffer: &mut [u8], _timeout: Duration) -> Result<usize, LinkError> {
        if self.0 == 0 {
            return Err(LinkError::Disconnected {
                name: "x".to_owned(),
                detail: "unplugged".to_owned(),
            });
        }
        self.0 -= 1;
        Ok(0)
    }
    fn write_all(&mut self, _bytes: &[u8], _timeout: Duration) -> Result<(), LinkError> {
        Ok(())
    }
    fn name(&self) -> &str {
        "x"
    }
}

fn runner<F: FnMut(PortEvent<char>, Duration) -> bool>(
    name: &str,
    requests: mpsc::Receiver<PortRequest<()>>,
    send_event: F,
) -> PortRunner<LetterDriver, F> {
    PortRunner {
        port: PortConfig {
            device: Device::Laser,
            name: name.to_owned(),
            baud: 115_200,
            unit: None,
            origins: SettingOrigins::default(),
        },
        clock: Clock::scaled(1000.0),
        requests,
        stop: Arc::new(AtomicBool::new(false)),
        send_event,
        backoff: INITIAL_REOPEN_PAUSE,
        connected: false,
        baud_found: false,
        last_good: None,
        found_baud: 0,
    }
}

#[test]
fn events_of_the_driver_decide_how_the_port_is_opened_next() {
    let long = Duration::from_secs(8);
    for (events, backoff, connected, baud) in [
        ("f", long, false, 115_200),
        ("cf", long, true, 115_200),
        ("clf", INITIAL_REOPEN_PAUSE, true, 115_200),
        ("kf", long, false, 19_200),
        // What comes after the fault is of no account.
        ("fclk", long, false, 115_200),
    ] {
        let mut runner = runner(events, mpsc::channel().1, |_, _| true);
        runner.backoff = long;
        let end = runner.serve(Box::new(UnpluggedLink(0)), 19_200, false);
        let failed = matches!(end, ServeEnd::Failed(DeviceError::Cancelled));
        assert!(failed, "{events}");
        assert_eq!(
            (runner.backoff, runner.connected, runner.port.baud),
            (backoff, connected, baud),
            "{events}"
        );
        assert_eq!(runner.baud_found, connected, "{events}");
    }
}

#[test]
fn a_command_made_before_the_port_is_open_is_dropped() {
    let (requests, inbox) = mpsc::channel();
    requests.send(PortRequest::Command(())).expect("received");
    let mut events = Vec::new();
    let later = requests.clone();
    let send_event = |event, _| {
        if event == PortEvent::Device(CONNECTED) {
            later.send(PortRequest::Command(())).expect("received");
        }
        events.push(event);
        true
    };
    let mut runner = runner("c", inbox, send_event);
    let end = runner.serve(Box::new(UnpluggedLink(2)), 0, false);
    assert!(matches!(end, ServeEnd::Failed(DeviceError::Port { .. })));
    drop(runner);
    let device = |letter| PortEvent::Device(letter);
    assert_eq!(
        events,
        [PortEvent::Opened, device(CONNECTED), device(COMMANDED)]
    );
}

#[test]
fn a_recording_begins_behind_the_commands_sent_before_it() {
    let (requests, inbox) = mpsc::channel();
    let tap = DialogueTap::new(Duration::ZERO);
    let recording = tap.clone();
    let send_event = |event, _| {
        if event == PortEvent::Device(CONNECTED) {
            // All three wait when the port looks for requests next.
            for request in [
                PortRequest::Command(()),
                PortRequest::Record(recording.clone()),
                PortRequest::Command(()),
            ] {
                requests.send(request).expect("received");
            }
        }
        true
    };
    let mut runner = runner("c", inbox, send_event);
    let end = runner.serve(Box::new(UnpluggedLink(2)), 0, false);
    assert!(matches!(end, ServeEnd::Failed(DeviceError::Port { .. })));
    assert!(tap.join(Device::Head, || Some(Vec::new())));
    let bytes = tap.finish(&[], DialogueEnd::Complete).expect("joined");
    let dialogue = SweepDialogue::from_bytes(&bytes).expect("read");
    let kinds: Vec<_> = dialogue.entries.into_iter().map(|e| e.kind).collect();
    assert_eq!(kinds, [DialogueEntryKind::CommandTaken]);
}

#[test]
fn the_pauses_between_openings_grow_up_to_that_of_an_absent_port() {
    let mut pauses = Vec::new();
    let send_event = |event, _| {
        if let PortEvent::Lost { retry_in, .. } = event {
            pauses.push(retry_in.as_millis());
        }
        pauses.len() < 4
    };
    runner("/dev/no-such-port", mpsc::channel().1, send_event).run();
    assert_eq!(pauses, [500, 1000, 1000, 1000]);
}

#[test]
fn an_attempt_is_good_by_its_own_connection_alone() {
    let mut runner = runner("c", mpsc::channel().1, |_, _| true);
    // Of the opening before.
    (runner.connected, runner.baud_found) = (true, true);
    let attempt = |node: &str| OpenAttempt {
        node: node.to_owned(),
        baud: 19_200,
        is_of_other_device: false,
    };
    let nodes = ["/dev/no-such-port", "/dev/no-such-port-either"];
    let ended = runner.try_attempts(nodes.map(attempt).into());
    assert!(matches!(ended, Some(DeviceError::Port { .. })), "{ended:?}");
    assert_eq!((&runner.last_good, runner.connected), (&None, false));
    // One that connects, and fails.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let node = format!("tcp:{}", listener.local_addr().expect("bound"));
    runner.port.name = format!("{CONNECTED}{FAULT}");
    let ended = runner.try_attempts(vec![attempt(nodes[0]), attempt(&node)]);
    assert_eq!(ended, Some(DeviceError::Cancelled));
    assert_eq!(runner.last_good, Some(attempt(&node)));
}
