//! Parsing of a reply line: success or refusal, and the number or text after it (ptu-d46 sections 2 to 4).

/// A line split at its first `*` or `! `.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ParsedReply<'a> {
    /// What came before the marker: an echo, or line noise.
    pub(crate) before: &'a [u8],
    pub(crate) outcome: ReplyOutcome<'a>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ReplyOutcome<'a> {
    /// `*`, with the text after it.
    Success(&'a str),
    /// `! `, with the unit's text, which is never interpreted (ptu-d46 section 4).
    Refusal(&'a str),
    /// Unprintable bytes after the marker.
    Garbled,
    /// No marker.
    Unmarked,
}

/// Splits a line.
pub(crate) fn parse(line: &[u8]) -> ParsedReply<'_> {
    let begins = |i: usize| line.get(i) == Some(&b'*') || line.get(i..i + 2) == Some(b"! ");
    let Some(at) = (0..line.len()).find(|i| begins(*i)) else {
        return ParsedReply {
            before: line,
            outcome: ReplyOutcome::Unmarked,
        };
    };
    let (before, marked) = line.split_at(at);
    let (marker, rest) = marked.split_at(1.min(marked.len()));
    let text = if rest.iter().all(|b| (0x20..0x7f).contains(b)) {
        std::str::from_utf8(rest).ok()
    } else {
        None
    };
    let outcome = match text.map(str::trim) {
        None => ReplyOutcome::Garbled,
        Some(text) if marker == b"*" => ReplyOutcome::Success(text),
        Some(text) => ReplyOutcome::Refusal(text),
    };
    ParsedReply { before, outcome }
}

impl ParsedReply<'_> {
    /// Whether the command itself came back before the marker, in any case.
    pub(crate) fn echoes(&self, command: &str) -> bool {
        let before = self.before.trim_ascii();
        let tail = before
            .len()
            .checked_sub(command.len())
            .and_then(|from| before.get(from..));
        !command.is_empty()
            && tail.is_some_and(|tail| tail.eq_ignore_ascii_case(command.as_bytes()))
    }
}

/// A number, and whether a phrase surrounds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Number {
    pub(crate) value: f64,
    pub(crate) verbose: bool,
}

/// The number of a success: alone (terse) or in a phrase (verbose). `None` if there is none, or two: then two replies have run
/// into each other.
pub(crate) fn number(text: &str) -> Option<Number> {
    let mut value = None;
    let mut words = 0_usize;
    for word in text.split_ascii_whitespace() {
        words += 1;
        let numeric =
            word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'));
        if word.contains('*') || (numeric && value.is_some()) {
            return None;
        }
        if numeric {
            value = Some(decimal(word)?);
        }
    }
    value.map(|value| Number {
        value,
        verbose: words > 1,
    })
}

/// Which of two keywords a text contains: `Some(true)` for the wanted one. Whole words in any case; failing that, the first letter
/// of the text (ptu-d46 section 3, row `C`).
pub(crate) fn keyword(text: &str, wanted: &str, other: &str) -> Option<bool> {
    let mut words = text.split(|c: char| !c.is_ascii_alphabetic());
    let named = words.find_map(|word| {
        let is = |name: &str| word.eq_ignore_ascii_case(name);
        if is(wanted) {
            Some(true)
        } else {
            is(other).then_some(false)
        }
    });
    let begins = |name: &str| {
        text.get(..1)
            .zip(name.get(..1))
            .is_some_and(|(a, b)| a.eq_ignore_ascii_case(b))
    };
    named.or_else(|| {
        if begins(wanted) {
            Some(true)
        } else {
            begins(other).then_some(false)
        }
    })
}

/// A plain signed decimal, nothing else (no exponent, no `inf`).
fn decimal(word: &str) -> Option<f64> {
    let digits = word.strip_prefix(['-', '+']).unwrap_or(word);
    let plain = digits.starts_with(|c: char| c.is_ascii_digit())
        && digits.bytes().all(|b| b.is_ascii_digit() || b == b'.')
        && digits.len() <= 12;
    if plain { word.parse().ok() } else { None }
}

/// All numbers of a text, for supply and temperature: separated by spaces or commas.
pub(crate) fn all_numbers(text: &str) -> Vec<f64> {
    text.split([' ', ',']).filter_map(decimal).collect()
}

