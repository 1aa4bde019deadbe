//! The faults and their text form `kind[:key=value,...]`.

use std::str::FromStr;
use std::time::Duration;

use crate::emulator::constants::{
    HARDWARE_STATUS, TIMER_JUMP_MS, TIMER_MASK, TIMER_NEAR_WRAP_MS, VERIFY_STATUS,
};

/// A fault of laser or line (scip2 sections 13 and 15).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaserFault {
    /// `bad-sum`: one line of a scan has a wrong sum. Count: scans, 1 by default.
    BadSum,
    /// `dropped-byte`: one byte of a scan is missing. Count: scans, 1 by default.
    DroppedByte,
    /// `bit-flip`: one bit of a scan is flipped. Count: scans, 1 by default.
    BitFlip,
    /// `flood`: bursts of 0xFF, 7500 bytes every 100 ms. Count: bursts, 1 by default.
    Flood,
    /// `endless-line`: printable characters without a line feed, 7500 every 100 ms. Count: bursts, 1 by default.
    EndlessLine,
    /// `garbage`: a burst of random bytes. Count: bursts, 100 ms apart, 1 by default.
    Garbage,
    /// `truncated-scan`: a scan ends between a quarter and three quarters. Count: scans, 1 by default.
    TruncatedScan,
    /// `repeated-stamp`: new ranges with the stamp of the scan before. Count: scans; without end by default.
    RepeatedStamp,
    /// `older-stamp`: the stamp of a scan is 100 ms before that of the scan before. Count: scans, 1 by default.
    OlderStamp,
    /// `frozen-data`: the ranges of the scan before with new stamps. Count: scans; without end by default.
    FrozenData,
    /// `silence`: commands are taken and scans measured, but nothing is sent. Count: replies; until a power cycle by default.
    Silence,
    /// `verify`: streaming stops with `status`, and goes on with 98 after `for` (500 ms by default). It waits for a
    /// stream. Count: stops, 1 by default.
    Verify {
        /// 21 to 49.
        status: u8,
    },
    /// `hardware`: the laser fails; streaming ends with `status`, and every request to measure gets it. Lasts `for`, or
    /// until a power cycle.
    Hardware {
        /// 50 to 97.
        status: u8,
    },
    /// `trouble-stat`: `II` reports trouble while everything works. Count: replies; until a power cycle by default.
    TroubleStat,
    /// `odd-version`: `VV` as from old units: an extra line `I`, and a wrong sum after `SERI`. Count: replies; until a power
    /// cycle by default.
    OddVersion,
    /// `torn-version`: the reply to `VV` ends half-way. Count: replies, 1 by default.
    TornVersion,
    /// `left-streaming`: another host left an endless stream over the measuring window.
    LeftStreaming,
    /// `left-in-time-adjust`: another host left the sensor in time adjust.
    LeftInTimeAdjust,
    /// `firmware-update`: the sensor is in its update mode; nearly every command gets 0I.
    FirmwareUpdate,
    /// `deafened`: a request for intensity or multiple echoes that the model lacks leaves the sensor unresponsive until a
    /// power cycle (scip2 section 10). It waits for such a request.
    Deafened,
    /// `brown-out`: the sensor restarts: laser off, timer 0, in SCIP 1.1 if the model starts so.
    BrownOut,
    /// `covered`: every step has a code. Count: scans; without end by default.
    Covered,
    /// `half-covered`: the left half has a code. Count: scans; without end by default.
    HalfCovered,
    /// `timer-jump`: the timer jumps.
    TimerJump {
        /// Milliseconds; key `by` in seconds, 5 s by default.
        by_ms: i32,
    },
    /// `timer-set`: the timer is set.
    TimerSet {
        /// Milliseconds of 24 bits; key `to` in seconds, 5 s before the wrap by default.
        to_ms: u32,
    },
}

/// The kinds by name, with the defaults of their own keys.
const KINDS: [(&str, LaserFault); 25] = [
    ("bad-sum", LaserFault::BadSum),
    ("dropped-byte", LaserFault::DroppedByte),
    ("bit-flip", LaserFault::BitFlip),
    ("garbage", LaserFault::Garbage),
    ("flood", LaserFault::Flood),
    ("endless-line", LaserFault::EndlessLine),
    ("truncated-scan", LaserFault::TruncatedScan),
    ("repeated-stamp", LaserFault::RepeatedStamp),
    ("older-stamp", LaserFault::OlderStamp),
    ("frozen-data", LaserFault::FrozenData),
    ("silence", LaserFault::Silence),
    (
        "verify",
        LaserFault::Verify {
            status: VERIFY_STATUS,
        },
    ),
    (
        "hardware",
        LaserFault::Hardware {
            status: HARDWARE_STATUS,
        },
    ),
    ("trouble-stat", LaserFault::TroubleStat),
    ("odd-version", LaserFault::OddVersion),
    ("torn-version", LaserFault::TornVersion),
    ("left-streaming", LaserFault::LeftStreaming),
    ("left-in-time-adjust", LaserFault::LeftInTimeAdjust),
    ("firmware-update", LaserFault::FirmwareUpdate),
    ("deafened", LaserFault::Deafened),
    ("brown-out", LaserFault::BrownOut),
    ("covered", LaserFault::Covered),
    ("half-covered", LaserFault::HalfCovered),
    (
        "timer-jump",
        LaserFault::TimerJump {
            by_ms: TIMER_JUMP_MS,
        },
    ),
    (
        "timer-set",
        LaserFault::TimerSet {
            to_ms: TIMER_NEAR_WRAP_MS,
        },
    ),
];

