//! Encodes a scan as the lines of a data reply (scip2 sections 4, 6, 7 and 10).

use super::constants::{
    CODE_NOT_MEASURABLE, ECHO_JUMP_MM, INTENSITY_AT_1_M, MAX_THREE_CHARACTERS, MAX_TWO_CHARACTERS,
};
use super::window::{ReplyCoding, StepWindow};
use super::wire;

/// One revolution.
#[derive(Debug, Clone)]
pub(super) struct MeasuredScan {
    pub(super) revolution: u64,
    /// The timer at step 0, ms.
    pub(super) stamp: u32,
    /// Millimetres or codes, for every step from 0 to the last that can be requested.
    pub(super) ranges: Vec<u32>,
}

impl StepWindow {
    /// Appends the stamp line and the data lines of `scan` in this window. A partial last group has a value too (the
    /// protocol leaves it open).
    pub(super) fn push_scan(&self, out: &mut Vec<u8>, scan: &MeasuredScan, min_range_mm: u32) {
        let mut characters = Vec::with_capacity(4);
        wire::push_number(&mut characters, scan.stamp, 4);
        wire::push_summed(out, &characters);
        characters.clear();
        let steps = scan.ranges.get(self.start..=self.end).unwrap_or_default();
        for group in steps.chunks(self.cluster) {
            self.push_value(&mut characters, group, min_range_mm);
        }
        wire::push_data(out, &characters);
    }

    fn push_value(&self, out: &mut Vec<u8>, group: &[u32], min_range_mm: u32) {
        let value = merged(group, min_range_mm);
        let distance = |out: &mut Vec<u8>, value: u32| {
            wire::push_number(out, value.min(MAX_THREE_CHARACTERS), 3);
        };
        let intensity = |out: &mut Vec<u8>, value: u32| {
            wire::push_number(out, intensity(value, min_range_mm), 3);
        };
        match self.coding {
            ReplyCoding::TwoCharacters => wire::push_number(out, value.min(MAX_TWO_CHARACTERS), 2),
            ReplyCoding::ThreeCharacters => distance(out, value),
            ReplyCoding::WithIntensity => {
                distance(out, value);
                intensity(out, value);
            }
            ReplyCoding::Echoes | ReplyCoding::EchoesWithIntensity => {
                for (index, echo) in echoes(group, value, min_range_mm).enumerate() {
                    if index > 0 {
                        out.push(b'&');
                    }
                    distance(out, echo);
                    if self.coding == ReplyCoding::EchoesWithIntensity {
                        intensity(out, echo);
                    }
                }
            }
        }
    }
}

/// The value of a group: its smallest range, or its first code if it has no range (scip2 section 6, cluster).
fn merged(group: &[u32], min_range_mm: u32) -> u32 {
    let smallest = group
        .iter()
        .copied()
        .filter(|value| *value >= min_range_mm)
        .min();
    smallest.or_else(|| group.first().copied()).unwrap_or(0)
}

/// The echoes of a group: the nearest range, and the farthest if it is well behind. The source has one range per step, so
/// a single step has one echo.
fn echoes(group: &[u32], nearest: u32, min_range_mm: u32) -> impl Iterator<Item = u32> {
    let farthest = group.iter().copied().max().unwrap_or(nearest);
    let behind = nearest >= min_range_mm && farthest > nearest.saturating_add(ECHO_JUMP_MM);
    [Some(nearest), behind.then_some(farthest)]
        .into_iter()
        .flatten()
}

/// Intensity of a diffuse surface: falls with the square of the distance (the protocol has no scale, the source no
/// reflectivity). 0 for a code.
fn intensity(range_mm: u32, min_range_mm: u32) -> u32 {
    if range_mm < min_range_mm {
        return 0;
    }
    let range = u64::from(range_mm.max(1));
    let intensity = INTENSITY_AT_1_M * 1_000_000 / (range * range);
    u32::try_from(intensity).map_or(MAX_THREE_CHARACTERS, |intensity| {
        intensity.min(MAX_THREE_CHARACTERS)
    })
}

/// Sets every step outside the measuring window to code 19.
pub(super) fn blank_outside(ranges: &mut [u32], first_step: u32, last_step: u32) {
    let window = first_step as usize..=last_step as usize;
    for (step, range) in ranges.iter_mut().enumerate() {
        if !window.contains(&step) {
            *range = CODE_NOT_MEASURABLE;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(window: StepWindow, ranges: &[u32]) -> String {
        let mut all = vec![0; 769];
        all[..ranges.len()].copy_from_slice(ranges);
        let mut out = Vec::new();
        let scan = MeasuredScan {
            revolution: 0,
            stamp: 0,
            ranges: all,
        };
        window.push_scan(&mut out, &scan, 20);
        String::from_utf8(out[6..].to_vec()).expect("printable")
    }

    fn window(end: usize, cluster: usize, coding: ReplyCoding) -> StepWindow {
        StepWindow {
            start: 0,
            end,
            cluster,
            coding,
        }
    }

    #[test]
    fn a_group_has_its_smallest_range_and_a_code_only_without_one() {
        assert_eq!(merged(&[300, 0, 200], 20), 200);
        assert_eq!(merged(&[7, 19, 20], 20), 20);
        assert_eq!(merged(&[7, 0, 19], 20), 7);
    }

    #[test]
    fn a_partial_group_counts() {
        // 5432 is 1Dh, 1234 in three characters 0CB; byte totals 402 and 181.
        let three = ReplyCoding::ThreeCharacters;
        assert_eq!(
            encoded(window(2, 2, three), &[5432, 5500, 1234]),
            "1Dh0CBB\n"
        );
        assert_eq!(encoded(window(2, 99, three), &[5432, 5500, 1234]), "0CBe\n");
    }

    #[test]
    fn two_characters_end_at_4095() {
        assert_eq!(
            encoded(window(1, 1, ReplyCoding::TwoCharacters), &[4096, 1234]),
            "ooCBS\n"
        );
    }

    #[test]
    fn intensity_follows_each_distance() {
        // 1000 mm is 0?X; its intensity INTENSITY_AT_1_M = 4000 is 0nP. A code has 000.
        let line = encoded(window(1, 1, ReplyCoding::WithIntensity), &[1000, 7]);
        assert_eq!(&line[..12], "0?X0nP007000");
    }

    #[test]
    fn a_second_echo_follows_an_ampersand() {
        let line = encoded(window(3, 2, ReplyCoding::Echoes), &[1234, 5432, 1234, 1240]);
        assert_eq!(&line[..10], "0CB&1Dh0CB");
        let line = encoded(
            window(1, 2, ReplyCoding::EchoesWithIntensity),
            &[1000, 2000],
        );
        assert_eq!(&line[..13], "0?X0nP&0O@0?X");
    }
}
