//! Which steps a scan covers, and how its values are sent.

use crate::constants::DATA_LINE_CHARACTERS;
use crate::scan::ValueCoding;

/// Steps, cluster and coding of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanSpan {
    /// First step.
    pub first_step: u16,
    /// Last step, included.
    pub last_step: u16,
    /// Steps merged into one value; 0 and 1 mean none.
    pub cluster: u8,
    /// Characters per value.
    pub coding: ValueCoding,
}

impl ScanSpan {
    fn steps_per_value(&self) -> usize {
        usize::from(self.cluster.max(1))
    }

    /// Minimum and maximum number of values. They differ by the partial last group, which devices may send or not
    /// (scip2 section 6, cluster).
    pub(crate) fn value_counts(&self) -> (usize, usize) {
        let steps = usize::from(self.last_step.saturating_sub(self.first_step)) + 1;
        (
            steps / self.steps_per_value(),
            steps.div_ceil(self.steps_per_value()),
        )
    }

    /// Bytes of a scan's reply whose echo line has `echo_bytes`.
    #[must_use]
    pub fn reply_bytes(&self, echo_bytes: usize) -> usize {
        let characters = self.value_counts().1 * self.coding.width();
        let lines = characters.div_ceil(DATA_LINE_CHARACTERS);
        // Echo, status and stamp lines with their LF; data with a sum and LF per line; the empty line.
        (echo_bytes + 1) + 4 + 6 + characters + 2 * lines + 1
    }

    /// The fields of a request: start 4, end 4, cluster 2 digits.
    pub(super) fn digits(&self) -> String {
        format!(
            "{:04}{:04}{:02}",
            self.first_step, self.last_step, self.cluster
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: ScanSpan = ScanSpan {
        first_step: 44,
        last_step: 725,
        cluster: 1,
        coding: ValueCoding::ThreeCharacter,
    };

    #[test]
    fn counts_and_sizes_of_the_protocol() {
        assert_eq!(FULL.value_counts(), (682, 682));
        assert_eq!(FULL.reply_bytes(12), 2134);
        assert_eq!(FULL.reply_bytes(15), 2137);
        assert_eq!(
            ScanSpan {
                coding: ValueCoding::TwoCharacter,
                ..FULL
            }
            .reply_bytes(15),
            1435
        );
        assert_eq!(ScanSpan { cluster: 2, ..FULL }.reply_bytes(15), 1082);
        assert_eq!(ScanSpan { cluster: 0, ..FULL }.value_counts(), (682, 682));
        assert_eq!(ScanSpan { cluster: 3, ..FULL }.value_counts(), (227, 228));
        assert_eq!(FULL.digits(), "0044072501");
    }
}
