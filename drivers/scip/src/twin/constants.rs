//! Every number that decides how the twin behaves, with its unit and where it comes from ("section" is the protocol's).

use std::time::Duration;

/// Code of a step that cannot be measured (section 7).
pub(super) const CODE_NOT_MEASURABLE: u32 = 19;
/// Code every step reads while the window is covered: low intensity (section 7).
pub(super) const CODE_COVERED: u32 = 1;
/// Largest value two characters carry (section 4).
pub(super) const MAX_TWO_CHARACTERS: u32 = 4095;
/// Largest value three characters carry (section 4).
pub(super) const MAX_THREE_CHARACTERS: u32 = 262_143;

/// How far behind the nearest thing another must lie to be an echo of its own: an edge by section 11.
pub(super) const ECHO_JUMP_MM: u32 = 300;
/// Intensity told of a thing one metre away. Chosen: of the order of what UTM logs show; nothing depends on it.
pub(super) const INTENSITY_AT_1_M: u64 = 4_000;

/// The timer counts 24 bits of milliseconds (section 8).
pub(super) const TIMER_MASK: u32 = 0x00FF_FFFF;
/// How much faster than the host's clock the sensor's timer runs: 1000 sensor ms in 998.67 host ms (section 8, log L1).
pub(super) const CLOCK_RATE_ERROR: f64 = 0.0013;
/// How much faster than nominal the motor turns, by the sensor's own timer: mean stamp step 99.88 ms (section 8, log L1).
pub(super) const MOTOR_RATE_ERROR: f64 = 0.0012;
/// Change of speed per level of `CR`, in revolutions per minute (section 6).
pub(super) const RPM_PER_LEVEL: u32 = 6;
/// Highest level of `CR` (section 6).
pub(super) const MAX_SPEED_LEVEL: u8 = 10;

/// Where in a revolution (thousandths of it, from step 0) commands are taken. In log L2 the time told by `II` is 6 ms
/// before the stamp that `GD` got one tick later: the tick comes 6 ms before step 0 (sections 6 and 8).
pub(super) const TICK_PERMILLE: u64 = 940;
/// Commands of Ethernet models are taken on ticks of this length (section 10).
pub(super) const ETHERNET_TICK: Duration = Duration::from_millis(1);
/// From the last byte of a `TM` command to its being carried out; with `TM_REPLY` about 1 ms in all (sections 8, 15).
pub(super) const TM_LATENCY: Duration = Duration::from_micros(500);
/// From a `TM` command being carried out to its first byte.
pub(super) const TM_REPLY: Duration = Duration::from_micros(400);
/// Width of the even spread of that delay.
pub(super) const TM_SPREAD: Duration = Duration::from_micros(200);
/// Width of the even spread of every other first byte: a standard deviation of 0.44 ms (section 8, log L1).
pub(super) const REPLY_SPREAD: Duration = Duration::from_micros(1524);

/// Bytes handed over at once on USB. A full scan is nine such pieces.
pub(super) const USB_PIECE: usize = 256;
/// Nanoseconds per byte on USB: the last piece of a full scan (2048 bytes in) comes 5.5 to 8 ms after the first (section 2).
pub(super) const USB_NS_PER_BYTE: (u64, u64) = (2_690, 3_900);
/// The same of sensors that send 40 scans a second: USB full speed, so that even scans with intensity (6.7 kB) pass
/// within a turn. Chosen; no log has it.
pub(super) const FAST_USB_NS_PER_BYTE: (u64, u64) = (1_000, 1_300);
/// Bytes handed over at once on a network: a segment.
pub(super) const NETWORK_PIECE: usize = 1_460;
/// Nanoseconds per byte on a network of 100 Mbit/s (section 10, `SBPS`).
pub(super) const NETWORK_NS_PER_BYTE: (u64, u64) = (80, 80);
/// Bytes handed over at once on a serial line, about a receiver's queue.
pub(super) const SERIAL_PIECE: usize = 16;
/// Bits on the line per byte, 8N1 (section 2).
pub(super) const BITS_PER_BYTE: u64 = 10;
/// Factory bit rate (section 2).
pub(super) const DEFAULT_BAUD: u32 = 19_200;
/// Bit rates `SS` can set on the URG-04LX (section 2).
pub(super) const BAUDS: [u32; 6] = [19_200, 57_600, 115_200, 250_000, 500_000, 750_000];
/// A bit rate of the family that the URG-04LX lacks (section 2): status 04, not 02.
pub(super) const BAUD_OF_OTHER_MODELS: u32 = 38_400;

/// Longest request line kept, in bytes; the longest lawful one has 32 (15 of `MD`, `;`, 16 of string).
pub(super) const MAX_LINE: usize = 64;
/// Requests that wait at most; one more gets 0B.
pub(super) const MAX_PENDING: usize = 16;
/// Bytes that wait at most for a host that does not read; replies beyond are lost whole. About 50 s of scans.
pub(super) const MAX_WAITING_BYTES: usize = 1 << 20;
/// Faults kept at most.
pub(super) const MAX_FAULTS: usize = 256;
/// Longest string after `;` (section 3).
pub(super) const MAX_STRING: usize = 16;

/// Status told when streaming stops to verify an error, unless a fault names another in 21..=49 (section 6).
pub(super) const VERIFY_STATUS: u8 = 21;
/// How long that verification lasts, unless a fault says otherwise: five scans.
pub(super) const VERIFY_TIME: Duration = Duration::from_millis(500);
/// Status of hardware trouble, unless a fault names another in 50..=97 (section 6).
pub(super) const HARDWARE_STATUS: u8 = 50;
/// Scans that a `DB03`, `DB04` or `DB05` rehearsal lets pass before its error.
pub(super) const REHEARSAL_AFTER_SCANS: u64 = 5;
/// A rehearsal needs a count above this (section 6).
pub(super) const REHEARSAL_MIN_COUNT: u32 = 20;
/// `RB` within this time of the first one starts the sensor anew (section 10).
pub(super) const REBOOT_TWICE_WITHIN: Duration = Duration::from_secs(1);
/// From the second `RB` to the restart. Chosen: long enough for its reply.
pub(super) const REBOOT_AFTER: Duration = Duration::from_secs(1);

/// Bytes of one burst of garbage.
pub(super) const GARBAGE_BYTES: usize = 48;
/// Time between bursts when a fault asks for several.
pub(super) const GARBAGE_EVERY: Duration = Duration::from_millis(100);
/// Bytes of one burst of a flood of 0xFF, and of an endless line: 100 ms of the fastest serial rate (section 2).
pub(super) const FLOOD_BYTES: usize = 7_500;
/// Where a timer near its wrap is set, in milliseconds: 5 s before 2^24 (section 8).
pub(super) const TIMER_NEAR_WRAP_MS: u32 = (1 << 24) - 5_000;
/// How much older than the last one the stamp of a scan out of order is, in milliseconds: one turn.
pub(super) const OLDER_STAMP_MS: u32 = 100;
/// How far a timer jump goes unless the fault says otherwise, in milliseconds.
pub(super) const TIMER_JUMP_MS: i32 = 5_000;
