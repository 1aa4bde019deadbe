//! Limits of the wire format. Time-outs and retries are in [`ScipOptions`](crate::ScipOptions).

/// Ends every line; an empty line ends a reply (scip2 section 3).
pub(crate) const LF: u8 = b'\n';

/// Taken before an LF, never sent (scip2 section 2: a terminator of commands is LF or CR or both; replies have LF).
pub(crate) const CR: u8 = b'\r';

/// Lowest character of an encoded number or sum (scip2 section 4).
pub(crate) const FIRST_CHARACTER: u8 = 0x30;

/// Highest character of an encoded number or sum: `FIRST_CHARACTER` + 63 (scip2 section 4).
pub(crate) const LAST_CHARACTER: u8 = 0x6F;

/// Characters of values in a full data line, without its sum (scip2 section 6, data lines).
pub(crate) const DATA_LINE_CHARACTERS: usize = 64;

/// Longest line accepted, bytes: four times the longest text line on record (`SCSP`, 53). Data lines have 65.
pub(crate) const MAX_LINE_BYTES: usize = 256;

/// Longest message accepted, bytes: twice the largest reply of any model (1081 steps, distance and intensity: 6.7 kB).
pub const MAX_MESSAGE_BYTES: usize = 16 * 1024;

/// Highest step number that four digits can ask for (scip2 section 6).
pub(crate) const MAX_STEP: u16 = 9999;

/// Highest cluster that two digits can ask for (scip2 section 6).
pub(crate) const MAX_CLUSTER: u8 = 99;

/// Highest scan interval that one digit can ask for (scip2 section 6).
pub(crate) const MAX_INTERVAL: u8 = 9;

/// Highest count of scans that two digits can ask for (scip2 section 6).
pub(crate) const MAX_COUNT: u8 = 99;

/// Most steps of a turn: each has a number of four digits (scip2 section 6).
pub(crate) const MAX_STEPS_PER_TURN: u32 = MAX_STEP as u32 + 1;

/// Motor speeds that can be, revolutions per minute: known models turn at 600 to 2400 (scip2 section 1); own choice, ten
/// times either way.
pub(crate) const SCAN_RPM: std::ops::RangeInclusive<u32> = 60..=24_000;

/// Largest range of three characters, mm: 18 bits (scip2 section 4).
pub(crate) const MAX_RANGE_MM: u32 = (1 << 18) - 1;

/// Bits on a serial line per byte, 8N1 (scip2 section 2).
pub(crate) const BITS_PER_BYTE: u32 = 10;

/// Wait between the reply to `SS` and the first request at the new rate (scip2 section 6).
pub(crate) const BIT_RATE_PAUSE: std::time::Duration = std::time::Duration::from_millis(150);
