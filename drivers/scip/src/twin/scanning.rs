//! A revolution into the characters of a data reply (protocol sections 4, 6, 7 and 10).

use super::constants::{
    CODE_NOT_MEASURABLE, ECHO_JUMP_MM, INTENSITY_AT_1_M, MAX_THREE_CHARACTERS, MAX_TWO_CHARACTERS,
};
use super::request::decimal;
use super::state::Status;
use super::wire;

/// One revolution as it was measured.
#[derive(Debug, Clone)]
pub(super) struct Scan {
    pub(super) revolution: u64,
    /// The timer when the head passed step 0.
    pub(super) stamp: u32,
    /// Millimetres or codes of every step that can be asked for.
    pub(super) ranges: Vec<u32>,
}

/// How the value of a step is told: by the second letter of the command and, for several echoes, by the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    /// `GS`, `MS`.
    TwoCharacters,
    /// `GD`, `MD`.
    ThreeCharacters,
    /// `GE`, `ME`: distance and intensity.
    WithIntensity,
    /// `HD`, `ND`: further echoes after `&`.
    Echoes,
    /// `HE`, `NE`.
    EchoesWithIntensity,
}

impl Coding {
    /// The coding that a measuring command asks for.
    pub(super) fn of(name: &[u8]) -> Self {
        match name {
            [_, b'S', ..] => Self::TwoCharacters,
            [b'H' | b'N', b'E', ..] => Self::EchoesWithIntensity,
            [b'H' | b'N', ..] => Self::Echoes,
            [_, b'E', ..] => Self::WithIntensity,
            _ => Self::ThreeCharacters,
        }
    }
}

/// Which steps are asked for, and how they are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) start: usize,
    pub(super) end: usize,
    /// Steps merged into one value, at least 1.
    pub(super) cluster: usize,
    pub(super) coding: Coding,
}

impl Window {
    /// The window of `<start 4><end 4><cluster 2>` of a sensor that has steps up to `max_step`.
    ///
    /// # Errors
    /// 01, 02, 03 where start, end or cluster is no number; 04 for an end out of range; 05 for an end before the start.
    pub(super) fn parse(parameters: &[u8], coding: Coding, max_step: u32) -> Result<Self, Status> {
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
        if end > max_step as usize {
            return Err(Status::number(4));
        }
        if end < start {
            return Err(Status::number(5));
        }
        Ok(Self {
            start,
            end,
            cluster,
            coding,
        })
    }

    /// The stamp line and the data lines of `scan` in this window, of a sensor whose ranges begin at `min_range_mm`. A
    /// last group that is not full is told like the others (the number of values is rounded up; the protocol leaves it
    /// open).
    pub(super) fn push_scan(&self, out: &mut Vec<u8>, scan: &Scan, min_range_mm: u32) {
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
            Coding::TwoCharacters => wire::push_number(out, value.min(MAX_TWO_CHARACTERS), 2),
            Coding::ThreeCharacters => distance(out, value),
            Coding::WithIntensity => {
                distance(out, value);
                intensity(out, value);
            }
            Coding::Echoes | Coding::EchoesWithIntensity => {
                for (index, echo) in echoes(group, value, min_range_mm).enumerate() {
                    if index > 0 {
                        out.push(b'&');
                    }
                    distance(out, echo);
                    if self.coding == Coding::EchoesWithIntensity {
                        intensity(out, echo);
                    }
                }
            }
        }
    }
}

/// The value of a group: the least range in it, or the first code if there is no range (section 6, cluster).
fn merged(group: &[u32], min_range_mm: u32) -> u32 {
    let least = group
        .iter()
        .copied()
        .filter(|value| *value >= min_range_mm)
        .min();
    least.or_else(|| group.first().copied()).unwrap_or(0)
}

