//! A tar archive of plain files (POSIX.1-2001, ustar: <https://pubs.opengroup.org/onlinepubs/9699919799/utilities/pax.html>).

use std::io::{self, Write};

const BLOCK_BYTES: usize = 512;

/// Appends a file; `name` has at most 100 bytes.
pub(super) fn append(
    out: &mut dyn Write,
    name: &str,
    bytes: &[u8],
    modified_s: u64,
) -> io::Result<()> {
    out.write_all(&header(name, bytes.len(), modified_s))?;
    out.write_all(bytes)?;
    let rest = bytes.len().next_multiple_of(BLOCK_BYTES) - bytes.len();
    out.write_all(&[0; BLOCK_BYTES][..rest])
}

/// Ends the archive.
pub(super) fn finish(out: &mut dyn Write) -> io::Result<()> {
    out.write_all(&[0; 2 * BLOCK_BYTES])
}

fn header(name: &str, size: usize, modified_s: u64) -> [u8; BLOCK_BYTES] {
    let mut block = [0; BLOCK_BYTES];
    let mut put =
        |at: usize, text: &str| block[at..at + text.len()].copy_from_slice(text.as_bytes());
    put(0, name);
    put(100, "0000600");
    put(108, "0000000");
    put(116, "0000000");
    put(124, &format!("{size:011o}"));
    put(136, &format!("{modified_s:011o}"));
    // The checksum counts itself as blanks.
    put(148, "        ");
    put(156, "0");
    put(257, "ustar\0");
    put(263, "00");
    let sum: u32 = block.iter().map(|byte| u32::from(*byte)).sum();
    block[148..155].copy_from_slice(format!("{sum:06o}\0").as_bytes());
    block
}

#[cfg(test)]
mod tests {
    use super::{append, finish};
    use std::process::Command;

    #[test]
    fn tar_lists_and_unpacks_it() {
        let dir = tempfile::tempdir().expect("temp dir");
        let mut archive = Vec::new();
        let files = [
            ("d/a.txt", vec![b'a'; 511]),
            ("d/b.txt", vec![b'b'; 512]),
            ("d/c.txt", Vec::new()),
        ];
        for (name, bytes) in &files {
            append(&mut archive, name, bytes, 1_700_000_000).expect("appended");
        }
        finish(&mut archive).expect("ended");
        let path = dir.path().join("x.tar");
        std::fs::write(&path, &archive).expect("written");
        let ran = Command::new("tar")
            .arg("-xvf")
            .arg(&path)
            .arg("-C")
            .arg(dir.path())
            .output();
        let ran = ran.expect("tar runs");
        assert!(ran.status.success() && ran.stderr.is_empty(), "{ran:?}");
        assert_eq!(ran.stdout, b"d/a.txt\nd/b.txt\nd/c.txt\n");
        for (name, bytes) in files {
            assert_eq!(std::fs::read(dir.path().join(name)).expect("there"), bytes);
        }
    }
}
