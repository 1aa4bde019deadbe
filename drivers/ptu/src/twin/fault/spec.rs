//! The text of a fault, read and refused.

use std::time::Duration;

use crate::twin::constants::{BAUD_RATES, E_BAUD_RATES};
use crate::twin::names::AxisName;

/// Every kind, for messages.
const KINDS: &str = "lost-steps, stuck, slow, overshoot, event, text, echo, verbose, velocity, slaved, limits-off, monitor, moving, unit-id, baud, axis-error, supply, silence, lost-byte, garbage-byte, reset-fails, power-cycle, wrong-baud";

/// A fault description that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FaultError {
    /// The word before the colon.
    #[error("unknown fault `{0}`; valid kinds: {KINDS}")]
    UnknownKind(String),
    /// A key that this kind does not have.
    #[error("fault `{kind}` has no key `{key}`; valid keys: {valid}")]
    UnknownKey {
        /// The fault.
        kind: String,
        /// The word before `=`.
        key: String,
        /// What it could have been.
        valid: String,
    },
    /// A value that cannot be read.
    #[error("fault `{kind}`: `{key}={value}` is not {expected}")]
    BadValue {
        /// The fault.
        kind: String,
        /// The key.
        key: String,
        /// What stands there.
        value: String,
        /// What should.
        expected: &'static str,
    },
    /// A piece without `=`.
    #[error("fault `{kind}`: expected `key=value`, got `{got}`")]
    NotAPair {
        /// The fault.
        kind: String,
        /// The piece.
        got: String,
    },
}

/// What goes wrong.
#[derive(Debug, Clone, PartialEq)]
pub enum FaultKind {
    /// The rotor jumps by this many counts; the reported position does not.
    LostSteps {
        /// Axes concerned.
        axes: Vec<AxisName>,
        /// Counts, signed.
        steps: i32,
    },
    /// An axis stands still.
    Stuck {
        /// Axes concerned.
        axes: Vec<AxisName>,
        /// Only the rotor stands; the reported position goes on.
        hidden: bool,
    },
    /// An axis is slower than told.
    Slow {
        /// Axes concerned.
        axes: Vec<AxisName>,
        /// Factor on its speeds, above 0 and at most 1.
        factor: f64,
    },
    /// An axis runs past its targets and comes back.
    Overshoot {
        /// Axes concerned.
        axes: Vec<AxisName>,
        /// Counts.
        steps: i32,
    },
    /// An unsolicited `!` event.
    Event {
        /// `P`, `T` or `D`.
        which: char,
        /// Output bytes let through before it; `None`: at once, wherever the output stands.
        within: Option<u32>,
    },
    /// An unsolicited line.
    Text(String),
    /// Echo is switched on.
    Echo,
    /// Verbose replies are switched on.
    Verbose,
    /// Velocity mode is on.
    Velocity,
    /// Slaved mode is on.
    Slaved,
    /// Limits are not enforced.
    LimitsOff,
    /// Auto-scan runs over the pan range.
    Monitor,
    /// The head is sent to `[pan, tilt]`, counts.
    Moving([i32; 2]),
    /// The unit has this network id and is not selected.
    UnitId(u8),
    /// The unit speaks at this rate.
    Baud(u32),
    /// The axes are not calibrated.
    AxisError,
    /// What `O` tells.
    Supply {
        /// Volts.
        volts: f64,
        /// Degrees Fahrenheit of head and motors.
        degf: f64,
    },
    /// Nothing is sent.
    Silence {
        /// Nothing is heard either.
        deaf: bool,
    },
    /// Output bytes vanish.
    LostByte {
        /// Bytes let through before each.
        skip: u32,
    },
    /// Output bytes are replaced by random ones.
    GarbageByte {
        /// Bytes let through before each.
        skip: u32,
    },
    /// A calibration fails.
    ResetFails,
    /// Power goes and comes back.
    PowerCycle,
    /// The line runs at another speed than the host's.
    WrongBaud,
}

impl FaultKind {
    /// Every kind as text, in the order of the documentation.
    pub fn kinds() -> impl Iterator<Item = &'static str> {
        KINDS.split(", ")
    }
}

/// One fault and when it strikes.
#[derive(Debug, Clone, PartialEq)]
pub struct FaultSpec {
    /// What goes wrong.
    pub kind: FaultKind,
    /// From when on, virtual time; `None`: at once.
    pub at: Option<Duration>,
    /// For how long; `None`: for ever (for a power cycle: no time at all).
    pub lasting: Option<Duration>,
    /// How often (events), how many (bytes, calibrations).
    pub count: u32,
    /// Time between repeated events.
    pub every: Duration,
}

