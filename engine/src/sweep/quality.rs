//! How good a sweep is: the figures that the verdict reads.

use super::constants::{
    LEAST_HIT_SHARE, MOST_BLIND_LINES, MOST_DISPLACEMENT_PITCHES, MOST_GAP_PITCHES, MOST_GAP_RAD,
};
use super::lines::LegLines;
use serde::{Deserialize, Serialize};

/// Quality figures of one sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Lines that the plan asks for.
    pub lines_expected: usize,
    /// Lines that came, in each leg no more than it was asked for.
    pub lines_got: usize,
    /// Places where scans between two others are missing.
    pub gaps: usize,
    /// Most lines missing in a row.
    pub widest_gap_lines: usize,
    /// Widest angle without a line inside any leg's tilt range, radians.
    pub widest_gap_rad: f64,
    /// Pitch of the lines that was asked for, radians.
    pub line_pitch_rad: f64,
    /// The lines of each leg.
    pub legs: Vec<LegLines>,
    /// Share of beams that hit something.
    pub hit_share: f64,
    /// Share of beams with nothing there.
    pub no_return_share: f64,
    /// Largest distance of a position poll from the fitted motion, counts.
    pub position_residual_steps: f64,
    /// The same, radians.
    pub position_residual_rad: f64,
    /// Bound of the clock offset's error, seconds.
    pub clock_uncertainty_s: f64,
    /// What the head tilts in that time, radians.
    pub clock_uncertainty_rad: f64,
    /// Host seconds per laser second.
    pub clock_rate: f64,
    /// Whether scans repeat each other.
    pub frozen: bool,
    /// Lines of which a whole sector tells nothing; none in records older than this figure.
    #[serde(default)]
    pub blind_lines: usize,
}

impl Quality {
    /// Why the sweep must not be judged, nor become a reference; `None` where it is good. `max_missing_lines` is the
    /// largest share of its lines that any leg may miss.
    pub fn fault(&self, max_missing_lines: f64) -> Option<String> {
        if self.frozen {
            return Some("frozen laser data: scans repeat each other".to_owned());
        }
        self.incomplete(max_missing_lines)
            .or_else(|| self.displaced())
            .or_else(|| {
                let enough = self.hit_share >= LEAST_HIT_SHARE;
                (!enough).then(|| {
                    format!(
                        "blind laser: {:.1} % of the beams hit anything; is the lens covered?",
                        100.0 * self.hit_share
                    )
                })
            })
            .or_else(|| {
                let sees = self.blind_lines < MOST_BLIND_LINES;
                (!sees).then(|| {
                    format!(
                        "blind laser: {} lines tell nothing of a whole sector; is the lens covered in part?",
                        self.blind_lines
                    )
                })
            })
    }

    fn incomplete(&self, max_missing_lines: f64) -> Option<String> {
        let whole = LegLines {
            pan_rad: 0.0,
            expected: self.lines_expected,
            got: self.lines_got,
        };
        if !whole.complete(max_missing_lines) {
            return Some(format!(
                "incomplete sweep: {} of {} lines",
                whole.got, whole.expected
            ));
        }
        if let Some(leg) = self.legs.iter().find(|l| !l.complete(max_missing_lines)) {
            return Some(format!(
                "incomplete sweep: {} of {} lines at pan {:.1} deg",
                leg.got,
                leg.expected,
                leg.pan_rad.to_degrees()
            ));
        }
        let most_rad = MOST_GAP_RAD.max(MOST_GAP_PITCHES * self.line_pitch_rad);
        let dense = self.widest_gap_rad <= most_rad;
        (!dense).then(|| {
            format!(
                "gap in the sweep: {} lines missing in a row, {:.1} deg without any",
                self.widest_gap_lines,
                self.widest_gap_rad.to_degrees()
            )
        })
    }

    fn displaced(&self) -> Option<String> {
        let most_rad = MOST_DISPLACEMENT_PITCHES * self.line_pitch_rad;
        let reasons = [
            (
                self.clock_uncertainty_rad,
                format!(
                    "uncertain clock: laser and host agree to {:.1} ms only",
                    1e3 * self.clock_uncertainty_s
                ),
            ),
            (
                self.position_residual_rad,
                format!(
                    "uncertain head: a position lies {:.1} counts off the motion",
                    self.position_residual_steps
                ),
            ),
        ];
        // A figure that is no number is no proof of quality.
        let bad = reasons.into_iter().find(|(rad, _)| {
            let small = *rad <= most_rad;
            !small
        })?;
        Some(format!(
            "{}, {:.2} deg of tilt at lines {:.2} deg apart",
            bad.1,
            bad.0.to_degrees(),
            self.line_pitch_rad.to_degrees()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::Quality;
    use crate::sweep::LegLines;

    fn leg(expected: usize, got: usize) -> LegLines {
        LegLines {
            pan_rad: 0.5,
            expected,
            got,
        }
    }

    fn good() -> Quality {
        Quality {
            lines_expected: 240,
            lines_got: 239,
            gaps: 1,
            widest_gap_lines: 1,
            widest_gap_rad: 0.0174,
            line_pitch_rad: 0.0087,
            legs: vec![leg(120, 120), leg(120, 119)],
            hit_share: 0.6,
            no_return_share: 0.3,
            position_residual_steps: 0.4,
            position_residual_rad: 0.0004,
            clock_uncertainty_s: 5e-4,
            clock_uncertainty_rad: 5e-5,
            clock_rate: 0.9987,
            frozen: false,
            blind_lines: 0,
        }
    }

    #[test]
    fn each_fault_has_its_word() {
        assert_eq!(good().fault(0.05), None);
        let told = |spoil: &dyn Fn(&mut Quality), word: &str| {
            let mut quality = good();
            spoil(&mut quality);
            let fault = quality.fault(0.05).unwrap_or_default();
            assert!(fault.contains(word), "{fault:?} instead of {word:?}");
        };
        told(&|q| q.lines_got = 200, "200 of 240 lines");
        told(&|q| q.frozen = true, "frozen");
        told(&|q| q.hit_share = 0.01, "blind");
        told(&|q| q.hit_share = f64::NAN, "blind");
        told(&|q| q.blind_lines = 10, "covered in part");
        told(&|q| q.clock_uncertainty_rad = 0.009, "uncertain clock");
        told(&|q| q.position_residual_rad = 0.009, "uncertain head");
        told(&|q| q.position_residual_rad = f64::NAN, "uncertain head");
    }

    #[test]
    fn a_leg_is_not_made_whole_by_another() {
        let quality = Quality {
            lines_got: 230,
            legs: vec![leg(120, 120), leg(120, 110)],
            ..good()
        };
        let fault = quality.fault(0.05).unwrap_or_default();
        assert!(fault.contains("110 of 120 lines at pan 28.6"), "{fault}");
    }

    #[test]
    fn six_lines_missing_in_a_row_are_a_fault_though_few() {
        let gap = |missing: usize, pitch_rad: f64| Quality {
            widest_gap_lines: missing,
            widest_gap_rad: pitch_rad * (missing + 1) as f64,
            line_pitch_rad: pitch_rad,
            ..good()
        };
        let fault = gap(6, 0.0087).fault(0.05).unwrap_or_default();
        assert!(fault.contains("6 lines missing in a row"), "{fault}");
        assert_eq!(gap(2, 0.0087).fault(0.05), None);
        // Wide lines were asked for: what lies between two of them is nobody's fault.
        assert_eq!(gap(0, 0.06).fault(0.05), None);
        assert!(gap(1, 0.06).fault(0.05).is_some());
    }
}
