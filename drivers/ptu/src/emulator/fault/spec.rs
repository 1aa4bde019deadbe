//! Faults of the emulated head as text, and their parsing.

use fault_text::{FaultKeys, FaultKind, FaultTextError, FaultTimes};

use crate::emulator::axis_name::AxisName;
use crate::emulator::constants::{BAUD_RATES, E_SERIES_BAUD_RATES};

/// Every kind with its own keys, in the order of the table at [`HeadFaultSpec`].
const KINDS: [FaultKind; 23] = [
    ("lost-steps", &["axis", "steps"]),
    ("stuck", &["axis", "hidden"]),
    ("slow", &["axis", "factor"]),
    ("overshoot", &["axis", "steps"]),
    ("event", &["which", "within"]),
    ("text", &["text"]),
    ("echo", &[]),
    ("verbose", &[]),
    ("velocity", &[]),
    ("slaved", &[]),
    ("limits-off", &[]),
    ("monitor", &[]),
    ("moving", &["pan", "tilt"]),
    ("unit-id", &["id"]),
    ("baud", &["rate"]),
    ("axis-error", &[]),
    ("supply", &["volts", "degf"]),
    ("silence", &["deaf"]),
    ("lost-byte", &["skip"]),
    ("garbage-byte", &["skip"]),
    ("reset-fails", &[]),
    ("power-cycle", &[]),
    ("wrong-baud", &[]),
];

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
    /// The names of all kinds.
    pub fn kinds() -> impl Iterator<Item = &'static str> {
        KINDS.iter().map(|(kind, _)| *kind)
    }
}

/// One fault and when it strikes. As text: `kind[:key=value,...]` ([`fault_text`]).
///
/// | kind | own keys | what happens |
/// |---|---|---|
/// | `lost-steps` | `axis steps` | the rotor jumps by `steps` counts (20), the count stays |
/// | `stuck` | `axis hidden` | the count stalls; with `hidden=true` the count runs and the rotor is blocked |
/// | `slow` | `axis factor` | all speeds of the axis times `factor` (0.5) |
/// | `overshoot` | `axis steps` | the axis runs `steps` counts (20) past each target and comes back |
/// | `event` | `which within` | an unsolicited `!P`, `!T` or `!D` (`which=P`); `within=N` lets N bytes of the next replies pass first, so that it comes in their middle |
/// | `text` | `text` | unsolicited text on a line of its own |
/// | `echo` | | echo is on again |
/// | `verbose` | | verbose replies are back |
/// | `velocity` `slaved` `limits-off` `monitor` | | as after `CV`, `S`, `LD`, `M` of another program |
/// | `moving` | `pan tilt` | another program sent the head there |
/// | `unit-id` | `id` | the unit has this network id (5) and is not selected |
/// | `baud` | `rate` | the unit sends at another rate (19200); the host receives garbage if the emulator knows the host's rate |
/// | `axis-error` | | the axes are not calibrated; an E-series unit refuses targets with `! Axis Error` |
/// | `supply` | `volts degf` | `O` reports these volts (21) and degrees Fahrenheit (150) |
/// | `silence` | `deaf` | nothing is sent; with `deaf=true` nothing is received either |
/// | `lost-byte` | `skip` | the next `count` (1) output bytes are lost, letting `skip` through before each |
/// | `garbage-byte` | `skip` | as above, replaced by a random byte |
/// | `reset-fails` | | the next `count` (1) calibrations fail |
/// | `power-cycle` | | power off and on; `for` is how long it is off |
/// | `wrong-baud` | | garbage both ways |
///
/// `axis` is `pan`, `tilt` or `both` (the default). `count` (1) repeats what strikes once, and what lasts `for` a time, every
/// `every` (1 s); of bytes and calibrations it counts those that are hit, at least `every` (0 s) apart.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadFaultSpec {
    /// What goes wrong.
    pub kind: HeadFaultKind,
    /// When, how long, how often.
    pub times: FaultTimes,
}

impl std::str::FromStr for HeadFaultSpec {
    type Err = FaultTextError;

    fn from_str(text: &str) -> Result<Self, FaultTextError> {
        let keys = FaultKeys::split(text, &KINDS)?;
        let axes = || axes(&keys);
        let steps = |key| {
            keys.get(key, 0, "a whole number of 16 bits", |v| {
                v.parse::<i16>().ok().map(i32::from)
            })
        };
        let number = |key, default| {
            keys.get(key, default, "a number from 0 to 1000", |v| {
                v.parse().ok().filter(|n| (0.0..=1000.0).contains(n))
            })
        };
        let kind = match keys.kind() {
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
            "moving" => HeadFaultKind::Moving([steps("pan")?, steps("tilt")?]),
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
                volts: number("volts", 21.0)?,
                degf: number("degf", 150.0)?,
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
            times: keys.times()?,
        })
    }
}

fn axes(keys: &FaultKeys<'_>) -> Result<Vec<AxisName>, FaultTextError> {
    let both = AxisName::BOTH.to_vec();
    keys.get("axis", both, "pan, tilt or both", |v| match v {
        "pan" => Some(vec![AxisName::Pan]),
        "tilt" => Some(vec![AxisName::Tilt]),
        "both" => Some(AxisName::BOTH.to_vec()),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

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
        let times = FaultTimes {
            at: Some(Duration::from_millis(2500)),
            lasting: None,
            count: Some(3),
            every: Some(Duration::from_millis(200)),
        };
        assert_eq!(fault.times, times);
        for (kind, _) in KINDS {
            assert!(
                format!("{kind}:at=300ms,for=2s,count=2,every=5")
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
            "fault `stuck` has no key `steps`; valid keys: at, for, count, every, axis, hidden"
        );
        assert!(error("slow:factor=7").contains("at most 1"));
        assert!(error("silence:for=-1").contains("a time such as"));
        assert!(error("slow:factor=nan").contains("to be a number"));
        assert!(error("event:count").contains("expected `key=value`"));
    }
}
