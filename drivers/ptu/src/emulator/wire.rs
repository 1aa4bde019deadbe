//! Bytes on the line: input that waits for the parser, output that waits to be fetched.

use std::collections::VecDeque;
use std::time::Duration;

use super::constants::{BITS_PER_BYTE, MAX_INPUT_BYTES, MAX_OUTPUT_BYTES};

/// Bytes that the unit sends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeadOutput {
    /// When the last of them has left the line.
    pub at: Duration,
    /// One byte with byte pacing, otherwise all bytes printed at once.
    pub bytes: Vec<u8>,
}

/// Time of one byte at `baud`.
pub(super) fn byte_time(baud: u32) -> Duration {
    Duration::from_secs(u64::from(BITS_PER_BYTE)) / baud.max(1)
}

/// Bytes from the host.
#[derive(Debug, Default)]
pub(super) struct InputLine {
    bytes: VecDeque<(Duration, u8)>,
    last: Duration,
}

impl InputLine {
    /// Takes one byte whose transmission starts at `now` or when the line is free.
    pub(super) fn push(&mut self, byte: u8, now: Duration, byte_time: Duration) {
        let at = self.last.max(now).saturating_add(byte_time);
        self.last = at;
        if self.bytes.len() < MAX_INPUT_BYTES {
            self.bytes.push_back((at, byte));
        }
    }

    /// When the oldest byte that waits has arrived.
    pub(super) fn next_at(&self) -> Option<Duration> {
        self.bytes.front().map(|(at, _)| *at)
    }

    /// The oldest byte, if it has arrived.
    pub(super) fn pop(&mut self, now: Duration) -> Option<u8> {
        self.next_at().filter(|at| *at <= now)?;
        self.bytes.pop_front().map(|(_, byte)| byte)
    }

    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        self.last = Duration::ZERO;
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }
}

/// Bytes to the host.
#[derive(Debug, Default)]
pub(super) struct OutputLine {
    queue: VecDeque<HeadOutput>,
    waiting: usize,
    free_at: Duration,
}

impl OutputLine {
    /// Sends `bytes` from `now` on, each taking `pace`, or all at once.
    pub(super) fn send(&mut self, bytes: &[u8], now: Duration, pace: Option<Duration>) {
        let free = MAX_OUTPUT_BYTES.saturating_sub(self.waiting);
        let bytes = bytes.get(..free.min(bytes.len())).unwrap_or_default();
        if bytes.is_empty() {
            return;
        }
        self.waiting += bytes.len();
        self.free_at = self.free_at.max(now);
        match pace {
            None => self.queue.push_back(HeadOutput {
                at: self.free_at,
                bytes: bytes.to_vec(),
            }),
            Some(time) => {
                for &byte in bytes {
                    self.free_at = self.free_at.saturating_add(time);
                    self.queue.push_back(HeadOutput {
                        at: self.free_at,
                        bytes: vec![byte],
                    });
                }
            }
        }
    }

    /// When the next bytes have left the line.
    pub(super) fn next_at(&self) -> Option<Duration> {
        self.queue.front().map(|o| o.at)
    }

    /// The oldest bytes, if they have left the line by `now`.
    pub(super) fn pop(&mut self, now: Duration) -> Option<HeadOutput> {
        self.next_at().filter(|at| *at <= now)?;
        let output = self.queue.pop_front()?;
        self.waiting = self.waiting.saturating_sub(output.bytes.len());
        Some(output)
    }

    /// Drops what has not left the line when the power goes off.
    pub(super) fn power_off(&mut self, now: Duration) {
        self.queue.retain(|o| o.at <= now);
        self.waiting = self.queue.iter().map(|o| o.bytes.len()).sum();
        self.free_at = now;
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.waiting
    }
}
