//! Every constant that decides how the service runs, its unit and where it comes from. Wall time, unless it says
//! otherwise.

use std::time::Duration;

/// Pace of the loop: retries, deadlines and the watchdog are looked at so often.
pub const TICK: Duration = Duration::from_millis(100);

/// Idle devices are looked at so often: a client that asks for the status after a cable came off learns it within
/// a second or two.
pub const WATCH_PACE: Duration = Duration::from_secs(1);

/// From the wish to stop to the end, whatever hangs; the promise is 3 s.
pub const STOP_LIMIT: Duration = Duration::from_millis(2500);

/// For what the writer still has in hand at the end, where [`STOP_LIMIT`] leaves no more.
pub const LAST_WRITES_LIMIT: Duration = Duration::from_millis(200);

/// For answers on their way out at the end; with [`STOP_LIMIT`] and [`LAST_WRITES_LIMIT`] below the promised 3 s.
pub const LAST_WORDS_LIMIT: Duration = Duration::from_millis(250);

/// The watchdog is fed at this share of its period, as sd_watchdog_enabled(3) advises.
pub const WATCHDOG_SHARE: f64 = 0.5;

/// Longest time for connecting and homing, of the devices' clock: 90 s for a head found calibrating and 70 s for a
/// calibration of its own (ptu-d46 section 7), with the laser's 10 s between.
pub const OPEN_LIMIT: Duration = Duration::from_secs(180);

/// Longest time before a sweep begins, of the devices' clock: 20 s for a device plugged in again and 70 s for the
/// calibration that follows.
pub const RECOVERY_LIMIT: Duration = Duration::from_secs(90);

/// Longest time of one leg of a sweep beyond its tilting, of the devices' clock: approach at the head's slowest
/// usable speed, two exchanges of time, a laser brought back once (scip2 section 13).
pub const LEG_LIMIT: Duration = Duration::from_secs(60);

/// Longest time of one line of step-and-stare, of the devices' clock: a move, its settling and a few scans.
pub const LINE_LIMIT: Duration = Duration::from_secs(3);

/// Longest way back after a sweep, of the devices' clock: the whole range of pan and then of tilt, 318 and 78 deg, at a tenth of
/// the power-up speed (ptu-d46 section 5), and as much again.
pub const BACK_LIMIT: Duration = Duration::from_secs(160);

/// Tilting may take so many times as long as planned before it counts as stuck.
pub const TILT_SLACK: f64 = 2.0;

/// Longest judgement: a hundred times the usual second.
pub const JUDGE_LIMIT: Duration = Duration::from_secs(120);

/// Longest write: the database's own patience with other writers is 5 s, and disks in trouble retry for tens.
pub const WRITE_LIMIT: Duration = Duration::from_secs(60);

/// Pause between two looks at what retention lets go.
pub const RETENTION_PAUSE: Duration = Duration::from_secs(3600);

/// Sweeps go by age only after the wall clock has kept pace for so long: a machine that boots with a wrong time has
/// it set from the network within minutes.
pub const STEADY_FOR: Duration = Duration::from_secs(3600);

/// A wall clock that strays so far from the monotone one has been set: slewing gains 2 s an hour (adjtime, 500 ppm).
pub const WALL_STEP: Duration = Duration::from_secs(60);

/// Longest name of a waypoint, bytes.
pub const LONGEST_NAME: usize = 64;
