//! The whole unit: its parts, its clockwork and the calls of the outside.

use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Instant;
use super::axis::Axis;
use super::constants::UNSELECTED_BYTES;
use super::fault::{Board, FaultSpec, Strike};
use super::names::AxisName;
use super::options::{InputDuringReset, Supply, TwinOptions};
use super::parser::{LineParser, is_delimiter};
use super::replies::{Answer, Refusal};
use super::reset::Reset;
use super::settings::{ScanRange, Settings};
use super::wire::{Output, Receiver, Transmitter, byte_time};

/// What the single processor of the unit is busy with. Input waits unless it is ready.
#[derive(Debug)]
pub(super) enum Cpu {
    Ready,
    /// A request is complete and takes effect when due.
    Executing { due: Instant, text: Vec<u8> },
    /// Speed tables are recomputed; then these settings hold and `*` is printed.
    Recomputing { due: Instant, settings: Box<Settings> },
    /// `A`: `*` when both axes have stopped.
    Awaiting,
    Resetting(Reset),
    /// Without power.
    Off { until: Instant },
}

/// Auto-scan under way.
#[derive(Debug)]
pub(super) struct Scan {
    pub range: ScanRange,
    pub second: bool,
}

/// One emulated unit.
#[derive(Debug)]
pub struct Twin {
    pub(super) options: TwinOptions,
    pub(super) now: Instant,
    pub(super) axes: [Axis; 2],
    pub(super) settings: Settings,
    pub(super) saved: Settings,
    pub(super) cpu: Cpu,
    /// Measured limits, counts.
    pub(super) limits: [(i32, i32); 2],
    pub(super) calibrated: bool,
    /// Targets that slaved mode holds back.
    pub(super) held_back: [Option<i32>; 2],
    pub(super) scan: Option<Scan>,
    pub(super) selected: bool,
    pub(super) baud: u32,
    pub(super) power_up_baud: u32,
    pub(super) byte_gap: Duration,
    /// Line speed to take on after the reply.
    pub(super) next_baud: Option<u32>,
    pub(super) supply: Option<Supply>,
    pub(super) eeprom_writes: u32,
    pub(super) faults: Board,
    pub(super) rng: ChaCha8Rng,
    parser: LineParser,
    after_cr: bool,
    rx: Receiver,
    tx: Transmitter,
    unselected_output: Vec<u8>,
    host_baud: Option<u32>,
    noise: ChaCha8Rng,
}

impl Twin {
    /// A unit as the options describe it, at `now`.
    #[must_use]
    pub fn new(options: TwinOptions, now: Instant) -> Self {
        let started = Settings::started(&options);
        let saved = if options.power_up { started.clone() } else { Settings::factory(&options) };
        let axis = |name: AxisName| {
            let i = name.index();
            let margin = options.stop_margin_steps.max(options.limit_spread_steps).max(0);
            let stops = (options.minimum_steps[i] - margin, options.maximum_steps[i] + margin);
            Axis::new(options.start.position_steps[i], (f64::from(stops.0), f64::from(stops.1)), options.whole_steps, now)
        };
        let mut twin = Self {
            now,
            axes: [axis(AxisName::Pan), axis(AxisName::Tilt)],
            settings: started,
            saved,
            cpu: Cpu::Ready,
            limits: [(0, 0); 2],
            calibrated: true,
            held_back: [None; 2],
            scan: None,
            selected: options.start.unit_id == 0,
            baud: options.start.baud,
            power_up_baud: if options.power_up { options.start.baud } else { 9600 },
            byte_gap: Duration::ZERO,
            next_baud: None,
            supply: None,
            eeprom_writes: 0,
            faults: Board::default(),
            rng: ChaCha8Rng::seed_from_u64(options.seed),
            parser: LineParser::default(),
            after_cr: false,
            rx: Receiver::default(),
            tx: Transmitter::default(),
            unselected_output: Vec::new(),
            host_baud: None,
            noise: ChaCha8Rng::seed_from_u64(options.seed ^ 0x6e6f_6973_65),
            options,
        };
        if twin.options.power_up {
            twin.power_up();
        } else {
            AxisName::BOTH.into_iter().for_each(|axis| twin.measure_limits(axis));
            twin.start_running();
        }
        twin
    }

