//! Checks sums independently of the driver: no message with a wrong sum may become a scan (scip2 section 3).

use scip::LaserScan;

/// The last bytes that the driver received: enough for several of the largest replies.
#[derive(Default)]
pub(crate) struct ReceivedBytes(Vec<u8>);

const MAX_KEPT: usize = 64 * 1024;

impl ReceivedBytes {
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
        let over = self.0.len().saturating_sub(MAX_KEPT);
        self.0.drain(..over);
    }

    /// Panics unless these bytes hold a message with the content of `scan` and all sums right.
    pub(crate) fn assert_contains(&self, scan: &LaserScan) {
        let lines: Vec<&[u8]> = self
            .0
            .split(|byte| *byte == b'\n')
            // A CR before the LF is no part of the line.
            .map(|line| line.strip_suffix(b"\r").unwrap_or(line))
            .collect();
        let messages = lines.split(|line| line.is_empty());
        let contained = messages.clone().any(|message| matches_scan(message, scan));
        assert!(contained, "a scan that no intact message holds: {scan:?}");
    }
}

fn body(line: &[u8]) -> Option<&[u8]> {
    let (sum, body) = line.split_last()?;
    let total = body
        .iter()
        .fold(0_u32, |total, byte| total + u32::from(*byte));
    (u32::from(*sum) == total % 64 + 48).then_some(body)
}

/// `None` for more characters than a number has.
fn number(characters: &[u8]) -> Option<u32> {
    characters.iter().try_fold(0_u32, |value, byte| {
        let digit = u32::from(byte.wrapping_sub(48));
        value.checked_mul(64)?.checked_add(digit)
    })
}

fn matches_scan(message: &[&[u8]], scan: &LaserScan) -> bool {
    let [_, status, stamp, data @ ..] = message else {
        return false;
    };
    if !matches!(body(status), Some(b"99" | b"00"))
        || body(stamp).and_then(number) != Some(scan.stamp_ms)
    {
        return false;
    }
    let mut characters = Vec::new();
    for line in data {
        let Some(body) = body(line) else {
            return false;
        };
        characters.extend_from_slice(body);
    }
    let width = if scan.coding == scip::ValueCoding::TwoCharacter {
        2
    } else {
        3
    };
    let values: Option<Vec<u32>> = characters.chunks(width).map(number).collect();
    let Some(values) = values else {
        return false;
    };
    if scan.intensities.is_empty() {
        return values == scan.ranges;
    }
    let pairs = scan.ranges.iter().zip(&scan.intensities);
    values
        == pairs
            .flat_map(|(range, light)| [*range, *light])
            .collect::<Vec<u32>>()
}
