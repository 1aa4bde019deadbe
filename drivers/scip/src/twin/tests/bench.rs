//! A twin on a bench: a room to look at, a present that goes on, and a host that reads what comes.

use std::time::Duration;

use crate::twin::{
    FaultSpec, Instant, Output, Profile, StartState, Surroundings, Twin, TwinOptions,
};

pub(crate) const MS: Duration = Duration::from_millis(1);

/// Surroundings at one distance, which note when they were asked.
pub(crate) struct Room {
    pub(crate) range_mm: u32,
    pub(crate) looks: Vec<(Instant, Duration)>,
    /// How many steps were asked for each time.
    pub(crate) lengths: Vec<usize>,
}

impl Surroundings for Room {
    fn revolve(&mut self, start: Instant, period: Duration, out: &mut [u32]) {
        self.looks.push((start, period));
        self.lengths.push(out.len());
        out.fill(self.range_mm);
    }
}

/// A twin, a room, and a present that only goes on.
pub(crate) struct Bench {
    pub(crate) twin: Twin,
    pub(crate) room: Room,
    pub(crate) now: Instant,
}

/// A sensor whose motor and timer are exact, so that a test can count.
pub(crate) fn exact(start_state: StartState) -> TwinOptions {
    TwinOptions {
        clock_rate_error: 0.0,
        motor_rate_error: 0.0,
        start_state,
        ..TwinOptions::default()
    }
}

impl Bench {
    pub(crate) fn new(options: TwinOptions) -> Self {
        let room = Room {
            range_mm: 1234,
            looks: Vec::new(),
            lengths: Vec::new(),
        };
        Self {
            twin: Twin::new(options, Duration::ZERO),
            room,
            now: Duration::ZERO,
        }
    }

    pub(crate) fn idle() -> Self {
        Self::new(exact(StartState::Idle))
    }

    pub(crate) fn ug01() -> Self {
        Self::of(Profile::urg_04lx_ug01())
    }

    /// A sensor of this profile with an exact motor and timer, just switched on.
    pub(crate) fn of(profile: Profile) -> Self {
        Self::new(TwinOptions {
            profile,
            ..exact(StartState::PowerUp)
        })
    }

    pub(crate) fn send(&mut self, text: &str) {
        self.twin.advance(self.now, &mut self.room);
        self.twin.handle_bytes(text.as_bytes(), self.now);
    }

    /// Goes on for `time`, from event to event, and hands over what came.
    pub(crate) fn run(&mut self, time: Duration) -> Vec<Output> {
        let end = self.now + time;
        let mut outputs = Vec::new();
        loop {
            let next = self.twin.next_event().filter(|at| *at < end);
            let at = next.unwrap_or(end);
            assert!(
                at >= self.now,
                "an event at {at:?} has passed at {:?}",
                self.now
            );
            self.now = at;
            self.twin.advance(self.now, &mut self.room);
            while let Some(output) = self.twin.poll_output() {
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

    /// Sends one line and gives back all that comes within 120 ms.
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
        self.twin
            .inject(spec.parse::<FaultSpec>().expect("a fault"));
    }
}

pub(crate) fn joined(outputs: &[Output]) -> String {
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

/// Reads six-bit groups, written apart from the twin's own encoder.
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
