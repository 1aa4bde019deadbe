//! What passes inside the unit between two calls of the outside, in the order of its instants.

use std::time::Duration;

use rand::RngExt;

use super::Instant;
use super::constants::UNSELECTED_BYTES;
use super::fault::{FaultKind, Strike};
use super::names::AxisName;
use super::options::InputDuringReset;
use super::parser::{LineParser, is_delimiter};
use super::replies::{Answer, Refusal};
use super::settings::LimitMode;
use super::unit::{Cpu, Twin};
use super::wire::byte_time;

impl Twin {
    pub(super) fn wrong_baud(&self) -> bool {
        self.host_baud.is_some_and(|baud| baud != self.baud)
    }

    /// When something happens next inside.
    pub(super) fn next_change(&self) -> Option<Instant> {
        let cpu = match &self.cpu {
            Cpu::Executing { due, .. } | Cpu::Recomputing { due, .. } => Some(*due),
            Cpu::Off { until } => Some(*until).filter(|until| *until != Instant::MAX),
            Cpu::Resetting(reset) => reset.deadline(),
            Cpu::Ready | Cpu::Awaiting => None,
        };
        let input = if self.listening() {
            self.rx.next_at()
        } else {
            None
        };
        let [pan, tilt] = &self.axes;
        [
            cpu,
            input,
            pan.next_change(),
            tilt.next_change(),
            self.faults.next_at(self.now),
        ]
        .into_iter()
        .flatten()
        .min()
    }

    /// Whether arriving bytes are taken off the line now (to be read or to be lost).
    fn listening(&self) -> bool {
        match self.cpu {
            Cpu::Ready | Cpu::Off { .. } => true,
            Cpu::Resetting(_) => self.options.input_during_reset == InputDuringReset::Dropped,
            _ => false,
        }
    }

    /// Everything that is due at `self.now`.
    pub(super) fn tick(&mut self) {
        self.move_axes();
        for strike in self.faults.strike(self.now) {
            self.suffer(strike);
        }
        for axis in AxisName::BOTH {
            let (stalled, blocked, pace) = self.faults.hindrance(axis, self.now);
            self.axes[axis.index()].hinder(self.now, stalled, blocked, pace);
        }
        self.come_back();
        self.run_cpu();
        while self.listening()
            && let Some(byte) = self.rx.pop(self.now)
        {
            if matches!(self.cpu, Cpu::Ready) {
                self.consume(byte);
            }
        }
        self.turn_scan();
    }

    pub(super) fn move_axes(&mut self) {
        for name in AxisName::BOTH {
            let axis = &mut self.axes[name.index()];
            for at in axis.advance(self.now) {
                if self.settings.velocity_mode {
                    self.axes[name.index()].stop_at_once(self.now);
                }
                self.emit_at(name.limit_event(), at);
            }
        }
    }

    /// An axis that has run past its target turns back to it.
    fn come_back(&mut self) {
        for axis in AxisName::BOTH {
            if !self.axes[axis.index()].moving()
                && let Some(target) = self.overshot[axis.index()].take()
            {
                let ramp = self.settings.axis(axis).ramp();
                self.axes[axis.index()].drive(self.now, target, ramp);
            }
        }
    }

    fn run_cpu(&mut self) {
        let now = self.now;
        match std::mem::replace(&mut self.cpu, Cpu::Ready) {
            Cpu::Executing { due, text } if due <= now => self.execute(&text),
            Cpu::Recomputing { due, settings } if due <= now => {
                self.settings = *settings;
                self.reply(Ok(None));
            }
            Cpu::Awaiting if !self.moving() => self.reply(Ok(None)),
            Cpu::Off { until } if until <= now => self.power_up(),
            Cpu::Resetting(reset) => self.continue_reset(reset),
            busy => self.cpu = busy,
        }
    }

    /// The parser takes one byte.
    fn consume(&mut self, byte: u8) {
        let second_half = std::mem::replace(&mut self.after_cr, byte == b'\r') && byte == b'\n';
        if second_half {
            return;
        }
        self.end_scan();
        if self.settings.echo {
            let line_end = self.options.line_end.bytes();
            let echo = [byte];
            self.emit_if_selected(if byte != b' ' && is_delimiter(byte) {
                line_end
            } else {
                &echo
            });
        }
        if let Some(text) = self.parser.feed(byte) {
            let [least, most] = self
                .options
                .latency
                .map(|d| u64::try_from(d.as_nanos()).unwrap_or(u64::MAX));
            let latency = Duration::from_nanos(self.rng.random_range(least..=most.max(least)));
            self.cpu = Cpu::Executing {
                due: self.now.saturating_add(latency),
                text,
            };
        }
    }