impl std::str::FromStr for FaultSpec {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, FaultError> {
        let (name, rest) = text.trim().split_once(':').unwrap_or((text.trim(), ""));
        let name = name.trim().replace('_', "-");
        let own: &[&str] = match name.as_str() {
            "lost-steps" => &["axis", "steps", "count", "every"],
            "stuck" => &["axis", "hidden"],
            "slow" => &["axis", "factor"],
            "overshoot" => &["axis", "steps"],
            "event" => &["which", "count", "every", "within"],
            "moving" => &["pan", "tilt"],
            "unit-id" => &["id"],
            "baud" => &["rate"],
            "supply" => &["volts", "degf"],
            "text" => &["text", "count", "every"],
            "silence" => &["deaf"],
            "lost-byte" | "garbage-byte" => &["count", "skip"],
            "reset-fails" => &["count"],
            _ if KINDS.split(", ").any(|kind| kind == name) => &[],
            _ => return Err(FaultError::UnknownKind(name)),
        };
        let keys = Keys::read(&name, rest, own)?;
        let axes = || keys.axes();
        let kind = match name.as_str() {
            "lost-steps" => FaultKind::LostSteps {
                axes: axes()?,
                steps: keys.get("steps", 20, "a whole number", |v| {
                    v.parse().ok().filter(|n: &i32| n.abs() <= 100_000)
                })?,
            },
            "stuck" => FaultKind::Stuck {
                axes: axes()?,
                hidden: keys.flag("hidden")?,
            },
            "slow" => FaultKind::Slow {
                axes: axes()?,
                factor: keys.get("factor", 0.5, "a number above 0.01 and at most 1", |v| {
                    v.parse().ok().filter(|f| (0.01..=1.0).contains(f))
                })?,
            },
            "overshoot" => FaultKind::Overshoot {
                axes: axes()?,
                steps: keys.get("steps", 20, "a whole number from 1 to 1000", |v| {
                    v.parse().ok().filter(|n| (1..=1000).contains(n))
                })?,
            },
            "event" => FaultKind::Event {
                which: keys.get("which", 'P', "P, T or D", |v| {
                    let letter = v.chars().next().map(|c| c.to_ascii_uppercase());
                    letter.filter(|c| v.len() == 1 && "PTD".contains(*c))
                })?,
                within: keys.get("within", None, "a whole number from 0", |v| {
                    v.parse().ok().map(Some)
                })?,
            },
            "text" => FaultKind::Text(
                keys.get("text", "noise".to_owned(), "text", |v| Some(v.to_owned()))?,
            ),
            "echo" => FaultKind::Echo,
            "verbose" => FaultKind::Verbose,
            "velocity" => FaultKind::Velocity,
            "slaved" => FaultKind::Slaved,
            "limits-off" => FaultKind::LimitsOff,
            "monitor" => FaultKind::Monitor,
            "moving" => FaultKind::Moving([keys.steps("pan")?, keys.steps("tilt")?]),
            "unit-id" => {
                FaultKind::UnitId(keys.get("id", 5, "a whole number from 1 to 127", |v| {
                    v.parse().ok().filter(|id| (1..=127).contains(id))
                })?)
            }
            "baud" => FaultKind::Baud(keys.get("rate", 19_200, "a rate of the unit", |v| {
                let rate = v.parse().ok();
                rate.filter(|rate| BAUD_RATES.contains(rate) || E_BAUD_RATES.contains(rate))
            })?),
            "axis-error" => FaultKind::AxisError,
            "supply" => FaultKind::Supply {
                volts: keys.figure("volts", 21.0)?,
                degf: keys.figure("degf", 150.0)?,
            },
            "silence" => FaultKind::Silence {
                deaf: keys.flag("deaf")?,
            },
            "lost-byte" => FaultKind::LostByte {
                skip: keys.whole("skip", 0)?,
            },
            "garbage-byte" => FaultKind::GarbageByte {
                skip: keys.whole("skip", 0)?,
            },
            "reset-fails" => FaultKind::ResetFails,
            "power-cycle" => FaultKind::PowerCycle,
            _ => FaultKind::WrongBaud,
        };
        Ok(Self {
            kind,
            at: keys.time("at")?,
            lasting: keys.time("for")?,
            count: keys.whole("count", 1)?,
            every: keys
                .time("every")?
                .unwrap_or(Duration::from_secs(1))
                .max(Duration::from_millis(1)),
        })
    }
}

/// The `key=value` part of a description.
struct Keys<'a> {
    kind: &'a str,
    pairs: Vec<(&'a str, &'a str)>,
}

