//! Counts the lines of a pan segment and the gaps between them.

use super::constants::SAME_LINE_PITCHES;
use serde::{Deserialize, Serialize};

/// The lines of one pan segment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PanSegmentLines {
    /// Pan, radians.
    pub pan_rad: f64,
    /// Lines of the plan.
    pub expected: usize,
    /// Lines measured, at most those of the plan.
    pub got: usize,
}

impl PanSegmentLines {
    /// Whether at most the share `max_missing` is missing, and not all.
    pub(super) fn is_complete(&self, max_missing: f64) -> bool {
        let missing = 1.0 - self.got as f64 / self.expected.max(1) as f64;
        self.got > 0 && missing <= max_missing
    }
}

/// A range of tilts without lines.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LineGap {
    /// Lines missing in a row.
    pub(super) lines: usize,
    /// Angle between the lines on both sides, or to the end of the tilt range, radians.
    pub(super) angle_rad: f64,
}

/// Counts the lines at `tilts_rad` in the range from `low_rad` to `high_rad`, and finds the widest gap. Lines nearer
/// together than half a pitch count once.
pub(super) fn count_lines(
    tilts_rad: &mut [f64],
    low_rad: f64,
    high_rad: f64,
    pitch_rad: f64,
) -> (usize, LineGap) {
    tilts_rad.sort_by(f64::total_cmp);
    let mut got = 0;
    let mut widest = LineGap::default();
    let mut last_rad = None;
    // At the ends of the range, a line may lie anywhere within a pitch.
    let mut add_gap = |angle_rad: f64, at_end: bool| {
        let pitches = angle_rad / pitch_rad;
        let missing = if at_end {
            (pitches - SAME_LINE_PITCHES).round()
        } else {
            pitches.round() - 1.0
        };
        widest = LineGap {
            lines: widest.lines.max(missing.max(0.0) as usize),
            angle_rad: widest.angle_rad.max(angle_rad),
        };
    };
    for tilt_rad in tilts_rad.iter() {
        let from_rad = last_rad.unwrap_or(low_rad);
        let repeated = last_rad.is_some() && tilt_rad - from_rad < SAME_LINE_PITCHES * pitch_rad;
        if !repeated {
            add_gap(tilt_rad - from_rad, last_rad.is_none());
            got += 1;
            last_rad = Some(*tilt_rad);
        }
    }
    add_gap(high_rad - last_rad.unwrap_or(low_rad), true);
    (got, widest)
}

#[cfg(test)]
mod tests {
    use super::{LineGap, count_lines};

    fn counted(kept: impl Fn(usize) -> bool) -> (usize, LineGap) {
        // From 0.3 to 99.3.
        let mut tilts: Vec<f64> = (0..100)
            .rev()
            .filter(|i| kept(*i))
            .map(|i| 0.3 + i as f64)
            .collect();
        count_lines(&mut tilts, 0.0, 100.0, 1.0)
    }

    #[test]
    fn gaps_are_found_inside_and_at_both_ends() {
        assert_eq!(counted(|_| true).0, 100);
        assert_eq!(counted(|_| true).1.lines, 0);
        assert_eq!(counted(|i| !(40..46).contains(&i)).1.lines, 6);
        assert_eq!(counted(|i| i >= 4).1.lines, 4);
        assert_eq!(counted(|i| i < 96).1.lines, 4);
        assert_eq!(
            counted(|_| false),
            (
                0,
                LineGap {
                    lines: 100,
                    angle_rad: 100.0
                }
            )
        );
    }

    #[test]
    fn a_repeated_line_replaces_no_missing_one() {
        let mut tilts: Vec<f64> = (0..90).map(f64::from).chain([5.01; 10]).collect();
        assert_eq!(count_lines(&mut tilts, 0.0, 99.0, 1.0).0, 90);
    }
}
