//! Options from text, `key=value`, as on a command line (scip2 section 15).

use super::constants::{BAUD_OF_OTHER_MODELS, BAUDS, TIMER_MASK};
use super::options::{LaserLink, LaserOptions, LaserStartState};
use super::profile::{KeyedSumRule, LaserProfile};

const KEYS: &str = "profile, serial, firmware, start, timer, clock-rate-error, motor-rate-error, stamp-offset, link, keyed-sum";

/// An option that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "each message shows what its fields are")]
pub enum LaserOptionError {
    #[error("expected key=value, got `{0}`")]
    NotAPair(String),
    #[error("unknown option `{0}`; valid: {KEYS}")]
    UnknownKey(String),
    #[error("option {key}: expected {expected}, got `{got}`")]
    BadValue {
        key: String,
        expected: &'static str,
        got: String,
    },
}

impl LaserOptions {
    /// Sets the model, and the link that it usually has.
    pub fn set_profile(&mut self, profile: LaserProfile) {
        self.link = if profile.generation.is_ethernet() {
            LaserLink::Network
        } else {
            LaserLink::Usb
        };
        self.profile = profile;
    }

    /// Changes one option from `key=value`. `profile` overrides others: set it first.
    ///
    /// | key | value | meaning |
    /// |---|---|---|
    /// | `profile` | `urg-04lx` `urg-04lx-ug01` `utm-30lx` `ust-20lx` | the model; sets the link too |
    /// | `serial` | text | `SERI` of `VV` |
    /// | `firmware` | text | `FIRM` of `VV` |
    /// | `start` | `power-up` `idle` `laser-on` `streaming` `time-adjust` `firmware-update` | the state at the start |
    /// | `timer` | s, below 16777.216 | timer at the start |
    /// | `clock-rate-error` | -0.05 to 0.05 | rate of the timer against the host's clock, minus one |
    /// | `motor-rate-error` | -0.05 to 0.05 | speed of the motor against nominal, by the timer, minus one |
    /// | `stamp-offset` | ms, -50 to 50 | when the stamp is taken, after step 0 |
    /// | `link` | `usb` `network` or a bit rate | a bit rate is RS-232C, paced |
    /// | `keyed-sum` | `before-semicolon` `with-semicolon` `before-comment` | what the sums of `KEY:value;` lines cover |
    ///
    /// # Errors
    /// [`LaserOptionError`] for an unknown key or a bad value.
    pub fn set(&mut self, text: &str) -> Result<(), LaserOptionError> {
        let (key, value) = text
            .split_once('=')
            .map(|(key, value)| (key.trim(), value.trim()))
            .ok_or_else(|| LaserOptionError::NotAPair(text.to_owned()))?;
        let wrong = |expected| LaserOptionError::BadValue {
            key: key.to_owned(),
            expected,
            got: value.to_owned(),
        };
        let number = |least: f64, most: f64| {
            let number = value.parse::<f64>().ok();
            number.filter(|number| (least..=most).contains(number))
        };
        let rate_error =
            || number(-0.05, 0.05).ok_or_else(|| wrong("a number between -0.05 and 0.05"));
        match key {
            "profile" => {
                let profile = LaserProfile::by_name(value);
                self.set_profile(
                    profile
                        .ok_or_else(|| wrong("urg-04lx, urg-04lx-ug01, utm-30lx or ust-20lx"))?,
                );
            }
            "serial" => value.clone_into(&mut self.profile.serial),
            "firmware" => value.clone_into(&mut self.profile.firmware),
            "start" => {
                self.start_state = start_state(value).ok_or_else(|| {
                    wrong("power-up, idle, laser-on, streaming, time-adjust or firmware-update")
                })?;
            }
            "timer" => {
                let seconds = number(0.0, 16_777.215);
                let seconds = seconds.ok_or_else(|| wrong("seconds from 0 and below 16777.216"))?;
                self.timer_start_ms = ((seconds * 1e3).round() as u32).min(TIMER_MASK);
            }
            "clock-rate-error" => self.clock_rate_error = rate_error()?,
            "motor-rate-error" => self.motor_rate_error = rate_error()?,
            "stamp-offset" => {
                let ms = number(-50.0, 50.0);
                self.stamp_offset_ms =
                    ms.ok_or_else(|| wrong("milliseconds between -50 and 50"))?;
            }
            "link" => {
                self.link = link(value).ok_or_else(|| wrong("usb, network or a bit rate"))?;
            }
            "keyed-sum" => {
                self.profile.keyed_sum = keyed_sum(value)
                    .ok_or_else(|| wrong("before-semicolon, with-semicolon or before-comment"))?;
            }
            _ => return Err(LaserOptionError::UnknownKey(key.to_owned())),
        }
        Ok(())
    }
}

fn start_state(text: &str) -> Option<LaserStartState> {
    Some(match text {
        "power-up" => LaserStartState::PowerUp,
        "idle" => LaserStartState::Idle,
        "laser-on" => LaserStartState::LaserOn,
        "streaming" => LaserStartState::Streaming,
        "time-adjust" => LaserStartState::TimeAdjust,
        "firmware-update" => LaserStartState::FirmwareUpdate,
        _ => return None,
    })
}

fn link(text: &str) -> Option<LaserLink> {
    match text {
        "usb" => Some(LaserLink::Usb),
        "network" => Some(LaserLink::Network),
        rate => {
            let baud = rate.parse().ok()?;
            let known = BAUDS.contains(&baud) || baud == BAUD_OF_OTHER_MODELS;
            known.then_some(LaserLink::Serial { baud })
        }
    }
}

fn keyed_sum(text: &str) -> Option<KeyedSumRule> {
    match text {
        "before-semicolon" => Some(KeyedSumRule::BeforeSemicolon),
        "with-semicolon" => Some(KeyedSumRule::WithSemicolon),
        "before-comment" => Some(KeyedSumRule::BeforeComment),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_listed_keys_are_valid() {
        let value = |key: &str| match key {
            "profile" => "utm-30lx",
            "start" => "streaming",
            "link" => "57600",
            "keyed-sum" => "with-semicolon",
            "serial" => "H0001234",
            _ => "0.01",
        };
        for key in KEYS.split(", ") {
            let text = format!("{key}={}", value(key));
            assert_eq!(LaserOptions::default().set(&text), Ok(()), "{key}");
        }
        let error = |text: &str| {
            LaserOptions::default()
                .set(text)
                .expect_err(text)
                .to_string()
        };
        assert!(error("colour=red").contains("clock-rate-error, motor"));
        assert_eq!(error("start"), "expected key=value, got `start`");
        assert!(error("profile=sick").contains("ust-20lx"));
        assert!(error("timer=16777.216").contains("below 16777.216"));
        assert!(error("link=9600").contains("a bit rate"));
        assert!(error("clock-rate-error=nan").contains("-0.05"));
        for name in LaserProfile::NAMES {
            assert_eq!(
                LaserOptions::default().set(&format!("profile={name}")),
                Ok(())
            );
        }
    }

    #[test]
    fn options_are_set() {
        let mut options = LaserOptions::default();
        for text in ["profile=ust-20lx", "serial=H7", "start=idle", "timer=16777"] {
            options.set(text).expect("valid");
        }
        assert_eq!(options.link, LaserLink::Network);
        assert_eq!(
            (options.profile.serial.as_str(), options.profile.max_step),
            ("H7", 1080)
        );
        assert_eq!(
            (options.start_state, options.timer_start_ms),
            (LaserStartState::Idle, 16_777_000)
        );
    }
}
