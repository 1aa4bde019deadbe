//! The faults and their text form `kind[:key=value,...]`.

use std::str::FromStr;
use std::time::Duration;

use crate::twin::Instant;
use crate::twin::constants::{
    HARDWARE_STATUS, TIMER_JUMP_MS, TIMER_MASK, TIMER_NEAR_WRAP_MS, VERIFY_STATUS,
};

/// Something that goes wrong (protocol sections 13 and 15).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// `bad-sum`: one line of a scan carries a wrong sum. Count: scans, 1 unless told.
    BadSum,
    /// `dropped-byte`: one byte of a scan is missing. Count: scans, 1 unless told.
    DroppedByte,
    /// `bit-flip`: one bit of a scan is turned. Count: scans, 1 unless told.
    BitFlip,
    /// `flood`: bursts of 0xFF, 7500 bytes every 100 ms. Count: bursts, 1 unless told.
    Flood,
    /// `endless-line`: printable characters without a line feed, 7500 every 100 ms. Count: bursts, 1 unless told.
    EndlessLine,
    /// `garbage`: a burst of random bytes. Count: bursts, 100 ms apart, 1 unless told.
    Garbage,
    /// `truncated-scan`: a scan ends somewhere in its middle. Count: scans, 1 unless told.
    TruncatedScan,
    /// `repeated-stamp`: fresh ranges under the stamp of the scan before. Count: scans; without end unless told.
    RepeatedStamp,
    /// `older-stamp`: the stamp of a scan lies 100 ms before the last one's. Count: scans, 1 unless told.
    OlderStamp,
    /// `frozen-data`: the ranges of the scan before under fresh stamps. Count: scans; without end unless told.
    FrozenData,
    /// `silence`: commands are taken and scans measured, but nothing is sent. Count: replies; until a power cycle unless told.
    Silence,
    /// `verify`: streaming stops with `status`, and goes on with 98 after `for` (500 ms unless told). It waits for a
    /// stream. Count: stops, 1 unless told.
    Verify {
        /// The status told, 21 to 49.
        status: u8,
    },
    /// `hardware`: the laser fails; streaming ends with `status`, and every request to measure gets it. Lasts `for`, or
    /// until a power cycle.
    Hardware {
        /// The status told, 50 to 97.
        status: u8,
    },
    /// `trouble-stat`: `II` tells of trouble while everything works. Count: replies; until a power cycle unless told.
    TroubleStat,
    /// `odd-version`: `VV` as of old units: a line `I` too many, and a wrong sum after `SERI`. Count: replies; until a power
    /// cycle unless told.
    OddVersion,
    /// `torn-version`: the reply to `VV` ends in its middle. Count: replies, 1 unless told.
    TornVersion,
    /// `left-streaming`: another host left the measuring window streaming without end.
    LeftStreaming,
    /// `left-in-time-adjust`: another host left the sensor in time adjustment.
    LeftInTimeAdjust,
    /// `firmware-update`: the sensor is in its update mode; nearly everything gets 0I.
    FirmwareUpdate,
    /// `deafened`: a request for intensity or several echoes, which the model does not know, leaves the sensor deaf
    /// until a power cycle (section 10). It waits for such a request.
    Deafened,
    /// `brown-out`: the sensor starts anew: laser off, timer 0, SCIP1.1 if that is how it wakes.
    BrownOut,
    /// `covered`: every step reads a code. Count: scans; without end unless told.
    Covered,
    /// `half-covered`: the left half reads a code. Count: scans; without end unless told.
    HalfCovered,
    /// `timer-jump`: the timer moves at once.
    TimerJump {
        /// How far, ms; key `by` in seconds, 5 s unless told.
        by_ms: i32,
    },
    /// `timer-set`: the timer shows another time from now on; near its wrap unless told.
    TimerSet {
        /// What it shows, ms of 24 bits; key `to` in seconds, 5 s before the wrap unless told.
        to_ms: u32,
    },
}

/// The kinds by name, with what their optional keys default to.
const KINDS: [(&str, Fault); 25] = [
    ("bad-sum", Fault::BadSum),
    ("dropped-byte", Fault::DroppedByte),
    ("bit-flip", Fault::BitFlip),
    ("garbage", Fault::Garbage),
    ("flood", Fault::Flood),
    ("endless-line", Fault::EndlessLine),
    ("truncated-scan", Fault::TruncatedScan),
    ("repeated-stamp", Fault::RepeatedStamp),
    ("older-stamp", Fault::OlderStamp),
    ("frozen-data", Fault::FrozenData),
    ("silence", Fault::Silence),
    (
        "verify",
        Fault::Verify {
            status: VERIFY_STATUS,
        },
    ),
    (
        "hardware",
        Fault::Hardware {
            status: HARDWARE_STATUS,
        },
    ),
    ("trouble-stat", Fault::TroubleStat),
    ("odd-version", Fault::OddVersion),
    ("torn-version", Fault::TornVersion),
    ("left-streaming", Fault::LeftStreaming),
    ("left-in-time-adjust", Fault::LeftInTimeAdjust),
    ("firmware-update", Fault::FirmwareUpdate),
    ("deafened", Fault::Deafened),
    ("brown-out", Fault::BrownOut),
    ("covered", Fault::Covered),
    ("half-covered", Fault::HalfCovered),
    (
        "timer-jump",
        Fault::TimerJump {
            by_ms: TIMER_JUMP_MS,
        },
    ),
    (
        "timer-set",
        Fault::TimerSet {
            to_ms: TIMER_NEAR_WRAP_MS,
        },
    ),
];

