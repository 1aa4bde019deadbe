//! Every figure that decides something in this room, its unit and where it comes from.

use std::time::Duration;

/// Requests that may wait behind the one in hand: a robot asks for one at a time, so a longer queue is a client
/// gone wild.
pub const MOST_WAITING: usize = 4;

/// Pause before a device that is not there is looked for again: that moves nothing, and it is wanted within seconds of its
/// return.
pub const ABSENT_RETRY: Duration = Duration::from_secs(1);

/// First pause before lost devices are tried again: a replugged USB device needs about a second to get its name.
pub const FIRST_RETRY: Duration = Duration::from_secs(2);

/// Longest pause before lost devices are tried again.
pub const LONGEST_RETRY: Duration = Duration::from_secs(60);
