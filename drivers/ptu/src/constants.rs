//! Every figure that decides something in the dialogue, with its origin.

use std::time::Duration;

/// Baud rates the unit knows (section 1), in the order in which a search should try them: the power-up rate first.
pub const BAUD_RATES: [u32; 9] = [9600, 38400, 19200, 115_200, 57600, 4800, 2400, 1200, 600];

/// Bits on the wire per byte at 8N1: start, eight, stop.
pub(crate) const BITS_PER_BYTE: u32 = 10;

/// Quiet time after the three spaces that end a half-typed command (section 11, step 1).
pub(crate) const SETTLE: Duration = Duration::from_millis(250);

/// Wait for each of `ED` and `FT` at connecting (section 11, step 1).
pub(crate) const PREAMBLE_TIMEOUT: Duration = Duration::from_millis(300);

/// Least wait for a reply: slow hosts and USB adapters need it (section 12, last row).
pub(crate) const REPLY_TIMEOUT_MIN: Duration = Duration::from_millis(500);

/// Longest calibration waited for (section 7: others use 15 to 60 s).
pub(crate) const CALIBRATION_TIMEOUT: Duration = Duration::from_secs(60);

/// Silence in a calibration after which the unit is asked again (section 7: others give one axis 15 s).
pub(crate) const CALIBRATION_QUIET: Duration = Duration::from_secs(20);

/// Times a connection is tried, and times a command is sent, before it is called failed. Own choice: one lost byte and one late
/// line in the same exchange are still survived.
pub(crate) const TRIES: u32 = 3;

/// Drain before and after the space of a resynchronisation, the silence that ends a drain early enough, and its hard end. Own
/// choice: 100 ms is a hundred bytes at 9600 baud, longer than any reply.
pub(crate) const DRAIN: Duration = Duration::from_millis(100);
pub(crate) const DRAIN_QUIET: Duration = Duration::from_millis(50);
pub(crate) const DRAIN_LIMIT: Duration = Duration::from_secs(1);

/// Longest line kept, bytes. The longest of section 3 (the version text) has about 90.
pub(crate) const LINE_MAX: usize = 256;

/// Longest queue of waiting commands. Own choice: more waiting commands than that would be minutes old when sent.
pub(crate) const QUEUE_MAX: usize = 32;

/// No change of position for so long away from the target is a stall (section 11, step 6).
pub(crate) const STALL_AFTER: Duration = Duration::from_secs(1);

/// Margin over the closed-form travel time (section 11, step 6).
pub(crate) const OVERDUE_MARGIN: Duration = Duration::from_secs(1);

/// Equal polls at the target that confirm an arrival (section 11, step 6): a reversing axis passes its target once.
pub(crate) const ARRIVAL_POLLS: u32 = 3;

/// One half-step of the motor, degrees (section 5).
pub(crate) const HALF_STEP_DEG: f64 = 0.9;

/// Motor half-steps times gear for which the exact step is known: 17.5:1 and 70:1 in half, quarter and eighth steps (section 5).
pub(crate) const KNOWN_RATIOS: [f64; 5] = [17.5, 35.0, 70.0, 140.0, 280.0];

/// Resolution is printed with four decimals, cut or rounded (section 5): seconds of arc.
pub(crate) const RESOLUTION_PRINT_ERROR_ARCSEC: f64 = 1.0e-4;
