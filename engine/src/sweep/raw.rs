//! The raw data of a sweep, from which the points can be assembled again.

use crate::geometry::Mount;
use crate::scan::ScanGeometry;

/// One exchange of time with the sensor: its clock was `stamp_ms` some time between request and reply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSample {
    /// Request sent, host seconds.
    pub sent_s: f64,
    /// First byte of the reply, host seconds.
    pub received_s: f64,
    /// Sensor clock, milliseconds, unwrapped.
    pub stamp_ms: u64,
}

/// One position query to the head: it was latched some time between request and reply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionPoll {
    /// Request sent, host seconds.
    pub sent_s: f64,
    /// First byte of the reply, host seconds.
    pub received_s: f64,
    /// Tilt, in position counts of the head.
    pub tilt_steps: i32,
}

/// The scan of one revolution.
#[derive(Debug, Clone, PartialEq)]
pub struct StampedScan {
    /// Sensor clock at step 0, milliseconds, unwrapped.
    pub stamp_ms: u64,
    /// Arrival of the first byte, host seconds.
    pub arrived_s: f64,
    /// One per beam: millimetres, or codes below DMIN (scip2 section 7).
    pub values: Vec<u32>,
}

/// How the head moved during a pan segment.
#[derive(Debug, Clone, PartialEq)]
pub enum HeadMotion {
    /// Continuous tilt at a constant speed.
    Tilting {
        /// The commanded speed, counts per second, signed.
        speed_steps_s: f64,
    },
    /// The head stopped for every scan.
    StepAndStare {
        /// The confirmed position during each scan, counts.
        tilt_steps: Vec<i32>,
    },
}

/// The scans at one pan.
#[derive(Debug, Clone, PartialEq)]
pub struct PanSegment {
    /// Pan, radians.
    pub pan_rad: f64,
    /// How the head moved meanwhile.
    pub motion: HeadMotion,
    /// The scans, in order.
    pub scans: Vec<StampedScan>,
    /// Position queries during the scans; none for step-and-stare.
    pub polls: Vec<PositionPoll>,
    /// Time exchanges before and after the scans.
    pub time_samples: Vec<TimeSample>,
}

/// The raw data of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct RawSweep {
    /// The beams of the laser.
    pub scan_geometry: ScanGeometry,
    /// The mount of the laser when the sweep was taken.
    pub mount: Mount,
    /// Tilt per count, radians, signed.
    pub tilt_rad_per_step: f64,
    /// Tilt at count 0, radians.
    pub tilt_zero_rad: f64,
    /// Lowest tilt that belongs to the sweep, radians.
    pub tilt_low_rad: f64,
    /// Highest tilt that belongs to the sweep, radians.
    pub tilt_high_rad: f64,
    /// Added to the time of a beam before the tilt at that time is computed, seconds (tau of sweep-geometry section 5).
    pub time_offset_s: f64,
    /// Difference of the tilt between a travel up and one down at the same count, radians: the laser lags behind the count
    /// by half of it (b of sweep-geometry section 5).
    pub tilt_backlash_rad: f64,
    /// Planned angle between lines, radians.
    pub line_pitch_rad: f64,
    /// One per pan.
    pub pan_segments: Vec<PanSegment>,
}
