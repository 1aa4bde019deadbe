//! Which scans to ask for, on a line that may be slower than the laser.

use super::LaserFacts;
use crate::devices::constants::LINE_SHARE;
use scip::command::span::Span;
use scip::{Coding, StreamPlan};
use std::time::Duration;

/// All beams in three characters. A line too slow for that gets two steps a value, and then fewer scans: regular lines
/// are worth more than dense ones (sweep-geometry section 3).
pub(super) fn stream_plan(laser: LaserFacts, notes: &mut Vec<String>) -> (StreamPlan, Duration) {
    let parameters = laser.parameters;
    let step = |n: u32| u16::try_from(n).unwrap_or(u16::MAX);
    let mut plan = StreamPlan {
        first_step: step(parameters.amin),
        last_step: step(parameters.amax),
        cluster: 1,
        interval: 0,
        coding: Coding::ThreeCharacter,
        count: 0,
    };
    let period = parameters.scan_period();
    if let Some(rate) = laser.line_bytes_s {
        let seconds = |cluster: u8| {
            let span = Span {
                first_step: plan.first_step,
                last_step: plan.last_step,
                cluster,
                coding: plan.coding,
            };
            // The echo of `MD` with its count has 15 characters.
            span.reply_bytes(15) as f64 / f64::from(rate.max(1))
        };
        let budget = LINE_SHARE * period.as_secs_f64();
        if seconds(1) > budget {
            plan.cluster = 2;
            let periods = (seconds(2) / budget).ceil().clamp(1.0, 10.0);
            plan.interval = periods as u8 - 1;
            notes.push(format!(
                "the laser's line carries {rate} bytes/s: two steps a value, every {}th scan",
                plan.interval + 1
            ));
        }
    }
    (plan, period * (u32::from(plan.interval) + 1))
}
