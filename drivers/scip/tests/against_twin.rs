//! The driver against the twin of every model, in every state a host can leave it in and under every fault: it connects,
//! or says why not, in bounded time; it never takes a wrong scan.

use std::time::Duration;

use scip::command::motor_speed::SetMotorSpeed;
use scip::command::rehearsal::Rehearse;
use scip::command::span::Span;
use scip::twin::{
    Fault, Generation, KeyedSum, Profile, StartState, Surroundings, Twin, TwinOptions,
};
use scip::{Action, Coding, Event, Sensor, SensorError, SensorOptions, Setting, StreamPlan};

const MS: Duration = Duration::from_millis(1);

/// Every step at a distance of its own, so that a value in a wrong place shows.
struct Staircase;

impl Surroundings for Staircase {
    fn revolve(&mut self, _: Duration, _: Duration, out: &mut [u32]) {
        for (step, range) in out.iter_mut().enumerate() {
            *range = 1000 + step as u32;
        }
    }
}

/// Driver and twin on one line, in one virtual time.
struct Pair {
    twin: Twin,
    sensor: Sensor,
    now: Duration,
    profile: Profile,
    events: Vec<Event>,
}

impl Pair {
    fn new(options: TwinOptions) -> Self {
        Self::found(options, Duration::from_millis(730))
    }

    /// The host comes so long after the twin's beginning.
    fn found(options: TwinOptions, after: Duration) -> Self {
        let profile = options.profile.clone();
        Self {
            twin: Twin::new(options, Duration::ZERO),
            sensor: Sensor::new(SensorOptions::default()),
            now: after,
            profile,
            events: Vec::new(),
        }
    }

    fn of(profile: Profile) -> Self {
        let mut options = TwinOptions::default();
        options.set_profile(profile);
        Self::new(options)
    }

    fn inject(&mut self, fault: &str) {
        let mut spec: scip::twin::FaultSpec = fault.parse().expect("a fault");
        spec.at += self.now;
        self.twin.inject(spec);
    }

    fn exchange(&mut self) {
        while let Some(action) = self.sensor.poll_action() {
            match action {
                Action::Send(bytes) => self.twin.handle_bytes(&bytes, self.now),
                Action::Event(event) => {
                    if let Event::Scan { scan, .. } = &event {
                        self.check(scan);
                    }
                    self.events.push(event);
                }
            }
        }
    }

    fn check(&self, scan: &scip::RawScan) {
        let window = self.profile.first_step..=self.profile.last_step;
        for (index, range) in scan.ranges.iter().enumerate() {
            let step = scan.step(index) as u32;
            let wanted = if window.contains(&step) {
                1000 + step
            } else {
                19
            };
            assert!(
                *range == wanted || *range == 1,
                "step {step}: {range}, not {wanted} (nor a code of a covered window)"
            );
        }
    }

    /// Lets time pass until an event of interest or the end of patience.
    fn until(&mut self, patience: Duration, wanted: impl Fn(&Event) -> bool) -> Option<Event> {
        let end = self.now + patience;
        loop {
            self.twin.advance(self.now, &mut Staircase);
            while let Some(output) = self.twin.poll_output() {
                self.sensor.handle_bytes(&output.bytes, self.now);
            }
            self.sensor.handle_deadline(self.now);
            self.exchange();
            if let Some(at) = self.events.iter().position(&wanted) {
                return Some(self.events.drain(..=at).next_back().expect("found"));
            }
            self.events.clear();
            if self.now >= end {
                return None;
            }
            let next = [self.twin.next_event(), self.sensor.deadline()];
            let next = next.into_iter().flatten().min().unwrap_or(end);
            self.now = next.max(self.now + Duration::from_micros(100)).min(end);
        }
    }

    fn connect(&mut self) -> Event {
        self.sensor.connect(self.now);
        let over = |event: &Event| matches!(event, Event::Connected(_) | Event::Fault(_));
        let patience = Duration::from_secs(16);
        self.until(patience, over).expect("an end, in bounded time")
    }

    fn connected(&mut self) {
        let event = self.connect();
        assert!(matches!(event, Event::Connected(_)), "{event:?}");
    }

    fn plan(&self, coding: Coding) -> StreamPlan {
        StreamPlan {
            first_step: self.profile.first_step as u16,
            last_step: self.profile.last_step as u16,
            cluster: 1,
            interval: 0,
            coding,
            count: 0,
        }
    }

    fn stream(&mut self, coding: Coding) {
        let plan = self.plan(coding);
        self.sensor.start_streaming(plan, self.now).expect("idle");
    }

