//! How good a sweep is: the figures that the verdict reads.

use super::constants::LEAST_HIT_SHARE;
use serde::{Deserialize, Serialize};

/// Quality figures of one sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Lines that the plan asks for.
    pub lines_expected: usize,
    /// Lines that came.
    pub lines_got: usize,
    /// Places where scans between two others are missing.
    pub gaps: usize,
    /// Share of beams that hit something.
    pub hit_share: f64,
    /// Share of beams with nothing there.
    pub no_return_share: f64,
    /// Largest distance of a position poll from the fitted motion, counts.
    pub position_residual_steps: f64,
    /// Bound of the clock offset's error, seconds.
    pub clock_uncertainty_s: f64,
    /// Host seconds per laser second.
    pub clock_rate: f64,
    /// Whether scans repeat each other.
    pub frozen: bool,
}

impl Quality {
    /// Why the sweep must not be judged, nor become a reference; `None` where it is good.
    pub fn fault(&self, max_missing_lines: f64) -> Option<String> {
        let missing = 1.0 - self.lines_got as f64 / self.lines_expected.max(1) as f64;
        if self.frozen {
            return Some("frozen laser data: scans repeat each other".to_owned());
        }
        if self.lines_got == 0 || missing > max_missing_lines {
            return Some(format!(
                "incomplete sweep: {} of {} lines",
                self.lines_got, self.lines_expected
            ));
        }
        if self.hit_share < LEAST_HIT_SHARE {
            return Some(format!(
                "blind laser: {:.1} % of the beams hit anything; is the lens covered?",
                100.0 * self.hit_share
            ));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::Quality;

    fn good() -> Quality {
        Quality {
            lines_expected: 120,
            lines_got: 119,
            gaps: 1,
            hit_share: 0.6,
            no_return_share: 0.3,
            position_residual_steps: 0.4,
            clock_uncertainty_s: 5e-4,
            clock_rate: 0.9987,
            frozen: false,
        }
    }

    #[test]
    fn each_fault_has_its_word() {
        assert_eq!(good().fault(0.05), None);
        let fault = |q: Quality| q.fault(0.05).unwrap_or_default();
        assert!(
            fault(Quality {
                lines_got: 100,
                ..good()
            })
            .contains("100 of 120 lines")
        );
        assert!(
            fault(Quality {
                frozen: true,
                ..good()
            })
            .contains("frozen")
        );
        assert!(
            fault(Quality {
                hit_share: 0.01,
                ..good()
            })
            .contains("blind")
        );
    }
}
