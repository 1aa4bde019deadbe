//! The interface of the emulated head: its construction, bytes in and out, time, and the truth behind the counts.

use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::axis::EmulatedAxis;
use super::axis_name::AxisName;
use super::fault::{FaultSchedule, HeadFaultSpec};
use super::options::{HeadOptions, Supply};
use super::parser::RequestBuffer;
use super::settings::UnitSettings;
use super::state::{CpuState, EmulatedHead};
use super::wire::{HeadOutput, InputLine, OutputLine, byte_time};

impl EmulatedHead {
    /// A unit with these options, started at `now`.
    #[must_use]
    pub fn new(options: HeadOptions, now: Duration) -> Self {
        let started = UnitSettings::started(&options);
        let saved = if options.power_up {
            started.clone()
        } else {
            UnitSettings::factory(&options)
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
            EmulatedAxis::new(
                options.start.position_steps[i],
                (f64::from(stops.0), f64::from(stops.1)),
                options.whole_steps,
                now,
            )
            .with_backlash(options.backlash_half_steps[i])
        };
        let mut head = Self {
            now,
            axes: [axis(AxisName::Pan), axis(AxisName::Tilt)],
            settings: started,
            saved,
            cpu: CpuState::Ready,
            limits: [(0, 0); 2],
            calibrated: true,
            held_back: [None; 2],
            overshoot_target: [None; 2],
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
            faults: FaultSchedule::default(),
            rng: ChaCha8Rng::seed_from_u64(options.seed),
            parser: RequestBuffer::default(),
            after_cr: false,
            rx: InputLine::default(),
            tx: OutputLine::default(),
            held_output: Vec::new(),
            host_baud: None,
            noise: ChaCha8Rng::seed_from_u64(options.seed ^ 0x006e_6f69_7365),
            options,
        };
        if head.options.power_up {
            head.power_up();
        } else {
            AxisName::BOTH
                .into_iter()
                .for_each(|axis| head.measure_limits(axis));
            head.start_running();
        }
        head
    }

    /// Takes bytes that the host puts on the line at `now`.
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.advance(now);
        let pace = if self.options.byte_pacing {
            byte_time(self.baud)
        } else {
            Duration::ZERO
        };
        for &byte in bytes {
            let garbled = self.wrong_baud().then(|| self.noise.random());
            if let Some(byte) =
                self.faults
                    .filter_input(garbled.unwrap_or(byte), self.now, &mut self.noise)
            {
                self.rx.push(byte, self.now, pace);
            }
        }
        self.advance(now);
    }

    /// Lets time pass until `now`; an earlier instant than the latest changes nothing.
    pub fn advance(&mut self, now: Duration) {
        let now = now.max(self.now);
        while let Some(at) = self.next_change().filter(|at| *at <= now) {
            self.now = at.max(self.now);
            self.process_due();
        }
        self.now = now;
        self.move_axes();
    }

    /// The next bytes that have left the line by the latest instant.
    pub fn poll_output(&mut self) -> Option<HeadOutput> {
        self.tx.pop(self.now)
    }

    /// When to call [`EmulatedHead::advance`] next, if nothing is sent before.
    #[must_use]
    pub fn next_event(&self) -> Option<Duration> {
        [self.next_change(), self.tx.next_at()]
            .into_iter()
            .flatten()
            .min()
            .map(|at| at.max(self.now))
    }

    /// True `(pan, tilt)` in half steps, whatever the step mode, at an instant of the last two seconds. Earlier instants give the
    /// oldest position kept, later ones the latest position.
    #[must_use]
    pub fn true_position_at(&self, at: Duration) -> (f64, f64) {
        let at = at.min(self.now);
        let [pan, tilt] = &self.axes;
        (pan.head_at(at), tilt.head_at(at))
    }

    /// [`EmulatedHead::true_position_at`] in degrees.
    #[must_use]
    pub fn true_degrees_at(&self, at: Duration) -> (f64, f64) {
        let degrees = self.options.model.half_step_arcsec() / 3600.0;
        let (pan, tilt) = self.true_position_at(at);
        (pan * degrees, tilt * degrees)
    }

    /// Whether an axis is moving.
    #[must_use]
    pub fn moving(&self) -> bool {
        self.axes.iter().any(EmulatedAxis::moving)
    }

    /// Switches the unit off and on: volatile settings and the position are lost, the head stays where it is.
    pub fn power_cycle(&mut self, now: Duration) {
        self.advance(now);
        self.cut_power(self.now);
    }

    /// Switches the unit off until the next [`EmulatedHead::power_cycle`].
    pub fn power_off(&mut self, now: Duration) {
        self.advance(now);
        self.cut_power(Duration::MAX);
    }

    /// Schedules a fault; one whose instant has passed strikes now.
    pub fn inject(&mut self, fault: HeadFaultSpec) {
        self.faults.add(fault, self.now);
    }

    /// Sets what `O` reports.
    pub fn set_supply(&mut self, supply: Supply) {
        self.supply = Some(supply);
    }

    /// Sets the host's line speed, if it is known (that of a pseudo-terminal is): while it differs from the unit's, bytes are
    /// garbage both ways.
    pub fn set_host_baud(&mut self, baud: Option<u32>) {
        self.host_baud = baud;
    }

    /// The unit's line speed.
    #[must_use]
    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// How often the EEPROM has been written; it wears out.
    #[must_use]
    pub fn eeprom_writes(&self) -> u32 {
        self.eeprom_writes
    }

    /// Bytes waiting in and out, and motion segments kept.
    #[cfg(test)]
    pub(super) fn queue_lengths(&self) -> (usize, usize, usize) {
        (
            self.rx.len(),
            self.tx.len(),
            self.axes.iter().map(EmulatedAxis::history_len).sum(),
        )
    }
}
