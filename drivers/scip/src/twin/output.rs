//! Replies onto the link: one after the other, each piece at the instant at which it has passed.

use std::collections::VecDeque;
use std::time::Duration;

use super::Instant;
use super::constants::{
    BITS_PER_BYTE, DEFAULT_BAUD, FAST_USB_NS_PER_BYTE, MAX_WAITING_BYTES, NETWORK_NS_PER_BYTE,
    NETWORK_PIECE, SERIAL_PIECE, USB_NS_PER_BYTE, USB_PIECE,
};
use super::noise::Noise;
use super::options::Link;

/// Bytes that reach the host at `at`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// When they are there.
    pub at: Instant,
    /// The bytes.
    pub bytes: Vec<u8>,
}

/// The sending half of the link.
#[derive(Debug, Clone)]
pub(super) struct Transmitter {
    link: Link,
    /// Of USB or the network.
    ns_per_byte: (u64, u64),
    baud: u32,
    host_baud: u32,
    waiting: VecDeque<Output>,
    waiting_bytes: usize,
    busy_until: Instant,
    lost_replies: u64,
}

impl Transmitter {
    /// The link of a sensor that is `fast` if it sends 40 scans a second.
    pub(super) fn new(link: Link, fast: bool) -> Self {
        let baud = default_baud(link);
        Self {
            link,
            ns_per_byte: match link {
                Link::Network => NETWORK_NS_PER_BYTE,
                _ if fast => FAST_USB_NS_PER_BYTE,
                _ => USB_NS_PER_BYTE,
            },
            baud,
            host_baud: baud,
            waiting: VecDeque::new(),
            waiting_bytes: 0,
            busy_until: Instant::ZERO,
            lost_replies: 0,
        }
    }

    /// Sends a reply from `at` on, or as soon as the line is free.
    pub(super) fn send(&mut self, bytes: &[u8], at: Instant, noise: &mut Noise) {
        if self.waiting_bytes + bytes.len() > MAX_WAITING_BYTES {
            self.lost_replies += 1;
            return;
        }
        let begin = at.max(self.busy_until);
        let garbled = !self.rates_agree();
        let (piece, per_byte_ns) = match self.link {
            Link::Usb | Link::Network => (
                if self.link == Link::Usb {
                    USB_PIECE
                } else {
                    NETWORK_PIECE
                },
                noise.between(self.ns_per_byte.0, self.ns_per_byte.1),
            ),
            Link::Serial { .. } => (
                SERIAL_PIECE,
                BITS_PER_BYTE * 1_000_000_000 / u64::from(self.baud.max(1)),
            ),
        };
        let mut passed = 0u64;
        for bytes in bytes.chunks(piece) {
            let before = passed;
            passed += bytes.len() as u64;
            // A packet is there whole when it begins; a serial piece when its last bit has passed.
            let offset = if matches!(self.link, Link::Serial { .. }) {
                passed
            } else {
                before
            };
            let bytes = if garbled {
                bytes.iter().map(|_| noise.byte()).collect()
            } else {
                bytes.to_vec()
            };
            self.waiting_bytes += bytes.len();
            self.waiting.push_back(Output {
                at: begin + Duration::from_nanos(offset * per_byte_ns),
                bytes,
            });
        }
        self.busy_until = begin + Duration::from_nanos(passed * per_byte_ns);
    }

    /// The next piece that is there by `now`.
    pub(super) fn take(&mut self, now: Instant) -> Option<Output> {
        if self.waiting.front()?.at > now {
            return None;
        }
        let output = self.waiting.pop_front()?;
        self.waiting_bytes -= output.bytes.len();
        Some(output)
    }

    /// When the next piece is there.
    pub(super) fn next_at(&self) -> Option<Instant> {
        self.waiting.front().map(|output| output.at)
    }

    /// Whether an earlier reply is still on the line at `t`.
    pub(super) fn is_busy(&self, t: Instant) -> bool {
        self.busy_until > t
    }

    /// Counts a reply that was never sent.
    pub(super) fn lose(&mut self) {
        self.lost_replies += 1;
    }

    pub(super) fn lost_replies(&self) -> u64 {
        self.lost_replies
    }

    /// The sensor's bit rate.
    pub(super) fn baud(&self) -> u32 {
        self.baud
    }

    /// Changes the sensor's bit rate for everything sent from now on.
    pub(super) fn set_baud(&mut self, baud: u32) {
        self.baud = baud;
    }

    pub(super) fn reset_baud(&mut self) {
        self.baud = default_baud(self.link);
    }

    pub(super) fn set_host_baud(&mut self, baud: u32) {
        self.host_baud = baud;
    }

    /// Whether both sides have the same bit rate, or none.
    pub(super) fn rates_agree(&self) -> bool {
        !matches!(self.link, Link::Serial { .. }) || self.baud == self.host_baud
    }

    /// Drops what has not passed by `now`: the power went.
    pub(super) fn cut(&mut self, now: Instant) {
        while self.waiting.back().is_some_and(|output| output.at > now) {
            if let Some(output) = self.waiting.pop_back() {
                self.waiting_bytes -= output.bytes.len();
            }
        }
        self.busy_until = now;
    }
}

fn default_baud(link: Link) -> u32 {
    match link {
        Link::Usb | Link::Network => DEFAULT_BAUD,
        Link::Serial { baud } => baud,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(link: Link, bytes: usize) -> Vec<Output> {
        let mut line = Transmitter::new(link, false);
        line.send(
            &vec![b'x'; bytes],
            Duration::from_millis(1),
            &mut Noise::new(3),
        );
        std::iter::from_fn(|| line.take(Duration::from_secs(10))).collect()
    }

    #[test]
    fn a_scan_on_usb_takes_some_milliseconds() {
        let pieces = sent(Link::Usb, 2134);
        let span = pieces[pieces.len() - 1].at - pieces[0].at;
        assert!((5.5e-3..=8.1e-3).contains(&span.as_secs_f64()), "{span:?}");
        assert_eq!(
            pieces.iter().map(|piece| piece.bytes.len()).sum::<usize>(),
            2134
        );
    }

    #[test]
    fn a_scan_at_19200_takes_1111_ms() {
        let pieces = sent(Link::Serial { baud: 19_200 }, 2134);
        let end = pieces[pieces.len() - 1].at - Duration::from_millis(1);
        assert!((end.as_secs_f64() - 1.1115).abs() < 1e-3, "{end:?}");
    }

    #[test]
    fn rates_that_differ_garble() {
        let mut line = Transmitter::new(Link::Serial { baud: 19_200 }, false);
        line.set_host_baud(115_200);
        line.send(b"BM\n00P\n\n", Duration::ZERO, &mut Noise::new(3));
        assert_ne!(
            line.take(Duration::from_secs(1)).expect("sent").bytes,
            b"BM\n00P\n\n"
        );
    }

    #[test]
    fn nobody_reading_costs_bounded_memory() {
        let mut line = Transmitter::new(Link::Usb, false);
        for _ in 0..10_000 {
            line.send(&[b'x'; 2134], Duration::ZERO, &mut Noise::new(3));
        }
        assert!(line.waiting_bytes <= MAX_WAITING_BYTES);
        assert!(line.lost_replies() > 9_000);
    }
}
