//! The raw data of a sweep, as the devices gave it: kept beside the points, enough to assemble them again.

use crate::geometry::Mount;
use crate::scan::Optics;

/// One exchange of time with the sensor: its clock read `stamp_ms` some time between the two instants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSample {
    /// Request sent, host seconds.
    pub sent_s: f64,
    /// First byte of the reply, host seconds.
    pub received_s: f64,
    /// Sensor clock, milliseconds, unwrapped.
    pub stamp_ms: u64,
}

/// One position asked of the head: it was latched some time between the two instants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Poll {
    /// Request sent, host seconds.
    pub sent_s: f64,
    /// First byte of the reply, host seconds.
    pub received_s: f64,
    /// Tilt, in counts of the head (positions).
    pub tilt_steps: i32,
}

/// One revolution.
#[derive(Debug, Clone, PartialEq)]
pub struct RawScan {
    /// Sensor clock when the head passed step 0, milliseconds, unwrapped.
    pub stamp_ms: u64,
    /// First byte at the host, host seconds.
    pub arrived_s: f64,
    /// Millimetres, or codes below DMIN.
    pub values: Vec<u32>,
}

/// How the head moved while the scans of a leg were taken.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// Tilting at a constant speed, counts per second (signed).
    Tilting {
        /// The commanded speed.
        speed_steps_s: f64,
    },
    /// Standing; `tilt_steps[i]` is the confirmed position during scan `i`.
    Standing {
        /// One position per scan.
        tilt_steps: Vec<i32>,
    },
}

/// The scans of one pan.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// Pan, radians.
    pub pan_rad: f64,
    /// How the head moved.
    pub motion: Motion,
    /// The scans, in order.
    pub scans: Vec<RawScan>,
    /// Positions asked while they came; empty when standing.
    pub polls: Vec<Poll>,
    /// Time exchanges before and after.
    pub time_samples: Vec<TimeSample>,
}

/// All legs of one sweep and what is needed to read them.
#[derive(Debug, Clone, PartialEq)]
pub struct RawSweep {
    /// The laser's beams.
    pub optics: Optics,
    /// Where the laser sat when the sweep was taken.
    pub mount: Mount,
    /// Radians of tilt per count, signed, and radians at count 0.
    pub tilt_rad_per_step: f64,
    /// Tilt at count 0, radians.
    pub tilt_zero_rad: f64,
    /// Lowest tilt that belongs to the sweep, radians.
    pub tilt_low_rad: f64,
    /// Highest tilt that belongs to the sweep, radians.
    pub tilt_high_rad: f64,
    /// Added to every instant of the laser before the head's tilt is asked for, seconds (tau of sweep-geometry section 5).
    pub time_offset_s: f64,
    /// Angle by which the tilt of a travel up and of one down differ at the same count, radians: half of it is what the
    /// laser lags behind the count in its direction of travel (b of sweep-geometry section 5).
    pub tilt_backlash_rad: f64,
    /// Pitch of the lines that was asked for, radians.
    pub line_pitch_rad: f64,
    /// One leg per pan.
    pub legs: Vec<Leg>,
}
