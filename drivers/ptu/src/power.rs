//! Power of the motors at rest and while moving (ptu-d46 section 10).

/// Power of an axis at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HoldPower {
    /// For a duty cycle below 20 %.
    Regular,
    /// The usual setting.
    Low,
    /// None: the load may turn the axis, which then needs a new calibration.
    Off,
}

/// Power of a moving axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MovePower {
    /// For a duty cycle below 20 %.
    High,
    /// The usual setting.
    Regular,
    /// For light loads and less heat.
    Low,
}

impl HoldPower {
    /// Parses `LOW`, `REG`, `OFF` and `Pan in LOW hold power mode`.
    pub(crate) fn from_text(text: &str) -> Option<Self> {
        find_keyword(
            text,
            &[
                ("REG", Self::Regular),
                ("REGULAR", Self::Regular),
                ("LOW", Self::Low),
                ("OFF", Self::Off),
            ],
        )
    }
}

impl MovePower {
    /// Parses `LOW`, `REG`, `HIGH` and `Pan in REGULAR move power mode`.
    pub(crate) fn from_text(text: &str) -> Option<Self> {
        find_keyword(
            text,
            &[
                ("REG", Self::Regular),
                ("REGULAR", Self::Regular),
                ("LOW", Self::Low),
                ("HIGH", Self::High),
            ],
        )
    }
}

fn find_keyword<T: Copy>(text: &str, words: &[(&str, T)]) -> Option<T> {
    text.split(|c: char| !c.is_ascii_alphabetic())
        .find_map(|word| {
            words
                .iter()
                .find(|(name, _)| word.eq_ignore_ascii_case(name))
        })
        .map(|(_, power)| *power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_both_feedback_modes() {
        for (text, power) in [
            ("LOW", Some(HoldPower::Low)),
            ("REG", Some(HoldPower::Regular)),
            ("Tilt in OFF hold power mode", Some(HoldPower::Off)),
            ("Pan in REGULAR hold power mode", Some(HoldPower::Regular)),
            ("22", None),
        ] {
            assert_eq!(HoldPower::from_text(text), power, "{text}");
        }
        assert_eq!(MovePower::from_text("HIGH"), Some(MovePower::High));
        let verbose = "Pan in LOW move power mode";
        assert_eq!(MovePower::from_text(verbose), Some(MovePower::Low));
    }
}
