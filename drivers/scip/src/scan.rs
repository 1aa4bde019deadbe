//! One scan as the device sent it.

/// How many characters carry a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ValueCoding {
    /// `MS`, `GS`: 12 bits; 4095 mm means that or more. A third fewer bytes.
    TwoCharacter,
    /// `MD`, `GD`: 18 bits.
    #[default]
    ThreeCharacter,
    /// `ME`, `GE`: 18 bits of distance, then 18 of intensity. Only for models that have it: a URG-04LX may need a power
    /// cycle after being asked (scip2 section 10).
    WithIntensity,
}

impl ValueCoding {
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

/// One scan in device units.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LaserScan {
    /// Step of the first value's group.
    pub first_step: u16,
    /// Steps per value, at least 1. A value is the smallest valid range of its group.
    pub cluster: u8,
    /// How the values were sent.
    pub coding: ValueCoding,
    /// Ranges, mm, by rising step (anti-clockwise seen from above). Values below DMIN are codes, kept as sent (scip2
    /// section 7).
    pub ranges: Vec<u32>,
    /// Intensities in the device's own scale, one per range; empty if not asked for.
    pub intensities: Vec<u32>,
    /// The sensor's timer at step 0, ms, 24 bits.
    pub stamp_ms: u32,
    /// Scans still to come of a counted stream; 0 for the last one and in an endless stream.
    pub remaining: u8,
}

impl LaserScan {
    /// First step of the group of value `index`.
    #[must_use]
    pub fn step(&self, index: usize) -> usize {
        usize::from(self.first_step) + index * usize::from(self.cluster)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_clustered_values() {
        let scan = LaserScan {
            first_step: 44,
            cluster: 3,
            coding: ValueCoding::ThreeCharacter,
            ranges: vec![1000, 0],
            intensities: Vec::new(),
            stamp_ms: 0,
            remaining: 0,
        };
        assert_eq!((scan.step(0), scan.step(1)), (44, 47));
    }
}
