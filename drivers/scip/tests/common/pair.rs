//! A driver and a twin, wired together in virtual time.

use scip::twin::{Profile, Surroundings, Twin, TwinOptions};
use scip::{Action, Coding, Event, Sensor, SensorOptions, StreamPlan};
use std::time::Duration;

pub const MS: Duration = Duration::from_millis(1);

/// Every step at a distance of its own, so that a value in a wrong place shows.
pub struct Staircase;

impl Surroundings for Staircase {
    fn revolve(&mut self, _: Duration, _: Duration, out: &mut [u32]) {
        for (step, range) in out.iter_mut().enumerate() {
            *range = 1000 + step as u32;
        }
    }
}

/// Driver and twin on one line, in one virtual time.
pub struct Pair {
    pub twin: Twin,
    pub sensor: Sensor,
    pub now: Duration,
    pub profile: Profile,
    pub events: Vec<Event>,
}

impl Pair {
    pub fn new(options: TwinOptions) -> Self {
        Self::found(options, Duration::from_millis(730))
    }

    /// The host comes so long after the twin's beginning.
    pub fn found(options: TwinOptions, after: Duration) -> Self {
        let profile = options.profile.clone();
        Self {
            twin: Twin::new(options, Duration::ZERO),
            sensor: Sensor::new(SensorOptions::default()),
            now: after,
            profile,
            events: Vec::new(),
        }
    }

    pub fn of(profile: Profile) -> Self {
        let mut options = TwinOptions::default();
        options.set_profile(profile);
        Self::new(options)
    }

    pub fn inject(&mut self, fault: &str) {
        let mut spec: scip::twin::FaultSpec = fault.parse().expect("a fault");
        spec.at += self.now;
        self.twin.inject(spec);
    }

    pub fn exchange(&mut self) {
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

    pub fn check(&self, scan: &scip::RawScan) {
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
    pub fn until(&mut self, patience: Duration, wanted: impl Fn(&Event) -> bool) -> Option<Event> {
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

    pub fn connect(&mut self) -> Event {
        self.sensor.connect(self.now);
        let over = |event: &Event| matches!(event, Event::Connected(_) | Event::Fault(_));
        let patience = Duration::from_secs(16);
        self.until(patience, over).expect("an end, in bounded time")
    }

    pub fn connected(&mut self) {
        let event = self.connect();
        assert!(matches!(event, Event::Connected(_)), "{event:?}");
    }

    pub fn plan(&self, coding: Coding) -> StreamPlan {
        StreamPlan {
            first_step: self.profile.first_step as u16,
            last_step: self.profile.last_step as u16,
            cluster: 1,
            interval: 0,
            coding,
            count: 0,
        }
    }

    pub fn stream(&mut self, coding: Coding) {
        let plan = self.plan(coding);
        self.sensor.start_streaming(plan, self.now).expect("idle");
    }

    /// How many scans come in this time, and whether none is lost.
    pub fn scans(&mut self, time: Duration) -> usize {
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
