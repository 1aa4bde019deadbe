//! Numbers as the tools of this field write them.

/// Spellings of "no number" in tables, besides `nan` and those of Microsoft's C library; lower case.
const MISSING: [&[u8]; 4] = [b"na", b"n/a", b"null", b"none"];
/// Longest word that is read as a number: the shortest decimals of every double have at most 25 characters, and some tools
/// print all 330 digits.
const MAX_NUMBER_BYTES: usize = 400;

/// A number as C, Rust, Fortran (`1.5D+00`) and spreadsheets write it; NaN for `nan`, `-nan(ind)`, `1.#QNAN`, `NA` and their
/// like, infinite for `inf` and `1.#INF`. `None` for anything else.
pub(super) fn parse_number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    if word.is_empty() || word.len() > MAX_NUMBER_BYTES {
        return None;
    }
    let lower = text.to_ascii_lowercase();
    if MISSING.contains(&lower.as_bytes()) {
        return Some(f64::NAN);
    }
    let unsigned = lower.strip_prefix(['-', '+']).unwrap_or(&lower);
    if let Some(kind) = unsigned.strip_prefix("1.#") {
        let is_infinite = kind.starts_with("inf");
        let is_nan = ["qnan", "snan", "ind", "nan"].map(|k| kind.starts_with(k));
        return match (is_infinite, is_nan.contains(&true)) {
            (true, _) => Some(f64::INFINITY.copysign(if unsigned == lower { 1.0 } else { -1.0 })),
            (false, true) => Some(f64::NAN),
            (false, false) => None,
        };
    }
    if let Some(kind) = unsigned.strip_prefix("nan(") {
        return kind.ends_with(')').then_some(f64::NAN);
    }
    // Fortran's exponent of a double.
    let is_fortran = lower
        .bytes()
        .all(|b| b.is_ascii_digit() || b"+-.d".contains(&b));
    is_fortran.then(|| lower.replacen('d', "e", 1).parse().ok())?
}

/// A number with a decimal comma; see [`parse_number`].
pub(super) fn parse_decimal_comma(word: &[u8]) -> Option<f64> {
    let mut with_point = [0; MAX_NUMBER_BYTES];
    let copy = with_point.get_mut(..word.len())?;
    copy.copy_from_slice(word);
    if copy.contains(&b'.') {
        return None;
    }
    if let Some(comma) = copy.iter_mut().find(|b| **b == b',') {
        *comma = b'.';
    }
    parse_number(copy)
}

#[cfg(test)]
mod tests {
    use super::{parse_decimal_comma, parse_number};

    #[test]
    fn every_spelling_of_a_number_is_read() {
        for (word, expected) in [
            ("1.5", 1.5),
            ("+1.5e-3", 0.0015),
            ("-3.5D+01", -35.0),
            ("2d0", 2.0),
            ("inf", f64::INFINITY),
            ("1.#INF", f64::INFINITY),
            ("-1.#INF00", f64::NEG_INFINITY),
        ] {
            assert_eq!(parse_number(word.as_bytes()), Some(expected), "{word}");
        }
        for word in [
            "nan",
            "NaN",
            "-nan",
            "-nan(ind)",
            "nan(0x7ff8)",
            "1.#QNAN",
            "-1.#IND00",
            "1.#SNAN",
            "NA",
            "n/a",
            "NULL",
            "None",
        ] {
            let number = parse_number(word.as_bytes());
            assert!(number.is_some_and(f64::is_nan), "{word}");
        }
        for word in [
            "", "x", "1,5", "1.#", "1.#X", "nan(", "dd", "1d2d3", "0x10", "1_0", "d",
        ] {
            assert_eq!(parse_number(word.as_bytes()), None, "{word}");
        }
        assert_eq!(parse_number(&[b'9'; 5000]), Some(f64::INFINITY));
        assert_eq!(parse_number(&[b'd'; 5000]), None);
    }

    #[test]
    fn a_decimal_comma_stands_for_the_point() {
        for (word, expected) in [
            ("3,25", Some(3.25)),
            ("-0,5e1", Some(-5.0)),
            ("7", Some(7.0)),
        ] {
            assert_eq!(parse_decimal_comma(word.as_bytes()), expected, "{word}");
        }
        for word in ["3.198,100", "1,2,3", "1.5", ""] {
            assert_eq!(parse_decimal_comma(word.as_bytes()), None, "{word}");
        }
        assert_eq!(parse_decimal_comma(&[b'9'; 5000]), None);
    }
}
