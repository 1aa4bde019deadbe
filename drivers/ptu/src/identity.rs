//! Identity and capabilities of the unit, as it reports them.

use crate::axis::StepSize;
use crate::command::{AxisProperty, PtuCommand};
use crate::constants::{MAX_LIMIT_DEG, MAX_SPEED_DEG_S, RESOLUTION_ARCSEC};
use crate::error::HeadError;
use crate::motion::MotionProfile;
use crate::{Axis, HoldPower, MovePower, reply};

/// Range of one axis in counts, as measured by the unit's last calibration; each calibration moves it by a few counts (ptu-d46 section 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisLimits {
    /// Lowest reachable position, counts.
    pub min_steps: i32,
    /// Highest reachable position, counts.
    pub max_steps: i32,
}

impl AxisLimits {
    /// Whether a position is within the range.
    #[must_use]
    pub const fn contains(&self, steps: i32) -> bool {
        steps >= self.min_steps && steps <= self.max_steps
    }
}

/// One axis as read when connecting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisIdentity {
    /// Reachable positions, counts.
    pub limits: AxisLimits,
    /// Angle of one count.
    pub step: StepSize,
    /// Lowest settable speed, counts per second.
    pub speed_min: i32,
    /// Highest settable speed, counts per second.
    pub speed_max: i32,
    /// Set speed when connecting, counts per second.
    pub speed: i32,
    /// Base speed, counts per second: no ramps at or below it.
    pub base_speed: i32,
    /// Acceleration above the base speed, counts per second squared.
    pub acceleration: i32,
    /// Power at rest, if the unit reports it.
    pub hold_power: Option<HoldPower>,
    /// Power while moving, if the unit reports it.
    pub move_power: Option<MovePower>,
}

impl AxisIdentity {
    /// The profile of a move at `speed` counts per second.
    #[must_use]
    pub const fn profile(&self, speed: i32) -> MotionProfile {
        MotionProfile {
            speed,
            base_speed: self.base_speed,
            acceleration: self.acceleration,
        }
    }
}

/// The unit as read when connecting.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadIdentity {
    /// Firmware text, as printed.
    pub version: String,
    /// Limits, step size, speeds and powers of the pan axis.
    pub pan: AxisIdentity,
    /// Limits, step size, speeds and powers of the tilt axis.
    pub tilt: AxisIdentity,
    /// Supply voltage and temperatures, if the unit reports them.
    pub health: Option<Health>,
    /// True if the unit finished a calibration while connecting: its zero is fresh.
    pub calibration_seen: bool,
}

impl HeadIdentity {
    /// The identity of one axis.
    #[must_use]
    pub const fn axis(&self, axis: Axis) -> &AxisIdentity {
        match axis {
            Axis::Pan => &self.pan,
            Axis::Tilt => &self.tilt,
        }
    }
}

/// Supply voltage and temperatures (ptu-d46 section 10).
#[derive(Debug, Clone, PartialEq)]
pub struct Health {
    /// Supply, volts.
    pub supply_volts: f64,
    /// Temperatures, degrees Celsius: the controller, on later models also the pan and tilt motors.
    pub temperatures_c: Vec<f64>,
}

impl Health {
    /// Parses `Input 30 VDC @ 86 degF` and the four comma-separated numbers of later models. `None` without at least one number.
    pub(crate) fn from_text(text: &str) -> Option<Self> {
        let numbers = reply::all_numbers(text);
        let (supply_volts, fahrenheit) = numbers.split_first()?;
        let temperatures_c = fahrenheit.iter().map(|f| (f - 32.0) / 1.8).collect();
        Some(Self {
            supply_volts: *supply_volts,
            temperatures_c,
        })
    }
}

/// Values of one axis while they are being read.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct AxisDraft {
    pub(crate) min_steps: Option<i32>,
    pub(crate) max_steps: Option<i32>,
    /// Arc seconds per count.
    pub(crate) arcsec: Option<f64>,
    pub(crate) speed_min: Option<i32>,
    pub(crate) speed_max: Option<i32>,
    pub(crate) speed: Option<i32>,
    pub(crate) base_speed: Option<i32>,
    pub(crate) acceleration: Option<i32>,
    pub(crate) hold_power: Option<HoldPower>,
    pub(crate) move_power: Option<MovePower>,
}

/// Checks the values of one axis.
struct ValueCheck {
    axis: Axis,
}

