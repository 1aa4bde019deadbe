//! Options of the emulated laser.

use super::constants::{CLOCK_RATE_ERROR, MOTOR_RATE_ERROR};
use super::profile::LaserProfile;

/// Options of an [`EmulatedLaser`](super::EmulatedLaser).
#[derive(Debug, Clone, PartialEq)]
pub struct LaserOptions {
    /// Model and firmware: commands, texts and ranges of the emulated laser.
    pub profile: LaserProfile,
    /// Rate of the timer against the host's clock, minus one; measured: +0.0013 (scip2 section 8).
    pub clock_rate_error: f64,
    /// Speed of the motor against nominal, by the timer, minus one; measured: +0.0012, so that stamps are 99 or 100 ms
    /// apart, 99.88 ms on average (scip2 section 8).
    pub motor_rate_error: f64,
    /// The timer at the start, ms of 24 bits. After a power cycle it starts from 0.
    pub timer_start_ms: u32,
    /// When the stamp of a scan is taken, ms after step 0; negative is before. By scip2 section 8 it is 0; sensors may
    /// differ.
    pub stamp_offset_ms: f64,
    /// The connection to the host.
    pub link: LaserLink,
    /// The state at the start.
    pub start_state: LaserStartState,
    /// Seed of jitter and corrupted bytes.
    pub seed: u64,
}

impl Default for LaserOptions {
    fn default() -> Self {
        Self {
            profile: LaserProfile::default(),
            clock_rate_error: CLOCK_RATE_ERROR,
            motor_rate_error: MOTOR_RATE_ERROR,
            timer_start_ms: 0,
            stamp_offset_ms: 0.0,
            link: LaserLink::Usb,
            start_state: LaserStartState::PowerUp,
            seed: 1,
        }
    }
}

/// The connection to the host (scip2 section 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaserLink {
    /// USB: a full scan takes 5.5 to 8 ms; no bit rate.
    Usb,
    /// Ethernet, 100 Mbit/s.
    Network,
    /// RS-232C, 8N1, paced by the bit rate; a scan is dropped whole if the line is still busy.
    Serial {
        /// Bits per second: of both sides at the start, and the default after `RS` or power-up.
        baud: u32,
    },
}

/// The state at the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaserStartState {
    /// As after power-up: SCIP 1.1 or SCIP 2.0, depending on the profile; laser off.
    PowerUp,
    /// SCIP 2.0, laser off.
    Idle,
    /// SCIP 2.0, laser on, no stream.
    LaserOn,
    /// Left streaming by an earlier host: endless `MD` over the measuring window.
    Streaming,
    /// Left in time adjust by an earlier host.
    TimeAdjust,
    /// Firmware update mode: all but VV, II, RS and SCIP2.0 get 0I (scip2 section 5).
    FirmwareUpdate,
}
