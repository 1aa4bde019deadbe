//! The driver against the twin, in every state a unit can be found in and under every fault: it connects, or says why
//! not, in bounded time, and once the fault is over and the power was cycled it works as before.

use std::time::Duration;

use ptu::twin::{FaultKind, FaultSpec, Twin, TwinOptions};
use ptu::{Action, Axis, Event, Head, HeadError, HeadOptions, HoldPower, MovePower};

/// Driver and twin on one line, in one virtual time.
struct Pair {
    twin: Twin,
    head: Head,
    now: Duration,
    events: Vec<Event>,
}

impl Pair {
    fn new(options: TwinOptions) -> Self {
        Self {
            twin: Twin::new(options, Duration::ZERO),
            head: Head::new(HeadOptions::default()),
            now: Duration::ZERO,
            events: Vec::new(),
        }
    }

    fn with(options: &[&str]) -> Self {
        let mut all = TwinOptions::default();
        for option in options {
            all.set(option).expect("an option");
        }
        Self::new(all)
    }

    fn inject(&mut self, fault: &str) {
        let mut spec: FaultSpec = fault.parse().expect("a fault");
        spec.at = Some(spec.at.unwrap_or_default() + self.now);
        self.twin.inject(spec);
    }

    /// Lets time pass until an event of interest or the end of patience.
    fn until(&mut self, patience: Duration, wanted: impl Fn(&Event) -> bool) -> Option<Event> {
        let end = self.now + patience;
        loop {
            self.twin.advance(self.now);
            while let Some(output) = self.twin.poll_output() {
                self.head.handle_bytes(&output.bytes, self.now);
            }
            self.head.handle_deadline(self.now);
            while let Some(action) = self.head.poll_action() {
                match action {
                    Action::Send(bytes) => self.twin.handle_bytes(&bytes, self.now),
                    Action::Event(event) => self.events.push(event),
                }
            }
            if let Some(at) = self.events.iter().position(&wanted) {
                return self.events.drain(..=at).next_back();
            }
            self.events.clear();
            if self.now >= end {
                return None;
            }
            let next = [self.twin.next_event(), self.head.deadline()];
            let next = next.into_iter().flatten().min().unwrap_or(end);
            self.now = next.max(self.now + Duration::from_micros(200)).min(end);
        }
    }

    fn connect(&mut self) -> Event {
        self.head.connect(self.now);
        let over = |event: &Event| matches!(event, Event::Connected(_) | Event::Fault(_));
        self.until(Duration::from_secs(200), over)
            .expect("an end, in bounded time")
    }

    fn connected(&mut self) {
        let event = self.connect();
        assert!(matches!(event, Event::Connected(_)), "{event:?}");
    }

    fn homed(&mut self) {
        self.head.reset(self.now).expect("connected");
        let over = |event: &Event| matches!(event, Event::HomeDone { .. } | Event::Fault(_));
        let home = self.until(Duration::from_secs(70), over);
        assert!(matches!(home, Some(Event::HomeDone { .. })), "{home:?}");
    }

