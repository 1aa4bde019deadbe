//! The whole unit: its parts and the calls of the outside.

use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Instant;
use super::axis::Axis;
use super::fault::{Board, FaultSpec};
use super::names::AxisName;
use super::options::{Supply, TwinOptions};
use super::parser::LineParser;
use super::reset::Reset;
use super::settings::{ScanRange, Settings};
use super::wire::{Output, Receiver, Transmitter, byte_time};

/// What the single processor of the unit is busy with. Input waits unless it is ready.
#[derive(Debug)]
pub(super) enum Cpu {
    Ready,
    /// A request is complete and takes effect when due.
    Executing {
        due: Instant,
        text: Vec<u8>,
    },
    /// Speed tables are recomputed; then these settings hold and `*` is printed.
    Recomputing {
        due: Instant,
        settings: Box<Settings>,
    },
    /// `A`: `*` when both axes have stopped.
    Awaiting,
    Resetting(Reset),
    /// Without power.
    Off {
        until: Instant,
    },
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
    /// Targets that an axis is made to run past, and to come back to.
    pub(super) overshot: [Option<i32>; 2],
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
    pub(super) parser: LineParser,
    pub(super) after_cr: bool,
    pub(super) rx: Receiver,
    pub(super) tx: Transmitter,
    pub(super) unselected_output: Vec<u8>,
    pub(super) host_baud: Option<u32>,
    pub(super) noise: ChaCha8Rng,
}

impl Twin {
    /// A unit as the options describe it, at `now`.
    #[must_use]
    pub fn new(options: TwinOptions, now: Instant) -> Self {
        let started = Settings::started(&options);
        let saved = if options.power_up {
            started.clone()
        } else {
            Settings::factory(&options)
        };
        let axis = |name: AxisName| {
            let i = name.index();
            let margin = options
                .stop_margin_steps
                .max(options.limit_spread_steps)
                .max(0);
            let stops = (
                options.minimum_steps[i] - margin,
                options.maximum_steps[i] + margin,
            );
            Axis::new(
                options.start.position_steps[i],
                (f64::from(stops.0), f64::from(stops.1)),
                options.whole_steps,
                now,
            )
            .with_backlash(options.backlash_half_steps[i])
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
            overshot: [None; 2],
            scan: None,
            selected: options.start.unit_id == 0,
            baud: options.start.baud,
            power_up_baud: if options.power_up {
                options.start.baud
            } else {
                9600
            },
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
            noise: ChaCha8Rng::seed_from_u64(options.seed ^ 0x006e_6f69_7365),
            options,
        };
        if twin.options.power_up {
            twin.power_up();
        } else {
            AxisName::BOTH
                .into_iter()
                .for_each(|axis| twin.measure_limits(axis));
            twin.start_running();
        }
        twin
    }

    /// Bytes from the host, put on the line at `now`.
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Instant) {
        self.advance(now);
        let pace = if self.options.byte_pacing {
            byte_time(self.baud)
        } else {
            Duration::ZERO
        };
        for &byte in bytes {
            let garbled = self.wrong_baud().then(|| self.noise.random());
            if let Some(byte) = self
                .faults
                .hear(garbled.unwrap_or(byte), self.now, &mut self.noise)
            {
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
        [self.next_change(), self.tx.next_at()]
            .into_iter()
            .flatten()
            .min()
            .map(|at| at.max(self.now))
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
        self.go_dark(self.now);
    }

    /// Takes the power away until the next [`Twin::power_cycle`].
    pub fn power_off(&mut self, now: Instant) {
        self.advance(now);
        self.go_dark(Instant::MAX);
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

    /// Bytes that wait, in and out, and segments remembered.
    #[cfg(test)]
    pub(super) fn load(&self) -> (usize, usize, usize) {
        (
            self.rx.len(),
            self.tx.len(),
            self.axes.iter().map(Axis::remembered).sum(),
        )
    }
}