impl ValueCheck {
    fn fail<T>(
        &self,
        property: AxisProperty,
        got: impl ToString,
        expected: impl Into<String>,
    ) -> Result<T, HeadError> {
        Err(HeadError::ImpossibleValue {
            command: PtuCommand::Query(self.axis, property).to_text(),
            expected: expected.into(),
            got: got.to_string(),
        })
    }

    /// A value that was read: a script that ended has read all.
    fn read<T>(&self, property: AxisProperty, value: Option<T>) -> Result<T, HeadError> {
        value.map_or_else(|| self.fail(property, "nothing", "a number"), Ok)
    }
}

impl AxisDraft {
    /// The angle of a count, and both limits. 0 is the middle that the calibration found, so it lies between them (ptu-d46
    /// section 5).
    fn range(&self, check: &ValueCheck) -> Result<(StepSize, AxisLimits), HeadError> {
        use AxisProperty as P;
        let arcsec = check.read(P::Resolution, self.arcsec)?;
        let possible = RESOLUTION_ARCSEC.contains(&arcsec);
        let step = StepSize::from_print(arcsec).filter(|_| possible);
        let Some(step) = step else {
            return check.fail(P::Resolution, arcsec, "1 to 400 arc seconds");
        };
        let limits = AxisLimits {
            min_steps: check.read(P::MinPosition, self.min_steps)?,
            max_steps: check.read(P::MaxPosition, self.max_steps)?,
        };
        let degrees = |steps: i32| f64::from(steps) * step.radians().to_degrees();
        let AxisLimits {
            min_steps,
            max_steps,
        } = limits;
        if min_steps >= 0 || degrees(min_steps) < -MAX_LIMIT_DEG {
            check.fail(P::MinPosition, min_steps, "less than 0, within 400 deg")
        } else if max_steps <= 0 || degrees(max_steps) > MAX_LIMIT_DEG {
            check.fail(P::MaxPosition, max_steps, "more than 0, within 400 deg")
        } else {
            Ok((step, limits))
        }
    }

    fn finish(&self, axis: Axis) -> Result<AxisIdentity, HeadError> {
        use AxisProperty as P;
        let check = ValueCheck { axis };
        let (step, limits) = self.range(&check)?;
        let speed_min = check.read(P::MinSpeed, self.speed_min)?;
        let speed_max = check.read(P::MaxSpeed, self.speed_max)?;
        let speed = check.read(P::Speed, self.speed)?;
        let base_speed = check.read(P::BaseSpeed, self.base_speed)?;
        let acceleration = check.read(P::Acceleration, self.acceleration)?;
        let fastest = f64::from(speed_max) * step.radians().to_degrees();
        if speed_max <= 0 || fastest > MAX_SPEED_DEG_S {
            return check.fail(P::MaxSpeed, speed_max, "more than 0, at most 1000 deg/s");
        }
        if !(0..=speed_max).contains(&speed_min) {
            return check.fail(P::MinSpeed, speed_min, format!("0 to {speed_max}"));
        }
        // In velocity mode it has a sign.
        if speed.unsigned_abs() > speed_max.unsigned_abs() {
            return check.fail(P::Speed, speed, format!("at most {speed_max}"));
        }
        if base_speed < 0 {
            return check.fail(P::BaseSpeed, base_speed, "0 or more");
        }
        if acceleration <= 0 {
            return check.fail(P::Acceleration, acceleration, "more than 0");
        }
        Ok(AxisIdentity {
            limits,
            step,
            speed_min,
            speed_max,
            speed,
            base_speed,
            acceleration,
            hold_power: self.hold_power,
            move_power: self.move_power,
        })
    }
}

/// The identity while it is being read.
#[derive(Debug, Clone, Default)]
pub(crate) struct IdentityDraft {
    pub(crate) version: String,
    pub(crate) pan: AxisDraft,
    pub(crate) tilt: AxisDraft,
    pub(crate) health: Option<Health>,
}

impl IdentityDraft {
    pub(crate) const fn axis_mut(&mut self, axis: Axis) -> &mut AxisDraft {
        match axis {
            Axis::Pan => &mut self.pan,
            Axis::Tilt => &mut self.tilt,
        }
    }

    /// Pan and tilt.
    ///
    /// # Errors
    /// [`HeadError::ImpossibleValue`].
    pub(crate) fn limits(&self) -> Result<(AxisLimits, AxisLimits), HeadError> {
        let limits = |draft: &AxisDraft, axis| draft.range(&ValueCheck { axis });
        Ok((
            limits(&self.pan, Axis::Pan)?.1,
            limits(&self.tilt, Axis::Tilt)?.1,
        ))
    }

