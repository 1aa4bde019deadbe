//! Every figure that decides something in the twin and is not an option. Speeds and positions are in half steps.

use std::time::Duration;

/// How far back [`super::Twin::true_position_at`] remembers.
pub(super) const HISTORY: Duration = Duration::from_secs(2);
/// Most motion segments remembered per axis, whatever happens within [`HISTORY`].
pub(super) const HISTORY_SEGMENTS: usize = 8192;
/// Input bytes that wait for the parser; more are lost, as in any receive buffer.
pub(super) const INPUT_BYTES: usize = 4096;
/// Longest command text kept; a longer one is answered as illegal.
pub(super) const COMMAND_BYTES: usize = 64;
/// Output bytes that wait to be fetched; more are lost.
pub(super) const OUTPUT_BYTES: usize = 65_536;
/// Output that a unit keeps while another unit is selected (section 6, `_`).
pub(super) const UNSELECTED_BYTES: usize = 100;
/// Faults that can be pending or active at once; further ones are ignored.
pub(super) const FAULTS: usize = 256;
/// Shortest period of a repeated fault.
pub(super) const MIN_PERIOD: Duration = Duration::from_millis(1);
/// Smallest settable speed, positions/s (section 5).
pub(super) const MIN_SPEED: i32 = 31;
/// Largest settable upper bound, positions/s (unconfirmed in section 5; over 300 deg/s needs 5833).
pub(super) const MAX_SPEED: i32 = 12_000;
/// Largest settable acceleration, positions/s^2 (unconfirmed in section 5).
pub(super) const MAX_ACCELERATION: i32 = 200_000;
/// Targets are 16 bit in the unit (section 13).
pub(super) const MAX_POSITION: i32 = 32_767;
/// A stop fails the calibration if it is not reached within this many times its computed time plus [`RESET_GRACE`].
pub(super) const RESET_PATIENCE: f64 = 3.0;
/// See [`RESET_PATIENCE`].
pub(super) const RESET_GRACE: Duration = Duration::from_secs(2);
/// Presets 0..=32 (section 6).
pub(super) const PRESETS: usize = 33;
/// Largest network id (section 6).
pub(super) const MAX_UNIT_ID: i32 = 127;
/// Largest gap between output bytes that `@(...)` accepts, ms.
pub(super) const MAX_BYTE_GAP_MS: i32 = 255;
/// Baud rates of the D46 (section 1).
pub(super) const BAUD_RATES: [u32; 7] = [600, 1200, 2400, 4800, 9600, 19_200, 38_400];
/// Further baud rates of the E series (section 1).
pub(super) const E_BAUD_RATES: [u32; 2] = [57_600, 115_200];
/// Bits of one byte on the line, 8N1.
pub(super) const BITS_PER_BYTE: u32 = 10;
/// Half-step resolution of the 17.5:1 gear, arc seconds: 0.9 deg / 17.5 (section 5).
pub(super) const ARCSEC_D46_17: f64 = 0.9 * 3600.0 / 17.5;
/// Half-step resolution of the 70:1 gear, arc seconds: 0.9 deg / 70 (section 5).
pub(super) const ARCSEC_D46_70: f64 = 0.9 * 3600.0 / 70.0;
/// A target that no stop lets an axis reach: where velocity mode goes when limits are off.
pub(super) const BEYOND: i32 = 1_000_000;