/// A whole number in the range of a position or speed.
pub(crate) fn integer(value: f64) -> Option<i32> {
    let fits = value.fract() == 0.0 && value >= f64::from(i32::MIN) && value <= f64::from(i32::MAX);
    fits.then_some(value as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(line: &str) -> Option<f64> {
        match parse(line.as_bytes()).outcome {
            ReplyOutcome::Success(text) => number(text).map(|n| n.value),
            _ => None,
        }
    }

    /// The numeric replies of ptu-d46 section 3.
    const NUMERIC: [(&str, f64); 20] = [
        ("* Current Pan position is -2500", -2500.0),
        ("* Current Tilt position is 12", 12.0),
        ("* Target Pan position is -500", -500.0),
        ("* Current pan position is 7", 7.0),
        ("* Minimum Pan position is -3090", -3090.0),
        ("* Maximum Tilt position is 604", 604.0),
        ("* 185.1428 seconds arc per Pan position", 185.1428),
        ("* 46.2857 seconds arc per position", 46.2857),
        ("* Target Pan speed is 1000 positions/sec", 1000.0),
        ("* Desired Pan speed is 1000 positions/sec", 1000.0),
        ("* Current Pan speed is 450 positions/sec", 450.0),
        ("* Pan acceleration is 2000 positions/sec^2", 2000.0),
        ("* Current Pan base speed is 1000 positions/sec", 1000.0),
        ("* Base Pan speed is 1000 positions/sec", 1000.0),
        ("* Maximum Pan speed is 2902 positions/sec", 2902.0),
        ("* Minimum Pan speed is 31 positions/sec", 31.0),
        ("* Unit ID is 0", 0.0),
        ("* -1234", -1234.0),
        ("* 185.1428", 185.1428),
        ("* 0", 0.0),
    ];

    #[test]
    fn every_numeric_reply_is_read_with_and_without_echo() {
        for (line, wanted) in NUMERIC {
            assert_eq!(value(line), Some(wanted), "{line}");
            let echoed = format!("PP {line}");
            assert_eq!(value(&echoed), Some(wanted), "{echoed}");
            assert!(parse(echoed.as_bytes()).echoes("PP"));
            assert!(!parse(line.as_bytes()).echoes("PP"));
        }
    }

    #[test]
    fn terse_is_a_number_alone() {
        let verbose = |text| number(text).expect("a number").verbose;
        assert!(!verbose("-1234"));
        assert!(!verbose("185.1428"));
        assert!(verbose("185.1428 seconds arc per Pan position"));
        assert!(verbose("Current Pan position is -2500"));
    }

    #[test]
    fn refusals_are_recognised_by_their_marker() {
        for text in [
            "Maximum allowable Pan position is 3090",
            "Minimum allowable Tilt position is -903",
            "Pan speed cannot exceed 2902 positions/sec",
            "Motor speed cannot be less than 31 pos/sec",
            "Axis Error",
            "Illegal command",
        ] {
            assert_eq!(
                parse(format!("! {text}").as_bytes()).outcome,
                ReplyOutcome::Refusal(text)
            );
            assert_eq!(
                parse(format!("PS9999 ! {text}").as_bytes()).outcome,
                ReplyOutcome::Refusal(text)
            );
        }
    }

    #[test]
    fn damaged_lines_give_no_number() {
        for line in [
            "* 1x00",
            "*",
            "1234",
            "* 1* 2",
            "* 12 34",
            "* --5",
            "* 1e9",
            "* nan",
            "* 9999999999999",
        ] {
            assert_eq!(value(line), None, "{line}");
        }
        assert_eq!(parse(b"* 1\xff00").outcome, ReplyOutcome::Garbled);
        assert_eq!(parse(b"1234").outcome, ReplyOutcome::Unmarked);
        assert_eq!(
            value("\u{fffd}* 100"),
            Some(100.0),
            "noise before the marker does no harm"
        );
        assert_eq!(integer(1.5), None);
        assert_eq!(integer(1e12), None);
    }

    #[test]
    fn mode_texts_of_every_firmware() {
        for (text, wanted, other, is) in [
            ("Echoing ON", "off", "on", false),
            ("Echoing OFF", "off", "on", true),
            ("ASCII verbose mode", "terse", "verbose", false),
            ("ASCII terse mode", "terse", "verbose", true),
            (
                "independent (default) speed control mode",
                "independent",
                "pure",
                true,
            ),
            (
                "Independent speed control mode",
                "independent",
                "pure",
                true,
            ),
            (
                "Pure Velocity speed control mode",
                "independent",
                "pure",
                false,
            ),
            ("i", "independent", "pure", true),
            (
                "Limit bounds are ENABLED (soft limits enabled)",
                "enabled",
                "disabled",
                true,
            ),
            (
                "Limit bounds are DISABLED (hard limits only: use care)",
                "enabled",
                "disabled",
                false,
            ),
        ] {
            assert_eq!(keyword(text, wanted, other), Some(is), "{text}");
        }
        assert_eq!(keyword("22", "off", "on"), None);
        assert_eq!(keyword("", "off", "on"), None);
    }

    #[test]
    fn echo_is_the_command_itself() {
        assert!(parse(b"ED *").echoes("ED"));
        assert!(parse(b"pp * 22").echoes("PP"));
        assert!(parse(b"PS97 *").echoes("PS97"));
        assert!(!parse(b"TP * 22").echoes("PP"));
        assert!(!parse(b"*").echoes("PP"));
    }
}
