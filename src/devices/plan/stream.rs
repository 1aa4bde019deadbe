//! The scans to request, reduced where the line is slower than the laser.

use crate::devices::constants::MAX_LINE_LOAD;
use scip::command::span::ScanSpan;
use scip::{LaserParameters, StreamPlan, ValueCoding};
use std::time::Duration;

/// All beams in three characters. On a line too slow for that two steps share a value, then scans are skipped: regular lines
/// matter more than dense ones (sweep-geometry section 3). Also returns the time between two transmitted scans.
pub(super) fn plan_stream(
    parameters: LaserParameters,
    line_bytes_s: Option<u32>,
    notes: &mut Vec<String>,
) -> (StreamPlan, Duration) {
    let step = |n: u32| u16::try_from(n).unwrap_or(u16::MAX);
    let mut plan = StreamPlan {
        first_step: step(parameters.amin),
        last_step: step(parameters.amax),
        cluster: 1,
        interval: 0,
        coding: ValueCoding::ThreeCharacter,
        count: 0,
    };
    let period = parameters.scan_period();
    if let Some(rate) = line_bytes_s {
        let seconds = |cluster: u8| {
            let span = ScanSpan {
                first_step: plan.first_step,
                last_step: plan.last_step,
                cluster,
                coding: plan.coding,
            };
            // The echo of `MD` with its count has 15 characters.
            span.reply_bytes(15) as f64 / f64::from(rate.max(1))
        };
        let budget = MAX_LINE_LOAD * period.as_secs_f64();
        if seconds(1) > budget {
            plan.cluster = 2;
            let periods = (seconds(2) / budget).ceil().clamp(1.0, 10.0);
            plan.interval = periods as u8 - 1;
            notes.push(format!(
                "the laser's line carries {rate} bytes/s: two steps per value, one of {} scans",
                plan.interval + 1
            ));
        }
    }
    (plan, period * (u32::from(plan.interval) + 1))
}
