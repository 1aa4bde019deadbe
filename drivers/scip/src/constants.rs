//! The figures of the wire that decide something, in one table. What decides in the dialogue (time-outs, retries)
//! stands in [`SensorOptions`](crate::SensorOptions).

/// Line feed: ends every line; an empty line ends a reply (protocol section 3).
pub const LF: u8 = b'\n';

/// Lowest character of an encoded number or sum (protocol section 4).
pub const FIRST_CHARACTER: u8 = 0x30;

/// Highest character of an encoded number or sum: `FIRST_CHARACTER` + 63 (protocol section 4).
pub const LAST_CHARACTER: u8 = 0x6F;

/// Value characters in a full data line, its sum not counted (protocol section 6, data lines).
pub const DATA_LINE_CHARACTERS: usize = 64;

/// Longest line taken, bytes. Data lines have 65; the longest text line on record (`SCSP`) has 53; four times that.
pub const MAX_LINE_BYTES: usize = 256;

/// Longest message taken, bytes. The greatest the format can ask of any model (1081 steps, distance and intensity) has
/// some 6.7 kB; doubled.
pub const MAX_MESSAGE_BYTES: usize = 16 * 1024;

/// Highest step number that four digits can ask for (protocol section 6).
pub const MAX_STEP: u16 = 9999;

/// Highest cluster that two digits can ask for (protocol section 6).
pub const MAX_CLUSTER: u8 = 99;

/// Highest scan interval that one digit can ask for (protocol section 6).
pub const MAX_INTERVAL: u8 = 9;

/// What a two-character value says when the truth is that or more, mm (protocol section 7).
pub const TWO_CHARACTER_CEILING_MM: u32 = 4095;