    /// Goes there and says where it says it is.
    fn goes_to(&mut self, axis: Axis, target: i32) -> i32 {
        self.head
            .move_to(axis, target, self.now)
            .expect("connected");
        let accepted = |event: &Event| matches!(event, Event::MoveAccepted { .. });
        self.until(Duration::from_secs(2), accepted)
            .expect("accepted");
        self.until(Duration::from_secs(15), |_| false);
        self.head.poll_position(axis, self.now).expect("connected");
        let told = self.until(Duration::from_secs(2), |event| {
            matches!(event, Event::Position { .. })
        });
        match told {
            Some(Event::Position { steps, .. }) => steps,
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn it_connects_whatever_state_the_unit_is_found_in() {
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
        let mut pair = Pair::with(options);
        pair.connected();
        pair.homed();
        assert_eq!(pair.goes_to(Axis::Pan, 250), 250, "{options:?}");
        assert_eq!(pair.twin.true_position_at(pair.now).0, 250.0, "{options:?}");
        assert_eq!(pair.twin.eeprom_writes(), 0);
    }
}

#[test]
fn another_rate_and_another_network_id_are_said_to_be_silence() {
    let mut pair = Pair::with(&["unit-id=5"]);
    assert!(matches!(
        pair.connect(),
        Event::Fault(HeadError::Silent { .. })
    ));
    let mut pair = Pair::with(&["baud=38400"]);
    pair.twin.set_host_baud(Some(9600));
    let told = pair.connect();
    assert!(matches!(told, Event::Fault(_)), "{told:?}");
    pair.twin.set_host_baud(Some(38_400));
    pair.connected();
}

#[test]
fn powers_speeds_and_targets_are_read_and_set() {
    let mut pair = Pair::with(&[]);
    let Event::Connected(identity) = pair.connect() else {
        panic!("not connected");
    };
    assert_eq!(identity.pan.hold_power, Some(HoldPower::Regular));
    assert_eq!(identity.tilt.move_power, Some(MovePower::Regular));
    let soon = Duration::from_secs(2);
    pair.head
        .set_hold_power(Axis::Pan, HoldPower::Off, pair.now)
        .expect("connected");
    pair.head
        .set_move_power(Axis::Tilt, MovePower::Low, pair.now)
        .expect("connected");
    let moved = pair.until(soon, |event| matches!(event, Event::MovePowerSet { .. }));
    let (axis, power) = (Axis::Tilt, MovePower::Low);
    assert_eq!(moved, Some(Event::MovePowerSet { axis, power }));
    pair.head
        .move_to(Axis::Pan, 2000, pair.now)
        .expect("connected");
    pair.head
        .move_to(Axis::Tilt, -600, pair.now)
        .expect("connected");
    pair.until(Duration::from_millis(200), |_| false);
    pair.head
        .poll_target(Axis::Pan, pair.now)
        .expect("connected");
    let target = pair.until(soon, |event| matches!(event, Event::Target { .. }));
    let axis = Axis::Pan;
    assert_eq!(target, Some(Event::Target { axis, steps: 2000 }));
    pair.head
        .poll_speed(Axis::Pan, pair.now)
        .expect("connected");
    let speed = pair.until(soon, |event| matches!(event, Event::Speed { .. }));
    let steps_per_s = 1000;
    assert_eq!(speed, Some(Event::Speed { axis, steps_per_s }));
    pair.head.halt_axis(Axis::Pan, pair.now).expect("connected");
    let halted = pair.until(soon, |event| matches!(event, Event::AxisHalted(_)));
    assert_eq!(halted, Some(Event::AxisHalted(Axis::Pan)));
    pair.until(Duration::from_secs(3), |_| false);
    let (pan, tilt) = pair.twin.true_position_at(pair.now);
    assert!(pan < 1000.0 && tilt == -600.0, "{pan} {tilt}");
    let Event::Connected(identity) = pair.connect() else {
        panic!("not connected");
    };
    assert_eq!(identity.pan.hold_power, Some(HoldPower::Off));
    assert_eq!(identity.tilt.move_power, Some(MovePower::Low));
}

#[test]
fn an_event_within_a_reply_costs_neither_the_reply_nor_goes_unseen() {
    for within in 0..9 {
        let mut pair = Pair::with(&[]);
        pair.connected();
        pair.homed();
        pair.inject(&format!("event:which=T,within={within}"));
        pair.head
            .poll_position(Axis::Pan, pair.now)
            .expect("connected");
        let first = pair.until(Duration::from_secs(3), |event| {
            matches!(event, Event::LimitHit(_) | Event::Position { .. })
        });
        let hit = match first {
            Some(Event::LimitHit(axis)) => Some(axis),
            _ => {
                pair.head
                    .poll_position(Axis::Pan, pair.now)
                    .expect("connected");
                let told = pair.until(Duration::from_secs(3), |event| {
                    matches!(event, Event::LimitHit(_))
                });
                told.map(|_| Axis::Tilt)
            }
        };
        assert_eq!(hit, Some(Axis::Tilt), "within {within}");
        assert!(!pair.head.position_trusted());
        assert_eq!(pair.goes_to(Axis::Pan, 40), 40);
    }
}

/// Every fault, from the beginning and while the head moves.
#[test]
fn no_fault_is_a_dead_end() {
    for kind in FaultKind::kinds() {
        for at_s in [0.0, 6.0] {
            let mut pair = Pair::with(&[]);
            pair.inject(&format!("{kind}:at={at_s},for=3"));
            let first = pair.connect();
            if matches!(first, Event::Connected(_)) {
                pair.head
                    .move_to(Axis::Tilt, 300, pair.now)
                    .expect("connected");
                for _ in 0..40 {
                    if pair.head.poll_position(Axis::Tilt, pair.now).is_err() {
                        break;
                    }
                    pair.until(Duration::from_millis(200), |_| false);
                }
            }
            pair.twin.power_cycle(pair.now);
            pair.now += Duration::from_secs(40);
            pair.connected();
            pair.homed();
            assert_eq!(pair.goes_to(Axis::Tilt, 100), 100, "{kind} {at_s}");
            assert_eq!(
                pair.twin.true_position_at(pair.now).1,
                100.0,
                "{kind} {at_s}"
            );
        }
    }
}