    /// How many scans come in this time, and whether none is lost.
    fn scans(&mut self, time: Duration) -> usize {
        let end = self.now + time;
        let mut scans = 0;
        while self.now < end {
            let left = end - self.now;
            let event = self.until(left, |event| {
                matches!(
                    event,
                    Event::Scan { .. } | Event::LostScans(_) | Event::Fault(_)
                )
            });
            match event {
                Some(Event::Scan { .. }) => scans += 1,
                Some(other) => panic!("{other:?}"),
                None => {}
            }
        }
        scans
    }
}

#[test]
fn every_model_in_every_state_connects_and_streams() {
    for name in Profile::NAMES {
        for start_state in [
            StartState::PowerUp,
            StartState::Idle,
            StartState::LaserOn,
            StartState::Streaming,
            StartState::TimeAdjust,
            StartState::FirmwareUpdate,
        ] {
            let mut options = TwinOptions {
                start_state,
                ..TwinOptions::default()
            };
            options.set_profile(Profile::by_name(name).expect("of the list"));
            let mut pair = Pair::new(options);
            pair.connected();
            pair.sensor.exchange_time(5, pair.now).expect("idle");
            let exchanged = pair.until(Duration::from_secs(3), |event| {
                matches!(event, Event::TimeExchanged { .. })
            });
            assert_eq!(
                exchanged,
                Some(Event::TimeExchanged { samples: 5 }),
                "{name}"
            );
            pair.stream(Coding::ThreeCharacter);
            let started = pair.until(Duration::from_secs(1), |e| matches!(e, Event::Scan { .. }));
            assert!(started.is_some(), "{name} {start_state:?}");
            let period = Duration::from_secs(60) / pair.profile.speed_rpm;
            let scans = pair.scans(100 * period) as i32;
            assert!((scans - 100).abs() <= 1, "{name} {start_state:?}: {scans}");
            pair.sensor.stop(pair.now);
            let stopped = pair.until(Duration::from_secs(1), |e| matches!(e, Event::Stopped));
            assert!(
                stopped.is_some() && !pair.twin.laser_on(),
                "{name} {start_state:?}"
            );
        }
    }
}

#[test]
fn sums_of_every_habit_and_versions_of_old_units_are_taken() {
    for keyed_sum in [
        KeyedSum::BeforeSemicolon,
        KeyedSum::WithSemicolon,
        KeyedSum::BeforeComment,
    ] {
        for name in Profile::NAMES {
            Pair::of(Profile {
                keyed_sum,
                ..Profile::by_name(name).expect("of the list")
            })
            .connected();
        }
    }
    for fault in ["odd-version", "odd-version:count=1", "torn-version:count=2"] {
        let mut pair = Pair::of(Profile::urg_04lx());
        pair.inject(fault);
        pair.connected();
    }
}

#[test]
fn intensity_is_asked_of_models_that_have_it_only() {
    for (profile, knows) in [
        (Profile::urg_04lx(), false),
        (Profile::urg_04lx_ug01(), false),
        (Profile::utm_30lx(), true),
        (Profile::ust_20lx(), true),
    ] {
        let mut pair = Pair::of(profile);
        // Were it asked for all the same, this one would fall deaf.
        pair.inject("deafened");
        pair.connected();
        let plan = pair.plan(Coding::WithIntensity);
        let taken = pair.sensor.start_streaming(plan, pair.now);
        if !knows {
            assert!(matches!(
                taken,
                Err(SensorError::Unsupported {
                    what: "intensity",
                    ..
                })
            ));
            let span = Span {
                first_step: 44,
                last_step: 725,
                cluster: 1,
                coding: Coding::WithIntensity,
            };
            let taken = pair.sensor.single(span, pair.now);
            assert!(matches!(taken, Err(SensorError::Unsupported { .. })));
            pair.stream(Coding::TwoCharacter);
            assert!(pair.scans(Duration::from_secs(1)) >= 7);
            continue;
        }
        taken.expect("known to have it");
        let scan = pair.until(Duration::from_secs(1), |event| {
            matches!(event, Event::Scan { .. })
        });
        let Some(Event::Scan { scan, .. }) = scan else {
            panic!("no scan");
        };
        assert_eq!((scan.ranges.len(), scan.intensities.len()), (1081, 1081));
        assert_eq!(scan.intensities[0], 4000);
        assert!((39..=41).contains(&pair.scans(Duration::from_secs(1))));
    }
}

#[test]
fn counted_streams_end_by_themselves_with_clusters_and_skipped_turns() {
    for (cluster, interval, count) in [(1, 0, 1), (3, 2, 5), (99, 9, 2), (2, 0, 99)] {
        let mut pair = Pair::of(Profile::urg_04lx());
        pair.connected();
        let plan = StreamPlan {
            cluster,
            interval,
            count,
            ..pair.plan(Coding::ThreeCharacter)
        };
        pair.sensor.start_streaming(plan, pair.now).expect("idle");
        let mut left = Vec::new();
        while let Some(Event::Scan { scan, .. }) = pair.until(Duration::from_secs(5), |event| {
            matches!(event, Event::Scan { .. } | Event::Stopped)
        }) {
            left.push(scan.remaining);
        }
        let expected: Vec<u8> = (0..count).rev().collect();
        assert_eq!(left, expected, "cluster {cluster}, interval {interval}");
        assert!(!pair.twin.laser_on());
        pair.sensor.query_info(pair.now).expect("idle");
    }
}

