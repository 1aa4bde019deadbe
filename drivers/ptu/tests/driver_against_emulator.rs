//! The driver against the emulated head, in every start state and under every fault: it connects or reports why not, in
//! bounded time; after the fault and a power cycle it works as before.

use std::time::Duration;

use ptu::emulator::{EmulatedHead, HeadFaultKind, HeadFaultSpec, HeadOptions};
use ptu::{Axis, HeadError, HoldPower, MovePower, PtuAction, PtuDriver, PtuEvent, PtuOptions};

/// Driver and emulated head on one line, in virtual time.
struct DriverAndHead {
    head: EmulatedHead,
    driver: PtuDriver,
    now: Duration,
    events: Vec<PtuEvent>,
}

impl DriverAndHead {
    fn new(options: HeadOptions) -> Self {
        Self {
            head: EmulatedHead::new(options, Duration::ZERO),
            driver: PtuDriver::new(PtuOptions::default()),
            now: Duration::ZERO,
            events: Vec::new(),
        }
    }

    fn with(options: &[&str]) -> Self {
        let mut all = HeadOptions::default();
        for option in options {
            all.set(option).expect("an option");
        }
        Self::new(all)
    }

    fn inject(&mut self, fault: &str) {
        let mut spec: HeadFaultSpec = fault.parse().expect("a fault");
        spec.times = spec.times.counted_from(self.now);
        self.head.inject(spec);
    }

    /// Lets time pass until a wanted event or the time limit.
    fn run_until(
        &mut self,
        limit: Duration,
        wanted: impl Fn(&PtuEvent) -> bool,
    ) -> Option<PtuEvent> {
        let end = self.now + limit;
        loop {
            self.head.advance(self.now);
            while let Some(output) = self.head.poll_output() {
                self.driver.handle_bytes(&output.bytes, self.now);
            }
            self.driver.handle_deadline(self.now);
            while let Some(action) = self.driver.poll_action() {
                match action {
                    PtuAction::Send(bytes) => self.head.handle_bytes(&bytes, self.now),
                    PtuAction::Event(event) => self.events.push(event),
                }
            }
            if let Some(at) = self.events.iter().position(&wanted) {
                return self.events.drain(..=at).next_back();
            }
            self.events.clear();
            if self.now >= end {
                return None;
            }
            let next = [self.head.next_event(), self.driver.deadline()];
            let next = next.into_iter().flatten().min().unwrap_or(end);
            self.now = next.max(self.now + Duration::from_micros(200)).min(end);
        }
    }

    fn try_connect(&mut self) -> PtuEvent {
        self.driver.connect(self.now);
        let over = |event: &PtuEvent| matches!(event, PtuEvent::Connected(_) | PtuEvent::Fault(_));
        self.run_until(Duration::from_secs(200), over)
            .expect("an end, in bounded time")
    }

    fn connect(&mut self) {
        let event = self.try_connect();
        assert!(matches!(event, PtuEvent::Connected(_)), "{event:?}");
    }

    fn homed(&mut self) {
        self.driver.reset(self.now).expect("connected");
        let over =
            |event: &PtuEvent| matches!(event, PtuEvent::HomeDone { .. } | PtuEvent::Fault(_));
        let home = self.run_until(Duration::from_secs(70), over);
        assert!(matches!(home, Some(PtuEvent::HomeDone { .. })), "{home:?}");
    }

