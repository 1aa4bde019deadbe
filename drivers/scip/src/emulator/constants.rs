//! Constants of the emulated laser, with units and sources. Logs are those of scip2 section 0.

use std::time::Duration;

/// Code of a step outside the measuring window (scip2 section 7).
pub(super) const CODE_NOT_MEASURABLE: u32 = 19;
/// Code of every step while the window is covered: low intensity (scip2 section 7).
pub(super) const CODE_COVERED: u32 = 1;
/// Largest value of two characters (scip2 section 4).
pub(super) const MAX_TWO_CHARACTERS: u32 = 4095;
/// Largest value of three characters (scip2 section 4).
pub(super) const MAX_THREE_CHARACTERS: u32 = 262_143;

/// Minimum distance between two echoes, mm: an edge by scip2 section 11.
pub(super) const ECHO_JUMP_MM: u32 = 300;
/// Intensity at a range of one metre. Chosen, of the order of UTM logs; nothing depends on it.
pub(super) const INTENSITY_AT_1_M: u64 = 4_000;

/// The timer counts 24 bits of milliseconds (scip2 section 8).
pub(super) const TIMER_MASK: u32 = 0x00FF_FFFF;
/// Rate of the sensor's timer against the host's clock, minus one: 1000 sensor ms in 998.67 host ms (scip2 section 8, log
/// L1).
pub(super) const CLOCK_RATE_ERROR: f64 = 0.0013;
/// Speed of the motor against nominal, by the sensor's timer, minus one: mean stamp step 99.88 ms (scip2 section 8, log
/// L1).
pub(super) const MOTOR_RATE_ERROR: f64 = 0.0012;
/// Change of speed per level of `CR`, revolutions per minute (scip2 section 6).
pub(super) const RPM_PER_LEVEL: u32 = 6;
/// Highest level of `CR` (scip2 section 6).
pub(super) const MAX_SPEED_LEVEL: u8 = 10;

/// Where in a revolution commands are taken, thousandths of it from step 0. In log L2 the time of `II` is 6 ms before the
/// stamp of the `GD` one tick later: the tick is 6 ms before step 0 (scip2 sections 6 and 8).
pub(super) const TICK_PERMILLE: u64 = 940;
/// Commands of Ethernet models are taken on ticks of this length (scip2 section 10).
pub(super) const ETHERNET_TICK: Duration = Duration::from_millis(1);
/// From the last byte of a `TM` command to its execution; with `TM_REPLY` about 1 ms in all (scip2 sections 8 and 15).
pub(super) const TM_LATENCY: Duration = Duration::from_micros(500);
/// From the execution of a `TM` command to the first byte of its reply.
pub(super) const TM_REPLY: Duration = Duration::from_micros(400);
/// Width of the uniform jitter of that delay.
pub(super) const TM_SPREAD: Duration = Duration::from_micros(200);
/// Width of the uniform jitter of every other first byte: standard deviation 0.44 ms (scip2 section 8, log L1).
pub(super) const REPLY_SPREAD: Duration = Duration::from_micros(1524);

/// Bytes per USB packet; a full scan is nine.
pub(super) const USB_PIECE: usize = 256;
/// Nanoseconds per byte on USB, lowest and highest: the last packet of a full scan (2048 bytes in) comes 5.5 to 8 ms
/// after the first (scip2 section 2).
pub(super) const USB_NS_PER_BYTE: (u64, u64) = (2_690, 3_900);
/// The same for sensors with 40 scans per second: USB full speed, so that even scans with intensity (6.7 kB) pass within
/// a revolution. Chosen; no log has it.
pub(super) const FAST_USB_NS_PER_BYTE: (u64, u64) = (1_000, 1_300);
/// Bytes per TCP segment.
pub(super) const NETWORK_PIECE: usize = 1_460;
/// Nanoseconds per byte on a network of 100 Mbit/s (scip2 section 10, `SBPS`).
pub(super) const NETWORK_NS_PER_BYTE: (u64, u64) = (80, 80);
/// Bytes per piece on a serial line, about a receiver's queue.
pub(super) const SERIAL_PIECE: usize = 16;
/// Bits on the line per byte, 8N1 (scip2 section 2).
pub(super) const BITS_PER_BYTE: u64 = 10;
/// Factory bit rate (scip2 section 2).
pub(super) const DEFAULT_BAUD: u32 = 19_200;
/// Bit rates of the URG-04LX (scip2 section 2).
pub(super) const BAUDS: [u32; 6] = [19_200, 57_600, 115_200, 250_000, 500_000, 750_000];
/// A bit rate that other models of the family have (scip2 section 2): gets status 04, not 02.
pub(super) const BAUD_OF_OTHER_MODELS: u32 = 38_400;

/// Bytes kept of a request line; the longest valid one has 32 (15 of `MD`, `;`, 16 of string).
pub(super) const MAX_LINE: usize = 64;
/// Requests in the queue; one more gets 0B.
pub(super) const MAX_PENDING: usize = 16;
/// Bytes queued for a host that does not read, about 50 s of scans; further replies are lost whole.
pub(super) const MAX_QUEUED_BYTES: usize = 1 << 20;
pub(super) const MAX_FAULTS: usize = 256;
/// Longest string after `;` (scip2 section 3).
pub(super) const MAX_STRING: usize = 16;

/// Status of a stream that stops to verify an error, unless a fault names another in 21..=49 (scip2 section 6).
pub(super) const VERIFY_STATUS: u8 = 21;
/// Duration of that verification, unless a fault names another: five scans.
pub(super) const VERIFY_TIME: Duration = Duration::from_millis(500);
/// Status of hardware trouble, unless a fault names another in 50..=97 (scip2 section 6).
pub(super) const HARDWARE_STATUS: u8 = 50;
/// Scans before the error that `DB03`, `DB04` or `DB05` simulates.
pub(super) const SIMULATION_AFTER_SCANS: u64 = 5;
/// These need a stream with a higher count than this (scip2 section 6).
pub(super) const SIMULATION_MIN_COUNT: u32 = 20;
/// A second `RB` within this time restarts the sensor (scip2 section 10).
pub(super) const REBOOT_TWICE_WITHIN: Duration = Duration::from_secs(1);
/// From the second `RB` to the restart. Chosen, long enough for its reply.
pub(super) const REBOOT_AFTER: Duration = Duration::from_secs(1);

pub(super) const GARBAGE_BYTES: usize = 48;
/// Period of a repeated fault without one of its own.
pub(super) const FAULT_PERIOD: Duration = Duration::from_secs(1);
/// Shortest period of a repeated fault.
pub(super) const MIN_FAULT_PERIOD: Duration = Duration::from_millis(1);
/// Time between bursts.
pub(super) const GARBAGE_EVERY: Duration = Duration::from_millis(100);
/// Bytes per burst of a flood or an endless line: 100 ms of the fastest serial rate (scip2 section 2).
pub(super) const FLOOD_BYTES: usize = 7_500;
/// Default of `timer-set`, ms: 5 s before the wrap at 2^24 (scip2 section 8).
pub(super) const TIMER_NEAR_WRAP_MS: u32 = (1 << 24) - 5_000;
/// Age of the stamp of `older-stamp`, ms: one revolution.
pub(super) const OLDER_STAMP_MS: u32 = 100;
/// Default of `timer-jump`, ms.
pub(super) const TIMER_JUMP_MS: i32 = 5_000;
