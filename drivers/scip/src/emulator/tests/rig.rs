//! An emulated laser with constant ranges, a clock that only goes forward, and a host that reads everything.

use std::time::Duration;

use crate::emulator::{
    EmulatedLaser, LaserFaultSpec, LaserOptions, LaserOutput, LaserProfile, LaserStartState,
    RangeSource,
};

pub(crate) const MS: Duration = Duration::from_millis(1);

/// One range in all directions; records the revolutions that were asked for.
pub(crate) struct ConstantRange {
    pub(crate) range_mm: u32,
    pub(crate) revolutions: Vec<(Duration, Duration)>,
    /// Steps of each of them.
    pub(crate) lengths: Vec<usize>,
}

impl RangeSource for ConstantRange {
    fn fill_revolution(&mut self, start: Duration, period: Duration, out: &mut [u32]) {
        self.revolutions.push((start, period));
        self.lengths.push(out.len());
        out.fill(self.range_mm);
    }
}

pub(crate) struct LaserRig {
    pub(crate) laser: EmulatedLaser,
    pub(crate) source: ConstantRange,
    pub(crate) now: Duration,
}

/// Exact motor and timer, so that a test can count.
pub(crate) fn exact(start_state: LaserStartState) -> LaserOptions {
    LaserOptions {
        clock_rate_error: 0.0,
        motor_rate_error: 0.0,
        start_state,
        ..LaserOptions::default()
    }
}

impl LaserRig {
    pub(crate) fn new(options: LaserOptions) -> Self {
        let source = ConstantRange {
            range_mm: 1234,
            revolutions: Vec::new(),
            lengths: Vec::new(),
        };
        Self {
            laser: EmulatedLaser::new(options, Duration::ZERO),
            source,
            now: Duration::ZERO,
        }
    }

    pub(crate) fn idle() -> Self {
        Self::new(exact(LaserStartState::Idle))
    }

    pub(crate) fn ug01() -> Self {
        Self::with_profile(LaserProfile::urg_04lx_ug01())
    }

    /// With exact motor and timer, just switched on.
    pub(crate) fn with_profile(profile: LaserProfile) -> Self {
        Self::new(LaserOptions {
            profile,
            ..exact(LaserStartState::PowerUp)
        })
    }

    pub(crate) fn send(&mut self, text: &str) {
        self.laser.advance(self.now, &mut self.source);
        self.laser.handle_bytes(text.as_bytes(), self.now);
    }

    /// Advances by `time`, from event to event, and returns what was sent.
    pub(crate) fn run(&mut self, time: Duration) -> Vec<LaserOutput> {
        let end = self.now + time;
        let mut outputs = Vec::new();
        loop {
            let next = self.laser.next_event().filter(|at| *at < end);
            let at = next.unwrap_or(end);
            assert!(
                at >= self.now,
                "an event at {at:?} has passed at {:?}",
                self.now
            );
            self.now = at;
            self.laser.advance(self.now, &mut self.source);
            while let Some(output) = self.laser.poll_output() {
                assert!(output.at <= self.now);
                outputs.push(output);
            }
            if next.is_none() {
                return outputs;
            }
        }
    }

    pub(crate) fn text(&mut self, time: Duration) -> String {
        joined(&self.run(time))
    }

    /// Sends one line and returns everything within 120 ms.
    pub(crate) fn ask(&mut self, line: &str) -> String {
        self.send(&format!("{line}\n"));
        self.text(120 * MS)
    }

    /// The two characters of the status of the reply to `line`.
    pub(crate) fn status(&mut self, line: &str) -> String {
        let replies = messages(&self.ask(line));
        let reply = replies.iter().find(|reply| reply[0] == line);
        reply
            .and_then(|reply| reply.get(1))
            .map_or_else(String::new, |status| status.chars().take(2).collect())
    }

    pub(crate) fn inject(&mut self, spec: &str) {
        self.laser
            .inject(spec.parse::<LaserFaultSpec>().expect("a fault"));
    }
}

pub(crate) fn joined(outputs: &[LaserOutput]) -> String {
    let bytes: Vec<u8> = outputs
        .iter()
        .flat_map(|output| output.bytes.clone())
        .collect();
    bytes.iter().map(|byte| *byte as char).collect()
}

/// Messages: cut at empty lines, each as its lines.
pub(crate) fn messages(text: &str) -> Vec<Vec<String>> {
    text.split_terminator("\n\n")
        .map(|message| message.split('\n').map(str::to_owned).collect())
        .collect()
}

/// Reads six-bit groups, independently of the encoder.
pub(crate) fn decode(characters: &str) -> u32 {
    characters
        .bytes()
        .fold(0, |value, byte| value * 64 + u32::from(byte) - 48)
}

/// The stamps of the data messages in `text`.
pub(crate) fn stamps(text: &str) -> Vec<u32> {
    let data = messages(text)
        .into_iter()
        .filter(|message| message.get(1).is_some_and(|status| status == "99b"));
    data.map(|message| decode(&message[2][..4])).collect()
}
