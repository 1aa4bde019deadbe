//! The checksum of stored bytes.

use sha2::{Digest, Sha256};
use std::fmt::Write as _;

/// Hexadecimal digits of a SHA-256.
pub(super) const HASH_DIGITS: usize = 64;

/// SHA-256 of `bytes` in lower-case hexadecimal digits.
pub(super) fn sha256_hex(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::{HASH_DIGITS, sha256_hex};

    #[test]
    fn it_is_that_of_the_standard() {
        // FIPS 180-2, appendix B.1.
        let hash = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(
            (sha256_hex(b"abc").as_str(), hash.len()),
            (hash, HASH_DIGITS)
        );
    }
}
