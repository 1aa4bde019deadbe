//! Settings of the driver and of a stream.

use std::time::Duration;

use super::error::ScipError;
use crate::command::span::ScanSpan;
use crate::command::stream::StreamRequest;
use crate::constants::{MAX_CLUSTER, MAX_COUNT, MAX_INTERVAL, MAX_STEP};
use crate::scan::ValueCoding;

/// Time-outs, retries and tolerances. The default fits a URG-04LX on USB.
#[derive(Debug, Clone, PartialEq)]
pub struct ScipOptions {
    /// Time-out of a reply. Firmware 3.1.04 answers on a 100 ms tick, after up to 111 ms; below 250 ms is too short
    /// (scip2 section 8).
    pub reply_timeout: Duration,
    /// How often a request is sent.
    pub attempts: u8,
    /// Time-out of connecting as a whole. 8 commands take 0.8 s; every mode change twice, with its retries, fits.
    pub connect_timeout: Duration,
    /// Mode changes (`SCIP2.0`, `TM2`) while connecting or stopping before the device counts as stuck.
    pub max_mode_changes: u8,
    /// Whether connecting sends `RS` for a known state and the timer at zero.
    pub reset_on_connect: bool,
    /// Time-out and attempts of the requests before the first answer, where a rate is only tried. `None`: as the others.
    pub probe: Option<(Duration, u8)>,
    /// Connecting ends at the first time-out where what came is no text: another line rate is to be tried.
    pub gives_up_on_garbage: bool,
    /// Periods without data after which the stream is restarted (scip2 section 14).
    pub silent_periods: u32,
    /// Minimum time without data before a restart, whatever the period: three revolutions of a URG. Data every 25 ms
    /// are more often late, on a busy host, than missing.
    pub min_silence: Duration,
    /// Speed of a link that may be slower than the scans (RS-232C: bit rate / 10). `None`: USB, network.
    pub link_bytes_per_second: Option<u32>,
    /// Bit rate that a line should have at least: a sensor on a slower one is asked to change (`SS`). `None`: left as it is.
    pub wanted_bit_rate: Option<u32>,
    /// How long the device may verify an error (status 21 to 49). The protocol has no figure; a URG's start takes less.
    pub verify_timeout: Duration,
    /// Damaged messages in a row that restart the stream; single ones are unavoidable (scip2 section 13).
    pub max_damaged_in_a_row: u8,
    /// Repeats of one stamp that are stale data (scip2 section 8).
    pub stale_repeats: u8,
    /// Implausible stamps in a row that are a fault.
    pub max_jumps_in_a_row: u8,
    /// Tolerance of a stamp's advance, share of the period (scip2 section 14).
    pub stamp_tolerance: f64,
    /// Tolerance of the sensor's speed over a gap, share of the gap: real mean period 99.88 ms (scip2 section 8).
    pub speed_tolerance: f64,
    /// Largest plausible gap between two stamps; silence restarts a stream long before.
    pub max_gap: Duration,
    /// Good scans after a restart until the next one begins with `QT` again.
    pub good_scans_to_recover: u32,
}

impl Default for ScipOptions {
    fn default() -> Self {
        Self {
            reply_timeout: Duration::from_secs(1),
            attempts: 3,
            connect_timeout: Duration::from_secs(15),
            max_mode_changes: 4,
            reset_on_connect: true,
            probe: None,
            gives_up_on_garbage: false,
            silent_periods: 3,
            min_silence: Duration::from_millis(300),
            link_bytes_per_second: None,
            wanted_bit_rate: None,
            verify_timeout: Duration::from_secs(10),
            max_damaged_in_a_row: 10,
            stale_repeats: 3,
            max_jumps_in_a_row: 3,
            stamp_tolerance: 0.1,
            speed_tolerance: 0.002,
            max_gap: Duration::from_secs(20),
            good_scans_to_recover: 10,
        }
    }
}

/// The window, clustering, interval and coding of a stream: the fields of `MD`, `MS` and `ME` (scip2 section 6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamPlan {
    /// First step of the window, 0 to 9999.
    pub first_step: u16,
    /// Last step, included. Choose a number of steps that the cluster divides: what devices do with the remainder is
    /// unconfirmed (scip2 section 6, cluster).
    pub last_step: u16,
    /// Steps merged into one value; 0 and 1 mean none.
    pub cluster: u8,
    /// Scans skipped between two that are sent, 0 to 9.
    pub interval: u8,
    /// Characters per value.
    pub coding: ValueCoding,
    /// Number of scans, 1 to 99; 0: until stopped.
    pub count: u8,
}

impl StreamPlan {
    /// The request for this plan, its fields checked against their digits.
    ///
    /// Sweeps stream without end. A counted stream, asked for again and again, would bound what a crashed host leaves
    /// behind, but loses a scan or more each time: a hole in the sweep every ten seconds. A laser left streaming does
    /// no harm, since connecting begins with `QT`.
    pub(super) fn request(&self) -> Result<StreamRequest, ScipError> {
        let plan = |what, expected, got| {
            Err(ScipError::Plan {
                what,
                expected,
                got,
            })
        };
        if self.last_step > MAX_STEP {
            plan("last step", "at most 9999", self.last_step.into())
        } else if self.first_step > self.last_step {
            plan(
                "first step",
                "at most the last step",
                self.first_step.into(),
            )
        } else if self.cluster > MAX_CLUSTER {
            plan("cluster", "at most 99", self.cluster.into())
        } else if self.interval > MAX_INTERVAL {
            plan("interval", "at most 9", self.interval.into())
        } else if self.count > MAX_COUNT {
            plan("count", "at most 99", self.count.into())
        } else {
            Ok(StreamRequest {
                span: ScanSpan {
                    first_step: self.first_step,
                    last_step: self.last_step,
                    cluster: self.cluster,
                    coding: self.coding,
                },
                interval: self.interval,
                count: self.count,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: StreamPlan = StreamPlan {
        first_step: 44,
        last_step: 725,
        cluster: 1,
        interval: 0,
        coding: ValueCoding::ThreeCharacter,
        count: 0,
    };

    #[test]
    fn plans_that_no_request_can_carry_are_refused_by_field() {
        assert!(FULL.request().is_ok());
        let refused = |plan: StreamPlan| match plan.request() {
            Err(ScipError::Plan { what, .. }) => what,
            other => panic!("{other:?}"),
        };
        assert_eq!(
            refused(StreamPlan {
                first_step: 726,
                ..FULL
            }),
            "first step"
        );
        assert_eq!(
            refused(StreamPlan {
                cluster: 100,
                ..FULL
            }),
            "cluster"
        );
        assert_eq!(
            refused(StreamPlan {
                last_step: 10_000,
                ..FULL
            }),
            "last step"
        );
        assert_eq!(
            refused(StreamPlan {
                interval: 10,
                ..FULL
            }),
            "interval"
        );
        assert_eq!(refused(StreamPlan { count: 100, ..FULL }), "count");
    }
}
