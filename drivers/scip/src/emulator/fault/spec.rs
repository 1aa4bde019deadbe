//! The faults and their names.

use std::str::FromStr;
use std::time::Duration;

use fault_text::{FaultKeys, FaultKind, FaultTextError, FaultTimes, parse_seconds};

use crate::emulator::constants::{
    FAULT_PERIOD, GARBAGE_EVERY, HARDWARE_STATUS, TIMER_JUMP_MS, TIMER_MASK, TIMER_NEAR_WRAP_MS,
    VERIFY_STATUS,
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
        /// Milliseconds; key `by`, 5 s by default.
        by_ms: i32,
    },
    /// `timer-set`: the timer is set.
    TimerSet {
        /// Milliseconds of 24 bits; key `to`, 5 s before the wrap by default.
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

    /// Whether `for` is the time of its effect, not that in which it may begin.
    pub(super) fn is_effect_lasting(self) -> bool {
        matches!(self, Self::Verify { .. } | Self::Hardware { .. })
    }

    /// Least time between two, unless `every` is given.
    pub(super) fn default_period(self) -> Duration {
        if self.comes_in_bursts() {
            GARBAGE_EVERY
        } else if self.is_event() {
            FAULT_PERIOD
        } else {
            Duration::ZERO
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

/// A fault with its schedule. As text: `kind[:key=value,...]` ([`fault_text`]), for example `silence:at=12.5,for=3s`.
///
/// `count` is how often it happens, `every` the least time between two: 0 s of replies and scans, 100 ms of bursts, 1 s of
/// the others. Own keys: `status` (of `verify` and `hardware`); `by` (of `timer-jump`), `to` (of `timer-set`), times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LaserFaultSpec {
    /// The kind, with its own keys.
    pub fault: LaserFault,
    /// When; without a count: without end if `lasting` is given, else the default of its kind.
    pub times: FaultTimes,
}

impl From<LaserFault> for LaserFaultSpec {
    fn from(fault: LaserFault) -> Self {
        Self {
            fault,
            times: FaultTimes::default(),
        }
    }
}

impl FromStr for LaserFaultSpec {
    type Err = FaultTextError;

    fn from_str(text: &str) -> Result<Self, FaultTextError> {
        let kinds = KINDS.map(|(name, fault)| -> FaultKind { (name, fault.own_keys()) });
        let keys = FaultKeys::split(text, &kinds)?;
        let fault = KINDS
            .iter()
            .find(|(name, _)| *name == keys.kind())
            .map_or(LaserFault::BadSum, |(_, fault)| *fault);
        Ok(Self {
            fault: fault.with_own_keys(&keys)?,
            times: keys.times()?,
        })
    }
}

impl LaserFault {
    /// The keys that only this kind has.
    fn own_keys(self) -> &'static [&'static str] {
        match self {
            Self::Verify { .. } | Self::Hardware { .. } => &["status"],
            Self::TimerJump { .. } => &["by"],
            Self::TimerSet { .. } => &["to"],
            _ => &[],
        }
    }

    fn with_own_keys(self, keys: &FaultKeys<'_>) -> Result<Self, FaultTextError> {
        let status = |default, low: u8, high: u8, expected| {
            keys.get("status", default, expected, |value| {
                let status = value.parse().ok();
                status.filter(|status| (low..=high).contains(status))
            })
        };
        Ok(match self {
            Self::Verify { status: code } => Self::Verify {
                status: status(code, 21, 49, "21 to 49")?,
            },
            Self::Hardware { status: code } => Self::Hardware {
                status: status(code, 50, 97, "50 to 97")?,
            },
            Self::TimerJump { by_ms } => Self::TimerJump {
                // Half of the 24 bits either way: more would be a jump in the other direction.
                by_ms: keys.get("by", by_ms, "a time between -8388 s and 8388 s", |value| {
                    let by = parse_seconds(value).filter(|by| by.abs() <= 8388.0)?;
                    Some((by * 1e3).round() as i32)
                })?,
            },
            Self::TimerSet { to_ms } => Self::TimerSet {
                to_ms: keys.get(
                    "to",
                    to_ms,
                    "a time from 0 and below 16777.216 s",
                    |value| {
                        let to =
                            parse_seconds(value).filter(|to| (0.0..16_777.216).contains(to))?;
                        Some(((to * 1e3).round() as u32).min(TIMER_MASK))
                    },
                )?,
            },
            other => other,
        })
    }
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
            "silence:at=300ms, for=3s,every=2".parse(),
            Ok(LaserFaultSpec {
                fault: LaserFault::Silence,
                times: FaultTimes {
                    at: Some(Duration::from_millis(300)),
                    lasting: Some(Duration::from_secs(3)),
                    count: None,
                    every: Some(Duration::from_secs(2)),
                },
            })
        );
        assert_eq!(
            "verify:status=49,count=2".parse(),
            Ok(LaserFaultSpec {
                fault: LaserFault::Verify { status: 49 },
                times: FaultTimes {
                    count: Some(2),
                    ..FaultTimes::default()
                },
            })
        );
        for (text, to_ms) in [
            ("timer-set:to=16777", 16_777_000),
            ("timer-set:to=250ms", 250),
        ] {
            let set = LaserFault::TimerSet { to_ms };
            assert_eq!(text.parse(), Ok(LaserFaultSpec::from(set)));
        }
        assert_eq!(
            "timer-jump:by=-1.5".parse(),
            Ok(LaserFaultSpec::from(LaserFault::TimerJump { by_ms: -1500 }))
        );
        assert_eq!(
            "hardware".parse(),
            Ok(LaserFaultSpec::from(LaserFault::Hardware {
                status: HARDWARE_STATUS
            }))
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
            "fault `bad-sum` has no key `status`; valid keys: at, for, count, every"
        );
        assert_eq!(
            error("hardware:status=20"),
            "fault `hardware`: expected status to be 50 to 97, got `20`"
        );
        assert!(error("silence:for=-1").contains("a time such as"));
        assert!(error("silence:at=nan").contains("a time such as"));
        assert!(error("silence:count=0").contains("above 0"));
        assert!(error("timer-set:to=16777.216").contains("below 16777.216"));
        assert!(error("timer-set:by=1").ends_with("every, to"));
        assert!(error("timer-set:to=-1ms").contains("from 0"));
        assert!(error("timer-jump:by=1e9").contains("-8388"));
    }
}
