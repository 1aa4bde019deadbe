//! What a twin is made with.

use super::constants::{CLOCK_RATE_ERROR, MOTOR_RATE_ERROR};
use super::profile::Profile;

/// The settings of a [`Twin`](super::Twin).
#[derive(Debug, Clone, PartialEq)]
pub struct TwinOptions {
    /// Which sensor.
    pub profile: Profile,
    /// How much faster than the host's clock the sensor's timer runs; +0.0013 as measured (protocol section 8).
    pub clock_rate_error: f64,
    /// How much faster than nominal the motor turns by the sensor's own timer; +0.0012 as measured, so that stamps
    /// are 99 or 100 ms apart and 99.88 ms on average (protocol section 8).
    pub motor_rate_error: f64,
    /// What the timer shows at the start, ms; near 2^24 to see it wrap. A later power cycle starts from 0.
    pub timer_start_ms: u32,
    /// How long after step 0 the timer is read for a scan's stamp, ms; negative is before. The document says step 0
    /// (protocol section 8), sensors may differ.
    pub stamp_offset_ms: f64,
    /// What the bytes travel over.
    pub link: Link,
    /// The state in which the twin is found.
    pub start_state: StartState,
    /// Seed of its jitter and of its spoilt bytes.
    pub seed: u64,
}

impl Default for TwinOptions {
    fn default() -> Self {
        Self {
            profile: Profile::default(),
            clock_rate_error: CLOCK_RATE_ERROR,
            motor_rate_error: MOTOR_RATE_ERROR,
            timer_start_ms: 0,
            stamp_offset_ms: 0.0,
            link: Link::Usb,
            start_state: StartState::PowerUp,
            seed: 1,
        }
    }
}

/// What the bytes travel over (protocol section 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Link {
    /// USB: a full scan takes 5.5 to 8 ms; no bit rate.
    Usb,
    /// A network of 100 Mbit/s.
    Network,
    /// RS-232C, 8N1, paced by the bit rate; scans that find the line still busy are dropped whole.
    Serial {
        /// The rate of both sides at the start, bits per second, and the sensor's default after `RS` or power-up.
        baud: u32,
    },
}

/// The state in which a twin is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartState {
    /// As after power-up: SCIP1.1 or SCIP2.0 by the profile, laser off.
    PowerUp,
    /// SCIP2.0, laser off.
    Idle,
    /// SCIP2.0, laser on, nothing asked for.
    LaserOn,
    /// Left streaming by an earlier host: `MD` over the measuring window, without end.
    Streaming,
    /// Left in time adjustment by an earlier host.
    TimeAdjust,
    /// In the firmware update mode: only VV, II, RS and SCIP2.0 are answered, all else with 0I (section 5).
    FirmwareUpdate,
}
