//! What is sought, and how a beam's place moves with it: the chain of sweep-geometry section 2, differentiated.

use super::beams::CalibrationBeam;
use super::constants::{
    COMMON_ANGLE_RAD, MOST_ANGLE_RAD, MOST_BACKLASH_RAD, MOST_PLACE_M, MOST_TIME_S,
    PRIOR_ANGLE_RAD, PRIOR_BACKLASH_RAD, PRIOR_PLACE_M, PRIOR_RANGE_M, PRIOR_TIME_S,
};
use crate::geometry::Mount;
use nalgebra::{Matrix3, Point3, Rotation3, SVector, Vector3};

/// Number of unknowns that all legs share.
pub const SHARED: usize = 9;

/// One number that a calibration looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// Roll of the laser on the plate, radians.
    Roll,
    /// Pitch of the laser on the plate, radians. The tilt of the head at count 0 does the same to every beam.
    Pitch,
    /// Yaw of the laser on the plate, radians.
    Yaw,
    /// Place of the laser on the plate, forward, metres.
    X,
    /// To the left, metres.
    Y,
    /// Up, metres.
    Z,
    /// Time offset, seconds.
    TimeOffset,
    /// Backlash of the tilt, radians.
    Backlash,
    /// What every range must be lengthened by, metres.
    RangeOffset,
}

impl Parameter {
    /// All, in the order of [`Present::values`].
    pub const ALL: [Self; SHARED] = [
        Self::Roll,
        Self::Pitch,
        Self::Yaw,
        Self::X,
        Self::Y,
        Self::Z,
        Self::TimeOffset,
        Self::Backlash,
        Self::RangeOffset,
    ];

    /// Standard deviation of what is believed beforehand.
    pub(super) fn prior(self) -> f64 {
        match self {
            Self::Roll | Self::Pitch | Self::Yaw => PRIOR_ANGLE_RAD,
            Self::X | Self::Y | Self::Z => PRIOR_PLACE_M,
            Self::TimeOffset => PRIOR_TIME_S,
            Self::Backlash => PRIOR_BACKLASH_RAD,
            Self::RangeOffset => PRIOR_RANGE_M,
        }
    }

    /// Standard deviation of what errs alike on all surfaces, and is in no spread of theirs.
    pub(super) fn common(self) -> f64 {
        match self {
            Self::Roll | Self::Pitch | Self::Yaw => COMMON_ANGLE_RAD,
            _ => 0.0,
        }
    }

    /// Standard deviation from which on it counts as not observable.
    pub(super) fn most(self) -> f64 {
        match self {
            Self::Roll | Self::Pitch | Self::Yaw => MOST_ANGLE_RAD,
            Self::X | Self::Y | Self::Z | Self::RangeOffset => MOST_PLACE_M,
            Self::TimeOffset => MOST_TIME_S,
            Self::Backlash => MOST_BACKLASH_RAD,
        }
    }
}

/// The values in force.
#[derive(Debug, Clone, PartialEq)]
pub struct Present {
    /// The chain.
    pub mount: Mount,
    /// Seconds.
    pub time_offset_s: f64,
    /// Radians.
    pub tilt_backlash_rad: f64,
}

impl Present {
    /// In the order of [`Parameter::ALL`]; ranges are believed as they are.
    pub fn values(&self) -> [f64; SHARED] {
        let [.., x, y, z, roll, pitch, yaw] = self.mount.numbers();
        let (time, backlash) = (self.time_offset_s, self.tilt_backlash_rad);
        [roll, pitch, yaw, x, y, z, time, backlash, 0.0]
    }
}

/// The chain at given values of the unknowns.
pub struct Chain {
    pan_axis: Vector3<f64>,
    tilt_axis: Vector3<f64>,
    place: Vector3<f64>,
    turn: Matrix3<f64>,
    /// Axes of pitch, in the laser's frame.
    pitch_axis: Vector3<f64>,
    time_offset_s: f64,
    backlash_rad: f64,
    range_offset_m: f64,
}

/// Where a beam ended.
pub struct Place {
    /// In the base's frame, metres.
    pub point: Point3<f64>,
    /// Direction of the beam, base's frame.
    pub direction: Vector3<f64>,
    base_from_tilted: Matrix3<f64>,
    tilted_by_tilt: Vector3<f64>,
    laser: Vector3<f64>,
    turned: Vector3<f64>,
}

impl Chain {
    /// The axes of `mount`, with its laser where `values` ([`Parameter::ALL`]) say.
    pub fn new(mount: &Mount, values: &[f64]) -> Self {
        let n = mount.numbers();
        let plate = Vector3::new(n[6], n[7], n[8]);
        let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
        let turn = Rotation3::from_euler_angles(at(0), at(1), at(2));
        let rolled = Rotation3::from_axis_angle(&Vector3::x_axis(), -at(0));
        Self {
            pan_axis: Vector3::new(n[0], n[1], n[2]),
            tilt_axis: Vector3::new(n[3], n[4], n[5]),
            place: plate + Vector3::new(at(3), at(4), at(5)),
            turn: turn.into_inner(),
            pitch_axis: rolled * Vector3::y(),
            time_offset_s: at(6),
            backlash_rad: at(7),
            range_offset_m: at(8),
        }
    }

