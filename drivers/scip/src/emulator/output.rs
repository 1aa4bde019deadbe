//! Paces replies over the link, one after the other.

use std::collections::VecDeque;
use std::time::Duration;

use super::constants::{
    BITS_PER_BYTE, DEFAULT_BAUD, FAST_USB_NS_PER_BYTE, MAX_QUEUED_BYTES, NETWORK_NS_PER_BYTE,
    NETWORK_PIECE, SERIAL_PIECE, USB_NS_PER_BYTE, USB_PIECE,
};
use super::options::LaserLink;
use super::rng::JitterRng;

/// Bytes that reach the host at `at`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LaserOutput {
    /// Arrival.
    pub at: Duration,
    /// One packet, segment or piece of a serial line.
    pub bytes: Vec<u8>,
}

/// The sending half of the link.
#[derive(Debug, Clone)]
pub(super) struct LaserTransmitter {
    link: LaserLink,
    /// Lowest and highest, of USB or network.
    ns_per_byte: (u64, u64),
    baud: u32,
    host_baud: u32,
    queued: VecDeque<LaserOutput>,
    queued_bytes: usize,
    busy_until: Duration,
    lost_replies: u64,
}

impl LaserTransmitter {
    /// `fast`: the sensor sends 40 scans per second.
    pub(super) fn new(link: LaserLink, fast: bool) -> Self {
        let baud = default_baud(link);
        Self {
            link,
            ns_per_byte: match link {
                LaserLink::Network => NETWORK_NS_PER_BYTE,
                _ if fast => FAST_USB_NS_PER_BYTE,
                _ => USB_NS_PER_BYTE,
            },
            baud,
            host_baud: baud,
            queued: VecDeque::new(),
            queued_bytes: 0,
            busy_until: Duration::ZERO,
            lost_replies: 0,
        }
    }

    /// Sends a reply from `at` on, or as soon as the line is free.
    pub(super) fn send(&mut self, bytes: &[u8], at: Duration, rng: &mut JitterRng) {
        if self.queued_bytes + bytes.len() > MAX_QUEUED_BYTES {
            self.lost_replies += 1;
            return;
        }
        let start = at.max(self.busy_until);
        let garbled = !self.rates_agree();
        let (piece, per_byte_ns) = match self.link {
            LaserLink::Usb | LaserLink::Network => (
                if self.link == LaserLink::Usb {
                    USB_PIECE
                } else {
                    NETWORK_PIECE
                },
                rng.between(self.ns_per_byte.0, self.ns_per_byte.1),
            ),
            LaserLink::Serial { .. } => (
                SERIAL_PIECE,
                BITS_PER_BYTE * 1_000_000_000 / u64::from(self.baud.max(1)),
            ),
        };
        let mut sent = 0u64;
        for bytes in bytes.chunks(piece) {
            let before = sent;
            sent += bytes.len() as u64;
            // A packet arrives whole when it begins, a serial piece with its last bit.
            let offset = if matches!(self.link, LaserLink::Serial { .. }) {
                sent
            } else {
                before
            };
            let bytes = if garbled {
                bytes.iter().map(|_| rng.byte()).collect()
            } else {
                bytes.to_vec()
            };
            self.queued_bytes += bytes.len();
            self.queued.push_back(LaserOutput {
                at: start + Duration::from_nanos(offset * per_byte_ns),
                bytes,
            });
        }
        self.busy_until = start + Duration::from_nanos(sent * per_byte_ns);
    }

    /// The next piece that has arrived by `now`.
    pub(super) fn take(&mut self, now: Duration) -> Option<LaserOutput> {
        if self.queued.front()?.at > now {
            return None;
        }
        let output = self.queued.pop_front()?;
        self.queued_bytes -= output.bytes.len();
        Some(output)
    }

    /// When the next piece arrives.
    pub(super) fn next_at(&self) -> Option<Duration> {
        self.queued.front().map(|output| output.at)
    }

    /// Whether an earlier reply is still on the line at `t`.
    pub(super) fn is_busy(&self, t: Duration) -> bool {
        self.busy_until > t
    }

    /// Counts a reply that was not sent.
    pub(super) fn count_lost(&mut self) {
        self.lost_replies += 1;
    }

    pub(super) fn lost_replies(&self) -> u64 {
        self.lost_replies
    }

    pub(super) fn baud(&self) -> u32 {
        self.baud
    }

    /// For everything sent from now on.
    pub(super) fn set_baud(&mut self, baud: u32) {
        self.baud = baud;
    }

    pub(super) fn reset_baud(&mut self) {
        self.baud = default_baud(self.link);
    }

    pub(super) fn set_host_baud(&mut self, baud: u32) {
        self.host_baud = baud;
    }

    /// Whether both sides have the same bit rate; true without one.
    pub(super) fn rates_agree(&self) -> bool {
        !matches!(self.link, LaserLink::Serial { .. }) || self.baud == self.host_baud
    }

    /// Drops what has not arrived by `now`, for a power failure.
    pub(super) fn drop_after(&mut self, now: Duration) {
        while self.queued.back().is_some_and(|output| output.at > now) {
            if let Some(output) = self.queued.pop_back() {
                self.queued_bytes -= output.bytes.len();
            }
        }
        self.busy_until = now;
    }
}

fn default_baud(link: LaserLink) -> u32 {
    match link {
        LaserLink::Usb | LaserLink::Network => DEFAULT_BAUD,
        LaserLink::Serial { baud } => baud,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(link: LaserLink, bytes: usize) -> Vec<LaserOutput> {
        let mut line = LaserTransmitter::new(link, false);
        line.send(
            &vec![b'x'; bytes],
            Duration::from_millis(1),
            &mut JitterRng::new(3),
        );
        std::iter::from_fn(|| line.take(Duration::from_secs(10))).collect()
    }

    #[test]
    fn a_scan_on_usb_takes_some_milliseconds() {
        let pieces = sent(LaserLink::Usb, 2134);
        let span = pieces[pieces.len() - 1].at - pieces[0].at;
        assert!((5.5e-3..=8.1e-3).contains(&span.as_secs_f64()), "{span:?}");
        assert_eq!(
            pieces.iter().map(|piece| piece.bytes.len()).sum::<usize>(),
            2134
        );
    }

    #[test]
    fn a_scan_at_19200_takes_1111_ms() {
        let pieces = sent(LaserLink::Serial { baud: 19_200 }, 2134);
        let end = pieces[pieces.len() - 1].at - Duration::from_millis(1);
        assert!((end.as_secs_f64() - 1.1115).abs() < 1e-3, "{end:?}");
    }

    #[test]
    fn rates_that_differ_garble() {
        let mut line = LaserTransmitter::new(LaserLink::Serial { baud: 19_200 }, false);
        line.set_host_baud(115_200);
        line.send(b"BM\n00P\n\n", Duration::ZERO, &mut JitterRng::new(3));
        assert_ne!(
            line.take(Duration::from_secs(1)).expect("sent").bytes,
            b"BM\n00P\n\n"
        );
    }

    #[test]
    fn nobody_reading_costs_bounded_memory() {
        let mut line = LaserTransmitter::new(LaserLink::Usb, false);
        for _ in 0..10_000 {
            line.send(&[b'x'; 2134], Duration::ZERO, &mut JitterRng::new(3));
        }
        assert!(line.queued_bytes <= MAX_QUEUED_BYTES);
        assert!(line.lost_replies() > 9_000);
    }
}