    /// Bytes from the host, put on the line at `now`.
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Instant) {
        self.advance(now);
        let pace = if self.options.byte_pacing { byte_time(self.baud) } else { Duration::ZERO };
        for &byte in bytes {
            let garbled = self.wrong_baud().then(|| self.noise.random());
            if let Some(byte) = self.faults.hear(garbled.unwrap_or(byte), self.now, &mut self.noise) {
                self.rx.push(byte, self.now, pace);
            }
        }
        self.advance(now);
    }

    /// Lets time pass until `now`; an earlier instant than the latest changes nothing.
    pub fn advance(&mut self, now: Instant) {
        let now = now.max(self.now);
        while let Some(at) = self.next_change().filter(|at| *at <= now) {
            self.now = at.max(self.now);
            self.tick();
        }
        self.now = now;
        self.move_axes();
    }

    /// The next bytes that have left the line by the latest instant.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.tx.pop(self.now)
    }

    /// When to call [`Twin::advance`] next, if nothing is sent before.
    #[must_use]
    pub fn next_event(&self) -> Option<Instant> {
        [self.next_change(), self.tx.next_at()].into_iter().flatten().min().map(|at| at.max(self.now))
    }

    /// True `(pan, tilt)` in half steps, whatever the step mode, at an instant of the last two seconds up to the latest
    /// one; earlier instants give the oldest position remembered, later ones the present motion's.
    #[must_use]
    pub fn true_position_at(&self, at: Instant) -> (f64, f64) {
        let at = at.min(self.now);
        let [pan, tilt] = &self.axes;
        (pan.true_at(at), tilt.true_at(at))
    }

    /// [`Twin::true_position_at`] in degrees.
    #[must_use]
    pub fn true_degrees_at(&self, at: Instant) -> (f64, f64) {
        let degrees = self.options.model.half_step_arcsec() / 3600.0;
        let (pan, tilt) = self.true_position_at(at);
        (pan * degrees, tilt * degrees)
    }

    /// Whether an axis is on its way.
    #[must_use]
    pub fn moving(&self) -> bool {
        self.axes.iter().any(Axis::moving)
    }

    /// Switches the unit off and on: volatile settings and the position are lost, the head stays where it is.
    pub fn power_cycle(&mut self, now: Instant) {
        self.advance(now);
        self.power_off(self.now);
    }

    /// Adds a fault; an instant that has passed means now.
    pub fn inject(&mut self, fault: FaultSpec) {
        self.faults.add(fault, self.now);
    }

    /// What `O` reports from now on, whatever the script says.
    pub fn set_supply(&mut self, supply: Supply) {
        self.supply = Some(supply);
    }

    /// The host's line speed, if it is known (a pseudo-terminal tells): garbage both ways while it differs from the unit's.
    pub fn set_host_baud(&mut self, baud: Option<u32>) {
        self.host_baud = baud;
    }

    /// The unit's line speed now.
    #[must_use]
    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// How often the EEPROM has been written; it wears out.
    #[must_use]
    pub fn eeprom_writes(&self) -> u32 {
        self.eeprom_writes
    }

    fn wrong_baud(&self) -> bool {
        self.host_baud.is_some_and(|baud| baud != self.baud)
    }

    /// When something happens next inside.
    fn next_change(&self) -> Option<Instant> {
        let cpu = match &self.cpu {
            Cpu::Executing { due, .. } | Cpu::Recomputing { due, .. } => Some(*due),
            Cpu::Off { until } => Some(*until),
            Cpu::Resetting(reset) => reset.deadline(),
            Cpu::Ready | Cpu::Awaiting => None,
        };
        let input = if self.listening() { self.rx.next_at() } else { None };
        let [pan, tilt] = &self.axes;
        [cpu, input, pan.next_change(), tilt.next_change(), self.faults.next_at(self.now)].into_iter().flatten().min()
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
    fn tick(&mut self) {
        self.move_axes();
        for strike in self.faults.strike(self.now) {
            self.suffer(strike);
        }
        for axis in AxisName::BOTH {
            let (stalled, blocked, pace) = self.faults.hindrance(axis, self.now);
            self.axes[axis.index()].hinder(self.now, stalled, blocked, pace);
        }
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

    fn move_axes(&mut self) {
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
            self.emit_if_selected(if byte != b' ' && is_delimiter(byte) { line_end } else { &echo });
        }
        if let Some(text) = self.parser.feed(byte) {
            let [least, most] = self.options.latency.map(|d| u64::try_from(d.as_nanos()).unwrap_or(u64::MAX));
            let latency = Duration::from_nanos(self.rng.random_range(least..=most.max(least)));
            self.cpu = Cpu::Executing { due: self.now.saturating_add(latency), text };
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
            let byte = if wrong { self.noise.random() } else { byte };
            said.extend(self.faults.say(byte, at, &mut self.noise));
        }
        let paced = self.options.byte_pacing || !self.byte_gap.is_zero();
        let pace = paced.then(|| {
            let byte = if self.options.byte_pacing { byte_time(self.baud) } else { Duration::ZERO };
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
            Strike::PowerCycle(until) => self.power_off(until),
            // A unit without power neither speaks nor changes its mind.
            _ if matches!(self.cpu, Cpu::Off { .. }) => {}
            Strike::Event(letter) => self.emit(format!("!{letter}").as_bytes()),
            Strike::Text(text) => self.emit_line(&text),
            Strike::Echo => self.settings.echo = true,
            Strike::Verbose => self.settings.verbose = true,
        }
    }

    fn power_off(&mut self, until: Instant) {
        for axis in &mut self.axes {
            axis.stop_at_once(self.now);
        }
        self.rx.clear();
        self.tx.power_off(self.now);
        self.parser = LineParser::default();
        self.after_cr = false;
        self.unselected_output.clear();
        self.held_back = [None; 2];
        self.scan = None;
        self.cpu = Cpu::Off { until };
        if until <= self.now {
            self.power_up();
        }
    }

    /// Bytes that wait, in and out, and segments remembered.
    #[cfg(test)]
    pub(super) fn load(&self) -> (usize, usize, usize) {
        (self.rx.len(), self.tx.len(), self.axes.iter().map(Axis::remembered).sum())
    }
}
