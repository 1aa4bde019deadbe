//! Which steps a scan covers and how its values are sent: common to `GD`, `GS`, `GE`, `MD`, `MS`, `ME`.

use crate::constants::{MAX_CLUSTER, MAX_STEP};
use crate::error::SensorError;
use crate::scan::Coding;

/// Steps, cluster and coding of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// First step wanted.
    pub first_step: u16,
    /// Last step wanted.
    pub last_step: u16,
    /// Steps merged into one value; 0 and 1 mean none.
    pub cluster: u8,
    /// Characters per value.
    pub coding: Coding,
}

impl Span {
    /// Checks that the fields fit their digits and are in order.
    ///
    /// # Errors
    /// [`SensorError::Plan`] naming the field.
    pub fn checked(self) -> Result<Self, SensorError> {
        let plan = |what, expected, got| {
            Err(SensorError::Plan {
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
        } else {
            Ok(self)
        }
    }

    /// Steps per value, at least one.
    #[must_use]
    pub fn steps_per_value(&self) -> usize {
        usize::from(self.cluster.max(1))
    }

    /// Values a scan may have: (least, most). They differ by the partial last group, which devices may send or not
    /// (protocol section 6, cluster).
    #[must_use]
    pub fn value_counts(&self) -> (usize, usize) {
        let steps = usize::from(self.last_step.saturating_sub(self.first_step)) + 1;
        (
            steps / self.steps_per_value(),
            steps.div_ceil(self.steps_per_value()),
        )
    }

    /// Bytes of a reply with `echo_bytes` in its echo line: what a slow link must carry per scan.
    #[must_use]
    pub fn reply_bytes(&self, echo_bytes: usize) -> usize {
        let characters = self.value_counts().1 * self.coding.width();
        let lines = characters.div_ceil(crate::constants::DATA_LINE_CHARACTERS);
        // Echo, status and stamp lines with their LF; data with a sum and LF per line; the empty line.
        (echo_bytes + 1) + 4 + 6 + characters + 2 * lines + 1
    }

    /// The fields as they stand in a request: start 4, end 4, cluster 2 digits.
    #[must_use]
    pub fn digits(&self) -> String {
        format!(
            "{:04}{:04}{:02}",
            self.first_step, self.last_step, self.cluster
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Span = Span {
        first_step: 44,
        last_step: 725,
        cluster: 1,
        coding: Coding::ThreeCharacter,
    };

    #[test]
    fn counts_and_sizes_of_the_protocol() {
        assert_eq!(FULL.value_counts(), (682, 682));
        assert_eq!(FULL.reply_bytes(12), 2134);
        assert_eq!(FULL.reply_bytes(15), 2137);
        assert_eq!(
            Span {
                coding: Coding::TwoCharacter,
                ..FULL
            }
            .reply_bytes(15),
            1435
        );
        assert_eq!(Span { cluster: 2, ..FULL }.reply_bytes(15), 1082);
        assert_eq!(Span { cluster: 0, ..FULL }.value_counts(), (682, 682));
        assert_eq!(Span { cluster: 3, ..FULL }.value_counts(), (227, 228));
        assert_eq!(FULL.digits(), "0044072501");
    }

    #[test]
    fn impossible_spans_are_named() {
        assert!(FULL.checked().is_ok());
        assert!(matches!(
            Span {
                first_step: 726,
                ..FULL
            }
            .checked(),
            Err(SensorError::Plan {
                what: "first step",
                ..
            })
        ));
        assert!(matches!(
            Span {
                cluster: 100,
                ..FULL
            }
            .checked(),
            Err(SensorError::Plan {
                what: "cluster",
                ..
            })
        ));
        assert!(matches!(
            Span {
                last_step: 10_000,
                ..FULL
            }
            .checked(),
            Err(SensorError::Plan {
                what: "last step",
                ..
            })
        ));
    }
}
