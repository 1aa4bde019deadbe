//! Options of a sensor as text, `key=value`: what a command line or a test can ask for (section 15).
//!
//! | key | value | what it is |
//! |---|---|---|
//! | `profile` | `urg-04lx` `urg-04lx-ug01` `utm-30lx` `ust-20lx` | the model; sets the link too |
//! | `serial` | text | `SERI` of `VV` |
//! | `firmware` | text | `FIRM` of `VV` |
//! | `start` | `power-up` `idle` `laser-on` `streaming` `time-adjust` `firmware-update` | the state it is found in |
//! | `timer` | s, below 16777.216 | what its timer shows at the start |
//! | `clock-rate-error` | -0.05 to 0.05 | how much faster than the host's clock its timer runs |
//! | `motor-rate-error` | -0.05 to 0.05 | how much faster than nominal its motor turns by its timer |
//! | `stamp-offset` | ms, -50 to 50 | how long after step 0 its timer is read for a scan's stamp |
//! | `link` | `usb` `network` or a bit rate | what the bytes travel over; a bit rate is RS-232C, paced |
//! | `keyed-sum` | `before-semicolon` `with-semicolon` `before-comment` | what sums of `KEY:value;` lines count |

use super::constants::{BAUD_OF_OTHER_MODELS, BAUDS, TIMER_MASK};
use super::options::{Link, StartState, TwinOptions};
use super::profile::{KeyedSum, Profile};

/// Every key, in the order of the table.
const KEYS: &str = "profile, serial, firmware, start, timer, clock-rate-error, motor-rate-error, stamp-offset, link, keyed-sum";

/// An option that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum OptionError {
    /// A text without `=`.
    #[error("expected key=value, got `{0}`")]
    NotAPair(String),
    /// The word before `=`.
    #[error("unknown option `{0}`; valid: {KEYS}")]
    UnknownKey(String),
    /// The word after it.
    #[error("option {key}: expected {expected}, got `{got}`")]
    BadValue {
        /// The option.
        key: String,
        /// What it can be.
        expected: &'static str,
        /// What stood there.
        got: String,
    },
}

impl TwinOptions {
    /// Makes it this model, on the link that belongs to it.
    pub fn set_profile(&mut self, profile: Profile) {
        self.link = if profile.generation.is_ethernet() {
            Link::Network
        } else {
            Link::Usb
        };
        self.profile = profile;
    }

    /// Changes one option told as `key=value`; the keys are in the table above. `profile` sets several others: give it
    /// first.
    ///
    /// # Errors
    /// [`OptionError`].
    pub fn set(&mut self, text: &str) -> Result<(), OptionError> {
        let (key, value) = text
            .split_once('=')
            .map(|(key, value)| (key.trim(), value.trim()))
            .ok_or_else(|| OptionError::NotAPair(text.to_owned()))?;
        let wrong = |expected| OptionError::BadValue {
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
                let profile = Profile::by_name(value);
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
            _ => return Err(OptionError::UnknownKey(key.to_owned())),
        }
        Ok(())
    }
}

fn start_state(word: &str) -> Option<StartState> {
    Some(match word {
        "power-up" => StartState::PowerUp,
        "idle" => StartState::Idle,
        "laser-on" => StartState::LaserOn,
        "streaming" => StartState::Streaming,
        "time-adjust" => StartState::TimeAdjust,
        "firmware-update" => StartState::FirmwareUpdate,
        _ => return None,
    })
}

fn link(word: &str) -> Option<Link> {
    match word {
        "usb" => Some(Link::Usb),
        "network" => Some(Link::Network),
        rate => {
            let baud = rate.parse().ok()?;
            let known = BAUDS.contains(&baud) || baud == BAUD_OF_OTHER_MODELS;
            known.then_some(Link::Serial { baud })
        }
    }
}

fn keyed_sum(word: &str) -> Option<KeyedSum> {
    match word {
        "before-semicolon" => Some(KeyedSum::BeforeSemicolon),
        "with-semicolon" => Some(KeyedSum::WithSemicolon),
        "before-comment" => Some(KeyedSum::BeforeComment),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_list_is_known_and_no_other() {
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
            assert_eq!(TwinOptions::default().set(&text), Ok(()), "{key}");
        }
        let error = |text: &str| {
            TwinOptions::default()
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
        for name in Profile::NAMES {
            assert_eq!(
                TwinOptions::default().set(&format!("profile={name}")),
                Ok(())
            );
        }
    }

    #[test]
    fn what_is_told_is_what_holds() {
        let mut options = TwinOptions::default();
        for text in ["profile=ust-20lx", "serial=H7", "start=idle", "timer=16777"] {
            options.set(text).expect("valid");
        }
        assert_eq!(options.link, Link::Network);
        assert_eq!(
            (options.profile.serial.as_str(), options.profile.max_step),
            ("H7", 1080)
        );
        assert_eq!(
            (options.start_state, options.timer_start_ms),
            (StartState::Idle, 16_777_000)
        );
    }
}