    /// Where `beam` ended, its leg's clock `leg_time_s` off by itself.
    pub fn place(&self, beam: &CalibrationBeam, leg_time_s: f64) -> Place {
        let tilt = beam.tilt_rad + beam.speed_rad_s * (self.time_offset_s + leg_time_s)
            - beam.way * self.backlash_rad / 2.0;
        let (sin, cos) = tilt.sin_cos();
        let (pan_sin, pan_cos) = beam.pan_rad.sin_cos();
        let pan = Matrix3::new(pan_cos, -pan_sin, 0.0, pan_sin, pan_cos, 0.0, 0.0, 0.0, 1.0);
        let up = Matrix3::new(cos, 0.0, -sin, 0.0, 1.0, 0.0, sin, 0.0, cos);
        let by_tilt = Matrix3::new(-sin, 0.0, -cos, 0.0, 0.0, 0.0, cos, 0.0, -sin);
        let laser = beam.direction * (beam.range_m + self.range_offset_m);
        let turned = self.turn * laser;
        let plate = self.place + turned;
        let base_from_tilted = pan * up;
        Place {
            point: Point3::from(self.pan_axis + pan * (self.tilt_axis + up * plate)),
            direction: base_from_tilted * (self.turn * beam.direction),
            base_from_tilted,
            tilted_by_tilt: pan * (by_tilt * plate),
            laser,
            turned,
        }
    }

    /// Derivatives of the place along `normal` by every unknown of [`Parameter::ALL`], and by the leg's own time.
    pub fn derivatives(
        &self,
        beam: &CalibrationBeam,
        place: &Place,
        normal: &Vector3<f64>,
    ) -> (SVector<f64, SHARED>, f64) {
        let plate = place.base_from_tilted.transpose() * normal;
        let laser = self.turn.transpose() * plate;
        let by_tilt = place.tilted_by_tilt.dot(normal);
        let by_time = by_tilt * beam.speed_rad_s;
        let shared = [
            laser.dot(&Vector3::x().cross(&place.laser)),
            laser.dot(&self.pitch_axis.cross(&place.laser)),
            plate.dot(&Vector3::z().cross(&place.turned)),
            plate.x,
            plate.y,
            plate.z,
            by_time,
            -by_tilt * beam.way / 2.0,
            laser.dot(&beam.direction),
        ];
        (SVector::from(shared), by_time)
    }
}

#[cfg(test)]
mod tests {
    use super::super::beams::CalibrationBeam;
    use super::{Chain, Present, SHARED};
    use crate::geometry::{Mount, RollPitchYaw};
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    fn present(values: &[f64]) -> Present {
        let turn = RollPitchYaw {
            roll_rad: values[0],
            pitch_rad: values[1],
            yaw_rad: values[2],
        };
        let place = [values[3], values[4], values[5]];
        Present {
            mount: Mount::new(
                [0.0, -0.01, 0.05],
                [0.01, 0.0, 0.04],
                [0.0, 0.002, 0.04],
                place,
                turn,
            ),
            time_offset_s: values[6],
            tilt_backlash_rad: values[7],
        }
    }

    proptest! {
        #[test]
        fn places_are_the_mounts_and_derivatives_are_those_of_places(
            values in proptest::array::uniform9(-0.2..0.2f64),
            pan_rad in -1.5..1.5f64,
            tilt_rad in -0.6..0.5f64,
            azimuth in -2.0..2.0f64,
            range_m in 0.3..4.0f64,
            normal in proptest::array::uniform3(-1.0..1.0f64),
        ) {
            let beam = CalibrationBeam {
                leg: 0,
                scan: 0,
                index: 0,
                direction: Vector3::new(azimuth.cos(), azimuth.sin(), 0.0),
                range_m,
                pan_rad,
                tilt_rad,
                speed_rad_s: 0.3,
                way: 1.0,
            };
            let normal = Vector3::from(normal);
            let present = present(&values);
            let place = |values: &[f64], leg_s| Chain::new(&present.mount, values).place(&beam, leg_s).point;
            let tilt = tilt_rad + 0.3 * (values[6] + 0.001) - values[7] / 2.0;
            let expected = present.mount.base_from_laser(pan_rad, tilt)
                * Point3::from(beam.direction * (range_m + values[8]));
            prop_assert!((place(&values, 0.001) - expected).norm() < 1e-12);
            let chain = Chain::new(&present.mount, &values);
            let (shared, by_leg) = chain.derivatives(&beam, &chain.place(&beam, 0.001), &normal);
            let h = 1e-6;
            for i in 0..SHARED {
                let (mut more, mut less) = (values, values);
                more[i] += h;
                less[i] -= h;
                let slope = normal.dot(&(place(&more, 0.001) - place(&less, 0.001))) / (2.0 * h);
                prop_assert!((slope - shared[i]).abs() < 1e-7, "{i}: {slope} {}", shared[i]);
            }
            let slope = normal.dot(&(place(&values, 0.001 + h) - place(&values, 0.001 - h))) / (2.0 * h);
            prop_assert!((slope - by_leg).abs() < 1e-7);
        }
    }
}
