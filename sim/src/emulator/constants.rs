//! Constants of the emulator.

use std::time::Duration;

/// Longest span of virtual time that the emulation advances in one step. The emulated head remembers two seconds of its
/// motion, and a scan looks one turn and a half back.
pub(crate) const MAX_TIME_STEP: Duration = Duration::from_millis(500);

/// Wall time after which an emulated port is served even if nothing is due.
pub(crate) const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Unplug faults that wait for their time; further ones are ignored.
pub(crate) const MAX_PENDING_UNPLUGS: usize = 64;

/// Time from one unplugging to the next, unless the fault has its own.
pub(super) const UNPLUG_PERIOD: Duration = Duration::from_secs(1);

/// Output held for a client that does not read, bytes: one large reply.
pub(super) const MAX_HELD_BYTES: usize = 8192;

/// Wall time between two attempts to write what is held.
pub(super) const HELD_RETRY: Duration = Duration::from_millis(2);

/// Shortest time-out that a socket accepts.
pub(crate) const MIN_SOCKET_TIMEOUT: Duration = Duration::from_micros(1);
