//! A revolution into the characters of a data reply (protocol sections 4, 6 and 7).

use super::constants::{FIRST_RANGE_MM, LAST_STEP, MAX_THREE_CHARACTERS, MAX_TWO_CHARACTERS};
use super::request::decimal;
use super::state::Status;
use super::wire;

/// One revolution as it was measured.
#[derive(Debug, Clone)]
pub(super) struct Scan {
    pub(super) revolution: u64,
    /// The timer when the head passed step 0.
    pub(super) stamp: u32,
    /// Millimetres or codes of steps `0..=768`.
    pub(super) ranges: Vec<u32>,
}

/// Which steps are asked for, and how they are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) start: usize,
    pub(super) end: usize,
    /// Steps merged into one value, at least 1.
    pub(super) cluster: usize,
    pub(super) two_characters: bool,
}

impl Window {
    /// The window of `<start 4><end 4><cluster 2>`.
    ///
    /// # Errors
    /// 01, 02, 03 where start, end or cluster is no number; 04 for an end out of range; 05 for an end before the start.
    pub(super) fn parse(parameters: &[u8], two_characters: bool) -> Result<Self, Status> {
        let field = |from: usize, to: usize, status: u8| {
            parameters
                .get(from..to)
                .and_then(decimal)
                .map(|value| value as usize)
                .ok_or(Status::number(status))
        };
        let start = field(0, 4, 1)?;
        let end = field(4, 8, 2)?;
        let cluster = field(8, 10, 3)?.max(1);
        if end > LAST_STEP {
            return Err(Status::number(4));
        }
        if end < start {
            return Err(Status::number(5));
        }
        Ok(Self {
            start,
            end,
            cluster,
            two_characters,
        })
    }

    /// The stamp line and the data lines of `scan` in this window. A last group that is not full is told like the
    /// others (the number of values is rounded up; the protocol leaves it open).
    pub(super) fn push_scan(&self, out: &mut Vec<u8>, scan: &Scan) {
        let mut characters = Vec::with_capacity(4);
        wire::push_number(&mut characters, scan.stamp, 4);
        wire::push_summed(out, &characters);
        characters.clear();
        let steps = scan.ranges.get(self.start..=self.end).unwrap_or_default();
        for group in steps.chunks(self.cluster) {
            let value = merged(group);
            if self.two_characters {
                wire::push_number(&mut characters, value.min(MAX_TWO_CHARACTERS), 2);
            } else {
                wire::push_number(&mut characters, value.min(MAX_THREE_CHARACTERS), 3);
            }
        }
        wire::push_data(out, &characters);
    }
}

/// The value of a group: the least range in it, or the first code if there is no range (section 6, cluster).
fn merged(group: &[u32]) -> u32 {
    let least = group
        .iter()
        .copied()
        .filter(|value| *value >= FIRST_RANGE_MM)
        .min();
    least.or_else(|| group.first().copied()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(window: Window, ranges: &[u32]) -> String {
        let mut all = vec![0; LAST_STEP + 1];
        all[..ranges.len()].copy_from_slice(ranges);
        let mut out = Vec::new();
        window.push_scan(
            &mut out,
            &Scan {
                revolution: 0,
                stamp: 0,
                ranges: all,
            },
        );
        String::from_utf8(out[6..].to_vec()).expect("printable")
    }

    fn window(end: usize, cluster: usize, two_characters: bool) -> Window {
        Window {
            start: 0,
            end,
            cluster,
            two_characters,
        }
    }

    #[test]
    fn a_group_tells_its_least_range_and_codes_only_if_alone() {
        assert_eq!(merged(&[300, 0, 200]), 200);
        assert_eq!(merged(&[7, 19, 20]), 20);
        assert_eq!(merged(&[7, 0, 19]), 7);
    }

    #[test]
    fn a_partial_group_counts() {
        // 5432 is 1Dh, 1234 in three characters 0CB; byte totals 402 and 181.
        assert_eq!(told(window(2, 2, false), &[5432, 5500, 1234]), "1Dh0CBB\n");
        assert_eq!(told(window(2, 99, false), &[5432, 5500, 1234]), "0CBe\n");
    }

    #[test]
    fn two_characters_end_at_4095() {
        assert_eq!(told(window(1, 1, true), &[4096, 1234]), "ooCBS\n");
    }

    #[test]
    fn statuses_of_a_window() {
        let table = [
            (&b"00440725x1"[..], Err(Status::number(3))),
            (b"0044x72501", Err(Status::number(2))),
            (b"x044x725x1", Err(Status::number(1))),
            (b"0044076901", Err(Status::number(4))),
            (b"0044004301", Err(Status::number(5))),
            (b"0900076801", Err(Status::number(5))),
            (
                b"0000076800",
                Ok(Window {
                    start: 0,
                    end: 768,
                    cluster: 1,
                    two_characters: false,
                }),
            ),
        ];
        for (parameters, expected) in table {
            assert_eq!(
                Window::parse(parameters, false),
                expected,
                "{}",
                parameters.escape_ascii()
            );
        }
    }
}
