//! Constants of the patrol, each with its unit and source.

use std::time::Duration;

/// Longest queue behind the current request. A robot sends one request at a time; a longer queue is a faulty client.
pub(super) const MAX_QUEUED: usize = 4;

/// Pause before an absent device is tried again: a try moves nothing, and a replugged device is wanted within seconds.
pub(super) const ABSENT_RETRY_PAUSE: Duration = Duration::from_secs(1);

/// First pause before failed devices are tried again: udev needs about a second to name a replugged USB device.
pub(super) const INITIAL_RETRY_PAUSE: Duration = Duration::from_secs(2);

/// Standard deviations of a mean turn from which steps may be lost. Homing at an idle moment costs nobody anything, so few
/// losses are to be missed: see the figures of docs/novelty.md section 11.
pub(super) const LOST_STEPS_SIGMAS: f64 = 3.0;

/// The robot's last errors that its standard deviation is taken from: .05 of it, and years of slow change are followed.
pub(super) const MAX_ERRORS: usize = 200;

/// Views since the last homing that are held against it: a mean of so many is known to an eighth of the robot's error.
pub(super) const MAX_VIEWS_SINCE_HOMING: usize = 64;

/// Least standard deviation of a turn, radians: two counts of the head, which no robot betters.
pub(super) const MIN_TURN_SD_RAD: f64 = 0.0018;

/// Least time between two homings at the end of a round: a homing takes half a minute, so the head spends a twentieth of its
/// time at it at most, however short the round.
pub(super) const MIN_HOMING_INTERVAL: Duration = Duration::from_secs(600);

/// Longest pause before failed devices are tried again.
pub(super) const MAX_RETRY_PAUSE: Duration = Duration::from_secs(60);

/// Reason of a visit whose client ended it in the middle of its sweep.
pub(super) const CANCELLED_DURING_SWEEP: &str = "cancelled by its client during the sweep";
