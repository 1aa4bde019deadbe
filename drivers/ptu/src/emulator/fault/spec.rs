//! Faults of the emulated head as text, and their parsing.

use std::time::Duration;

use crate::emulator::axis_name::AxisName;
use crate::emulator::constants::{BAUD_RATES, E_SERIES_BAUD_RATES};

/// Every kind, for messages.
const KINDS: &str = "lost-steps, stuck, slow, overshoot, event, text, echo, verbose, velocity, slaved, limits-off, monitor, moving, unit-id, baud, axis-error, supply, silence, lost-byte, garbage-byte, reset-fails, power-cycle, wrong-baud";

/// A fault text that is not valid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HeadFaultError {
    /// A kind that does not exist.
    #[error("unknown fault `{0}`; valid kinds: {KINDS}")]
    UnknownKind(String),
    /// A key that this kind does not have.
    #[error("fault `{kind}` has no key `{key}`; valid keys: {valid}")]
    UnknownKey {
        /// The fault.
        kind: String,
        /// The key.
        key: String,
        /// The keys that are valid.
        valid: String,
    },
    /// A value that is not valid for its key.
    #[error("fault `{kind}`: `{key}={value}` is not {expected}")]
    BadValue {
        /// The fault.
        kind: String,
        /// The key.
        key: String,
        /// The value.
        value: String,
        /// What is valid.
        expected: &'static str,
    },
    /// A part without `=`.
    #[error("fault `{kind}`: expected `key=value`, got `{got}`")]
    NotAPair {
        /// The fault.
        kind: String,
        /// The part.
        got: String,
    },
}

/// What goes wrong.
#[derive(Debug, Clone, PartialEq)]
pub enum HeadFaultKind {
    /// The rotor jumps by this many counts; the reported position does not.
    LostSteps {
        /// Axes concerned.
        axes: Vec<AxisName>,
        /// Counts, signed.
        steps: i32,
    },
    /// An axis does not move.
    Stuck {
        /// Axes concerned.
        axes: Vec<AxisName>,
        /// Only the rotor is blocked; the reported position advances.
        hidden: bool,
    },
    /// An axis is slower than commanded.
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
        /// Output bytes let through before it; `None`: at once, wherever the output is.
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
    /// The unit sends and receives at this rate.
    Baud(u32),
    /// The axes are not calibrated.
    AxisError,
    /// What `O` reports.
    Supply {
        /// Volts.
        volts: f64,
        /// Degrees Fahrenheit of head and motors.
        degf: f64,
    },
    /// Nothing is sent.
    Silence {
        /// Nothing is received either.
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
    /// Power is switched off and on again.
    PowerCycle,
    /// Bytes are garbage both ways.
    WrongBaud,
}

impl HeadFaultKind {
    /// Every kind as text, in the order of the table at [`HeadFaultSpec`].
    pub fn kinds() -> impl Iterator<Item = &'static str> {
        KINDS.split(", ")
    }
}

