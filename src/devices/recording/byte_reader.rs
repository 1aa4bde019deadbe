//! Reads what [`ByteWriter`](super::ByteWriter) wrote.

use super::error::DialogueError;

/// A place in bytes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ByteReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> ByteReader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    pub(crate) fn damaged(&self, expected: &'static str) -> DialogueError {
        DialogueError::Damaged {
            expected,
            at: self.at,
        }
    }

    pub(crate) fn take(
        &mut self,
        count: usize,
        expected: &'static str,
    ) -> Result<&'a [u8], DialogueError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.get(..count).ok_or_else(|| self.damaged(expected))?;
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], DialogueError> {
        let damaged = self.damaged(expected);
        self.take(N, expected)?.try_into().map_err(|_| damaged)
    }

    pub(crate) fn u8(&mut self, expected: &'static str) -> Result<u8, DialogueError> {
        self.array(expected).map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self, expected: &'static str) -> Result<u16, DialogueError> {
        self.array(expected).map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self, expected: &'static str) -> Result<u32, DialogueError> {
        self.array(expected).map(u32::from_le_bytes)
    }

    pub(crate) fn i32(&mut self, expected: &'static str) -> Result<i32, DialogueError> {
        self.array(expected).map(i32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self, expected: &'static str) -> Result<u64, DialogueError> {
        self.array(expected).map(u64::from_le_bytes)
    }

    pub(crate) fn f64(&mut self, expected: &'static str) -> Result<f64, DialogueError> {
        self.array(expected).map(f64::from_le_bytes)
    }

    pub(crate) fn varint(&mut self, expected: &'static str) -> Result<u64, DialogueError> {
        let start = *self;
        let mut value = 0_u64;
        for shift in (0..u64::BITS).step_by(7) {
            let byte = self.u8(expected)?;
            let bits = u64::from(byte & 0x7f);
            if bits << shift >> shift != bits {
                break;
            }
            value |= bits << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(start.damaged(expected))
    }

    pub(crate) fn signed_varint(&mut self, expected: &'static str) -> Result<i64, DialogueError> {
        let value = self.varint(expected)?;
        Ok((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
    }

    pub(crate) fn block(&mut self, expected: &'static str) -> Result<&'a [u8], DialogueError> {
        let length = self.u32(expected)?;
        self.take(length as usize, expected)
    }

    pub(crate) fn text(&mut self, expected: &'static str) -> Result<String, DialogueError> {
        let start = *self;
        let bytes = self.block(expected)?.to_vec();
        String::from_utf8(bytes).map_err(|_| start.damaged(expected))
    }

    pub(crate) fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::ByteReader;
    use crate::devices::recording::ByteWriter;
    use proptest::prelude::*;

    #[test]
    fn numbers_of_any_length_are_those_of_leb128_and_zigzag() {
        // DWARF 5, figure C.2: 624485 is e5 8e 26.
        let mut out = ByteWriter::default();
        out.varint(624_485);
        assert_eq!(out.0, [0xe5, 0x8e, 0x26]);
        for (value, byte) in [(0, 0), (-1, 1), (1, 2), (-2, 3)] {
            let mut out = ByteWriter::default();
            out.signed_varint(value);
            assert_eq!(out.0, [byte]);
        }
        let too_long = [0xff; 11];
        assert!(ByteReader::new(&too_long).varint("a number").is_err());
        let too_large = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x02];
        assert!(ByteReader::new(&too_large).varint("a number").is_err());
    }

    proptest! {
        #[test]
        fn numbers_are_read_back(value: u64, signed: i64) {
            let mut out = ByteWriter::default();
            out.varint(value);
            out.signed_varint(signed);
            let mut input = ByteReader::new(&out.0);
            prop_assert_eq!(input.varint("a number").expect("read"), value);
            prop_assert_eq!(input.signed_varint("a number").expect("read"), signed);
            prop_assert!(input.is_at_end());
        }
    }
}
