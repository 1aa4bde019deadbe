//! What decides in the dialogue, in one table; and what a stream shall be.

use std::time::Duration;

use crate::command::span::Span;
use crate::command::stream::Stream;
use crate::error::SensorError;
use crate::scan::Coding;

/// The dialogue's figures. The default fits a URG-04LX on USB.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorOptions {
    /// How long a reply is waited for. Firmware 3.1.04 answers on a 100 ms tick, up to 111 ms; below 250 ms is wrong
    /// (protocol section 8).
    pub reply_timeout: Duration,
    /// How often a request is sent before its silence counts.
    pub attempts: u8,
    /// Limit of the whole of connecting: 8 commands take 0.8 s; twice every mode change with its retries fits.
    pub connect_timeout: Duration,
    /// Mode changes (`SCIP2.0`, `TM2`) while connecting before the device counts as stuck.
    pub mode_changes: u8,
    /// Whether connecting sends `RS`: a known state, and the timer at zero.
    pub reset_on_connect: bool,
    /// Periods without data before the stream is restarted (protocol section 14).
    pub silent_periods: u32,
    /// Least time without data that is silence, whatever the period: three turns of a URG. A sensor that sends every
    /// 25 ms over a busy host is late more often than it is silent.
    pub least_silence: Duration,
    /// How fast the link is, if it is slower than the scans (RS-232C: bit rate / 10). `None`: USB, network.
    pub link_bytes_per_second: Option<u32>,
    /// How long the device may verify an error (status 21 to 49). Not in the protocol; a URG's own start takes less.
    pub verify_timeout: Duration,
    /// Damaged messages in a row before the stream is restarted; single ones are unavoidable (protocol section 13).
    pub damaged_in_a_row: u8,
    /// Repeats of one stamp that mean stale data (protocol section 8).
    pub stale_repeats: u8,
    /// Implausible stamps in a row that mean a fault.
    pub jumps_in_a_row: u8,
    /// Tolerance of a stamp's advance, share of the period (protocol section 14).
    pub stamp_tolerance: f64,
    /// Tolerance of the sensor's speed over a gap, share of the gap: real mean period 99.88 ms (protocol section 8).
    pub speed_tolerance: f64,
    /// Greatest gap in the stamps that is believed; silence ends a stream long before.
    pub longest_gap: Duration,
    /// Good scans after a restart before the next silence counts as the first again.
    pub recovered_after: u32,
}

impl Default for SensorOptions {
    fn default() -> Self {
        Self {
            reply_timeout: Duration::from_secs(1),
            attempts: 3,
            connect_timeout: Duration::from_secs(15),
            mode_changes: 4,
            reset_on_connect: true,
            silent_periods: 3,
            least_silence: Duration::from_millis(300),
            link_bytes_per_second: None,
            verify_timeout: Duration::from_secs(10),
            damaged_in_a_row: 10,
            stale_repeats: 3,
            jumps_in_a_row: 3,
            stamp_tolerance: 0.1,
            speed_tolerance: 0.002,
            longest_gap: Duration::from_secs(20),
            recovered_after: 10,
        }
    }
}

/// Which scans shall stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamPlan {
    /// First step wanted.
    pub first_step: u16,
    /// Last step wanted. Choose a number of steps that the cluster divides: what the device does with the rest is not
    /// known (protocol section 6, cluster).
    pub last_step: u16,
    /// Steps merged into one value; 0 and 1 mean none.
    pub cluster: u8,
    /// Scans left out between two that are sent, 0 to 9.
    pub interval: u8,
    /// Characters per value.
    pub coding: Coding,
    /// Scans wanted, 1 to 99; 0: until stopped.
    pub count: u8,
}

impl StreamPlan {
    /// The request of this plan. Sweeps ask without end: a finite count, re-armed, would bound what a crashed host leaves
    /// behind, but loses a scan or more at each re-arming, a hole in the sweep every ten seconds; and a device left
    /// streaming is no harm, for connecting begins with `QT`.
    pub(super) fn request(&self) -> Result<Stream, SensorError> {
        let span = Span {
            first_step: self.first_step,
            last_step: self.last_step,
            cluster: self.cluster,
            coding: self.coding,
        };
        Stream {
            span,
            interval: self.interval,
            count: self.count,
        }
        .checked()
    }
}