/// The echoes of a group: its nearest thing, and its farthest where that lies well behind. The surroundings tell one
/// range per step, so a single step has one echo.
fn echoes(group: &[u32], nearest: u32, min_range_mm: u32) -> impl Iterator<Item = u32> {
    let farthest = group.iter().copied().max().unwrap_or(nearest);
    let behind = nearest >= min_range_mm && farthest > nearest.saturating_add(ECHO_JUMP_MM);
    [Some(nearest), behind.then_some(farthest)]
        .into_iter()
        .flatten()
}

/// Light that comes back from a matt thing: it falls with the square of the distance (the protocol has no scale; the
/// surroundings do not tell how bright things are). A code has none.
fn intensity(range_mm: u32, min_range_mm: u32) -> u32 {
    if range_mm < min_range_mm {
        return 0;
    }
    let range = u64::from(range_mm.max(1));
    let light = INTENSITY_AT_1_M * 1_000_000 / (range * range);
    u32::try_from(light).map_or(MAX_THREE_CHARACTERS, |light| {
        light.min(MAX_THREE_CHARACTERS)
    })
}

/// Code 19 for every step outside the measuring window.
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

    fn told(window: Window, ranges: &[u32]) -> String {
        let mut all = vec![0; 769];
        all[..ranges.len()].copy_from_slice(ranges);
        let mut out = Vec::new();
        let scan = Scan {
            revolution: 0,
            stamp: 0,
            ranges: all,
        };
        window.push_scan(&mut out, &scan, 20);
        String::from_utf8(out[6..].to_vec()).expect("printable")
    }

    fn window(end: usize, cluster: usize, coding: Coding) -> Window {
        Window {
            start: 0,
            end,
            cluster,
            coding,
        }
    }

    #[test]
    fn a_group_tells_its_least_range_and_codes_only_if_alone() {
        assert_eq!(merged(&[300, 0, 200], 20), 200);
        assert_eq!(merged(&[7, 19, 20], 20), 20);
        assert_eq!(merged(&[7, 0, 19], 20), 7);
    }

    #[test]
    fn a_partial_group_counts() {
        // 5432 is 1Dh, 1234 in three characters 0CB; byte totals 402 and 181.
        let three = Coding::ThreeCharacters;
        assert_eq!(told(window(2, 2, three), &[5432, 5500, 1234]), "1Dh0CBB\n");
        assert_eq!(told(window(2, 99, three), &[5432, 5500, 1234]), "0CBe\n");
    }

    #[test]
    fn two_characters_end_at_4095() {
        assert_eq!(
            told(window(1, 1, Coding::TwoCharacters), &[4096, 1234]),
            "ooCBS\n"
        );
    }

    #[test]
    fn intensity_follows_each_distance() {
        // 1000 mm is 0?X; its light INTENSITY_AT_1_M = 4000 is 0nP. A code has light 000.
        let line = told(window(1, 1, Coding::WithIntensity), &[1000, 7]);
        assert_eq!(&line[..12], "0?X0nP007000");
    }

    #[test]
    fn a_second_echo_stands_behind_an_ampersand() {
        let line = told(window(3, 2, Coding::Echoes), &[1234, 5432, 1234, 1240]);
        assert_eq!(&line[..10], "0CB&1Dh0CB");
        let line = told(window(1, 2, Coding::EchoesWithIntensity), &[1000, 2000]);
        assert_eq!(&line[..13], "0?X0nP&0O@0?X");
    }

    #[test]
    fn statuses_of_a_window() {
        let three = Coding::ThreeCharacters;
        let table = [
            (&b"00440725x1"[..], Err(Status::number(3))),
            (b"0044x72501", Err(Status::number(2))),
            (b"x044x725x1", Err(Status::number(1))),
            (b"0044076901", Err(Status::number(4))),
            (b"0044004301", Err(Status::number(5))),
            (b"0900076801", Err(Status::number(5))),
            (b"0000076800", Ok(window(768, 1, three))),
        ];
        for (parameters, expected) in table {
            assert_eq!(
                Window::parse(parameters, three, 768),
                expected,
                "{}",
                parameters.escape_ascii()
            );
        }
    }
}