impl Fault {
    /// Every kind as text, in the order of the documentation.
    pub fn kinds() -> impl Iterator<Item = &'static str> {
        KINDS.iter().map(|(name, _)| *name)
    }

    /// Whether it happens at an instant of its own rather than to the replies and scans that come by.
    pub(super) fn is_event(self) -> bool {
        matches!(
            self,
            Self::Garbage
                | Self::Flood
                | Self::EndlessLine
                | Self::Hardware { .. }
                | Self::BrownOut
                | Self::LeftStreaming
                | Self::LeftInTimeAdjust
                | Self::FirmwareUpdate
                | Self::TimerJump { .. }
                | Self::TimerSet { .. }
        )
    }

    /// Whether an event repeats every 100 ms for its count or its time.
    pub(super) fn comes_in_bursts(self) -> bool {
        matches!(self, Self::Garbage | Self::Flood | Self::EndlessLine)
    }

    /// How often it happens if nothing is said; `None` is without end.
    pub(super) fn default_count(self) -> Option<u32> {
        match self {
            Self::RepeatedStamp
            | Self::FrozenData
            | Self::Silence
            | Self::TroubleStat
            | Self::OddVersion
            | Self::Covered
            | Self::HalfCovered => None,
            _ => Some(1),
        }
    }

    /// Whether a power cycle cures it, where nothing limits it.
    pub(super) fn is_cured_by_power(self) -> bool {
        matches!(
            self,
            Self::Silence
                | Self::TroubleStat
                | Self::OddVersion
                | Self::RepeatedStamp
                | Self::FrozenData
        )
    }
}

/// A fault with its time: `kind[:key=value,...]` as text, for example `silence:at=12.5,for=3` or `bad-sum:count=4`.
///
/// Keys: `at` and `for` in seconds, `count`, and `status` (for `verify` and `hardware`) `by` (for `timer-jump`,
/// seconds) or `to` (for `timer-set`, seconds).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultSpec {
    /// What happens.
    pub fault: Fault,
    /// From when on; an instant that has passed means at once.
    pub at: Instant,
    /// Key `for`: for how long it may happen; `None` is without end.
    pub lasting: Option<Duration>,
    /// How often it happens; `None` is once or without end, by its kind (once does not hold where `lasting` is given).
    pub count: Option<u32>,
}

impl From<Fault> for FaultSpec {
    fn from(fault: Fault) -> Self {
        Self {
            fault,
            at: Instant::ZERO,
            lasting: None,
            count: None,
        }
    }
}

/// Why a text is no [`FaultSpec`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FaultParseError {
    /// No such kind.
    #[error("expected a fault ({}), got `{got}`", Fault::kinds().collect::<Vec<_>>().join(", "))]
    Kind {
        /// What stood there.
        got: String,
    },
    /// No such key for this kind.
    #[error("fault `{kind}`: expected at=, for=, count={extra}, got `{got}`")]
    Key {
        /// The kind of fault.
        kind: String,
        /// The key that only this kind has.
        extra: &'static str,
        /// What stood there.
        got: String,
    },
    /// A value that its key cannot have.
    #[error("fault `{kind}`: expected {key} to be {expected}, got `{got}`")]
    Value {
        /// The kind of fault.
        kind: String,
        /// The key.
        key: &'static str,
        /// What it can be.
        expected: &'static str,
        /// What stood there.
        got: String,
    },
}

impl FromStr for FaultSpec {
    type Err = FaultParseError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (kind, settings) = text.split_once(':').unwrap_or((text, ""));
        let kind = kind.trim();
        let fault = KINDS
            .iter()
            .find(|(name, _)| *name == kind)
            .map(|(_, fault)| *fault);
        let mut spec = Self::from(fault.ok_or_else(|| FaultParseError::Kind {
            got: kind.to_owned(),
        })?);
        for setting in settings
            .split(',')
            .map(str::trim)
            .filter(|setting| !setting.is_empty())
        {
            let (key, got) = setting.split_once('=').unwrap_or((setting, ""));
            spec.set(kind, key.trim(), got.trim())?;
        }
        Ok(spec)
    }
}