    /// # Errors
    /// [`HeadError::ImpossibleValue`].
    pub(crate) fn finish(&self, calibration_seen: bool) -> Result<HeadIdentity, HeadError> {
        Ok(HeadIdentity {
            version: self.version.clone(),
            pan: self.pan.finish(Axis::Pan)?,
            tilt: self.tilt.finish(Axis::Tilt)?,
            health: self.health.clone(),
            calibration_seen,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_belong_to_their_range() {
        let limits = AxisLimits {
            min_steps: -907,
            max_steps: 604,
        };
        let inside = [-908, -907, 0, 604, 605].map(|steps| limits.contains(steps));
        assert_eq!(inside, [false, true, true, true, false]);
    }

    #[test]
    fn supply_texts_of_both_families() {
        let old = Health::from_text("Input 30 VDC @ 86 degF").expect("numbers");
        assert!(
            (old.supply_volts - 30.0).abs() < 1e-12 && (old.temperatures_c[0] - 30.0).abs() < 1e-12
        );
        let new = Health::from_text("29.8,104,95,93").expect("numbers");
        assert_eq!(new.temperatures_c.len(), 3);
        assert!((new.temperatures_c[0] - 40.0).abs() < 1e-12);
        assert!(Health::from_text("nothing").is_none());
    }

    fn d46() -> AxisDraft {
        AxisDraft {
            min_steps: Some(-3090),
            max_steps: Some(3091),
            arcsec: Some(185.1428),
            speed_min: Some(31),
            speed_max: Some(2902),
            speed: Some(1000),
            base_speed: Some(1000),
            acceleration: Some(2000),
            ..AxisDraft::default()
        }
    }

    /// The query at fault, if there is one.
    fn at_fault(change: impl Fn(&mut AxisDraft)) -> Option<String> {
        let mut draft = d46();
        change(&mut draft);
        match draft.finish(Axis::Tilt) {
            Ok(_) => None,
            Err(HeadError::ImpossibleValue { command, .. }) => Some(command),
            Err(other) => panic!("{other}"),
        }
    }

    #[test]
    fn values_that_cannot_be_are_named_each_bound_from_both_sides() {
        assert_eq!(at_fault(|_| {}), None);
        for (at_least, above, query) in [(1.0, 0.99, "TR"), (400.0, 400.1, "TR")] {
            let with = |arcsec| {
                at_fault(move |d| {
                    (d.arcsec, d.min_steps, d.max_steps) = (Some(arcsec), Some(-1), Some(1));
                    d.speed_max = Some(1000);
                })
            };
            assert_eq!(with(at_least), None);
            assert_eq!(with(above).as_deref(), Some(query));
        }
        let min = |n| at_fault(move |d| d.min_steps = Some(n));
        let max = |n| at_fault(move |d| d.max_steps = Some(n));
        // 400 deg are 7777.8 counts.
        for (limit, bounds, query) in [
            (&min as &dyn Fn(i32) -> Option<String>, [-1, 0], "TN"),
            (&min, [-7777, -7778], "TN"),
            (&max, [1, 0], "TX"),
            (&max, [7777, 7778], "TX"),
        ] {
            assert_eq!(limit(bounds[0]), None);
            assert_eq!(limit(bounds[1]).as_deref(), Some(query));
        }
        let speeds = |low, high, set, base, acceleration| {
            at_fault(move |d| {
                (d.speed_min, d.speed_max, d.speed) = (Some(low), Some(high), Some(set));
                (d.base_speed, d.acceleration) = (Some(base), Some(acceleration));
            })
        };
        // 1000 deg/s are 19444.4 counts/s.
        assert_eq!(speeds(0, 19_444, 19_444, 0, 1), None);
        assert_eq!(speeds(0, 1, -1, 0, 1), None);
        for (got, query) in [
            (speeds(0, 19_445, 5, 0, 1), "TU"),
            (speeds(0, 0, 0, 0, 1), "TU"),
            (speeds(6, 5, 5, 0, 1), "TL"),
            (speeds(-1, 5, 5, 0, 1), "TL"),
            (speeds(5, 5, 6, 0, 1), "TS"),
            (speeds(5, 5, -6, 0, 1), "TS"),
            (speeds(5, 5, 5, -1, 1), "TB"),
            (speeds(5, 5, 5, 0, 0), "TA"),
        ] {
            assert_eq!(got.as_deref(), Some(query));
        }
        assert_eq!(at_fault(|d| d.speed = None).as_deref(), Some("TS"));
    }
}
