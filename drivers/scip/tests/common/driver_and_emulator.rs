//! Driver and emulator, connected in virtual time.

use scip::emulator::{EmulatedLaser, LaserOptions, LaserProfile, RangeSource};
use scip::{LaserAction, LaserEvent, ScipDriver, ScipOptions, StreamPlan, ValueCoding};
use std::time::Duration;

pub(crate) const MS: Duration = Duration::from_millis(1);

/// A range of its own for every step, so that a misplaced value shows.
pub(crate) struct Staircase;

impl RangeSource for Staircase {
    fn fill_revolution(&mut self, _: Duration, _: Duration, out: &mut [u32]) {
        for (step, range) in out.iter_mut().enumerate() {
            *range = 1000 + step as u32;
        }
    }
}

pub(crate) struct DriverAndEmulator {
    pub laser: EmulatedLaser,
    pub driver: ScipDriver,
    pub now: Duration,
    pub profile: LaserProfile,
    pub events: Vec<LaserEvent>,
    pub max_bit_rate: u32,
}

impl DriverAndEmulator {
    pub(crate) fn new(options: LaserOptions) -> Self {
        Self::starting_after(options, Duration::from_millis(730))
    }

    /// The host connects this long after power-up.
    pub(crate) fn starting_after(options: LaserOptions, after: Duration) -> Self {
        let profile = options.profile.clone();
        Self {
            laser: EmulatedLaser::new(options, Duration::ZERO),
            driver: ScipDriver::new(ScipOptions::default()),
            now: after,
            profile,
            events: Vec::new(),
            max_bit_rate: u32::MAX,
        }
    }

    pub(crate) fn with_profile(profile: LaserProfile) -> Self {
        let mut options = LaserOptions::default();
        options.set_profile(profile);
        Self::new(options)
    }

    /// A rate that the line does not carry garbles like a wrong one.
    fn carried(&self, bit_s: u32) -> u32 {
        if bit_s > self.max_bit_rate { 1 } else { bit_s }
    }

    pub(crate) fn inject(&mut self, fault: &str) {
        let mut spec: scip::emulator::LaserFaultSpec = fault.parse().expect("a fault");
        spec.times = spec.times.counted_from(self.now);
        self.laser.inject(spec);
    }

    pub(crate) fn exchange(&mut self) {
        while let Some(action) = self.driver.poll_action() {
            match action {
                LaserAction::Send(bytes) => self.laser.handle_bytes(&bytes, self.now),
                LaserAction::SetBitRate(bit_s) => self.laser.set_host_baud(self.carried(bit_s)),
                LaserAction::Event(event) => {
                    if let LaserEvent::Scan { scan, .. } = &event {
                        self.check(scan);
                    }
                    self.events.push(event);
                }
            }
        }
    }

    pub(crate) fn check(&self, scan: &scip::LaserScan) {
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

    /// Lets time pass until such an event, or until the time-out.
    pub(crate) fn run_until(
        &mut self,
        timeout: Duration,
        wanted: impl Fn(&LaserEvent) -> bool,
    ) -> Option<LaserEvent> {
        let end = self.now + timeout;
        loop {
            self.laser.advance(self.now, &mut Staircase);
            while let Some(output) = self.laser.poll_output() {
                self.driver.handle_bytes(&output.bytes, self.now);
            }
            self.driver.handle_deadline(self.now);
            self.exchange();
            if let Some(at) = self.events.iter().position(&wanted) {
                return Some(self.events.drain(..=at).next_back().expect("found"));
            }
            self.events.clear();
            if self.now >= end {
                return None;
            }
            let next = [self.laser.next_event(), self.driver.deadline()];
            let next = next.into_iter().flatten().min().unwrap_or(end);
            self.now = next.max(self.now + Duration::from_micros(100)).min(end);
        }
    }

    pub(crate) fn try_connect(&mut self) -> LaserEvent {
        self.driver.connect(self.now);
        let over = |event: &LaserEvent| {
            matches!(
                event,
                LaserEvent::Connected(_) | LaserEvent::ConnectionFailed(_)
            )
        };
        let timeout = Duration::from_secs(16);
        self.run_until(timeout, over)
            .expect("an end, in bounded time")
    }

    pub(crate) fn connect(&mut self) {
        let event = self.try_connect();
        assert!(matches!(event, LaserEvent::Connected(_)), "{event:?}");
    }

    pub(crate) fn plan(&self, coding: ValueCoding) -> StreamPlan {
        StreamPlan {
            first_step: self.profile.first_step as u16,
            last_step: self.profile.last_step as u16,
            cluster: 1,
            interval: 0,
            coding,
            count: 0,
        }
    }

    pub(crate) fn stream(&mut self, coding: ValueCoding) {
        let plan = self.plan(coding);
        self.driver.start_streaming(plan, self.now).expect("idle");
    }

    /// Scans in this time; panics if one is lost.
    pub(crate) fn scans(&mut self, time: Duration) -> usize {
        let end = self.now + time;
        let mut scans = 0;
        while self.now < end {
            let left = end - self.now;
            let event = self.run_until(left, |event| {
                matches!(
                    event,
                    LaserEvent::Scan { .. }
                        | LaserEvent::LostScans(_)
                        | LaserEvent::ConnectionFailed(_)
                )
            });
            match event {
                Some(LaserEvent::Scan { .. }) => scans += 1,
                Some(other) => panic!("{other:?}"),
                None => {}
            }
        }
        scans
    }
}
