//! Options of the emulated head as text, `key=value`, for command lines and tests (ptu-d46 section 14).

use std::str::FromStr;
use std::time::Duration;

use super::constants::{
    BAUD_RATES, E_SERIES_BAUD_RATES, MAX_ACCELERATION, MAX_POSITION, MAX_SPEED,
};
use super::options::{HeadModel, HeadOptions, InputDuringReset, LineEnd};

/// Every key, in the order of the table at [`HeadOptions::set`].
const KEYS: &str = "model, series, firmware, pan-min, pan-max, tilt-min, tilt-max, limit-spread, speed, base-speed, \
acceleration, upper-speed, lower-speed, reset-speed, echo, verbose, velocity, slaved, limits, monitor, unit-id, baud, pan, \
tilt, moving-to, power-up, calibrate, banner, pacing, whole-steps, option-board, backlash, line-end, latency, table-delay, \
input-during-reset, volts, degf";

/// An option text that is not valid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HeadOptionError {
    /// A text without `=`.
    #[error("expected key=value, got `{0}`")]
    NotAPair(String),
    /// A key that does not exist.
    #[error("unknown option `{0}`; valid: {KEYS}")]
    UnknownKey(String),
    /// A value that is not valid for its key.
    #[error("option {key}: expected {expected}, got `{got}`")]
    BadValue {
        /// The key.
        key: String,
        /// What is valid.
        expected: &'static str,
        /// The value.
        got: String,
    },
}

/// A value with its key, for messages.
struct OptionValue<'a> {
    key: &'a str,
    text: &'a str,
}

impl OptionValue<'_> {
    fn bad_value(&self, expected: &'static str) -> HeadOptionError {
        HeadOptionError::BadValue {
            key: self.key.to_owned(),
            expected,
            got: self.text.to_owned(),
        }
    }

    fn one_of<T: Copy>(
        &self,
        words: &[(&str, T)],
        expected: &'static str,
    ) -> Result<T, HeadOptionError> {
        let found = words.iter().find(|(word, _)| *word == self.text);
        found
            .map(|(_, value)| *value)
            .ok_or_else(|| self.bad_value(expected))
    }

    fn switch(&self) -> Result<bool, HeadOptionError> {
        self.one_of(&[("on", true), ("off", false)], "on or off")
    }

    fn within<T: FromStr + PartialOrd>(
        &self,
        min: T,
        max: T,
        expected: &'static str,
    ) -> Result<T, HeadOptionError> {
        read_within(self.text, &min, &max).ok_or_else(|| self.bad_value(expected))
    }

    fn position(&self) -> Result<i32, HeadOptionError> {
        self.within(-MAX_POSITION, MAX_POSITION, "a whole number of 16 bits")
    }

    fn speed(&self) -> Result<[i32; 2], HeadOptionError> {
        let speed = self.within(1, MAX_SPEED, "a whole number from 1 to 12000")?;
        Ok([speed; 2])
    }

    /// Two numbers separated by `/`.
    fn pair<T: FromStr + PartialOrd>(
        &self,
        min: T,
        max: T,
        expected: &'static str,
    ) -> Result<[T; 2], HeadOptionError> {
        let both = self.text.split_once('/').and_then(|(first, second)| {
            Some([
                read_within(first, &min, &max)?,
                read_within(second, &min, &max)?,
            ])
        });
        both.ok_or_else(|| self.bad_value(expected))
    }
}

fn read_within<T: FromStr + PartialOrd>(text: &str, min: &T, max: &T) -> Option<T> {
    let value = text.trim().parse::<T>().ok()?;
    (value >= *min && value <= *max).then_some(value)
}

