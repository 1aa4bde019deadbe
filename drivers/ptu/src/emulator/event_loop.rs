//! Event loop of the emulated head: what happens inside between two calls, in the order of its instants.

use std::time::Duration;

use rand::RngExt;

use super::axis_name::AxisName;
use super::constants::MAX_UNSELECTED_BYTES;
use super::fault::{FaultEffect, HeadFaultKind};
use super::options::InputDuringReset;
use super::parser::{RequestBuffer, is_delimiter};
use super::replies::{QueryAnswer, RequestRefusal};
use super::settings::LimitMode;
use super::state::{CpuState, EmulatedHead};
use super::wire::byte_time;

impl EmulatedHead {
    pub(super) fn wrong_baud(&self) -> bool {
        self.host_baud.is_some_and(|baud| baud != self.baud)
    }

    /// When something changes next inside the unit.
    pub(super) fn next_change(&self) -> Option<Duration> {
        let cpu = match &self.cpu {
            CpuState::Executing { due, .. } | CpuState::Recomputing { due, .. } => Some(*due),
            CpuState::Off { until } => Some(*until).filter(|until| *until != Duration::MAX),
            CpuState::Resetting(reset) => reset.current.map(|(_, deadline)| deadline),
            CpuState::Ready | CpuState::Awaiting => None,
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

    /// Whether received bytes are taken off the line now, to be parsed or dropped.
    fn listening(&self) -> bool {
        match self.cpu {
            CpuState::Ready | CpuState::Off { .. } => true,
            CpuState::Resetting(_) => self.options.input_during_reset == InputDuringReset::Dropped,
            _ => false,
        }
    }

    /// Does everything that is due at `self.now`.
    pub(super) fn process_due(&mut self) {
        self.move_axes();
        for effect in self.faults.take_due(self.now) {
            self.apply_fault(effect);
        }
        for axis in AxisName::BOTH {
            let (stalled, blocked, speed_factor) = self.faults.hindrance(axis, self.now);
            self.axes[axis.index()].set_hindrance(self.now, stalled, blocked, speed_factor);
        }
        self.return_from_overshoot();
        self.run_cpu();
        while self.listening()
            && let Some(byte) = self.rx.pop(self.now)
        {
            if matches!(self.cpu, CpuState::Ready) {
                self.consume_byte(byte);
            }
        }
        self.reverse_scan();
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

    /// Sends an axis that ran past its target back to it.
    fn return_from_overshoot(&mut self) {
        for axis in AxisName::BOTH {
            if !self.axes[axis.index()].moving()
                && let Some(target) = self.overshoot_target[axis.index()].take()
            {
                let ramp = self.settings.axis(axis).ramp();
                self.axes[axis.index()].drive(self.now, target, ramp);
            }
        }
    }

    fn run_cpu(&mut self) {
        let now = self.now;
        match std::mem::replace(&mut self.cpu, CpuState::Ready) {
            CpuState::Executing { due, text } if due <= now => self.execute(&text),
            CpuState::Recomputing { due, settings } if due <= now => {
                self.settings = *settings;
                self.reply(Ok(None));
            }
            CpuState::Awaiting if !self.moving() => self.reply(Ok(None)),
            CpuState::Off { until } if until <= now => self.power_up(),
            CpuState::Resetting(reset) => self.continue_reset(reset),
            busy => self.cpu = busy,
        }
    }

    /// Echoes and parses one byte.
    fn consume_byte(&mut self, byte: u8) {
        let lf_of_crlf = std::mem::replace(&mut self.after_cr, byte == b'\r') && byte == b'\n';
        if lf_of_crlf {
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
        if let Some(text) = self.parser.push(byte) {
            let [min, max] = self
                .options
                .latency
                .map(|d| u64::try_from(d.as_nanos()).unwrap_or(u64::MAX));
            let latency = Duration::from_nanos(self.rng.random_range(min..=max.max(min)));
            self.cpu = CpuState::Executing {
                due: self.now.saturating_add(latency),
                text,
            };
        }
    }

    /// Prints a reply: `*`, `* answer` or `! refusal`.
    pub(super) fn reply(&mut self, reply: Result<Option<QueryAnswer>, RequestRefusal>) {
        let text = match reply {
            Ok(None) => "*".to_owned(),
            Ok(Some(answer)) if self.settings.verbose => format!("* {}", answer.verbose),
            Ok(Some(answer)) => format!("* {}", answer.terse),
            Err(refusal) => format!("! {refusal}"),
        };
        self.emit_line(&text);
    }

    pub(super) fn emit_line(&mut self, text: &str) {
        let mut line = text.as_bytes().to_vec();
        line.extend_from_slice(self.options.line_end.bytes());
        self.emit(&line);
    }

    pub(super) fn emit(&mut self, bytes: &[u8]) {
        self.emit_at(bytes, self.now);
    }

    fn emit_if_selected(&mut self, bytes: &[u8]) {
        if self.selected {
            self.emit(bytes);
        }
    }

    fn emit_at(&mut self, bytes: &[u8], at: Duration) {
        if !self.selected {
            let free = MAX_UNSELECTED_BYTES.saturating_sub(self.held_output.len());
            self.held_output.extend(bytes.iter().take(free));
            return;
        }
        let wrong = self.wrong_baud();
        let mut sent = Vec::with_capacity(bytes.len());
        for &byte in bytes {
            sent.extend(self.faults.inserted_event(at).into_iter().flatten());
            let byte = if wrong { self.noise.random() } else { byte };
            sent.extend(self.faults.filter_output(byte, at, &mut self.noise));
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
        self.tx.send(&sent, at, pace);
    }

    /// Selects this unit or another one on a shared line.
    pub(super) fn select(&mut self, selected: bool) {
        self.selected = selected;
        if selected {
            let kept = std::mem::take(&mut self.held_output);
            self.emit(&kept);
        }
    }

    fn apply_fault(&mut self, effect: FaultEffect) {
        match effect {
            FaultEffect::LoseSteps(axis, steps) => {
                self.axes[axis.index()].lose_steps(self.now, steps)
            }
            FaultEffect::PowerCycle(until) => self.cut_power(until),
            // A unit without power sends nothing and changes no setting.
            _ if matches!(self.cpu, CpuState::Off { .. }) => {}
            FaultEffect::Event(letter) => self.emit(format!("!{letter}").as_bytes()),
            FaultEffect::Text(text) => self.emit_line(&text),
            FaultEffect::Echo => self.settings.echo = true,
            FaultEffect::Verbose => self.settings.verbose = true,
            FaultEffect::ForeignCommand(kind) => self.apply_foreign_command(&kind),
        }
    }

    /// Takes effect like a command of another program; prints nothing.
    fn apply_foreign_command(&mut self, kind: &HeadFaultKind) {
        match *kind {
            HeadFaultKind::Velocity => self.set_velocity_mode(true),
            HeadFaultKind::Slaved => self.settings.slaved = true,
            HeadFaultKind::LimitsOff => self.settings.limits = LimitMode::Off,
            HeadFaultKind::Monitor => self.begin_scan(self.default_scan()),
            HeadFaultKind::Moving(targets) => {
                for (axis, target) in AxisName::BOTH.into_iter().zip(targets) {
                    self.drive(axis, target);
                }
            }
            HeadFaultKind::UnitId(id) => {
                self.settings.unit_id = id;
                self.selected = false;
            }
            HeadFaultKind::Baud(rate) => self.baud = rate,
            HeadFaultKind::AxisError => self.calibrated = false,
            _ => {}
        }
    }

    /// Switches the power off until `until`.
    pub(super) fn cut_power(&mut self, until: Duration) {
        for axis in &mut self.axes {
            axis.stop_at_once(self.now);
        }
        self.rx.clear();
        self.tx.power_off(self.now);
        self.parser = RequestBuffer::default();
        self.after_cr = false;
        self.held_output.clear();
        self.held_back = [None; 2];
        self.overshoot_target = [None; 2];
        self.scan = None;
        self.cpu = CpuState::Off { until };
        if until <= self.now {
            self.power_up();
        }
    }
}