    /// Prints a reply: `*`, `* answer` or `! refusal`.
    pub(super) fn reply(&mut self, reply: Result<Option<Answer>, Refusal>) {
        let text = match reply {
            Ok(None) => "*".to_owned(),
            Ok(Some(answer)) if self.settings.verbose => format!("* {}", answer.verbose),
            Ok(Some(answer)) => format!("* {}", answer.terse),
            Err(refusal) => format!("! {refusal}"),
        };
        self.emit_line(&text);
    }

    /// Prints a line.
    pub(super) fn emit_line(&mut self, text: &str) {
        let mut line = text.as_bytes().to_vec();
        line.extend_from_slice(self.options.line_end.bytes());
        self.emit(&line);
    }

    /// Prints bytes now.
    pub(super) fn emit(&mut self, bytes: &[u8]) {
        self.emit_at(bytes, self.now);
    }

    fn emit_if_selected(&mut self, bytes: &[u8]) {
        if self.selected {
            self.emit(bytes);
        }
    }

    fn emit_at(&mut self, bytes: &[u8], at: Instant) {
        if !self.selected {
            let room = UNSELECTED_BYTES.saturating_sub(self.unselected_output.len());
            self.unselected_output.extend(bytes.iter().take(room));
            return;
        }
        let wrong = self.wrong_baud();
        let mut said = Vec::with_capacity(bytes.len());
        for &byte in bytes {
            said.extend(self.faults.intrude(at).into_iter().flatten());
            let byte = if wrong { self.noise.random() } else { byte };
            said.extend(self.faults.say(byte, at, &mut self.noise));
        }
        let paced = self.options.byte_pacing || !self.byte_gap.is_zero();
        let pace = paced.then(|| {
            let byte = if self.options.byte_pacing {
                byte_time(self.baud)
            } else {
                Duration::ZERO
            };
            byte.saturating_add(self.byte_gap)
        });
        self.tx.send(&said, at, pace);
    }

    /// This unit or another one owns the line from now on.
    pub(super) fn select(&mut self, selected: bool) {
        self.selected = selected;
        if selected {
            let kept = std::mem::take(&mut self.unselected_output);
            self.emit(&kept);
        }
    }

    fn suffer(&mut self, strike: Strike) {
        match strike {
            Strike::Lose(axis, steps) => self.axes[axis.index()].lose(self.now, steps),
            Strike::PowerCycle(until) => self.go_dark(until),
            // A unit without power neither speaks nor changes its mind.
            _ if matches!(self.cpu, Cpu::Off { .. }) => {}
            Strike::Event(letter) => self.emit(format!("!{letter}").as_bytes()),
            Strike::Text(text) => self.emit_line(&text),
            Strike::Echo => self.settings.echo = true,
            Strike::Verbose => self.settings.verbose = true,
            Strike::Meddle(meddling) => self.be_meddled_with(&meddling),
        }
    }

    /// Somebody else commanded the unit: what they did holds, nothing is printed.
    fn be_meddled_with(&mut self, meddling: &FaultKind) {
        match *meddling {
            FaultKind::Velocity => self.set_velocity_mode(true),
            FaultKind::Slaved => self.settings.slaved = true,
            FaultKind::LimitsOff => self.settings.limits = LimitMode::Off,
            FaultKind::Monitor => self.begin_scan(self.default_scan()),
            FaultKind::Moving(targets) => {
                for (axis, target) in AxisName::BOTH.into_iter().zip(targets) {
                    self.drive(axis, target);
                }
            }
            FaultKind::UnitId(id) => {
                self.settings.unit_id = id;
                self.selected = false;
            }
            FaultKind::Baud(rate) => self.baud = rate,
            FaultKind::AxisError => self.calibrated = false,
            _ => {}
        }
    }

    /// Without power until the instant.
    pub(super) fn go_dark(&mut self, until: Instant) {
        for axis in &mut self.axes {
            axis.stop_at_once(self.now);
        }
        self.rx.clear();
        self.tx.power_off(self.now);
        self.parser = LineParser::default();
        self.after_cr = false;
        self.unselected_output.clear();
        self.held_back = [None; 2];
        self.overshot = [None; 2];
        self.scan = None;
        self.cpu = Cpu::Off { until };
        if until <= self.now {
            self.power_up();
        }
    }
}
