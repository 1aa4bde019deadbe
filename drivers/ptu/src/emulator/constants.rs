//! Constants of the emulator that are not options. Speeds and positions are in half steps.

use std::time::Duration;

/// How far back [`super::EmulatedHead::true_position_at`] can look.
pub(super) const HISTORY_TIME: Duration = Duration::from_secs(2);
/// Most motion segments kept per axis within [`HISTORY_TIME`].
pub(super) const MAX_HISTORY_SEGMENTS: usize = 8192;
/// Size of the receive buffer; further bytes are lost.
pub(super) const MAX_INPUT_BYTES: usize = 4096;
/// Longest command; a longer one is refused as illegal.
pub(super) const MAX_COMMAND_BYTES: usize = 64;
/// Output bytes that can wait to be fetched; further ones are lost.
pub(super) const MAX_OUTPUT_BYTES: usize = 65_536;
/// Output that a unit buffers while another unit is selected (ptu-d46 section 6, `_`).
pub(super) const MAX_UNSELECTED_BYTES: usize = 100;
/// Faults that can be scheduled at once; further ones are ignored.
pub(super) const MAX_FAULTS: usize = 256;
/// Period of a repeated fault without one of its own.
pub(super) const FAULT_PERIOD: Duration = Duration::from_secs(1);
/// Shortest period of a repeated fault.
pub(super) const MIN_FAULT_PERIOD: Duration = Duration::from_millis(1);
/// Smallest settable speed, positions/s (ptu-d46 section 5).
pub(super) const MIN_SPEED: i32 = 31;
/// Largest settable upper bound, positions/s (unconfirmed in ptu-d46 section 5; over 300 deg/s needs 5833).
pub(super) const MAX_SPEED: i32 = 12_000;
/// Largest settable acceleration, positions/s^2 (unconfirmed in ptu-d46 section 5).
pub(super) const MAX_ACCELERATION: i32 = 200_000;
/// Targets are 16 bit in the unit (ptu-d46 section 13).
pub(super) const MAX_POSITION: i32 = 32_767;
/// A calibration fails if a stop is not reached within this many times the computed time plus [`RESET_TIME_MARGIN`].
pub(super) const RESET_TIME_FACTOR: f64 = 3.0;
/// See [`RESET_TIME_FACTOR`].
pub(super) const RESET_TIME_MARGIN: Duration = Duration::from_secs(2);
/// Presets 0..=32 (ptu-d46 section 6).
pub(super) const PRESET_COUNT: usize = 33;
/// Largest network id (ptu-d46 section 6).
pub(super) const MAX_UNIT_ID: i32 = 127;
/// Longest gap between output bytes that `@(...)` accepts, ms.
pub(super) const MAX_BYTE_GAP_MS: i32 = 255;
/// Baud rates of the D46 (ptu-d46 section 1).
pub(super) const BAUD_RATES: [u32; 7] = [600, 1200, 2400, 4800, 9600, 19_200, 38_400];
/// Further baud rates of the E series (ptu-d46 section 1).
pub(super) const E_SERIES_BAUD_RATES: [u32; 2] = [57_600, 115_200];
/// Bits of one byte on the line, 8N1.
pub(super) const BITS_PER_BYTE: u32 = 10;
/// Half-step resolution of the 17.5:1 gear, arc seconds: 0.9 deg / 17.5 (ptu-d46 section 5).
pub(super) const ARCSEC_D46_17: f64 = 0.9 * 3600.0 / 17.5;
/// Half-step resolution of the 70:1 gear, arc seconds: 0.9 deg / 70 (ptu-d46 section 5).
pub(super) const ARCSEC_D46_70: f64 = 0.9 * 3600.0 / 70.0;
/// A target beyond every stop: that of velocity mode while limits are off.
pub(super) const UNREACHABLE_TARGET: i32 = 1_000_000;
