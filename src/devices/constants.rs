//! Every figure that decides something about running the devices, its unit and where it comes from.

use std::time::Duration;

/// USB vendor of the laser's maker (scip2 section 3).
pub const HOKUYO: u16 = 0x15d1;

/// Speed of approaching moves, radians per second: the head's own after power-up, 1000 positions/s of a D46-17
/// (ptu-d46 section 5).
pub const APPROACH_RAD_S: f64 = 0.8976;

/// Positions kept free between a sweep and the head's limits: they move by a few counts with every calibration
/// (ptu-d46 section 5).
pub const LIMIT_MARGIN_STEPS: i32 = 8;

/// Counts by which a limit may move from one calibration to the next: "a few" (ptu-d46 section 5), and beyond twenty, one
/// degree, something stands in the way.
pub const LIMITS_MOVE_STEPS: u32 = 20;

/// Lines by which the head starts before the first wanted line and goes on after the last: half a line for the
/// middle of a line against its ends, one for the line under way when it begins (sweep-geometry section 3.4).
pub const MARGIN_LINES: f64 = 1.5;

/// Smallest tilt range worth a sweep, radians: one degree, as the configuration demands between its two ends.
pub const LEAST_RANGE_RAD: f64 = 0.017;

/// Exchanges of time before and after a leg (sweep-geometry section 3).
pub const TIME_SAMPLES: u32 = 20;

/// Good scans before the head begins to move (sweep-geometry section 7).
pub const WARM_SCANS: u32 = 3;

/// Step of the laser's timer against the host's clock, in scan periods, that voids a sweep: half of the smallest that
/// the driver takes for a lost scan (it allows a tenth of a period).
pub const TIMER_STEP_PERIODS: f64 = 0.5;

/// Scans whose least lag stands for the lag: a host that is late for all of ten scans is late for a second.
pub const TIMER_SCANS: usize = 10;

/// Scans that a leg needs for a rate of its laser's timer to be told (with fewer it is over before a timer wrong by 0.2 % is
/// a quarter of a scan off), and the part of the leg that lies between two that are compared: a step spoils that part of
/// the pairs, and stamps of whole milliseconds are as fine as the leg needs them.
pub const RATE_SCANS: (usize, usize) = (100, 5);

/// Scans whose least lag dates a scan of step-and-stare: ten seconds, in which a timer wrong by 0.2 % goes 20 ms wrong.
pub const DATING_SCANS: usize = 100;

/// Standing time before a scan of step-and-stare, over and above the confirmed arrival: the upper end of
/// "settling 50-100 ms, measure" (sweep-geometry section 4).
pub const SETTLE: Duration = Duration::from_millis(100);

/// Share of a turn between the stamp (step 0) and the first byte of its scan: data follow step 768 of 1024
/// (scip2 section 8).
pub const FIRST_BYTE_TURN: f64 = 0.75;

/// Longest wait for one step of a sweep that the drivers bound themselves; over it the sweep fails. A laser brought
/// back by `QT` and `RS` takes some 10 s (three requests of three attempts each), twice that is beyond doubt.
pub const STEP_LIMIT: Duration = Duration::from_secs(20);

/// Longest wait for laser off and head stopped when a sweep ends early. The slowest reply is the laser's, on its
/// 100 ms tick up to 111 ms (scip2 section 8); a device that says nothing in eight of them says nothing.
pub const END_LIMIT: Duration = Duration::from_millis(900);

/// Longest wait for a device that is being connected anew when a request comes: a laser connects in 0.8 s, a head in
/// 1.5 s, their retries in 15 s (scip2 section 8, ptu-d46 section 11).
pub const CONNECT_LIMIT: Duration = Duration::from_secs(20);

/// Longest wait for a head found calibrating at opening (ptu-d46 section 7: 60 s) with its connecting.
pub const OPEN_LIMIT: Duration = Duration::from_secs(90);

/// Longest wait for a calibration: the driver's own 60 s and the reading of the limits.
pub const HOME_LIMIT: Duration = Duration::from_secs(70);

/// Longest wait for an answer about health.
pub const HEALTH_LIMIT: Duration = Duration::from_secs(4);

/// First and longest pause before a port is opened again; doubled at every failure in a row.
pub const BACKOFF: (Duration, Duration) = (Duration::from_millis(500), Duration::from_secs(30));

/// Longest pause before a port that is not there is looked for again: that costs nothing, and a device plugged in again is
/// wanted within seconds.
pub const ABSENT_RETRY: Duration = Duration::from_secs(1);

/// Wait for a device that is away, when it is asked for: one look at its port, and its connecting.
pub const RETURN_LIMIT: Duration = Duration::from_millis(1500);

/// Wall time that a port thread blocks in one read while something is under way, and while nothing is. Commands wait
/// at most that long.
pub const READ_BUSY: Duration = Duration::from_millis(4);
/// See [`READ_BUSY`].
pub const READ_IDLE: Duration = Duration::from_millis(20);

/// Wall time within which a port must take a command; one of them is at most some 20 bytes.
pub const WRITE_LIMIT: Duration = Duration::from_millis(500);

/// Wall time for the last words to a device whose port is being closed. With [`WRITE_LIMIT`] below the second in which
/// everything must stand still.
pub const CLOSE_LIMIT: Duration = Duration::from_millis(450);

/// Wall time between two looks at a cancelled flag.
pub const CANCEL_CHECK: Duration = Duration::from_millis(20);

/// Wall time to connect to a sensor by TCP.
pub const TCP_LIMIT: Duration = Duration::from_secs(2);

/// Rates of a laser on RS-232, in the order of a search after the configured one (scip2 section 13).
pub const LASER_BAUDS: [u32; 6] = [19_200, 57_600, 115_200, 250_000, 500_000, 750_000];

/// Wait for a reply and attempts while a laser's rate is searched for: more than the 250 ms below which a URG's tick is
/// missed (scip2 section 13).
pub const PROBE: (Duration, u8) = (Duration::from_millis(400), 2);

/// Bits on the wire per byte, 8N1.
pub const BITS_PER_BYTE: u32 = 10;

/// Largest share of a scan's period that its bytes may take on a slow line.
pub const LINE_SHARE: f64 = 0.95;

/// Slow speed of a calibration, radians per second: 5 deg/s, the usual sweep; there the backlash outweighs the time offset.
pub const CALIBRATION_SLOW_RAD_S: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Fast speed of a calibration, radians per second, and how many sweeps up and down have it: at 25 deg/s a millisecond is
/// 0.025 deg, and each leg's clock is off by 0.3 ms of its own, which the mean of twelve legs is not.
pub const CALIBRATION_FAST: (f64, usize) = (25.0 * std::f64::consts::PI / 180.0, 2);

/// Pan to either side of the middle in a calibration, radians: 50 deg, within every head's range, and the tilt axis is
/// turned by 100 deg between the two.
pub const CALIBRATION_PAN_RAD: f64 = 50.0 * std::f64::consts::PI / 180.0;

/// Set speed of both axes after a power-up, counts per second (ptu-d46 section 5): a unit found at it tells nothing.
pub const POWER_UP_SPEED: i32 = 1000;