impl HeadOptions {
    /// Sets one option from `key=value`. `model` and `series` set several others: give them first.
    ///
    /// | key | value | what it is |
    /// |---|---|---|
    /// | `model` | `d46-17` `d46-70` | the gear, with its ranges |
    /// | `series` | `d46` `e` | command set, wordings and immediate `RP RT RE` of the E series |
    /// | `firmware` | text | what `V` prints |
    /// | `pan-min` `pan-max` `tilt-min` `tilt-max` | half steps | nominal limits |
    /// | `limit-spread` | half steps | largest deviation of each calibration's limits from the nominal ones |
    /// | `speed` `base-speed` `acceleration` `upper-speed` `lower-speed` `reset-speed` | counts/s, counts/s^2 | both axes |
    /// | `echo` `verbose` `velocity` `slaved` `limits` `monitor` | `on` `off` | start state |
    /// | `unit-id` | 0 to 127 | network id at the start |
    /// | `baud` | a rate of ptu-d46 section 1 | line speed at the start |
    /// | `pan` `tilt` | half steps | position at the start |
    /// | `moving-to` | `pan/tilt`, half steps | targets of a move under way |
    /// | `power-up` | `on` `off` | it is being switched on: banner, calibration |
    /// | `calibrate` `banner` | `on` `off` | what it does at power-up |
    /// | `pacing` `whole-steps` `option-board` | `on` `off` | bytes take time on the line; the rotor moves in whole steps; the option board is fitted |
    /// | `backlash` | `pan/tilt`, half steps | play between rotor and head |
    /// | `line-end` | `crlf` `cr` | of replies |
    /// | `latency` | `min/max`, ms | from delimiter to reply |
    /// | `table-delay` | s | time to recompute after `PA PB PU` |
    /// | `input-during-reset` | `queued` `dropped` | bytes received during a calibration |
    /// | `volts` `degf` | number | what `O` reports |
    ///
    /// # Errors
    /// [`HeadOptionError`].
    pub fn set(&mut self, text: &str) -> Result<(), HeadOptionError> {
        let (key, value) = text
            .split_once('=')
            .ok_or_else(|| HeadOptionError::NotAPair(text.to_owned()))?;
        let value = OptionValue {
            key: key.trim(),
            text: value.trim(),
        };
        if !self.set_identity(&value)? && !self.set_start(&value)? && !self.set_wire(&value)? {
            return Err(HeadOptionError::UnknownKey(value.key.to_owned()));
        }
        Ok(())
    }

