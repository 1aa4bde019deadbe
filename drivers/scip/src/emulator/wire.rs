//! Characters and sums (scip2 sections 3 and 4), independent of the driver's.

use super::profile::KeyedSumRule;

/// Values of a full data line (scip2 section 6, data lines).
const DATA_LINE_CHARACTERS: usize = 64;

/// All bytes added, the low six bits, plus 0x30.
pub(super) fn sum(line: &[u8]) -> u8 {
    let total = line
        .iter()
        .fold(0u8, |total, byte| total.wrapping_add(*byte));
    (total & 0x3F) + 0x30
}

/// Appends `value` as `characters` six-bit groups, the highest first.
pub(super) fn push_number(out: &mut Vec<u8>, value: u32, characters: u32) {
    for group in (0..characters).rev() {
        out.push(((value >> (6 * group)) & 0x3F) as u8 + 0x30);
    }
}

/// Appends a status, stamp or data line, whose sum covers every character.
pub(super) fn push_summed(out: &mut Vec<u8>, line: &[u8]) {
    out.extend_from_slice(line);
    out.push(sum(line));
    out.push(b'\n');
}

/// Appends `KEY:value;<sum>`.
pub(super) fn push_keyed(out: &mut Vec<u8>, text: &str, rule: KeyedSumRule) {
    let line = format!("{text};");
    let sum = sum(match rule {
        KeyedSumRule::BeforeSemicolon => text,
        KeyedSumRule::WithSemicolon => &line,
        KeyedSumRule::BeforeComment => text.split_once("<-").map_or(text, |(before, _)| before),
    }
    .as_bytes());
    out.extend_from_slice(line.as_bytes());
    out.push(sum);
    out.push(b'\n');
}

/// Appends encoded values cut into lines of 64 characters.
pub(super) fn push_data(out: &mut Vec<u8>, characters: &[u8]) {
    for line in characters.chunks(DATA_LINE_CHARACTERS) {
        push_summed(out, line);
    }
}

/// A decimal number of digits only.
pub(super) fn decimal(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0u32, |value, digit| {
        let digit = digit.is_ascii_digit().then(|| u32::from(digit - b'0'))?;
        value.checked_mul(10)?.checked_add(digit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: u32, characters: u32) -> String {
        let mut out = Vec::new();
        push_number(&mut out, value, characters);
        String::from_utf8(out).expect("printable")
    }

    #[test]
    fn sums_of_section_3() {
        let table = [
            ("00", 'P'),
            ("99", 'b'),
            ("01", 'Q'),
            ("10", 'Q'),
            ("02", 'R'),
            ("03", 'S'),
            ("04", 'T'),
            ("05", 'U'),
            ("98", 'a'),
            ("0C", 'c'),
            ("0E", 'e'),
            ("JUGn", 'D'),
            ("PROT:SCIP 2.0", 'N'),
            ("DMIN:20", '4'),
            ("TIME:6A55F8", '8'),
            ("MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.)", 'N'),
        ];
        for (line, expected) in table {
            assert_eq!(sum(line.as_bytes()) as char, expected, "{line}");
        }
    }

    #[test]
    fn values_of_section_4() {
        assert_eq!(number(1234, 2), "CB");
        assert_eq!(number(5432, 3), "1Dh");
        assert_eq!(number(16_000_000, 4), "m2@0");
        assert_eq!(number(6_968_830, 4), "JUGn");
        assert_eq!(number(4095, 2), "oo");
    }

    #[test]
    fn a_multiple_of_64_leaves_no_short_line() {
        let mut out = Vec::new();
        push_data(&mut out, &[b'0'; 128]);
        assert_eq!(out.len(), 2 * 66);
        out.clear();
        push_data(&mut out, &[b'0'; 2046]);
        assert_eq!(out.len(), 31 * 66 + 64);
    }

    #[test]
    fn decimals() {
        assert_eq!(decimal(b"0044"), Some(44));
        assert_eq!(decimal(b"00a4"), None);
        assert_eq!(decimal(b""), None);
        assert_eq!(decimal(b"99999999999"), None);
    }
}
