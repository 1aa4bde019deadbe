//! State of the emulated head.

use std::collections::VecDeque;
use std::time::Duration;

use rand_chacha::ChaCha8Rng;

use super::axis::EmulatedAxis;
use super::axis_name::AxisName;
use super::fault::FaultSchedule;
use super::options::{HeadOptions, Supply};
use super::parser::RequestBuffer;
use super::settings::{ScanRange, UnitSettings};
use super::wire::{InputLine, OutputLine};

/// One drive of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ResetStage {
    /// To a stop, where the unit prints a limit event.
    Stop { axis: AxisName, upper: bool },
    /// The chosen axes to 0.
    Home,
}

/// A calibration under way.
#[derive(Debug)]
pub(super) struct ResetRun {
    pub axes: Vec<AxisName>,
    pub stages: VecDeque<ResetStage>,
    /// The drive under way, and when it counts as failed.
    pub current: Option<(ResetStage, Duration)>,
    pub fails: bool,
    pub power_up: bool,
}

/// What the unit's single processor is doing. Input waits unless it is ready.
#[derive(Debug)]
pub(super) enum CpuState {
    Ready,
    /// A request is complete and takes effect when due.
    Executing {
        due: Duration,
        text: Vec<u8>,
    },
    /// Speed tables are being recomputed; then these settings hold and `*` is printed.
    Recomputing {
        due: Duration,
        settings: Box<UnitSettings>,
    },
    /// `A`: `*` when both axes have stopped.
    Awaiting,
    Resetting(ResetRun),
    /// Without power.
    Off {
        until: Duration,
    },
}

/// An auto-scan under way.
#[derive(Debug)]
pub(super) struct AutoScan {
    pub range: ScanRange,
    /// Whether the axes move to the second ends of the range.
    pub second: bool,
}

/// One emulated PTU-D46.
#[derive(Debug)]
pub struct EmulatedHead {
    pub(super) options: HeadOptions,
    pub(super) now: Duration,
    pub(super) axes: [EmulatedAxis; 2],
    pub(super) settings: UnitSettings,
    pub(super) saved: UnitSettings,
    pub(super) cpu: CpuState,
    /// Measured limits, counts.
    pub(super) limits: [(i32, i32); 2],
    pub(super) calibrated: bool,
    /// Targets that slaved mode holds back.
    pub(super) held_back: [Option<i32>; 2],
    /// Targets of axes that run past them and come back.
    pub(super) overshoot_target: [Option<i32>; 2],
    pub(super) scan: Option<AutoScan>,
    pub(super) selected: bool,
    pub(super) baud: u32,
    pub(super) power_up_baud: u32,
    pub(super) byte_gap: Duration,
    /// Line speed after the reply.
    pub(super) next_baud: Option<u32>,
    pub(super) supply: Option<Supply>,
    pub(super) eeprom_writes: u32,
    pub(super) faults: FaultSchedule,
    pub(super) rng: ChaCha8Rng,
    pub(super) parser: RequestBuffer,
    pub(super) after_cr: bool,
    pub(super) rx: InputLine,
    pub(super) tx: OutputLine,
    /// Output kept while another unit on the line is selected.
    pub(super) held_output: Vec<u8>,
    pub(super) host_baud: Option<u32>,
    pub(super) noise: ChaCha8Rng,
}
