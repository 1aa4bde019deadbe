//! Bytes on the line: arrivals that wait for the parser, replies that wait to be fetched.

use std::collections::VecDeque;
use std::time::Duration;

use super::Instant;
use super::constants::{BITS_PER_BYTE, INPUT_BYTES, OUTPUT_BYTES};

/// Bytes that the unit sends, and when the last of them has left the line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// End of transmission.
    pub at: Instant,
    /// One byte with byte pacing, else all bytes printed at once.
    pub bytes: Vec<u8>,
}

/// Time of one byte at `baud`.
pub(super) fn byte_time(baud: u32) -> Duration {
    Duration::from_secs(u64::from(BITS_PER_BYTE)) / baud.max(1)
}

/// Bytes on their way in.
#[derive(Debug, Default)]
pub(super) struct Receiver {
    bytes: VecDeque<(Instant, u8)>,
    last: Instant,
}

impl Receiver {
    /// Takes one byte whose transmission starts at `now`, or when the line is free.
    pub(super) fn push(&mut self, byte: u8, now: Instant, byte_time: Duration) {
        let at = self.last.max(now).saturating_add(byte_time);
        self.last = at;
        if self.bytes.len() < INPUT_BYTES {
            self.bytes.push_back((at, byte));
        }
    }

    /// When the oldest byte that waits has arrived.
    pub(super) fn next_at(&self) -> Option<Instant> {
        self.bytes.front().map(|(at, _)| *at)
    }

    /// The oldest byte, if it has arrived.
    pub(super) fn pop(&mut self, now: Instant) -> Option<u8> {
        self.next_at().filter(|at| *at <= now)?;
        self.bytes.pop_front().map(|(_, byte)| byte)
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        self.last = Instant::ZERO;
    }

    /// Bytes that wait.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }
}

/// Bytes on their way out.
#[derive(Debug, Default)]
pub(super) struct Transmitter {
    queue: VecDeque<Output>,
    waiting: usize,
    free_at: Instant,
}

impl Transmitter {
    /// Sends `bytes` from `now` on: each taking `pace`, or all at once.
    pub(super) fn send(&mut self, bytes: &[u8], now: Instant, pace: Option<Duration>) {
        let room = OUTPUT_BYTES.saturating_sub(self.waiting);
        let bytes = bytes.get(..room.min(bytes.len())).unwrap_or_default();
        if bytes.is_empty() {
            return;
        }
        self.waiting += bytes.len();
        self.free_at = self.free_at.max(now);
        match pace {
            None => self.queue.push_back(Output {
                at: self.free_at,
                bytes: bytes.to_vec(),
            }),
            Some(time) => {
                for &byte in bytes {
                    self.free_at = self.free_at.saturating_add(time);
                    self.queue.push_back(Output {
                        at: self.free_at,
                        bytes: vec![byte],
                    });
                }
            }
        }
    }

    /// When the next bytes have left.
    pub(super) fn next_at(&self) -> Option<Instant> {
        self.queue.front().map(|o| o.at)
    }

    /// The oldest bytes that have left by `now`.
    pub(super) fn pop(&mut self, now: Instant) -> Option<Output> {
        self.next_at().filter(|at| *at <= now)?;
        let output = self.queue.pop_front()?;
        self.waiting = self.waiting.saturating_sub(output.bytes.len());
        Some(output)
    }

    /// Power is gone: what has not left never will.
    pub(super) fn power_off(&mut self, now: Instant) {
        self.queue.retain(|o| o.at <= now);
        self.waiting = self.queue.iter().map(|o| o.bytes.len()).sum();
        self.free_at = now;
    }

    /// Bytes that wait.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.waiting
    }
}
