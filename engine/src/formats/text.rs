//! Lines and words of text in files that may also hold binary data.

/// Reads a byte slice line by line.
pub(super) struct LineReader<'a> {
    bytes: &'a [u8],
    /// Offset of the next byte.
    pub(super) offset: usize,
    /// Number of the line read last, from 1.
    pub(super) line: usize,
}

impl<'a> LineReader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            offset: 0,
            line: 0,
        }
    }

    /// The bytes not yet read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.offset..).unwrap_or_default()
    }

    /// The next line without its line end (LF or CR LF), trimmed of blanks.
    pub(super) fn next_line(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|b| *b == b'\n');
        self.offset += length.map_or(rest.len(), |n| n + 1);
        self.line += 1;
        Some(
            rest.get(..length.unwrap_or(rest.len()))
                .unwrap_or_default()
                .trim_ascii(),
        )
    }

    /// The next line that is not blank.
    pub(super) fn next_filled(&mut self) -> Option<&'a [u8]> {
        loop {
            let line = self.next_line()?;
            if !line.is_empty() {
                return Some(line);
            }
        }
    }
}

/// The words of a line, separated by blanks.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty())
}

pub(super) fn parse_count(word: Option<&[u8]>) -> Option<u64> {
    std::str::from_utf8(word?).ok()?.parse().ok()
}

/// Bytes of a file as a quoted text of one line, shortened to 40 characters.
pub(super) fn quoted(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes.get(..bytes.len().min(160)).unwrap_or_default());
    let mut short: String = text.chars().take(40).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    format!("{short:?}")
}
