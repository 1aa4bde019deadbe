//! Limits of the wire format. Time-outs and retries are in [`ScipOptions`](crate::ScipOptions).

/// Ends every line; an empty line ends a reply (scip2 section 3).
pub(crate) const LF: u8 = b'\n';

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
