//! LZF (Lehmann), the compression of PCD's `binary_compressed`.
//!
//! A control byte below 32 is followed by that many plus one literal bytes; otherwise its upper three bits (plus the
//! next byte if they are 7) are a length less two, and its lower five with one more byte a distance back less one.

/// Most bytes per compressed byte: 3 bytes give at most 264.
const MAX_EXPANSION: usize = 88;

/// Decompresses `input` to `length` bytes; `None` if it is damaged or has another length.
pub(super) fn decompress(input: &[u8], length: usize) -> Option<Vec<u8>> {
    if length > input.len().saturating_mul(MAX_EXPANSION) {
        return None;
    }
    let mut out = Vec::with_capacity(length);
    let mut input = input.iter();
    while let Some(&control) = input.next() {
        let control = usize::from(control);
        if control < 32 {
            let literals = input.as_slice().get(..=control)?;
            out.extend_from_slice(literals);
            input = input.as_slice().get(control + 1..)?.iter();
        } else {
            let mut run = control >> 5;
            if run == 7 {
                run += usize::from(*input.next()?);
            }
            let back = ((control & 31) << 8) + usize::from(*input.next()?) + 1;
            let start = out.len().checked_sub(back)?;
            if out.len() + run + 2 > length {
                return None;
            }
            // Byte by byte: the copied range may overlap its own output.
            for i in start..start + run + 2 {
                out.push(*out.get(i)?);
            }
        }
        if out.len() > length {
            return None;
        }
    }
    (out.len() == length).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::decompress;

    #[test]
    fn literals_and_runs_are_decompressed() {
        assert_eq!(
            decompress(&[2, b'a', b'b', b'c'], 3).as_deref(),
            Some(&b"abc"[..])
        );
        // "ab", then 5 bytes from 2 back, overlapping itself.
        let run = [1, b'a', b'b', 3 << 5, 1];
        assert_eq!(decompress(&run, 7).as_deref(), Some(&b"abababa"[..]));
        // A long run: 7 + 10 + 2 bytes from 1 back.
        assert_eq!(
            decompress(&[0, b'z', 7 << 5, 10, 0], 20),
            Some(vec![b'z'; 20])
        );
    }

    #[test]
    fn damaged_data_are_refused() {
        assert_eq!(decompress(&[2, b'a'], 3), None);
        assert_eq!(decompress(&[1 << 5, 0], 3), None);
        assert_eq!(decompress(&[0, b'z', 7 << 5, 10, 0], 19), None);
        assert_eq!(decompress(&[0, b'z'], 1_000_000_000_000), None);
        assert_eq!(decompress(&[0, b'z', 1 << 5], 4), None);
    }
}
