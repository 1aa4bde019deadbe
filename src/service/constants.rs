//! Time limits and other constants of the service. Wall time, unless the comment says otherwise.

use std::time::Duration;

/// Period of the loop: retries, deadlines and the watchdog are checked once per tick.
pub(super) const TICK: Duration = Duration::from_millis(100);

/// Idle devices are checked so often: the status shows a pulled cable within two seconds.
pub(super) const IDLE_CHECK_INTERVAL: Duration = Duration::from_secs(1);

/// From the stop command to released devices. With [`FLUSH_LIMIT`] and [`REPLY_LIMIT`] the service ends within 3 s,
/// whatever hangs.
pub(super) const STOP_LIMIT: Duration = Duration::from_millis(2500);

/// Least time for the last writes to the store, where [`STOP_LIMIT`] leaves no more.
pub(super) const FLUSH_LIMIT: Duration = Duration::from_millis(200);

/// For the last replies to clients.
pub(super) const REPLY_LIMIT: Duration = Duration::from_millis(250);

/// Share of the watchdog's period between two notifications, as sd_watchdog_enabled(3) advises.
pub(super) const WATCHDOG_INTERVAL_SHARE: f64 = 0.5;

/// Longest time for connecting and homing, on the devices' clock: 90 s for a head found calibrating and 70 s for a
/// calibration of its own (ptu-d46 section 7), with the laser's 10 s between.
pub(super) const CONNECT_AND_HOME_LIMIT: Duration = Duration::from_secs(180);

/// Longest time before a sweep begins, on the devices' clock: 20 s for a device plugged in again and 70 s for the
/// calibration that follows.
pub(super) const RECOVERY_LIMIT: Duration = Duration::from_secs(90);

/// Longest time of one pan segment of a sweep besides its tilting, on the devices' clock: approach at the head's slowest
/// usable speed, two time synchronisations, one recovery of the laser (scip2 section 13).
pub(super) const SEGMENT_LIMIT: Duration = Duration::from_secs(60);

/// Longest time of one line of step-and-stare, on the devices' clock: a move, its settling and a few scans.
pub(super) const STEP_LINE_LIMIT: Duration = Duration::from_secs(3);

/// Longest return to the start after a sweep, on the devices' clock: the whole range of pan and then of tilt, 318 and
/// 78 deg, at a tenth of the power-up speed (ptu-d46 section 5), and as much again.
pub(super) const RETURN_TO_START_LIMIT: Duration = Duration::from_secs(160);

/// Tilting that takes longer than so many times its planned duration counts as stuck.
pub(super) const MAX_TILT_TIME_RATIO: f64 = 2.0;

/// Longest judging of a sweep: a hundred times the usual second.
pub(super) const JUDGE_LIMIT: Duration = Duration::from_secs(120);

/// Longest write: the database waits 5 s for other writers, and a failing disk retries for tens of seconds.
pub(super) const STORE_WRITE_LIMIT: Duration = Duration::from_secs(60);

/// Period of the upkeep of the store: held visits are written, lost space is noticed.
pub(super) const STORAGE_INTERVAL: Duration = Duration::from_secs(10);

pub(super) const RETENTION_INTERVAL: Duration = Duration::from_secs(3600);

/// Sweeps are deleted by age only after the wall clock has been stable for so long: a machine that boots with a wrong
/// time has it set from the network within minutes.
pub(super) const WALL_CLOCK_STABLE_FOR: Duration = Duration::from_secs(3600);

/// A wall clock that deviates so far from the monotonic one has been set: slewing gains 2 s an hour (adjtime, 500 ppm).
pub(super) const WALL_CLOCK_STEP: Duration = Duration::from_secs(60);

/// Waypoints that nobody visits are looked for this often; `alarms.unseen_after` is in hours.
pub(super) const UNSEEN_CHECK_INTERVAL: Duration = Duration::from_secs(60);

/// Most connections of the control socket. A robot has one; its people and their programs a few more. Each costs a
/// descriptor of the 1024 that a process has by default.
pub(super) const MAX_CONNECTIONS: usize = 64;

/// For the head of a request, from the connection or the answer before: also how long a connection may idle.
pub(super) const REQUEST_HEAD_LIMIT: Duration = Duration::from_secs(10);

/// For the body of a request, after its head.
pub(super) const REQUEST_BODY_LIMIT: Duration = Duration::from_secs(5);

/// From a write that the client does not take to the end of its connection.
pub(super) const REPLY_STALL_LIMIT: Duration = Duration::from_secs(10);

/// Longest body of a request: a thousand times the usual one.
pub(super) const MAX_REQUEST_BYTES: usize = 64 * 1024;

/// Pause after a connection that the system could not accept, as where no descriptor is left.
pub(super) const ACCEPT_RETRY_PAUSE: Duration = Duration::from_millis(100);

/// How many finished requests of clients that do not wait stay readable.
pub(super) const MAX_FINISHED_REQUESTS: usize = 100;

/// How long they do.
pub(super) const FINISHED_REQUEST_KEPT_FOR: Duration = Duration::from_secs(3600);

/// What is nearer than this stands before the sensor, metres: a hand, a cover, a pillar that the robot touches.
pub(super) const BLOCKED_WITHIN_M: f64 = 0.35;
/// From this share of the returns on, a reference is blocked.
pub(super) const BLOCKED_SHARE: f64 = 0.5;
/// A new reference shows at least this share of the surface of the one before.
pub(super) const MIN_SHOWN_SHARE: f64 = 0.5;
