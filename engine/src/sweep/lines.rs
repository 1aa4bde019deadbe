//! The lines of one leg: how many came, and where none did.

use super::constants::SAME_LINE_PITCHES;
use serde::{Deserialize, Serialize};

/// Lines of one leg.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LegLines {
    /// Pan, radians.
    pub pan_rad: f64,
    /// Lines that the plan asks for.
    pub expected: usize,
    /// Lines that came, no more than were asked for.
    pub got: usize,
}

impl LegLines {
    /// Whether no larger share than `max_missing` is missing, and not all.
    pub fn complete(&self, max_missing: f64) -> bool {
        let missing = 1.0 - self.got as f64 / self.expected.max(1) as f64;
        self.got > 0 && missing <= max_missing
    }
}

/// The widest place without lines.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gap {
    /// Lines missing in a row.
    pub lines: usize,
    /// Angle between the lines on either side, or to the end of the range, radians.
    pub angle_rad: f64,
}

/// Counts lines at these tilts, radians, in the range from `low_rad` to `high_rad`; lines that lie together count once.
pub fn count(tilts_rad: &mut [f64], low_rad: f64, high_rad: f64, pitch_rad: f64) -> (usize, Gap) {
    tilts_rad.sort_by(f64::total_cmp);
    let mut got = 0;
    let mut widest = Gap::default();
    let mut last_rad = None;
    // Where the range ends, a line may stand anywhere within a pitch.
    let mut note = |angle_rad: f64, from_end: bool| {
        let pitches = angle_rad / pitch_rad;
        let missing = if from_end {
            (pitches - SAME_LINE_PITCHES).round()
        } else {
            pitches.round() - 1.0
        };
        widest = Gap {
            lines: widest.lines.max(missing.max(0.0) as usize),
            angle_rad: widest.angle_rad.max(angle_rad),
        };
    };
    for tilt_rad in tilts_rad.iter() {
        let from_rad = last_rad.unwrap_or(low_rad);
        let again = last_rad.is_some() && tilt_rad - from_rad < SAME_LINE_PITCHES * pitch_rad;
        if !again {
            note(tilt_rad - from_rad, last_rad.is_none());
            got += 1;
            last_rad = Some(*tilt_rad);
        }
    }
    note(high_rad - last_rad.unwrap_or(low_rad), true);
    (got, widest)
}

#[cfg(test)]
mod tests {
    use super::{Gap, count};

    fn counted(kept: impl Fn(usize) -> bool) -> (usize, Gap) {
        // From 0.3 to 99.3.
        let mut tilts: Vec<f64> = (0..100)
            .rev()
            .filter(|i| kept(*i))
            .map(|i| 0.3 + i as f64)
            .collect();
        count(&mut tilts, 0.0, 100.0, 1.0)
    }

    #[test]
    fn gaps_are_counted_inside_and_at_both_ends() {
        assert_eq!(counted(|_| true).0, 100);
        assert_eq!(counted(|_| true).1.lines, 0);
        assert_eq!(counted(|i| !(40..46).contains(&i)).1.lines, 6);
        assert_eq!(counted(|i| i >= 4).1.lines, 4);
        assert_eq!(counted(|i| i < 96).1.lines, 4);
        assert_eq!(
            counted(|_| false),
            (
                0,
                Gap {
                    lines: 100,
                    angle_rad: 100.0
                }
            )
        );
    }

    #[test]
    fn a_repeated_line_makes_up_for_none() {
        let mut tilts: Vec<f64> = (0..90).map(f64::from).chain([5.01; 10]).collect();
        assert_eq!(count(&mut tilts, 0.0, 99.0, 1.0).0, 90);
    }
}
