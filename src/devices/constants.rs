//! Constants for running the devices, each with its unit and source.

use std::time::Duration;

/// USB vendor id of Hokuyo (scip2 section 2).
pub(super) const HOKUYO_VENDOR: u16 = 0x15d1;

/// Speed of moves between sweeps, radians per second: the power-up speed of a D46-17, 1000 positions/s (ptu-d46 section 5).
pub(super) const APPROACH_RAD_S: f64 = 0.8976;

/// Margin between a sweep and the head's limits, counts: the limits move by a few counts with every calibration
/// (ptu-d46 section 5).
pub(super) const LIMIT_MARGIN_STEPS: i32 = 8;

/// Largest change of a limit from one calibration to the next, counts. It is "a few" (ptu-d46 section 5); at more than
/// twenty, one degree, the head hit an obstacle.
pub(super) const MAX_LIMIT_CHANGE_STEPS: u32 = 20;

/// Lines by which the motion starts before the first wanted line and ends after the last: half a line for the middle of a
/// line against its ends, one for the line under way at the start (sweep-geometry section 3.4).
pub(super) const MARGIN_LINES: f64 = 1.5;

/// Smallest tilt range of a sweep, radians: one degree, as in the check of the configuration.
pub(super) const MIN_RANGE_RAD: f64 = 0.017;

/// Time exchanges before and after a pan segment (sweep-geometry section 3).
pub(super) const TIME_SAMPLES: u32 = 20;

/// Valid scans before the head starts to move (sweep-geometry section 7).
pub(super) const WARM_UP_SCANS: u32 = 3;

/// Step of the laser's timer against the host clock that voids a sweep, in scan periods: half of the smallest step that the
/// driver takes for a lost scan (it tolerates a tenth of a period).
pub(super) const TIMER_STEP_PERIODS: f64 = 0.5;

/// Scans whose smallest lag is taken as the lag: a host late for all of ten scans is late for a second.
pub(super) const TIMER_SCANS: usize = 10;

/// Fewest scans of a segment for estimating the rate of the laser's timer: a shorter one ends before a timer wrong by 0.2 %
/// is a quarter of a scan off.
pub(super) const RATE_MIN_SCANS: usize = 100;

/// The two scans of a pair that estimates the timer's rate are a fifth of the segment apart: a step of the
/// timer spoils that fraction of the pairs, and stamps in whole milliseconds are precise enough over it.
pub(super) const RATE_PAIR_DIVISOR: usize = 5;

/// Scans whose smallest lag gives the start time of a scan of step-and-stare: ten seconds, in which a timer wrong by 0.2 %
/// drifts by 20 ms.
pub(super) const START_TIME_SCANS: usize = 100;

/// Pause between the confirmed arrival and a scan of step-and-stare: the upper end of "settling (50-100 ms, measure)"
/// (sweep-geometry section 4).
pub(super) const SETTLE: Duration = Duration::from_millis(100);

/// Fraction of a mirror turn between the stamp (step 0) and the first byte of its scan: data follow step 768 of 1024
/// (scip2 section 8).
pub(super) const FIRST_BYTE_TURNS: f64 = 0.75;

/// Shortest time between two polls of the head's position: what a query takes at 9600 baud (ptu-d46 section 1). With that
/// many polls the fit of the tilt is good to 0.01 counts (sweep-geometry section 3.3); on a fast link more of them would
/// only load unit and host.
pub(super) const POLL_INTERVAL: Duration = Duration::from_micros(12_500);

/// Time limit for one step of a sweep. Recovering a laser by `QT` and `RS` takes some 10 s (three requests of three attempts
/// each); this is twice that.
pub(super) const STEP_LIMIT: Duration = Duration::from_secs(20);

/// Time limit for laser off and head stopped when a sweep ends early. The slowest reply is the laser's, up to 111 ms because
/// of its 100 ms tick (scip2 section 8); this is eight of them.
pub(super) const END_LIMIT: Duration = Duration::from_millis(900);

/// Longest wait for a device that is reconnecting when a request arrives: a laser connects in 0.8 s, a head in 1.5 s, their
/// retries in 15 s (scip2 section 8, ptu-d46 section 11).
pub(super) const CONNECT_LIMIT: Duration = Duration::from_secs(20);

/// Longest wait for both devices at opening. The head may be calibrating, 60 s (ptu-d46 section 7).
pub(super) const DEVICES_READY_LIMIT: Duration = Duration::from_secs(90);