impl FaultSpec {
    fn set(&mut self, kind: &str, key: &str, got: &str) -> Result<(), FaultParseError> {
        let wrong = |key, expected| FaultParseError::Value {
            kind: kind.to_owned(),
            key,
            expected,
            got: got.to_owned(),
        };
        let status = |low: u8, high: u8, expected| {
            let status = got
                .parse::<u8>()
                .ok()
                .filter(|status| (low..=high).contains(status));
            status.ok_or_else(|| wrong("status", expected))
        };
        match (key, &mut self.fault) {
            ("at", _) => self.at = seconds(got).ok_or_else(|| wrong("at", "seconds, 0 or more"))?,
            ("for", _) => {
                self.lasting = Some(seconds(got).ok_or_else(|| wrong("for", "seconds, 0 or more"))?)
            }
            ("count", _) => {
                let count = got.parse::<u32>().ok().filter(|count| *count > 0);
                self.count = Some(count.ok_or_else(|| wrong("count", "a whole number above 0"))?);
            }
            ("status", Fault::Verify { status: told }) => *told = status(21, 49, "21 to 49")?,
            ("status", Fault::Hardware { status: told }) => *told = status(50, 97, "50 to 97")?,
            ("by", Fault::TimerJump { by_ms }) => {
                // Half a turn of the timer either way: more would be another jump.
                let by = got.parse::<f64>().ok().filter(|by| by.abs() <= 8388.0);
                *by_ms = (by.ok_or_else(|| wrong("by", "seconds between -8388 and 8388"))? * 1e3)
                    .round() as i32;
            }
            ("to", Fault::TimerSet { to_ms }) => {
                let to = got.parse::<f64>().ok();
                let to = to.filter(|to| (0.0..16_777.216).contains(to));
                let to = to.ok_or_else(|| wrong("to", "seconds from 0 and below 16777.216"))?;
                *to_ms = ((to * 1e3).round() as u32).min(TIMER_MASK);
            }
            (_, fault) => {
                let extra = match fault {
                    Fault::Verify { .. } | Fault::Hardware { .. } => ", status=",
                    Fault::TimerJump { .. } => ", by=",
                    Fault::TimerSet { .. } => ", to=",
                    _ => "",
                };
                return Err(FaultParseError::Key {
                    kind: kind.to_owned(),
                    extra,
                    got: key.to_owned(),
                });
            }
        }
        Ok(())
    }
}

fn seconds(text: &str) -> Option<Duration> {
    Duration::try_from_secs_f64(text.parse().ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_form() {
        assert_eq!("bad-sum".parse(), Ok(FaultSpec::from(Fault::BadSum)));
        assert_eq!(
            "silence:at=12.5, for=3".parse(),
            Ok(FaultSpec {
                fault: Fault::Silence,
                at: Duration::from_millis(12_500),
                lasting: Some(Duration::from_secs(3)),
                count: None,
            })
        );
        assert_eq!(
            "verify:status=49,count=2".parse(),
            Ok(FaultSpec {
                count: Some(2),
                ..Fault::Verify { status: 49 }.into()
            })
        );
        assert_eq!(
            "timer-set:to=16777".parse(),
            Ok(FaultSpec::from(Fault::TimerSet { to_ms: 16_777_000 }))
        );
        assert_eq!(
            "timer-jump:by=-1.5".parse(),
            Ok(FaultSpec::from(Fault::TimerJump { by_ms: -1500 }))
        );
    }

    #[test]
    fn every_kind_is_known_by_its_name() {
        for kind in Fault::kinds() {
            assert!(kind.parse::<FaultSpec>().is_ok(), "{kind}");
        }
    }

    #[test]
    fn errors_say_what_was_expected() {
        let error = |text: &str| text.parse::<FaultSpec>().expect_err(text).to_string();
        assert!(
            error("smoke").contains("bad-sum, dropped-byte, bit-flip"),
            "{}",
            error("smoke")
        );
        assert!(error("smoke").ends_with("got `smoke`"));
        assert_eq!(
            error("bad-sum:status=3"),
            "fault `bad-sum`: expected at=, for=, count=, got `status`"
        );
        assert_eq!(
            error("hardware:status=20"),
            "fault `hardware`: expected status to be 50 to 97, got `20`"
        );
        assert!(error("silence:for=-1").contains("seconds, 0 or more"));
        assert!(error("silence:at=nan").contains("seconds"));
        assert!(error("silence:count=0").contains("above 0"));
        assert!(error("timer-set:to=16777.216").contains("below 16777.216"));
        assert!(error("timer-set:by=1").contains("to="));
        assert!(error("timer-jump:by=1e9").contains("-8388"));
    }
}