/// One fault and when it strikes. As text: `kind[:key=value,...]`.
///
/// | kind | keys | what happens |
/// |---|---|---|
/// | `lost-steps` | `axis steps count every` | the rotor jumps by `steps` counts (20), the count stays |
/// | `stuck` | `axis hidden` | the count stalls; with `hidden=true` the count runs and the rotor is blocked |
/// | `slow` | `axis factor` | all speeds of the axis times `factor` (0.5) |
/// | `overshoot` | `axis steps` | the axis runs `steps` counts (20) past each target and comes back |
/// | `event` | `which count every within` | an unsolicited `!P`, `!T` or `!D` (`which=P`); `within=N` lets N bytes of the next replies pass first, so that it comes in their middle |
/// | `text` | `text count every` | unsolicited text on a line of its own |
/// | `echo` | | echo is on again |
/// | `verbose` | | verbose replies are back |
/// | `velocity` `slaved` `limits-off` `monitor` | | as after `CV`, `S`, `LD`, `M` of another program |
/// | `moving` | `pan tilt` | another program sent the head there |
/// | `unit-id` | `id` | the unit has this network id (5) and is not selected |
/// | `baud` | `rate` | the unit sends at another rate (19200); the host receives garbage if the emulator knows the host's rate |
/// | `axis-error` | | the axes are not calibrated; an E-series unit refuses targets with `! Axis Error` |
/// | `supply` | `volts degf` | `O` reports these volts (21) and degrees Fahrenheit (150) |
/// | `silence` | `deaf` | nothing is sent; with `deaf=true` nothing is received either |
/// | `lost-byte` | `count skip` | the next `count` (1) output bytes are lost, letting `skip` through before each |
/// | `garbage-byte` | `count skip` | as above, replaced by a random byte |
/// | `reset-fails` | `count` | the next `count` (1) calibrations fail |
/// | `power-cycle` | | power off and on; `for` is how long it is off |
/// | `wrong-baud` | | garbage both ways |
///
/// Common keys: `at` (instant of virtual time, s; default now), `for` (s; default for ever). `count` repeats one-time
/// faults every `every` seconds (1). `axis` is `pan`, `tilt` or `both` (the default).
#[derive(Debug, Clone, PartialEq)]
pub struct HeadFaultSpec {
    /// What goes wrong.
    pub kind: HeadFaultKind,
    /// From when on, virtual time; `None`: at once.
    pub at: Option<Duration>,
    /// For how long; `None`: for ever (a power cycle: no time).
    pub lasting: Option<Duration>,
    /// Number of strikes (one-time faults), bytes or calibrations.
    pub count: u32,
    /// Time between the strikes of a one-time fault.
    pub every: Duration,
}

impl std::str::FromStr for HeadFaultSpec {
    type Err = HeadFaultError;