/// Longest wait for homing: the driver's own 60 s and the reading of the limits.
pub(super) const HOME_LIMIT: Duration = Duration::from_secs(70);

/// Longest wait for the head's supply voltage and temperatures.
pub(super) const HEALTH_LIMIT: Duration = Duration::from_secs(4);

/// First pause before a port is opened again; doubled at every consecutive failure.
pub(super) const INITIAL_REOPEN_PAUSE: Duration = Duration::from_millis(500);

/// Longest pause before a port is opened again.
pub(super) const MAX_REOPEN_PAUSE: Duration = Duration::from_secs(30);

/// Longest pause before an absent port is tried again: a try is cheap, and a replugged device is wanted within seconds.
pub(super) const ABSENT_REOPEN_PAUSE: Duration = Duration::from_secs(1);

/// Wait for an absent device when it is needed: one try of its port, and connecting.
pub(super) const RECONNECT_WAIT: Duration = Duration::from_millis(1500);

/// Longest blocking read of a port thread while the driver has a deadline, wall time. Commands wait at most that long.
pub(super) const READ_BUSY: Duration = Duration::from_millis(4);
/// The same while it has none.
pub(super) const READ_IDLE: Duration = Duration::from_millis(20);

/// Time limit for writing a command of some 20 bytes, wall time.
pub(super) const COMMAND_WRITE_LIMIT: Duration = Duration::from_millis(500);

/// Time limit for stopping a device whose port is being closed, wall time. With [`COMMAND_WRITE_LIMIT`] below the second in
/// which laser and head must be stopped.
pub(super) const CLOSE_LIMIT: Duration = Duration::from_millis(450);

/// Interval of checking for cancellation, wall time.
pub(super) const CANCEL_CHECK: Duration = Duration::from_millis(20);

/// Time limit for a TCP connection, wall time.
pub(super) const TCP_LIMIT: Duration = Duration::from_secs(2);

/// Line rates of a laser on RS-232, bit/s, in the order tried after the configured one (scip2 section 13).
pub(super) const LASER_BAUDS: [u32; 6] = [19_200, 57_600, 115_200, 250_000, 500_000, 750_000];

/// Line rate of a pan-tilt after power-up, bit/s (ptu-d46 section 1).
pub(super) const HEAD_POWER_UP_BAUD: u32 = 9600;

/// Wait for a reply while a laser's line rate is searched: more than 250 ms, below which a URG misses its tick
/// (scip2 section 13).
pub(super) const PROBE_REPLY_LIMIT: Duration = Duration::from_millis(400);

/// Attempts per request while a laser's line rate is searched.
pub(super) const PROBE_ATTEMPTS: u8 = 2;

/// Attempts to connect a head while its line rate is searched. The second one is answered by a laser too.
pub(super) const HEAD_PROBE_ATTEMPTS: u32 = 2;

/// Bits on the line per byte, 8N1.
pub(super) const BITS_PER_BYTE: u32 = 10;

/// Most steps that share a value on a slow line: 1.4 deg, three lines of a usual sweep.
pub(super) const MAX_CLUSTER: u8 = 4;

/// Most scan periods per transmitted scan: the interval has one digit (scip2 section 6).
pub(super) const MAX_STREAM_PERIODS: u32 = 10;

/// Largest fraction of the scan period that the bytes of a scan may take on a slow line.
pub(super) const MAX_LINE_LOAD: f64 = 0.95;

/// Slow speed of a calibration, radians per second: 5 deg/s, as in a usual sweep; here backlash outweighs the time offset.
pub(super) const CALIBRATION_SLOW_RAD_S: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Fast speed of a calibration, radians per second: at 25 deg/s a millisecond is 0.025 deg.
pub(super) const CALIBRATION_FAST_RAD_S: f64 = 25.0 * std::f64::consts::PI / 180.0;

/// Pairs of fast sweeps, up and down. The clock offset of each segment is wrong by 0.3 ms; the mean over twelve segments
/// (three pans) reduces that.
pub(super) const CALIBRATION_FAST_PAIRS: usize = 2;

/// Pan to either side of the middle in a calibration, radians: 50 deg is within every head's range and turns the tilt axis
/// by 100 deg between the two.
pub(super) const CALIBRATION_PAN_RAD: f64 = 50.0 * std::f64::consts::PI / 180.0;

/// Speed setting of both axes after power-up, counts per second (ptu-d46 section 5).
pub(super) const POWER_UP_STEPS_S: i32 = 1000;