#[test]
fn settings_are_made_or_refused() {
    let mut pair = Pair::of(Profile::urg_04lx_ug01());
    pair.connected();
    let mut apply = |setting| {
        pair.sensor.apply(setting, pair.now).expect("idle");
        let over = |event: &Event| matches!(event, Event::Applied(_) | Event::Failed(_));
        pair.until(Duration::from_secs(4), over).expect("an answer")
    };
    let slower = Setting::MotorSpeed(SetMotorSpeed::Slower(5));
    assert_eq!(apply(slower), Event::Applied(slower));
    assert_eq!(apply(slower), Event::Applied(slower), "already so");
    let played = Setting::Rehearsal(Rehearse::OldMalfunction);
    assert!(matches!(apply(played), Event::Failed(_)), "not supported");
    assert!(
        matches!(apply(Setting::SoftReset), Event::Failed(_)),
        "a URG has no RT"
    );
    let end = Setting::Rehearsal(Rehearse::End);
    assert_eq!(apply(end), Event::Applied(end));
}

/// `DB03`, `DB04` and `DB05` as a stream without end sees them (section 6).
#[test]
fn played_malfunctions_are_told_as_such() {
    for (play, recovers) in [
        (Rehearse::Recovery, true),
        (Rehearse::Failure, false),
        (Rehearse::SuddenFailure, false),
    ] {
        let mut pair = Pair::of(Profile::urg_04lx_ug01());
        pair.connected();
        pair.sensor
            .apply(Setting::Rehearsal(play), pair.now)
            .expect("idle");
        pair.until(Duration::from_secs(1), |event| {
            matches!(event, Event::Applied(_))
        })
        .expect("applied");
        pair.stream(Coding::ThreeCharacter);
        if play != Rehearse::SuddenFailure {
            let told = pair.until(Duration::from_secs(2), |e| {
                matches!(e, Event::Verifying { .. })
            });
            assert_eq!(told, Some(Event::Verifying { status: 21 }));
        }
        let told = pair.until(Duration::from_secs(3), |event| {
            matches!(event, Event::VerifiedNormal | Event::Fault(_))
        });
        if recovers {
            assert_eq!(told, Some(Event::VerifiedNormal));
            // What the pause cost is told with the first scan after it.
            pair.until(Duration::from_secs(1), |event| {
                matches!(event, Event::Scan { .. })
            });
            assert!(pair.scans(Duration::from_secs(1)) >= 8);
        } else {
            let hardware = Event::Fault(SensorError::Hardware { status: 50 });
            assert_eq!(told, Some(hardware));
        }
    }
}

/// Every fault, once while connecting and once while streaming: no wrong scan, no endless wait, and once it is over and
/// the power was cycled the sensor works as before.
#[test]
fn no_fault_is_a_dead_end() {
    for name in Profile::NAMES {
        for kind in Fault::kinds() {
            for at_s in [0.0, 0.35] {
                let profile = Profile::by_name(name).expect("of the list");
                let urg = profile.generation == Generation::Urg;
                let mut pair = Pair::of(profile);
                pair.inject(&format!("{kind}:at={at_s},for=1"));
                let first = pair.connect();
                if matches!(first, Event::Connected(_)) {
                    pair.stream(Coding::ThreeCharacter);
                    pair.inject(&format!("{kind}:at=0.5,for=1"));
                    pair.until(Duration::from_secs(12), |event| {
                        matches!(event, Event::Fault(_))
                    });
                }
                pair.twin.power_cycle(pair.now);
                pair.now += Duration::from_secs(2);
                pair.connected();
                pair.stream(Coding::ThreeCharacter);
                let scans = pair.scans(Duration::from_secs(2));
                let least = if urg { 17 } else { 70 };
                assert!(scans >= least, "{name} {kind} {at_s}: {scans}");
            }
        }
    }
}

/// 16 777.216 s (section 8): the stream goes on across the wrap, without a gap and without a jump.
#[test]
fn the_timer_wraps_under_a_stream() {
    let mut pair = Pair::of(Profile::urg_04lx());
    pair.connected();
    pair.inject("timer-set");
    pair.until(10 * MS, |_| false);
    pair.stream(Coding::ThreeCharacter);
    assert!(pair.scans(Duration::from_secs(10)) >= 97);
    assert!(pair.twin.timer_ms(pair.now) < 10_000);
}
