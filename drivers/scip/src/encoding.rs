//! Numbers as characters (six bits each, big-endian, plus 0x30) and the sum character of a line (scip2 sections 3 and 4).

use crate::constants::{FIRST_CHARACTER, LAST_CHARACTER};
use crate::error::ReplyError;

/// The sum character of `bytes`: low six bits of their total, plus 0x30 (scip2 section 3).
#[must_use]
pub fn sum(bytes: &[u8]) -> u8 {
    let total = bytes
        .iter()
        .fold(0_u8, |total, byte| total.wrapping_add(*byte));
    (total & 0x3F) + FIRST_CHARACTER
}

/// Checks the sum character at the end of a line and returns the line without it.
///
/// # Errors
/// [`ReplyError::Sum`] if it is another character, [`ReplyError::Length`] if the line is empty.
pub fn checked_body(line: &[u8]) -> Result<&[u8], ReplyError> {
    let Some((got, body)) = line.split_last() else {
        return Err(ReplyError::Length {
            what: "a line with its sum",
            expected: 1,
            got: 0,
        });
    };
    let expected = sum(body);
    if *got == expected {
        Ok(body)
    } else {
        Err(ReplyError::sum(line, expected, *got))
    }
}

/// Decodes a number of one to four characters (6 to 24 bits).
///
/// # Errors
/// [`ReplyError::Character`] for a byte outside 0x30..=0x6F, [`ReplyError::Length`] for none or more than four.
pub fn decode(characters: &[u8]) -> Result<u32, ReplyError> {
    if characters.is_empty() || characters.len() > 4 {
        return Err(ReplyError::Length {
            what: "characters of a number",
            expected: 4,
            got: characters.len(),
        });
    }
    characters.iter().try_fold(0_u32, |value, byte| match byte {
        FIRST_CHARACTER..=LAST_CHARACTER => Ok((value << 6) | u32::from(byte - FIRST_CHARACTER)),
        _ => Err(ReplyError::Character { got: *byte }),
    })
}

/// Encodes `value` in `N` characters (at most four); `None` if it needs more.
#[must_use]
pub fn encode<const N: usize>(value: u32) -> Option<[u8; N]> {
    if N > 4 || u64::from(value) >> (6 * N) != 0 {
        return None;
    }
    let mut rest = value;
    let mut characters = [FIRST_CHARACTER; N];
    for character in characters.iter_mut().rev() {
        *character += (rest & 0x3F) as u8;
        rest >>= 6;
    }
    Some(characters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sums_of_the_protocol_table() {
        let table: [(&[u8], u8); 18] = [
            (b"00", b'P'),
            (b"99", b'b'),
            (b"01", b'Q'),
            (b"10", b'Q'),
            (b"02", b'R'),
            (b"03", b'S'),
            (b"04", b'T'),
            (b"05", b'U'),
            (b"98", b'a'),
            (b"0C", b'c'),
            (b"0E", b'e'),
            (b"JUGn", b'D'),
            (b"PROT:SCIP 2.0", b'N'),
            (b"DMIN:20", b'4'),
            (b"TIME:6A55F8", b'8'),
            (b"MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.)", b'N'),
            (b"ARES:1024", b'\\'),
            (b"Sfk", sum(b"Sfk")),
        ];
        for (body, expected) in table {
            assert_eq!(
                char::from(sum(body)),
                char::from(expected),
                "{}",
                String::from_utf8_lossy(body)
            );
        }
    }

    #[test]
    fn values_of_the_protocol_examples() {
        for (characters, value) in [
            (&b"CB"[..], 1234),
            (b"1Dh", 5432),
            (b"m2@0", 16_000_000),
            (b"JUGn", 6_968_830),
            (b"ooo", 262_143),
        ] {
            assert_eq!(decode(characters).expect("valid"), value);
        }
        assert_eq!(encode::<2>(1234), Some(*b"CB"));
        assert_eq!(encode::<3>(5432), Some(*b"1Dh"));
        assert_eq!(encode::<4>(16_000_000), Some(*b"m2@0"));
        assert_eq!(encode::<2>(4096), None);
        assert_eq!(encode::<4>(1 << 24), None);
    }

    #[test]
    fn bytes_outside_the_character_set_are_named() {
        assert_eq!(decode(b"0p0"), Err(ReplyError::Character { got: b'p' }));
        assert_eq!(decode(b"/00"), Err(ReplyError::Character { got: b'/' }));
        assert!(matches!(decode(b""), Err(ReplyError::Length { .. })));
        assert!(matches!(decode(b"00000"), Err(ReplyError::Length { .. })));
    }

    #[test]
    fn a_line_is_its_body_and_its_sum() {
        assert_eq!(checked_body(b"JUGnD").expect("real stamp line"), b"JUGn");
        assert!(matches!(
            checked_body(b"JUGnE"),
            Err(ReplyError::Sum {
                expected: b'D',
                got: b'E',
                ..
            })
        ));
        assert!(checked_body(b"").is_err());
    }

    proptest! {
        #[test]
        fn what_is_encoded_decodes_to_itself(value in 0_u32..(1 << 24)) {
            prop_assert_eq!(decode(&encode::<4>(value).expect("24 bits fit")), Ok(value));
            if let Some(three) = encode::<3>(value) {
                prop_assert_eq!(decode(&three), Ok(value));
            }
            if let Some(two) = encode::<2>(value) {
                prop_assert_eq!(decode(&two), Ok(value));
            }
        }

        #[test]
        fn decoding_anything_never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..8)) {
            let _ = decode(&bytes);
            let _ = checked_body(&bytes);
        }
    }
}
