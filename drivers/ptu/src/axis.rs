//! The two axes, and positions in steps against angles in radians.

use crate::constants::{HALF_STEP_DEG, KNOWN_RATIOS, RESOLUTION_PRINT_ERROR_ARCSEC};

const ARCSEC_PER_DEG: f64 = 3600.0;

/// One of the two axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Rotates about the vertical; positive is usually to the left.
    Pan,
    /// Rotates about the lateral axis; positive is usually up.
    Tilt,
}

impl Axis {
    /// Both axes, pan first.
    pub const BOTH: [Self; 2] = [Self::Pan, Self::Tilt];

    /// The letter that its commands begin with.
    pub(crate) const fn letter(self) -> char {
        match self {
            Self::Pan => 'P',
            Self::Tilt => 'T',
        }
    }
}

/// Angle of one position count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSize {
    radians: f64,
}

impl StepSize {
    /// From the resolution that the unit prints, arc seconds. That of a known gear (185.1428, 46.2857) stands for its exact value,
    /// 0.9 deg over the gear ratio (ptu-d46 section 5); any other is taken as it is. `None` unless positive and finite.
    pub(crate) fn from_print(arcsec: f64) -> Option<Self> {
        if !(arcsec.is_finite() && arcsec > 0.0) {
            return None;
        }
        let exact = KNOWN_RATIOS.iter().map(|ratio| HALF_STEP_DEG / ratio);
        let known = exact
            .into_iter()
            .find(|deg| (deg * ARCSEC_PER_DEG - arcsec).abs() <= RESOLUTION_PRINT_ERROR_ARCSEC);
        let degrees = known.unwrap_or(arcsec / ARCSEC_PER_DEG);
        Some(Self {
            radians: degrees.to_radians(),
        })
    }

    /// As stored before. `None` unless positive and finite.
    #[must_use]
    pub fn from_radians(radians: f64) -> Option<Self> {
        (radians.is_finite() && radians > 0.0).then_some(Self { radians })
    }

    /// Radians per position count.
    #[must_use]
    pub const fn radians(self) -> f64 {
        self.radians
    }
}

/// Direction of counting (ptu-d46 section 5: documents disagree, so it is a setting).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sign {
    /// Counts and angle grow together.
    #[default]
    Positive,
    /// Counts grow while the angle falls.
    Negative,
}

impl Sign {
    /// +1 or -1.
    #[must_use]
    pub const fn factor(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }
}

/// Counts against radians for one axis: angle = sign * steps * step - offset (sweep-geometry section 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisScale {
    /// Angle of one count.
    pub step: StepSize,
    /// Direction of counting.
    pub sign: Sign,
    /// Mechanical zero, radians: count 0 is at the angle `-offset_rad`.
    pub offset_rad: f64,
}

impl AxisScale {
    /// Angle at a count, radians.
    #[must_use]
    pub fn radians(&self, steps: i32) -> f64 {
        self.radians_at(f64::from(steps))
    }

    /// Angle at a fractional count (a fitted position), radians.
    fn radians_at(&self, steps: f64) -> f64 {
        self.sign.factor() * steps * self.step.radians - self.offset_rad
    }

    /// The nearest count to an angle; rounded, because truncation is up to one count off (ptu-d46 section 5). `None` if the angle is
    /// not finite or out of range.
    #[must_use]
    pub fn steps(&self, radians: f64) -> Option<i32> {
        let steps = (self.sign.factor() * (radians + self.offset_rad) / self.step.radians).round();
        let holds =
            steps.is_finite() && steps >= f64::from(i32::MIN) && steps <= f64::from(i32::MAX);
        holds.then_some(steps as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{Just, prop_assert, prop_assert_eq, prop_oneof, proptest};

    #[test]
    fn a_known_resolution_stands_for_its_exact_gear() {
        let step = |print| {
            StepSize::from_print(print)
                .expect("positive")
                .radians()
                .to_degrees()
        };
        assert!((step(185.1428) - 0.9 / 17.5).abs() < 1e-15);
        assert!((step(46.2857) - 0.9 / 70.0).abs() < 1e-15);
        assert!(
            (step(23.142) - 23.142 / 3600.0).abs() < 1e-15,
            "23.142 is not the 23.1428 of a known gear"
        );
        assert!(StepSize::from_print(0.0).is_none());
        assert!(StepSize::from_print(f64::NAN).is_none());
    }

    #[test]
    fn ranges_of_the_document_in_degrees() {
        // ptu-d46 section 5: +-3090 is +-158.9 deg, -907..604 is -46.6..+31.1 deg.
        let step = StepSize::from_print(185.1428).expect("positive");
        let scale = AxisScale {
            step,
            sign: Sign::Positive,
            offset_rad: 0.0,
        };
        for (steps, degrees) in [(3090, 158.9), (-907, -46.6), (604, 31.1)] {
            assert!((scale.radians(steps).to_degrees() - degrees).abs() < 0.05);
        }
        assert_eq!(scale.steps(5.0_f64.to_radians()), Some(97), "97.2 counts");
        assert_eq!(scale.steps(f64::INFINITY), None);
        assert_eq!(scale.steps(1e12), None);
    }

    proptest! {
        #[test]
        fn counts_survive_conversion_to_radians_and_back(
            steps in -200_000i32..200_000,
            offset_rad in -0.5f64..0.5,
            sign in prop_oneof![Just(Sign::Positive), Just(Sign::Negative)],
            print in prop_oneof![Just(185.1428), Just(46.2857), Just(11.5714)],
        ) {
            let step = StepSize::from_print(print).expect("positive");
            let scale = AxisScale { step, sign, offset_rad };
            prop_assert_eq!(scale.steps(scale.radians(steps)), Some(steps));
            // Rounding: a target is never more than half a count off.
            let between = scale.radians_at(f64::from(steps) + 0.4);
            prop_assert!((scale.radians(scale.steps(between).expect("finite")) - between).abs() <= 0.5 * step.radians());
        }
    }
}