    /// Moves to `target`; returns the position polled afterwards.
    fn move_and_poll(&mut self, axis: Axis, target: i32) -> i32 {
        self.driver
            .move_to(axis, target, self.now)
            .expect("connected");
        let accepted = |event: &PtuEvent| matches!(event, PtuEvent::MoveAccepted { .. });
        self.run_until(Duration::from_secs(2), accepted)
            .expect("accepted");
        self.run_until(Duration::from_secs(15), |_| false);
        self.driver
            .poll_position(axis, self.now)
            .expect("connected");
        let position = self.run_until(Duration::from_secs(2), |event| {
            matches!(event, PtuEvent::Position { .. })
        });
        match position {
            Some(PtuEvent::Position { steps, .. }) => steps,
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn it_connects_from_every_start_state() {
    for options in [
        &["echo=off", "verbose=off"][..],
        &["velocity=on"],
        &["slaved=on"],
        &["limits=off"],
        &["monitor=on"],
        &["moving-to=900/-300"],
        &["power-up=on"],
        &["power-up=on", "banner=off"],
        &["power-up=on", "calibrate=off"],
        &["power-up=on", "input-during-reset=dropped"],
        &["line-end=cr"],
        &["latency=0/80"],
        &["pacing=off"],
        &["model=d46-70"],
        &["series=e"],
        &["series=e", "power-up=on"],
        &["base-speed=57", "acceleration=400"],
    ] {
        let mut pair = DriverAndHead::with(options);
        pair.connect();
        pair.homed();
        assert_eq!(pair.move_and_poll(Axis::Pan, 250), 250, "{options:?}");
        assert_eq!(pair.head.true_position_at(pair.now).0, 250.0, "{options:?}");
        assert_eq!(pair.head.eeprom_writes(), 0);
    }
}

#[test]
fn another_rate_and_another_network_id_are_reported_as_silence() {
    let mut pair = DriverAndHead::with(&["unit-id=5"]);
    assert!(matches!(
        pair.try_connect(),
        PtuEvent::Fault(HeadError::Silent)
    ));
    let mut pair = DriverAndHead::with(&["baud=38400"]);
    pair.head.set_host_baud(Some(9600));
    let event = pair.try_connect();
    assert!(matches!(event, PtuEvent::Fault(_)), "{event:?}");
    pair.head.set_host_baud(Some(38_400));
    pair.connect();
}

#[test]
fn powers_set_by_another_program_are_read() {
    let mut pair = DriverAndHead::with(&[]);
    let PtuEvent::Connected(identity) = pair.try_connect() else {
        panic!("not connected");
    };
    assert_eq!(identity.pan.hold_power, Some(HoldPower::Regular));
    assert_eq!(identity.tilt.move_power, Some(MovePower::Regular));
    pair.head.handle_bytes(b"PHO TML ", pair.now);
    let PtuEvent::Connected(identity) = pair.try_connect() else {
        panic!("not connected");
    };
    assert_eq!(identity.pan.hold_power, Some(HoldPower::Off));
    assert_eq!(identity.tilt.move_power, Some(MovePower::Low));
}

#[test]
fn an_event_within_a_reply_is_seen_and_the_reply_is_not_lost() {
    for within in 0..9 {
        let mut pair = DriverAndHead::with(&[]);
        pair.connect();
        pair.homed();
        pair.inject(&format!("event:which=T,within={within}"));
        pair.driver
            .poll_position(Axis::Pan, pair.now)
            .expect("connected");
        let first = pair.run_until(Duration::from_secs(3), |event| {
            matches!(event, PtuEvent::LimitHit(_) | PtuEvent::Position { .. })
        });
        let hit = match first {
            Some(PtuEvent::LimitHit(axis)) => Some(axis),
            _ => {
                pair.driver
                    .poll_position(Axis::Pan, pair.now)
                    .expect("connected");
                let hit = pair.run_until(Duration::from_secs(3), |event| {
                    matches!(event, PtuEvent::LimitHit(_))
                });
                hit.map(|_| Axis::Tilt)
            }
        };
        assert_eq!(hit, Some(Axis::Tilt), "within {within}");
        assert_eq!(pair.move_and_poll(Axis::Pan, 40), 40);
    }
}

/// Every fault, from the start and while the head moves.
#[test]
fn no_fault_is_a_dead_end() {
    for kind in HeadFaultKind::kinds() {
        for at_s in [0.0, 6.0] {
            let mut pair = DriverAndHead::with(&[]);
            pair.inject(&format!("{kind}:at={at_s},for=3"));
            let first = pair.try_connect();
            if matches!(first, PtuEvent::Connected(_)) {
                pair.driver
                    .move_to(Axis::Tilt, 300, pair.now)
                    .expect("connected");
                for _ in 0..40 {
                    if pair.driver.poll_position(Axis::Tilt, pair.now).is_err() {
                        break;
                    }
                    pair.run_until(Duration::from_millis(200), |_| false);
                }
            }
            pair.head.power_cycle(pair.now);
            pair.now += Duration::from_secs(40);
            pair.connect();
            pair.homed();
            assert_eq!(pair.move_and_poll(Axis::Tilt, 100), 100, "{kind} {at_s}");
            assert_eq!(
                pair.head.true_position_at(pair.now).1,
                100.0,
                "{kind} {at_s}"
            );
        }
    }
}
