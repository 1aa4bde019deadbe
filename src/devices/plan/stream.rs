//! The scans to request, reduced where the line is slower than the laser.

use super::LaserFacts;
use crate::devices::constants::{BITS_PER_BYTE, MAX_CLUSTER, MAX_LINE_LOAD, MAX_STREAM_PERIODS};
use scip::command::span::ScanSpan;
use scip::{LaserParameters, StreamPlan, ValueCoding};
use std::time::Duration;

/// All beams in three characters. On a line too slow for that, pairs of steps share a value; where that is not enough,
/// scans are skipped, evenly, and the tilt has to be as much slower: regular lines matter more than dense ones
/// (sweep-geometry section 3). Only where the tilt cannot be so slow (`max_periods`) more steps share a value. Also returns
/// the time between two transmitted scans.
pub(super) fn plan_stream(
    laser: LaserFacts,
    max_periods: u32,
    notes: &mut Vec<String>,
) -> (StreamPlan, Duration) {
    let period = laser.parameters.scan_period();
    let mut plan = all_beams(laser.parameters);
    if let Some(rate) = laser.line_bytes_s {
        let periods = |cluster: u8| periods_of_scan(&plan, cluster, rate, period);
        let allowed = max_periods
            .min(MAX_STREAM_PERIODS)
            .max(periods(MAX_CLUSTER));
        let cluster = if periods(1) <= 1 {
            1
        } else {
            let fits = |cluster: &u8| periods(*cluster) <= allowed;
            (2..=MAX_CLUSTER).find(fits).unwrap_or(MAX_CLUSTER)
        };
        let periods = periods(cluster).min(MAX_STREAM_PERIODS);
        plan.cluster = cluster;
        // What devices send of a partial last group is unconfirmed (scip2 section 6, Cluster).
        let steps = plan.last_step - plan.first_step + 1;
        plan.last_step -= steps % u16::from(cluster);
        plan.interval = u8::try_from(periods).unwrap_or(u8::MAX) - 1;
        if cluster > 1 || periods > 1 {
            notes.push(format!(
                "the laser's line carries {} bit/s: {cluster} steps per value, one of {periods} scans",
                rate * BITS_PER_BYTE
            ));
        }
    }
    (plan, period * (u32::from(plan.interval) + 1))
}

fn all_beams(parameters: LaserParameters) -> StreamPlan {
    let step = |n: u32| u16::try_from(n).unwrap_or(u16::MAX);
    StreamPlan {
        first_step: step(parameters.amin),
        last_step: step(parameters.amax),
        cluster: 1,
        interval: 0,
        coding: ValueCoding::ThreeCharacter,
        count: 0,
    }
}

/// Scan periods that the bytes of one scan take on the line.
fn periods_of_scan(plan: &StreamPlan, cluster: u8, bytes_s: u32, period: Duration) -> u32 {
    let span = ScanSpan {
        first_step: plan.first_step,
        last_step: plan.last_step,
        cluster,
        coding: plan.coding,
    };
    // The echo of `MD` with its count has 15 characters.
    let seconds = span.reply_bytes(15) as f64 / f64::from(bytes_s.max(1));
    (seconds / (MAX_LINE_LOAD * period.as_secs_f64()))
        .ceil()
        .max(1.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cluster and scan periods per line at a bit rate.
    fn planned(bit_s: u32, max_periods: u32) -> (u8, u32) {
        let laser = LaserFacts {
            parameters: LaserParameters::URG_04LX,
            line_bytes_s: Some(bit_s / 10),
        };
        let mut notes = Vec::new();
        let (plan, line_period) = plan_stream(laser, max_periods, &mut notes);
        let periods = u32::from(plan.interval) + 1;
        assert_eq!(line_period, Duration::from_millis(100) * periods);
        assert_eq!(
            notes.is_empty(),
            (plan.cluster, periods) == (1, 1),
            "{notes:?}"
        );
        // The scans fit the line.
        assert_eq!((plan.last_step - 43) % u16::from(plan.cluster), 0);
        let bytes = ScanSpan {
            first_step: 44,
            last_step: plan.last_step,
            cluster: plan.cluster,
            coding: plan.coding,
        }
        .reply_bytes(15);
        assert!(bytes as f64 * 10.0 / f64::from(bit_s) < line_period.as_secs_f64());
        (plan.cluster, periods)
    }

    #[test]
    fn a_slow_line_gets_fewer_values_then_fewer_scans() {
        // Times of a scan: scip2 section 2, RS-232 budget.
        for (bit_s, fastest_tilt) in [
            (750_000, (1, 1)),
            (250_000, (1, 1)),
            (115_200, (2, 1)),
            (57_600, (2, 2)),
            (19_200, (2, 6)),
        ] {
            assert_eq!(planned(bit_s, u32::MAX), fastest_tilt, "{bit_s}");
        }
        // The tilt can be three times as slow: more steps share a value.
        assert_eq!(planned(57_600, 3), (2, 2));
        assert_eq!(planned(19_200, 5), (3, 5));
        assert_eq!(planned(19_200, 4), (4, 4));
        // No more than four, and none in vain; the lines are farther apart then.
        assert_eq!(planned(19_200, 3), (4, 4));
        assert_eq!(planned(57_600, 1), (2, 2));
    }

    #[test]
    fn a_line_without_a_rate_carries_all() {
        let laser = LaserFacts {
            parameters: LaserParameters::URG_04LX,
            line_bytes_s: None,
        };
        let (plan, period) = plan_stream(laser, 1, &mut Vec::new());
        assert_eq!((plan.cluster, plan.interval), (1, 0));
        assert_eq!((plan.first_step, plan.last_step), (44, 725));
        assert_eq!(period, Duration::from_millis(100));
    }
}