    fn set_identity(&mut self, value: &OptionValue<'_>) -> Result<bool, HeadOptionError> {
        match value.key {
            "model" => {
                let models = [("d46-17", HeadModel::D46_17), ("d46-70", HeadModel::D46_70)];
                let gear = Self::for_model(value.one_of(&models, "d46-17 or d46-70")?);
                self.model = gear.model;
                self.minimum_steps = gear.minimum_steps;
                self.maximum_steps = gear.maximum_steps;
                self.reset_speed = gear.reset_speed;
            }
            "series" => {
                self.e_series = value.one_of(&[("d46", false), ("e", true)], "d46 or e")?;
                self.axis_reset_at_once = self.e_series;
            }
            "firmware" => value.text.clone_into(&mut self.firmware),
            "pan-min" => self.minimum_steps[0] = value.position()?,
            "pan-max" => self.maximum_steps[0] = value.position()?,
            "tilt-min" => self.minimum_steps[1] = value.position()?,
            "tilt-max" => self.maximum_steps[1] = value.position()?,
            "limit-spread" => {
                self.limit_spread_steps = value.within(0, 100, "a whole number from 0 to 100")?;
            }
            "speed" => self.speed = value.speed()?,
            "base-speed" => self.base_speed = value.speed()?,
            "upper-speed" => self.upper_speed = value.speed()?,
            "lower-speed" => self.lower_speed = value.speed()?,
            "reset-speed" => self.reset_speed = value.speed()?,
            "acceleration" => {
                let expected = "a whole number from 1 to 200000";
                self.acceleration = [value.within(1, MAX_ACCELERATION, expected)?; 2];
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn set_start(&mut self, value: &OptionValue<'_>) -> Result<bool, HeadOptionError> {
        let start = &mut self.start;
        match value.key {
            "echo" => start.echo = value.switch()?,
            "verbose" => start.verbose = value.switch()?,
            "velocity" => start.velocity_mode = value.switch()?,
            "slaved" => start.slaved = value.switch()?,
            "limits" => start.limits = value.switch()?,
            "monitor" => start.monitor = value.switch()?,
            "unit-id" => start.unit_id = value.within(0, 127, "a whole number from 0 to 127")?,
            "baud" => {
                let known =
                    |rate: &u32| BAUD_RATES.contains(rate) || E_SERIES_BAUD_RATES.contains(rate);
                let rate = value.text.parse().ok().filter(known);
                start.baud = rate.ok_or_else(|| value.bad_value("a rate of the unit"))?;
            }
            "pan" => start.position_steps[0] = value.position()?,
            "tilt" => start.position_steps[1] = value.position()?,
            "moving-to" => {
                let targets = value.pair(-MAX_POSITION, MAX_POSITION, "pan/tilt in half steps")?;
                start.moving_to_steps = Some(targets);
            }
            "power-up" => self.power_up = value.switch()?,
            "calibrate" => self.calibrate_at_power_up = value.switch()?,
            "banner" => self.banner = value.switch()?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn set_wire(&mut self, value: &OptionValue<'_>) -> Result<bool, HeadOptionError> {
        match value.key {
            "pacing" => self.byte_pacing = value.switch()?,
            "whole-steps" => self.whole_steps = value.switch()?,
            "backlash" => {
                let expected = "pan/tilt in half steps, 0 to 100";
                self.backlash_half_steps = value.pair(0.0, 100.0, expected)?;
            }
            "option-board" => self.option_board = value.switch()?,
            "line-end" => {
                let ends = [("crlf", LineEnd::CrLf), ("cr", LineEnd::Cr)];
                self.line_end = value.one_of(&ends, "crlf or cr")?;
            }
            "latency" => {
                let expected = "min/max in milliseconds, 0 to 10000";
                let both = value.pair(0.0, 10_000.0, expected)?;
                self.latency = both.map(|ms: f64| Duration::from_secs_f64(ms / 1e3));
            }
            "table-delay" => {
                let seconds: f64 = value.within(0.0, 60.0, "seconds from 0 to 60")?;
                self.table_delay = Duration::from_secs_f64(seconds);
            }
            "input-during-reset" => {
                let ways = [
                    ("queued", InputDuringReset::Queued),
                    ("dropped", InputDuringReset::Dropped),
                ];
                self.input_during_reset = value.one_of(&ways, "queued or dropped")?;
            }
            "volts" => {
                self.supply.volts = value.within(0.0, 1000.0, "a number from 0 to 1000")?;
            }
            "degf" => {
                let degf = value.within(-100.0, 1000.0, "a number from -100 to 1000")?;
                self.supply.temperature_f = [degf; 3];
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_list_is_known_and_no_other() {
        let value = |key: &str| {
            match key {
            "model" => "d46-70",
            "series" => "e",
            "moving-to" => "100/-50",
            "latency" | "backlash" => "1/2.5",
            "line-end" => "cr",
            "input-during-reset" => "dropped",
            "baud" => "38400",
            "firmware" => "v1.09.0b, (C)1996",
            key if "echo verbose velocity slaved limits monitor power-up calibrate banner pacing whole-steps option-board"
                .split(' ')
                .any(|word| word == key) =>
            {
                "on"
            }
            _ => "7",
        }
        };
        for key in KEYS.split(", ") {
            let mut options = HeadOptions::default();
            options.start.echo = false;
            assert_eq!(
                options.set(&format!("{key}={}", value(key))),
                Ok(()),
                "{key}"
            );
        }
        let error = |text: &str| {
            HeadOptions::default()
                .set(text)
                .expect_err(text)
                .to_string()
        };
        assert!(error("colour=red").contains("moving-to, power-up"));
        assert_eq!(error("echo"), "expected key=value, got `echo`");
        assert_eq!(error("echo=1"), "option echo: expected on or off, got `1`");
        assert!(error("latency=nan/1").contains("milliseconds"));
        assert!(error("pan=40000").contains("16 bits"));
        assert!(error("baud=9601").contains("a rate"));
    }

    #[test]
    fn options_given_as_text_take_effect() {
        let mut options = HeadOptions::default();
        for text in [
            "model=d46-70",
            "series=e",
            "velocity=on",
            "moving-to=10/-20",
            "latency=5/9",
        ] {
            options.set(text).expect("valid");
        }
        assert_eq!(options.minimum_steps, [-12_360, -3628]);
        assert!(options.e_series && options.axis_reset_at_once && options.start.velocity_mode);
        assert_eq!(options.start.moving_to_steps, Some([10, -20]));
        assert_eq!(options.latency, [5, 9].map(Duration::from_millis));
    }
}
