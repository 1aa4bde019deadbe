//! Whether the line is as slow as the device says.

use crate::constants::BITS_PER_BYTE;
use crate::frame::ScipMessage;

/// Ratio of the pace of the replies to the rate that `SBPS` names, within which they came over a line of that rate. Own
/// choice: reads group bytes, and USB is a hundred times as fast as the factory's 19200 bit/s.
const CONFIRMING_RATIO: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// The fastest reply so far. A slow line has none that is faster; a late host slows single ones.
#[derive(Debug, Default)]
pub(super) struct LinePace {
    fastest_bytes_s: f64,
}

impl LinePace {
    pub(super) fn note(&mut self, message: &ScipMessage) {
        let took = message.last_byte_at.saturating_sub(message.first_byte_at);
        // All at once: infinite.
        let pace = message.len() as f64 / took.as_secs_f64();
        self.fastest_bytes_s = self.fastest_bytes_s.max(pace);
    }

    /// Bytes per second of the rate that `SBPS` names (`19200[bps]<-...`), if the replies came as slowly as that.
    pub(super) fn confirmed_bytes_s(&self, bit_rate: Option<&str>) -> Option<u32> {
        let text = bit_rate?;
        let digits = text.split(|c: char| !c.is_ascii_digit()).next()?;
        let bytes_s = digits.parse::<u32>().ok()? / BITS_PER_BYTE;
        let ratio = self.fastest_bytes_s / f64::from(bytes_s);
        CONFIRMING_RATIO.contains(&ratio).then_some(bytes_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Framer;
    use std::time::Duration;

    /// A reply of 200 bytes with its LF, its last byte so long after its first.
    fn reply(took_ms: u64) -> ScipMessage {
        let mut framer = Framer::default();
        let text = [b'x'; 199];
        framer.take(&mut &text[..], Duration::ZERO);
        let end = Duration::from_millis(took_ms);
        framer.take(&mut &b"\n\n"[..], end).expect("a message")
    }

    fn confirmed(times_ms: &[u64], bit_rate: Option<&str>) -> Option<u32> {
        let mut pace = LinePace::default();
        times_ms.iter().for_each(|ms| pace.note(&reply(*ms)));
        pace.confirmed_bytes_s(bit_rate)
    }

    #[test]
    fn a_rate_is_confirmed_by_replies_as_slow_as_it() {
        let named = Some("19200[bps]<-Default setting by user");
        // 200 bytes take 104 ms.
        assert_eq!(confirmed(&[104, 104, 104], named), Some(1920));
        assert_eq!(confirmed(&[300, 208, 300], named), Some(1920));
        assert_eq!(confirmed(&[300, 209, 300], named), None);
        assert_eq!(confirmed(&[300, 53, 300], named), Some(1920));
        assert_eq!(confirmed(&[300, 52, 300], named), None, "one was faster");
        assert_eq!(confirmed(&[104, 0, 104], named), None, "all at once");
        assert_eq!(confirmed(&[104], Some("USB Full Speed")), None);
        assert_eq!(confirmed(&[104], Some("0[bps]")), None);
        assert_eq!(confirmed(&[104], None), None);
        assert_eq!(confirmed(&[], named), None);
    }
}
