//! How good the raw data of a sweep are.

use super::constants::{
    MAX_BLIND_LINES, MAX_DISPLACEMENT_PITCHES, MAX_GAP_PITCHES, MAX_GAP_RAD, MIN_HIT_SHARE,
};
use super::lines::PanSegmentLines;
use serde::{Deserialize, Serialize};

/// How good the raw data of a sweep are. Stored and reported as JSON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepQuality {
    /// Lines of the plan.
    pub lines_expected: usize,
    /// Lines measured, in each pan segment at most those of the plan.
    pub lines_got: usize,
    /// Number of times that scans between two others are missing.
    pub gaps: usize,
    /// Most lines missing in a row.
    pub widest_gap_lines: usize,
    /// Widest angle without a line inside the tilt range of any pan segment, radians.
    pub widest_gap_rad: f64,
    /// Planned angle between lines, radians.
    pub line_pitch_rad: f64,
    /// The lines of each pan segment.
    #[serde(rename = "legs")]
    pub pan_segments: Vec<PanSegmentLines>,
    /// Share of beams with a return.
    pub hit_share: f64,
    /// Share of beams of which nothing came back.
    pub no_return_share: f64,
    /// Largest distance of a position poll from the fitted motion, counts.
    pub position_residual_steps: f64,
    /// The same, radians.
    pub position_residual_rad: f64,
    /// Bound of the error of the clock offset, seconds.
    pub clock_uncertainty_s: f64,
    /// Tilt of the head in that time, radians.
    pub clock_uncertainty_rad: f64,
    /// Host seconds per laser second.
    pub clock_rate: f64,
    /// Whether scans repeat each other.
    pub frozen: bool,
    /// Lines with a blind sector; 0 in older records, which lack the key.
    #[serde(default)]
    pub blind_lines: usize,
}

impl SweepQuality {
    /// Why the sweep must neither be compared nor become a reference; `None` if it is good. `max_missing_lines` is the largest
    /// share of lines that any pan segment may miss.
    pub fn fault(&self, max_missing_lines: f64) -> Option<String> {
        if self.frozen {
            return Some("frozen laser data: scans repeat each other".to_owned());
        }
        self.incomplete(max_missing_lines)
            .or_else(|| self.displaced())
            .or_else(|| {
                let sees = self.hit_share >= MIN_HIT_SHARE;
                (!sees).then(|| {
                    format!(
                        "blind laser: {:.1} % of the beams hit anything; is the lens covered?",
                        100.0 * self.hit_share
                    )
                })
            })
            .or_else(|| {
                let sees = self.blind_lines < MAX_BLIND_LINES;
                (!sees).then(|| {
                    format!(
                        "blind laser: {} lines have no measurement in a whole sector; is the lens covered in part?",
                        self.blind_lines
                    )
                })
            })
    }

    fn incomplete(&self, max_missing_lines: f64) -> Option<String> {
        let all = PanSegmentLines {
            pan_rad: 0.0,
            expected: self.lines_expected,
            got: self.lines_got,
        };
        if !all.is_complete(max_missing_lines) {
            return Some(format!(
                "incomplete sweep: {} of {} lines",
                all.got, all.expected
            ));
        }
        if let Some(segment) = self
            .pan_segments
            .iter()
            .find(|lines| !lines.is_complete(max_missing_lines))
        {
            return Some(format!(
                "incomplete sweep: {} of {} lines at pan {:.1} deg",
                segment.got,
                segment.expected,
                segment.pan_rad.to_degrees()
            ));
        }
        let max_rad = MAX_GAP_RAD.max(MAX_GAP_PITCHES * self.line_pitch_rad);
        let dense = self.widest_gap_rad <= max_rad;
        (!dense).then(|| {
            format!(
                "gap in the sweep: {} lines missing in a row, {:.1} deg without any",
                self.widest_gap_lines,
                self.widest_gap_rad.to_degrees()
            )
        })
    }

    /// Whether the clock or the head is too uncertain for the distance of the lines.
    fn displaced(&self) -> Option<String> {
        let max_rad = MAX_DISPLACEMENT_PITCHES * self.line_pitch_rad;
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
        // NaN is no proof of quality: it must not pass.
        let (rad, reason) = reasons.into_iter().find(|(rad, _)| {
            let small = *rad <= max_rad;
            !small
        })?;
        Some(format!(
            "{}, {:.2} deg of tilt at lines {:.2} deg apart",
            reason,
            rad.to_degrees(),
            self.line_pitch_rad.to_degrees()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::SweepQuality;
    use crate::sweep::PanSegmentLines;

    fn lines(expected: usize, got: usize) -> PanSegmentLines {
        PanSegmentLines {
            pan_rad: 0.5,
            expected,
            got,
        }
    }

    fn good() -> SweepQuality {
        SweepQuality {
            lines_expected: 240,
            lines_got: 239,
            gaps: 1,
            widest_gap_lines: 1,
            widest_gap_rad: 0.0174,
            line_pitch_rad: 0.0087,
            pan_segments: vec![lines(120, 120), lines(120, 119)],
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
    fn each_fault_is_reported() {
        assert_eq!(good().fault(0.05), None);
        let check = |spoil: &dyn Fn(&mut SweepQuality), text: &str| {
            let mut quality = good();
            spoil(&mut quality);
            let fault = quality.fault(0.05).unwrap_or_default();
            assert!(fault.contains(text), "{fault:?} instead of {text:?}");
        };
        check(&|q| q.lines_got = 200, "200 of 240 lines");
        check(&|q| q.frozen = true, "frozen");
        check(&|q| q.hit_share = 0.01, "blind");
        check(&|q| q.hit_share = f64::NAN, "blind");
        check(&|q| q.blind_lines = 10, "covered in part");
        check(&|q| q.clock_uncertainty_rad = 0.009, "uncertain clock");
        check(&|q| q.position_residual_rad = 0.009, "uncertain head");
        check(&|q| q.position_residual_rad = f64::NAN, "uncertain head");
    }

    #[test]
    fn lines_of_one_pan_do_not_replace_those_of_another() {
        let quality = SweepQuality {
            lines_got: 230,
            pan_segments: vec![lines(120, 120), lines(120, 110)],
            ..good()
        };
        let fault = quality.fault(0.05).unwrap_or_default();
        assert!(fault.contains("110 of 120 lines at pan 28.6"), "{fault}");
    }

    #[test]
    fn six_lines_missing_in_a_row_are_a_fault_though_few() {
        let gap = |missing: usize, pitch_rad: f64| SweepQuality {
            widest_gap_lines: missing,
            widest_gap_rad: pitch_rad * (missing + 1) as f64,
            line_pitch_rad: pitch_rad,
            ..good()
        };
        let fault = gap(6, 0.0087).fault(0.05).unwrap_or_default();
        assert!(fault.contains("6 lines missing in a row"), "{fault}");
        assert_eq!(gap(2, 0.0087).fault(0.05), None);
        // A wide pitch was planned: what lies between two lines is no fault.
        assert_eq!(gap(0, 0.06).fault(0.05), None);
        assert!(gap(1, 0.06).fault(0.05).is_some());
    }
}
