//! Replay of a transcript as a link: provides the device's bytes, checks the host's.

use std::collections::VecDeque;
use std::time::Duration;

use crate::{Direction, Link, LinkError, ReplayFault, Transcript, TranscriptEntry};

/// A link whose device is a transcript. It does not wait for recorded times: bytes of the device are available as soon as the host
/// has written all bytes before them. Boundaries of writes and reads do not matter.
pub struct Replay {
    name: String,
    steps: VecDeque<(Direction, VecDeque<u8>)>,
    readable: VecDeque<u8>,
}

impl Replay {
    /// Replays `transcript`; `name` is used in messages.
    #[must_use]
    pub fn new(name: &str, transcript: Transcript) -> Self {
        let bytes = |entry| match entry {
            TranscriptEntry::Bytes {
                direction, bytes, ..
            } if !bytes.is_empty() => Some((direction, bytes.into())),
            _ => None,
        };
        let steps = transcript.entries.into_iter().filter_map(bytes).collect();
        let mut replay = Self {
            name: name.to_owned(),
            steps,
            readable: VecDeque::new(),
        };
        replay.release();
        replay
    }

    /// Ends the replay.
    ///
    /// # Errors
    /// [`ReplayFault::Unplayed`] if part of the transcript was not played.
    pub fn finish(self) -> Result<(), ReplayFault> {
        let left = |wanted| {
            self.steps
                .iter()
                .filter(|(d, _)| *d == wanted)
                .map(|(_, b)| b.len())
                .sum::<usize>()
        };
        let writes_left = left(Direction::ToDevice);
        let reads_left = left(Direction::ToHost) + self.readable.len();
        if writes_left + reads_left == 0 {
            Ok(())
        } else {
            Err(ReplayFault::Unplayed {
                writes_left,
                reads_left,
            })
        }
    }

    /// Makes readable what the device sends before the host's next bytes.
    fn release(&mut self) {
        while let Some((_, mut bytes)) = self
            .steps
            .pop_front_if(|(d, b)| *d == Direction::ToHost || b.is_empty())
        {
            self.readable.append(&mut bytes);
        }
    }

    fn check(&mut self, written: &[u8]) -> Result<(), ReplayFault> {
        let mut rest = written;
        while !rest.is_empty() {
            let Some((_, expected)) = self.steps.front_mut() else {
                return Err(ReplayFault::Extra { got: escape(rest) });
            };
            let count = expected.len().min(rest.len());
            let (head, tail) = rest.split_at(count);
            if !expected.iter().take(count).eq(head) {
                let expected: Vec<u8> = expected.iter().copied().collect();
                return Err(ReplayFault::Mismatch {
                    expected: escape(&expected),
                    got: escape(rest),
                });
            }
            expected.drain(..count);
            rest = tail;
            self.release();
        }
        Ok(())
    }
}

fn escape(bytes: &[u8]) -> String {
    bytes.escape_ascii().to_string()
}

impl Link for Replay {
    fn read(&mut self, buffer: &mut [u8], _timeout: Duration) -> Result<usize, LinkError> {
        let count = buffer.len().min(self.readable.len());
        for (slot, byte) in buffer.iter_mut().zip(self.readable.drain(..count)) {
            *slot = byte;
        }
        Ok(count)
    }

    fn write_all(&mut self, bytes: &[u8], _timeout: Duration) -> Result<(), LinkError> {
        self.check(bytes).map_err(|fault| LinkError::Replay {
            name: self.name.clone(),
            fault,
        })
    }

    fn name(&self) -> &str {
        &self.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn replay(text: &str) -> Replay {
        Replay::new("test", text.parse().expect("a transcript"))
    }

    fn read_all(link: &mut Replay) -> Vec<u8> {
        let mut buffer = [0; 64];
        let count = link
            .read(&mut buffer, Duration::ZERO)
            .expect("a replay never fails to read");
        buffer[..count].to_vec()
    }

    const DIALOGUE: &str = "# two polls\n0.000000 > \"PP \"\n0.010000 < \"* 1\"\n0.011000 < \"\\r\\n\"\n0.020000 > \"TP \"\n\
                            0.030000 < \"* 2\\r\\n\"\n";

    #[test]
    fn the_device_answers_only_after_the_host_asked() {
        let mut link = replay(DIALOGUE);
        assert!(read_all(&mut link).is_empty());
        link.write_all(b"P", Duration::ZERO)
            .expect("half a command");
        assert!(read_all(&mut link).is_empty());
        link.write_all(b"P ", Duration::ZERO)
            .expect("the other half");
        assert_eq!(read_all(&mut link), b"* 1\r\n");
        link.write_all(b"TP ", Duration::ZERO).expect("the second");
        assert_eq!(read_all(&mut link), b"* 2\r\n");
        link.finish().expect("all was played");
    }

    #[test]
    fn one_write_may_hold_several_lines() {
        let mut link =
            replay("0.000000 > \"ED \"\n0.000001 > \"FT \"\n0.000002 < \"*\\r\\n*\\r\\n\"\n");
        link.write_all(b"ED FT ", Duration::ZERO).expect("both");
        assert_eq!(read_all(&mut link), b"*\r\n*\r\n");
        link.finish().expect("all was played");
    }

    #[test]
    fn other_bytes_extra_bytes_and_missing_bytes_are_faults() {
        let fault = |result: Result<(), LinkError>| match result {
            Err(LinkError::Replay { fault, .. }) => fault,
            other => panic!("expected a replay fault, got {other:?}"),
        };
        let mut link = replay(DIALOGUE);
        assert!(matches!(
            fault(link.write_all(b"PT ", Duration::ZERO)),
            ReplayFault::Mismatch { .. }
        ));
        let mut link = replay("0.000000 > \"PP \"\n");
        assert_eq!(
            fault(link.write_all(b"PP TP ", Duration::ZERO)),
            ReplayFault::Extra { got: "TP ".into() }
        );
        let mut link = replay(DIALOGUE);
        link.write_all(b"PP ", Duration::ZERO).expect("the first");
        assert_eq!(
            link.finish(),
            Err(ReplayFault::Unplayed {
                writes_left: 3,
                reads_left: 10
            })
        );
    }
}
