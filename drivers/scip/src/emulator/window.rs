//! Which steps a request to measure asks for, and in which coding (scip2 sections 6 and 10).

use super::status::ReplyStatus;
use super::wire::decimal;

/// How a value is encoded: by the second letter of the command and, for multiple echoes, by the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ReplyCoding {
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

impl ReplyCoding {
    pub(super) fn from_command_name(name: &[u8]) -> Self {
        match name {
            [_, b'S', ..] => Self::TwoCharacters,
            [b'H' | b'N', b'E', ..] => Self::EchoesWithIntensity,
            [b'H' | b'N', ..] => Self::Echoes,
            [_, b'E', ..] => Self::WithIntensity,
            _ => Self::ThreeCharacters,
        }
    }
}

/// Requested steps and coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StepWindow {
    pub(super) start: usize,
    pub(super) end: usize,
    /// Steps merged into one value, at least 1.
    pub(super) cluster: usize,
    pub(super) coding: ReplyCoding,
}

impl StepWindow {
    /// Reads `<start 4><end 4><cluster 2>`, for a sensor with steps up to `max_step`.
    ///
    /// # Errors
    /// 01, 02, 03 if start, end or cluster is no number; 04 for an end out of range; 05 for an end before the start.
    pub(super) fn parse(
        parameters: &[u8],
        coding: ReplyCoding,
        max_step: u32,
    ) -> Result<Self, ReplyStatus> {
        let field = |from: usize, to: usize, status: u8| {
            parameters
                .get(from..to)
                .and_then(decimal)
                .map(|value| value as usize)
                .ok_or(ReplyStatus::number(status))
        };
        let start = field(0, 4, 1)?;
        let end = field(4, 8, 2)?;
        let cluster = field(8, 10, 3)?.max(1);
        if end > max_step as usize {
            return Err(ReplyStatus::number(4));
        }
        if end < start {
            return Err(ReplyStatus::number(5));
        }
        Ok(Self {
            start,
            end,
            cluster,
            coding,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statuses_of_a_window() {
        let three = ReplyCoding::ThreeCharacters;
        let whole = StepWindow {
            start: 0,
            end: 768,
            cluster: 1,
            coding: three,
        };
        let table = [
            (&b"00440725x1"[..], Err(ReplyStatus::number(3))),
            (b"0044x72501", Err(ReplyStatus::number(2))),
            (b"x044x725x1", Err(ReplyStatus::number(1))),
            (b"0044076901", Err(ReplyStatus::number(4))),
            (b"0044004301", Err(ReplyStatus::number(5))),
            (b"0900076801", Err(ReplyStatus::number(5))),
            (b"0000076800", Ok(whole)),
        ];
        for (parameters, expected) in table {
            assert_eq!(
                StepWindow::parse(parameters, three, 768),
                expected,
                "{}",
                parameters.escape_ascii()
            );
        }
    }
}
