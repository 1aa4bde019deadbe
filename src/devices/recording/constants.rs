//! Bounds and version of a recording.

use std::time::Duration;

/// The newest version of the container, and the only one so far.
pub(super) const VERSION: u8 = 1;

/// Bytes of entries that are recorded at most. The URG-04LX sends 21 kB/s, an UST-20LX at 40 scans/s 140 kB/s: a sweep of a
/// minute at four pans takes 5 MB and 34 MB. What comes later is not recorded, and the end says so.
pub(super) const MAX_DIALOGUE_BYTES: usize = 40 << 20;

/// Wait for both drivers to be idle before a sweep, on the devices' clock: a reply takes 0.1 s (scip2 section 8). After it the
/// sweep goes on without a recording.
pub(in crate::devices) const IDLE_LIMIT: Duration = Duration::from_millis(500);

/// Attempts to begin where neither device says anything unasked.
pub(in crate::devices) const BEGIN_ATTEMPTS: u32 = 3;

/// Bytes of a text in a container at most: a reason is one line.
pub(super) const MAX_TEXT_BYTES: usize = 4096;
