//! Identity and capabilities of the unit, as it reports them.

use crate::axis::StepSize;
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
    pub(crate) step: Option<StepSize>,
    pub(crate) speed_min: Option<i32>,
    pub(crate) speed_max: Option<i32>,
    pub(crate) speed: Option<i32>,
    pub(crate) base_speed: Option<i32>,
    pub(crate) acceleration: Option<i32>,
    pub(crate) hold_power: Option<HoldPower>,
    pub(crate) move_power: Option<MovePower>,
}

impl AxisDraft {
    /// Both limits, if both were read and the range is not empty.
    pub(crate) fn limits(&self) -> Option<AxisLimits> {
        let limits = AxisLimits {
            min_steps: self.min_steps?,
            max_steps: self.max_steps?,
        };
        (limits.min_steps < limits.max_steps).then_some(limits)
    }

    pub(crate) fn finish(&self) -> Option<AxisIdentity> {
        Some(AxisIdentity {
            limits: self.limits()?,
            step: self.step?,
            speed_min: self.speed_min?,
            speed_max: self.speed_max?,
            speed: self.speed?,
            base_speed: self.base_speed?,
            acceleration: self.acceleration?,
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

    pub(crate) fn finish(&self, calibration_seen: bool) -> Option<HeadIdentity> {
        Some(HeadIdentity {
            version: self.version.clone(),
            pan: self.pan.finish()?,
            tilt: self.tilt.finish()?,
            health: self.health.clone(),
            calibration_seen,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
