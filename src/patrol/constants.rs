//! Constants of the patrol, each with its unit and source.

use std::time::Duration;

/// Longest queue behind the current request. A robot sends one request at a time; a longer queue is a faulty client.
pub(super) const MAX_QUEUED: usize = 4;

/// Pause before an absent device is tried again: a try moves nothing, and a replugged device is wanted within seconds.
pub(super) const ABSENT_RETRY_PAUSE: Duration = Duration::from_secs(1);

/// First pause before failed devices are tried again: udev needs about a second to name a replugged USB device.
pub(super) const INITIAL_RETRY_PAUSE: Duration = Duration::from_secs(2);

/// Longest pause before failed devices are tried again.
pub(super) const MAX_RETRY_PAUSE: Duration = Duration::from_secs(60);
