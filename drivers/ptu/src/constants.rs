//! Constants of the driver, with their sources. "Own choice" marks those that have none.

use std::time::Duration;

/// Baud rates of the unit (ptu-d46 section 1), in the order in which a search should try them: the power-up rate first.
pub const BAUD_RATES: [u32; 9] = [9600, 38400, 19200, 115_200, 57600, 4800, 2400, 1200, 600];

/// Bits on the wire per byte at 8N1: start, eight, stop.
pub(crate) const BITS_PER_BYTE: u32 = 10;

/// Wait after the three spaces that end a half-typed command (ptu-d46 section 11, step 1).
pub(crate) const SETTLE_TIME: Duration = Duration::from_millis(250);

/// Wait for the first byte of a reply: slow hosts and USB adapters need it (ptu-d46 section 12, last row).
pub(crate) const REPLY_TIMEOUT: Duration = Duration::from_millis(500);

/// The longest reply of ptu-d46 section 3, the version text, bytes: a reply may take so long on the line after its first.
pub(crate) const LONGEST_REPLY_BYTES: usize = 90;

/// Time limit of a calibration (ptu-d46 section 7: others use 15 to 60 s).
pub(crate) const CALIBRATION_TIMEOUT: Duration = Duration::from_secs(60);

/// Silence during a calibration after which the unit is asked again (ptu-d46 section 7: others give one axis 15 s).
pub(crate) const CALIBRATION_POLL_AFTER: Duration = Duration::from_secs(20);

/// Attempts to connect, and times a command is sent, before it counts as failed. Own choice: survives one lost byte and one late
/// line in the same exchange.
pub(crate) const MAX_TRIES: u32 = 3;

/// Times that settings and identity are read, before replies that do not fit count as a fault. Own choice: a busy host is late
/// now and then, a line that repeats bytes always is wrong.
pub(crate) const MAX_SCRIPT_RUNS: u32 = 5;

/// Drain before and after the space of a resynchronisation; each byte extends it by the quiet time, up to the maximum. Own
/// choice: 100 ms is a hundred bytes at 9600 baud, longer than any reply.
pub(crate) const DRAIN_TIME: Duration = Duration::from_millis(100);
pub(crate) const QUIET_TIME: Duration = Duration::from_millis(50);
pub(crate) const MAX_DRAIN_TIME: Duration = Duration::from_secs(1);

/// Longest line kept, bytes: over twice [`LONGEST_REPLY_BYTES`].
pub(crate) const MAX_LINE_BYTES: usize = 256;

/// Own choice: with more commands waiting, the last would be minutes old when sent.
pub(crate) const MAX_QUEUED_COMMANDS: usize = 32;

/// An axis away from its target is stalled after this time without a change of position (ptu-d46 section 11, step 6).
pub(crate) const STALL_AFTER: Duration = Duration::from_secs(1);

/// Margin over the closed-form travel time (ptu-d46 section 11, step 6).
pub(crate) const OVERDUE_MARGIN: Duration = Duration::from_secs(1);

/// Equal polls at the target that confirm an arrival (ptu-d46 section 11, step 6): a reversing axis passes its target once.
pub(crate) const ARRIVAL_POLLS: u32 = 3;

/// Half step of the motor, degrees (ptu-d46 section 5).
pub(crate) const HALF_STEP_DEG: f64 = 0.9;

/// Gear ratio times steps per half step, where the exact step is known: 17.5:1 and 70:1 in half, quarter and eighth steps
/// (ptu-d46 section 5).
pub(crate) const KNOWN_RATIOS: [f64; 5] = [17.5, 35.0, 70.0, 140.0, 280.0];

/// The resolution is printed with four decimals, cut off or rounded (ptu-d46 section 5); arc seconds.
pub(crate) const RESOLUTION_PRINT_ERROR_ARCSEC: f64 = 1.0e-4;

/// Resolutions that can be, arc seconds per count: an eighth step behind 70:1 has 11.6, a full step behind 17.5:1 370.3
/// (ptu-d46 section 5). Own choice: a tenth of the first, the second rounded up.
pub(crate) const RESOLUTION_ARCSEC: std::ops::RangeInclusive<f64> = 1.0..=400.0;

/// Farthest limit from the middle that can be, degrees: a D46 reaches 159 (ptu-d46 section 5). Own choice: cables end any
/// head's turn a little beyond a full one.
pub(crate) const MAX_LIMIT_DEG: f64 = 400.0;

/// Highest speed that can be, degrees per second: the fastest unit is sold with "over 300" (ptu-d46 section 5). Own choice:
/// three times that.
pub(crate) const MAX_SPEED_DEG_S: f64 = 1000.0;
