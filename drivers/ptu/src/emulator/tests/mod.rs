//! The emulated head against `docs/protocols/ptu-d46.md`.

mod clients;
mod commands;
mod disturbances;
mod faults;
mod motion;
mod reset;
mod wire;

use std::time::Duration;

use super::{EmulatedHead, HeadOptions};

/// Options of a unit without byte pacing, deviation of limits, verbose replies or echo.
fn options() -> HeadOptions {
    let mut options = HeadOptions {
        byte_pacing: false,
        limit_spread_steps: 0,
        ..HeadOptions::default()
    };
    options.start.echo = false;
    options.start.verbose = false;
    options
}

fn seconds(s: f64) -> Duration {
    Duration::from_secs_f64(s)
}

/// A host: an emulated head and its clock.
struct Host {
    head: EmulatedHead,
    now: Duration,
}

impl Host {
    fn new(options: HeadOptions) -> Self {
        Self {
            head: EmulatedHead::new(options, Duration::ZERO),
            now: Duration::ZERO,
        }
    }

    fn drain(&mut self) -> String {
        let mut all = Vec::new();
        while let Some(output) = self.head.poll_output() {
            assert!(output.at <= self.now);
            all.extend(output.bytes);
        }
        String::from_utf8_lossy(&all).into_owned()
    }

    /// Lets time pass, event by event; returns what was printed.
    fn wait(&mut self, s: f64) -> String {
        let end = self.now + seconds(s);
        let mut text = String::new();
        while let Some(at) = self.head.next_event().filter(|at| *at <= end) {
            self.now = at.max(self.now);
            self.head.advance(self.now);
            text += &self.drain();
        }
        self.now = end;
        self.head.advance(end);
        text + &self.drain()
    }

    fn send(&mut self, text: &str) {
        self.head.handle_bytes(text.as_bytes(), self.now);
    }

    /// Sends and waits long enough for any reply but those to motion and table requests.
    fn ask(&mut self, text: &str) -> String {
        self.send(text);
        self.wait(0.1)
    }

    fn number(&mut self, query: &str) -> i32 {
        let reply = self.ask(query);
        reply
            .trim()
            .trim_start_matches("* ")
            .parse()
            .unwrap_or_else(|_| panic!("{query}: {reply:?}"))
    }

    fn inject(&mut self, fault: &str) {
        self.head.inject(fault.parse().expect("valid fault"));
    }

    fn truth(&self) -> (f64, f64) {
        self.head.true_position_at(self.now)
    }
}