    fn from_str(text: &str) -> Result<Self, HeadFaultError> {
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
            _ => return Err(HeadFaultError::UnknownKind(name)),
        };
        let keys = FaultKeys::read(&name, rest, own)?;
        let axes = || keys.axes();
        let kind = match name.as_str() {
            "lost-steps" => HeadFaultKind::LostSteps {
                axes: axes()?,
                steps: keys.get("steps", 20, "a whole number", |v| {
                    v.parse().ok().filter(|n: &i32| n.abs() <= 100_000)
                })?,
            },
            "stuck" => HeadFaultKind::Stuck {
                axes: axes()?,
                hidden: keys.flag("hidden")?,
            },
            "slow" => HeadFaultKind::Slow {
                axes: axes()?,
                factor: keys.get("factor", 0.5, "a number above 0.01 and at most 1", |v| {
                    v.parse().ok().filter(|f| (0.01..=1.0).contains(f))
                })?,
            },
            "overshoot" => HeadFaultKind::Overshoot {
                axes: axes()?,
                steps: keys.get("steps", 20, "a whole number from 1 to 1000", |v| {
                    v.parse().ok().filter(|n| (1..=1000).contains(n))
                })?,
            },
            "event" => HeadFaultKind::Event {
                which: keys.get("which", 'P', "P, T or D", |v| {
                    let letter = v.chars().next().map(|c| c.to_ascii_uppercase());
                    letter.filter(|c| v.len() == 1 && "PTD".contains(*c))
                })?,
                within: keys.get("within", None, "a whole number from 0", |v| {
                    v.parse().ok().map(Some)
                })?,
            },
            "text" => HeadFaultKind::Text(
                keys.get("text", "noise".to_owned(), "text", |v| Some(v.to_owned()))?,
            ),
            "echo" => HeadFaultKind::Echo,
            "verbose" => HeadFaultKind::Verbose,
            "velocity" => HeadFaultKind::Velocity,
            "slaved" => HeadFaultKind::Slaved,
            "limits-off" => HeadFaultKind::LimitsOff,
            "monitor" => HeadFaultKind::Monitor,
            "moving" => HeadFaultKind::Moving([keys.steps("pan")?, keys.steps("tilt")?]),
            "unit-id" => {
                HeadFaultKind::UnitId(keys.get("id", 5, "a whole number from 1 to 127", |v| {
                    v.parse().ok().filter(|id| (1..=127).contains(id))
                })?)
            }
            "baud" => HeadFaultKind::Baud(keys.get("rate", 19_200, "a rate of the unit", |v| {
                let rate = v.parse().ok();
                rate.filter(|rate| BAUD_RATES.contains(rate) || E_SERIES_BAUD_RATES.contains(rate))
            })?),
            "axis-error" => HeadFaultKind::AxisError,
            "supply" => HeadFaultKind::Supply {
                volts: keys.number("volts", 21.0)?,
                degf: keys.number("degf", 150.0)?,
            },
            "silence" => HeadFaultKind::Silence {
                deaf: keys.flag("deaf")?,
            },
            "lost-byte" => HeadFaultKind::LostByte {
                skip: keys.whole("skip", 0)?,
            },
            "garbage-byte" => HeadFaultKind::GarbageByte {
                skip: keys.whole("skip", 0)?,
            },
            "reset-fails" => HeadFaultKind::ResetFails,
            "power-cycle" => HeadFaultKind::PowerCycle,
            _ => HeadFaultKind::WrongBaud,
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

/// The `key=value` part of a fault text.
struct FaultKeys<'a> {
    kind: &'a str,
    pairs: Vec<(&'a str, &'a str)>,
}

impl<'a> FaultKeys<'a> {
    fn read(kind: &'a str, text: &'a str, own: &[&str]) -> Result<Self, HeadFaultError> {
        let mut pairs = Vec::new();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (key, value) = part
                .split_once('=')
                .ok_or_else(|| HeadFaultError::NotAPair {
                    kind: kind.to_owned(),
                    got: part.to_owned(),
                })?;
            let (key, value) = (key.trim(), value.trim());
            if !matches!(key, "at" | "for") && !own.contains(&key) {
                let valid = ["at", "for"]
                    .iter()
                    .chain(own)
                    .copied()
                    .collect::<Vec<_>>()
                    .join(", ");
                return Err(HeadFaultError::UnknownKey {
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
    ) -> Result<T, HeadFaultError> {
        let Some((_, value)) = self.pairs.iter().rev().find(|(k, _)| *k == key) else {
            return Ok(default);
        };
        read(value).ok_or_else(|| HeadFaultError::BadValue {
            kind: self.kind.to_owned(),
            key: key.to_owned(),
            value: (*value).to_owned(),
            expected,
        })
    }

    fn axes(&self) -> Result<Vec<AxisName>, HeadFaultError> {
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

    /// A position, counts; 0 by default.
    fn steps(&self, key: &str) -> Result<i32, HeadFaultError> {
        self.get(key, 0, "a whole number of 16 bits", |v| {
            v.parse::<i16>().ok().map(i32::from)
        })
    }

    fn number(&self, key: &str, default: f64) -> Result<f64, HeadFaultError> {
        self.get(key, default, "a number from 0 to 1000", |v| {
            v.parse().ok().filter(|n| (0.0..=1000.0).contains(n))
        })
    }

    fn flag(&self, key: &str) -> Result<bool, HeadFaultError> {
        self.get(key, false, "true or false", |v| v.parse().ok())
    }

    fn whole(&self, key: &str, default: u32) -> Result<u32, HeadFaultError> {
        self.get(key, default, "a whole number from 0", |v| v.parse().ok())
    }

    fn time(&self, key: &str) -> Result<Option<Duration>, HeadFaultError> {
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
    fn every_documented_form_is_parsed() {
        let fault: HeadFaultSpec = "lost-steps:axis=tilt,steps=-7,at=2.5,count=3,every=200ms"
            .parse()
            .expect("valid");
        assert_eq!(
            fault.kind,
            HeadFaultKind::LostSteps {
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
                format!("{kind}:at=1,for=2s")
                    .parse::<HeadFaultSpec>()
                    .is_ok(),
                "{kind}"
            );
        }
        assert_eq!("lost_steps".parse::<HeadFaultSpec>(), "lost-steps".parse());
    }

    #[test]
    fn errors_list_what_is_valid() {
        let error = |t: &str| t.parse::<HeadFaultSpec>().expect_err("invalid").to_string();
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
