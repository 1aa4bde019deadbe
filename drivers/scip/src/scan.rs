//! One revolution as the device sent it, and what each value says. Protocol section 7.

use crate::command::parameters::Parameters;
use crate::constants::TWO_CHARACTER_CEILING_MM;

/// How many characters carry a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coding {
    /// `MS`, `GS`: 12 bits; 4095 mm means that or more. A third less bytes.
    TwoCharacter,
    /// `MD`, `GD`: 18 bits.
    #[default]
    ThreeCharacter,
    /// `ME`, `GE`: 18 bits of distance, then 18 of intensity. Only for models that know it: a URG-04LX may need a power
    /// cycle after being asked (protocol section 10).
    WithIntensity,
}

impl Coding {
    /// Characters per step or group of steps.
    #[must_use]
    pub fn width(self) -> usize {
        match self {
            Self::TwoCharacter => 2,
            Self::ThreeCharacter => 3,
            Self::WithIntensity => 6,
        }
    }

    /// Second letter of the commands that ask for it.
    pub(crate) fn letter(self) -> char {
        match self {
            Self::TwoCharacter => 'S',
            Self::ThreeCharacter => 'D',
            Self::WithIntensity => 'E',
        }
    }
}

/// One scan in device units. Values below DMIN are codes and are kept as they came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawScan {
    /// Step of the first value's group.
    pub first_step: u16,
    /// Steps per value, at least 1. A value is the least good range of its group.
    pub cluster: u8,
    /// How the values were sent.
    pub coding: Coding,
    /// Values in mm by rising step, that is anti-clockwise seen from above; below DMIN: codes.
    pub ranges: Vec<u32>,
    /// As many intensities, in the device's own scale; empty where they were not asked for.
    pub intensities: Vec<u32>,
    /// The sensor's timer when the head passed step 0, ms, 24 bits.
    pub stamp_ms: u32,
    /// Scans still to come of a counted stream; 0 for the last, in an endless stream and for a single scan.
    pub remaining: u8,
}

impl RawScan {
    /// First step of the group of value `index`.
    #[must_use]
    pub fn step(&self, index: usize) -> usize {
        usize::from(self.first_step) + index * usize::from(self.cluster)
    }

    /// What value `index` says; `None` beyond the last.
    #[must_use]
    pub fn reading(&self, index: usize, parameters: &Parameters) -> Option<Reading> {
        self.ranges
            .get(index)
            .map(|value| Reading::new(*value, self.coding, parameters))
    }

    /// What each value says, by rising step.
    pub fn readings<'a>(
        &'a self,
        parameters: &'a Parameters,
    ) -> impl Iterator<Item = Reading> + 'a {
        self.ranges
            .iter()
            .map(|value| Reading::new(*value, self.coding, parameters))
    }
}

/// What one value says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// A distance, mm, DMIN to DMAX.
    Range(u32),
    /// A code below DMIN (0: nothing came back; the table of protocol section 7 has the others). Never a distance.
    Code(u8),
    /// More than DMAX, or the ceiling of two characters: no distance either.
    Beyond,
}

impl Reading {
    /// Sorts one value of a sensor with these parameters.
    #[must_use]
    pub fn new(value: u32, coding: Coding, parameters: &Parameters) -> Self {
        if value < parameters.dmin_mm {
            Self::Code(u8::try_from(value).unwrap_or(u8::MAX))
        } else if value > parameters.dmax_mm
            || (coding == Coding::TwoCharacter && value >= TWO_CHARACTER_CEILING_MM)
        {
            Self::Beyond
        } else {
            Self::Range(value)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_ranges_and_beyond() {
        let urg = Parameters::URG_04LX;
        let of = |value| Reading::new(value, Coding::ThreeCharacter, &urg);
        assert_eq!(of(0), Reading::Code(0));
        assert_eq!(of(19), Reading::Code(19));
        assert_eq!(of(20), Reading::Range(20));
        assert_eq!(of(4095), Reading::Range(4095));
        assert_eq!(of(5600), Reading::Range(5600));
        assert_eq!(of(5601), Reading::Beyond);
        assert_eq!(
            Reading::new(4095, Coding::TwoCharacter, &urg),
            Reading::Beyond
        );
        assert_eq!(
            Reading::new(4094, Coding::TwoCharacter, &urg),
            Reading::Range(4094)
        );
    }

    #[test]
    fn steps_of_clustered_values() {
        let scan = RawScan {
            first_step: 44,
            cluster: 3,
            coding: Coding::ThreeCharacter,
            ranges: vec![1000, 0],
            intensities: Vec::new(),
            stamp_ms: 0,
            remaining: 0,
        };
        assert_eq!((scan.step(0), scan.step(1)), (44, 47));
        assert_eq!(
            scan.reading(1, &Parameters::URG_04LX),
            Some(Reading::Code(0))
        );
        assert_eq!(scan.reading(2, &Parameters::URG_04LX), None);
    }
}