impl LaserFault {
    /// The names of all kinds.
    pub fn kinds() -> impl Iterator<Item = &'static str> {
        KINDS.iter().map(|(name, _)| *name)
    }

    /// Whether it happens at an instant of its own rather than to a reply or scan.
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

    /// Whether it repeats every 100 ms for its count or duration.
    pub(super) fn comes_in_bursts(self) -> bool {
        matches!(self, Self::Garbage | Self::Flood | Self::EndlessLine)
    }

    /// `None`: without end.
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

    /// Whether a power cycle cures it if it is unlimited.
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

/// A fault with its schedule: `kind[:key=value,...]` as text, for example `silence:at=12.5,for=3` or `bad-sum:count=4`.
///
/// Keys: `at` and `for` in seconds, `count`; `status` (of `verify` and `hardware`); `by` (of `timer-jump`, seconds); `to`
/// (of `timer-set`, seconds).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LaserFaultSpec {
    /// The kind, with its own keys.
    pub fault: LaserFault,
    /// Start; an instant that has passed means at once.
    pub at: Duration,
    /// Key `for`: how long it may happen; `None` is without end.
    pub duration: Option<Duration>,
    /// How often it happens. `None`: without end if `duration` is given, else the default of its kind.
    pub count: Option<u32>,
}

impl From<LaserFault> for LaserFaultSpec {
    fn from(fault: LaserFault) -> Self {
        Self {
            fault,
            at: Duration::ZERO,
            duration: None,
            count: None,
        }
    }
}

/// A text that is no [`LaserFaultSpec`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "each message shows what its fields are")]
pub enum LaserFaultParseError {
    #[error("expected a fault ({}), got `{got}`", LaserFault::kinds().collect::<Vec<_>>().join(", "))]
    Kind { got: String },
    #[error("fault `{kind}`: expected at=, for=, count={extra}, got `{got}`")]
    Key {
        kind: String,
        extra: &'static str,
        got: String,
    },
    #[error("fault `{kind}`: expected {key} to be {expected}, got `{got}`")]
    Value {
        kind: String,
        key: &'static str,
        expected: &'static str,
        got: String,
    },
}

impl FromStr for LaserFaultSpec {
    type Err = LaserFaultParseError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (kind, settings) = text.split_once(':').unwrap_or((text, ""));
        let kind = kind.trim();
        let fault = KINDS
            .iter()
            .find(|(name, _)| *name == kind)
            .map(|(_, fault)| *fault);
        let mut spec = Self::from(fault.ok_or_else(|| LaserFaultParseError::Kind {
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

impl LaserFaultSpec {
    fn set(&mut self, kind: &str, key: &str, got: &str) -> Result<(), LaserFaultParseError> {
        let wrong = |key, expected| LaserFaultParseError::Value {
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
                self.duration =
                    Some(seconds(got).ok_or_else(|| wrong("for", "seconds, 0 or more"))?)
            }
            ("count", _) => {
                let count = got.parse::<u32>().ok().filter(|count| *count > 0);
                self.count = Some(count.ok_or_else(|| wrong("count", "a whole number above 0"))?);
            }
            ("status", LaserFault::Verify { status: code }) => *code = status(21, 49, "21 to 49")?,
            ("status", LaserFault::Hardware { status: code }) => {
                *code = status(50, 97, "50 to 97")?
            }
            ("by", LaserFault::TimerJump { by_ms }) => {
                // Half of the 24 bits either way: more would be a jump in the other direction.
                let by = got.parse::<f64>().ok().filter(|by| by.abs() <= 8388.0);
                *by_ms = (by.ok_or_else(|| wrong("by", "seconds between -8388 and 8388"))? * 1e3)
                    .round() as i32;
            }
            ("to", LaserFault::TimerSet { to_ms }) => {
                let to = got.parse::<f64>().ok();
                let to = to.filter(|to| (0.0..16_777.216).contains(to));
                let to = to.ok_or_else(|| wrong("to", "seconds from 0 and below 16777.216"))?;
                *to_ms = ((to * 1e3).round() as u32).min(TIMER_MASK);
            }
            (_, fault) => {
                let extra = match fault {
                    LaserFault::Verify { .. } | LaserFault::Hardware { .. } => ", status=",
                    LaserFault::TimerJump { .. } => ", by=",
                    LaserFault::TimerSet { .. } => ", to=",
                    _ => "",
                };
                return Err(LaserFaultParseError::Key {
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
        assert_eq!(
            "bad-sum".parse(),
            Ok(LaserFaultSpec::from(LaserFault::BadSum))
        );
        assert_eq!(
            "silence:at=12.5, for=3".parse(),
            Ok(LaserFaultSpec {
                fault: LaserFault::Silence,
                at: Duration::from_millis(12_500),
                duration: Some(Duration::from_secs(3)),
                count: None,
            })
        );
        assert_eq!(
            "verify:status=49,count=2".parse(),
            Ok(LaserFaultSpec {
                count: Some(2),
                ..LaserFault::Verify { status: 49 }.into()
            })
        );
        assert_eq!(
            "timer-set:to=16777".parse(),
            Ok(LaserFaultSpec::from(LaserFault::TimerSet {
                to_ms: 16_777_000
            }))
        );
        assert_eq!(
            "timer-jump:by=-1.5".parse(),
            Ok(LaserFaultSpec::from(LaserFault::TimerJump { by_ms: -1500 }))
        );
    }

    #[test]
    fn every_kind_is_known_by_its_name() {
        for kind in LaserFault::kinds() {
            assert!(kind.parse::<LaserFaultSpec>().is_ok(), "{kind}");
        }
    }

    #[test]
    fn errors_name_what_was_expected() {
        let error = |text: &str| text.parse::<LaserFaultSpec>().expect_err(text).to_string();
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