impl<'a> Keys<'a> {
    fn read(kind: &'a str, text: &'a str, own: &[&str]) -> Result<Self, FaultError> {
        let mut pairs = Vec::new();
        for piece in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (key, value) = piece.split_once('=').ok_or_else(|| FaultError::NotAPair {
                kind: kind.to_owned(),
                got: piece.to_owned(),
            })?;
            let (key, value) = (key.trim(), value.trim());
            if !matches!(key, "at" | "for") && !own.contains(&key) {
                let valid = ["at", "for"]
                    .iter()
                    .chain(own)
                    .copied()
                    .collect::<Vec<_>>()
                    .join(", ");
                return Err(FaultError::UnknownKey {
                    kind: kind.to_owned(),
                    key: key.to_owned(),
                    valid,
                });
            }
            pairs.push((key, value));
        }
        Ok(Self { kind, pairs })
    }

    fn get<T>(
        &self,
        key: &str,
        default: T,
        expected: &'static str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Result<T, FaultError> {
        let Some((_, value)) = self.pairs.iter().rev().find(|(k, _)| *k == key) else {
            return Ok(default);
        };
        read(value).ok_or_else(|| FaultError::BadValue {
            kind: self.kind.to_owned(),
            key: key.to_owned(),
            value: (*value).to_owned(),
            expected,
        })
    }

    fn axes(&self) -> Result<Vec<AxisName>, FaultError> {
        self.get(
            "axis",
            AxisName::BOTH.to_vec(),
            "pan, tilt or both",
            |v| match v {
                "pan" => Some(vec![AxisName::Pan]),
                "tilt" => Some(vec![AxisName::Tilt]),
                "both" => Some(AxisName::BOTH.to_vec()),
                _ => None,
            },
        )
    }

    /// A position, counts; 0 unless told.
    fn steps(&self, key: &str) -> Result<i32, FaultError> {
        self.get(key, 0, "a whole number of 16 bits", |v| {
            v.parse::<i16>().ok().map(i32::from)
        })
    }

    fn figure(&self, key: &str, default: f64) -> Result<f64, FaultError> {
        self.get(key, default, "a number from 0 to 1000", |v| {
            v.parse().ok().filter(|n| (0.0..=1000.0).contains(n))
        })
    }

    fn flag(&self, key: &str) -> Result<bool, FaultError> {
        self.get(key, false, "true or false", |v| v.parse().ok())
    }

    fn whole(&self, key: &str, default: u32) -> Result<u32, FaultError> {
        self.get(key, default, "a whole number from 0", |v| v.parse().ok())
    }

    fn time(&self, key: &str) -> Result<Option<Duration>, FaultError> {
        self.get(key, None, "a time such as 2.5, 2.5s or 300ms", |v| {
            let (digits, scale) = match v.strip_suffix("ms") {
                Some(ms) => (ms, 1e-3),
                None => (v.strip_suffix('s').unwrap_or(v), 1.0),
            };
            let seconds = digits.parse::<f64>().ok()? * scale;
            Duration::try_from_secs_f64(seconds).ok().map(Some)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_it_documents() {
        let fault: FaultSpec = "lost-steps:axis=tilt,steps=-7,at=2.5,count=3,every=200ms"
            .parse()
            .expect("valid");
        assert_eq!(
            fault.kind,
            FaultKind::LostSteps {
                axes: vec![AxisName::Tilt],
                steps: -7
            }
        );
        assert_eq!(
            (fault.at, fault.count),
            (Some(Duration::from_millis(2500)), 3)
        );
        assert_eq!(fault.every, Duration::from_millis(200));
        for kind in KINDS.split(", ") {
            assert!(
                format!("{kind}:at=1,for=2s").parse::<FaultSpec>().is_ok(),
                "{kind}"
            );
        }
        assert_eq!("lost_steps".parse::<FaultSpec>(), "lost-steps".parse());
    }

    #[test]
    fn errors_list_what_is_valid() {
        let error = |t: &str| t.parse::<FaultSpec>().expect_err("invalid").to_string();
        assert!(error("melt").contains("lost-steps, stuck") && error("melt").contains("`melt`"));
        assert_eq!(
            error("stuck:steps=2"),
            "fault `stuck` has no key `steps`; valid keys: at, for, axis, hidden"
        );
        assert!(error("slow:factor=7").contains("at most 1"));
        assert!(error("silence:for=-1").contains("a time such as"));
        assert!(error("slow:factor=nan").contains("is not a number"));
        assert!(error("event:count").contains("expected `key=value`"));
    }
}
