//! Recording of the bytes on a link.

use std::io::Write;
use std::time::{Duration, Instant};

use crate::{Direction, Link, LinkError, TranscriptEntry};

/// A link that records its bytes as a [`Transcript`](crate::Transcript). An error of the writer ends the recording, not the link.
pub struct Recorder<L, W> {
    link: L,
    writer: Option<W>,
    started: Instant,
}

impl<L: Link, W: Write + Send> Recorder<L, W> {
    /// Starts recording `link` into `writer`; times count from now. The first line names the link.
    pub fn new(link: L, writer: W) -> Self {
        let name = link.name().to_owned();
        let mut recorder = Self {
            link,
            writer: Some(writer),
            started: Instant::now(),
        };
        recorder.comment(&name);
        recorder
    }

    /// Writes a comment into the transcript.
    pub fn comment(&mut self, text: &str) {
        self.write_entry(&TranscriptEntry::Comment(text.to_owned()));
    }

    /// Whether the writer has not failed so far.
    pub fn is_recording(&self) -> bool {
        self.writer.is_some()
    }

    /// Ends the recording; returns the link, and the writer unless it failed.
    pub fn into_parts(self) -> (L, Option<W>) {
        (self.link, self.writer)
    }

    fn write_entry(&mut self, entry: &TranscriptEntry) {
        let Some(writer) = &mut self.writer else {
            return;
        };
        if writeln!(writer, "{entry}")
            .and_then(|()| writer.flush())
            .is_err()
        {
            self.writer = None;
        }
    }

    fn write_bytes(&mut self, direction: Direction, bytes: &[u8]) {
        let at = self.started.elapsed();
        self.write_entry(&TranscriptEntry::Bytes {
            at,
            direction,
            bytes: bytes.to_vec(),
        });
    }
}

impl<L: Link, W: Write + Send> Link for Recorder<L, W> {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        let result = self.link.read(buffer, timeout);
        match &result {
            Ok(0) => {}
            Ok(count) => {
                self.write_bytes(Direction::ToHost, buffer.get(..*count).unwrap_or_default())
            }
            Err(e) => self.comment(&format!("read: {e}")),
        }
        result
    }

    fn write_all(&mut self, bytes: &[u8], timeout: Duration) -> Result<(), LinkError> {
        let result = self.link.write_all(bytes, timeout);
        match &result {
            Ok(()) => self.write_bytes(Direction::ToDevice, bytes),
            Err(e) => self.comment(&format!("write: {e}")),
        }
        result
    }

    fn name(&self) -> &str {
        self.link.name()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Replay, Transcript};

    #[test]
    fn a_recorded_replay_is_the_transcript_again() {
        let text = "0.000000 > \"PP \"\n0.010000 < \"* 22\\r\\n\"\n";
        let script: Transcript = text.parse().expect("a transcript");
        let mut link = Recorder::new(Replay::new("ptu", script.clone()), Vec::new());
        link.write_all(b"PP ", Duration::ZERO).expect("expected");
        let mut buffer = [0; 16];
        assert_eq!(link.read(&mut buffer, Duration::ZERO).expect("read"), 6);
        assert!(link.write_all(b"TP ", Duration::ZERO).is_err());
        let (replay, writer) = link.into_parts();
        replay.finish().expect("all was played");
        let recorded: Transcript = String::from_utf8(writer.expect("never failed"))
            .expect("text")
            .parse()
            .expect("a transcript");
        let bytes = |t: &Transcript| -> Vec<(Direction, Vec<u8>)> {
            let only = |e: &TranscriptEntry| match e {
                TranscriptEntry::Bytes {
                    direction, bytes, ..
                } => Some((*direction, bytes.clone())),
                TranscriptEntry::Comment(_) => None,
            };
            t.entries.iter().filter_map(only).collect()
        };
        assert_eq!(bytes(&recorded), bytes(&script));
        assert_eq!(
            recorded.entries.first(),
            Some(&TranscriptEntry::Comment("ptu".into()))
        );
    }

    #[test]
    fn a_full_disk_does_not_break_the_link() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
                Err(std::io::Error::other("full"))
            }
            fn flush(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let script: Transcript = "0.000000 > \"PP \"\n".parse().expect("a transcript");
        let mut link = Recorder::new(Replay::new("ptu", script), Full);
        assert!(!link.is_recording());
        link.write_all(b"PP ", Duration::ZERO)
            .expect("the link goes on");
    }
}
