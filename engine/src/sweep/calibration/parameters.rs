//! The parameters of a calibration, and the derivatives of a beam's end point by them: the chain of sweep-geometry
//! section 2.

use super::beams::CalibrationBeam;
use super::constants::{
    COMMON_ANGLE_SIGMA_RAD, MAX_ANGLE_SIGMA_RAD, MAX_BACKLASH_SIGMA_RAD, MAX_POSITION_SIGMA_M,
    MAX_TIME_SIGMA_S, PRIOR_ANGLE_RAD, PRIOR_BACKLASH_RAD, PRIOR_POSITION_M, PRIOR_RANGE_M,
    PRIOR_TIME_S,
};
use crate::geometry::Mount;
use nalgebra::{Matrix3, Point3, Rotation3, SVector, Vector3};

/// Number of unknowns that all pan segments share.
pub(super) const SHARED_UNKNOWNS: usize = 9;

/// A parameter that a calibration estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CalibrationParameter {
    /// Roll of the laser on the plate, radians.
    Roll,
    /// Pitch of the laser on the plate, radians. The tilt at count 0 has the same effect on every beam.
    Pitch,
    /// Yaw of the laser on the plate, radians.
    Yaw,
    /// Position of the laser on the plate, forward, metres.
    X,
    /// Position to the left, metres.
    Y,
    /// Position upwards, metres.
    Z,
    /// Time offset, seconds.
    TimeOffset,
    /// Backlash of the tilt, radians.
    Backlash,
    /// Added to every range, metres.
    RangeOffset,
}

impl CalibrationParameter {
    /// All parameters, in the order of the estimates.
    pub const ALL: [Self; SHARED_UNKNOWNS] = [
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

    /// Standard deviation of the prior.
    pub(super) fn prior_sigma(self) -> f64 {
        match self {
            Self::Roll | Self::Pitch | Self::Yaw => PRIOR_ANGLE_RAD,
            Self::X | Self::Y | Self::Z => PRIOR_POSITION_M,
            Self::TimeOffset => PRIOR_TIME_S,
            Self::Backlash => PRIOR_BACKLASH_RAD,
            Self::RangeOffset => PRIOR_RANGE_M,
        }
    }

    /// Standard deviation of errors that all planes share, so that their scatter does not show them.
    pub(super) fn common_sigma(self) -> f64 {
        match self {
            Self::Roll | Self::Pitch | Self::Yaw => COMMON_ANGLE_SIGMA_RAD,
            _ => 0.0,
        }
    }

    /// Standard deviation above which the parameter is not observable.
    pub(super) fn max_sigma(self) -> f64 {
        match self {
            Self::Roll | Self::Pitch | Self::Yaw => MAX_ANGLE_SIGMA_RAD,
            Self::X | Self::Y | Self::Z | Self::RangeOffset => MAX_POSITION_SIGMA_M,
            Self::TimeOffset => MAX_TIME_SIGMA_S,
            Self::Backlash => MAX_BACKLASH_SIGMA_RAD,
        }
    }
}

/// The values that the sweeps were taken with.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CalibrationValues {
    pub(super) mount: Mount,
    pub(super) time_offset_s: f64,
    pub(super) tilt_backlash_rad: f64,
}

impl CalibrationValues {
    /// In the order of [`CalibrationParameter::ALL`]; the range offset is 0.
    pub(super) fn values(&self) -> [f64; SHARED_UNKNOWNS] {
        let [.., x, y, z, roll, pitch, yaw] = self.mount.parameters();
        let (time, backlash) = (self.time_offset_s, self.tilt_backlash_rad);
        [roll, pitch, yaw, x, y, z, time, backlash, 0.0]
    }
}

/// The kinematic chain at given values of the parameters.
pub(super) struct KinematicChain {
    pan_axis: Vector3<f64>,
    tilt_axis: Vector3<f64>,
    position: Vector3<f64>,
    rotation: Matrix3<f64>,
    /// Axis of pitch, in the laser frame.
    pitch_axis: Vector3<f64>,
    time_offset_s: f64,
    backlash_rad: f64,
    range_offset_m: f64,
}

/// The end point of a beam.
pub(super) struct BeamEndpoint {
    /// In the base frame, metres.
    pub(super) point: Point3<f64>,
    /// Direction of the beam in the base frame.
    pub(super) direction: Vector3<f64>,
    base_from_tilted: Matrix3<f64>,
    /// Derivative of the point by the tilt.
    by_tilt: Vector3<f64>,
    /// The point in the laser frame.
    in_laser: Vector3<f64>,
    /// The same in the axes of the plate.
    in_plate: Vector3<f64>,
}

impl KinematicChain {
    /// The axes of `mount`, with the laser at `values` (in the order of [`CalibrationParameter::ALL`]).
    pub(super) fn new(mount: &Mount, values: &[f64]) -> Self {
        let n = mount.parameters();
        let plate = Vector3::new(n[6], n[7], n[8]);
        let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
        let rotation = Rotation3::from_euler_angles(at(0), at(1), at(2));
        let rolled = Rotation3::from_axis_angle(&Vector3::x_axis(), -at(0));
        Self {
            pan_axis: Vector3::new(n[0], n[1], n[2]),
            tilt_axis: Vector3::new(n[3], n[4], n[5]),
            position: plate + Vector3::new(at(3), at(4), at(5)),
            rotation: rotation.into_inner(),
            pitch_axis: rolled * Vector3::y(),
            time_offset_s: at(6),
            backlash_rad: at(7),
            range_offset_m: at(8),
        }
    }

    /// The end point of `beam`, with `segment_time_s` as the time error of its pan segment.
    pub(super) fn endpoint(&self, beam: &CalibrationBeam, segment_time_s: f64) -> BeamEndpoint {
        let tilt = beam.tilt_rad + beam.speed_rad_s * (self.time_offset_s + segment_time_s)
            - beam.travel_direction * self.backlash_rad / 2.0;
        let (sin, cos) = tilt.sin_cos();
        let (pan_sin, pan_cos) = beam.pan_rad.sin_cos();
        let pan = Matrix3::new(pan_cos, -pan_sin, 0.0, pan_sin, pan_cos, 0.0, 0.0, 0.0, 1.0);
        let up = Matrix3::new(cos, 0.0, -sin, 0.0, 1.0, 0.0, sin, 0.0, cos);
        let by_tilt = Matrix3::new(-sin, 0.0, -cos, 0.0, 0.0, 0.0, cos, 0.0, -sin);
        let in_laser = beam.direction * (beam.range_m + self.range_offset_m);
        let in_plate = self.rotation * in_laser;
        let plate = self.position + in_plate;
        let base_from_tilted = pan * up;
        BeamEndpoint {
            point: Point3::from(self.pan_axis + pan * (self.tilt_axis + up * plate)),
            direction: base_from_tilted * (self.rotation * beam.direction),
            base_from_tilted,
            by_tilt: pan * (by_tilt * plate),
            in_laser,
            in_plate,
        }
    }

    /// Derivatives of the end point along `normal` by every parameter of [`CalibrationParameter::ALL`], and by the time error of
    /// the pan segment.
    pub(super) fn derivatives(
        &self,
        beam: &CalibrationBeam,
        end: &BeamEndpoint,
        normal: &Vector3<f64>,
    ) -> (SVector<f64, SHARED_UNKNOWNS>, f64) {
        let plate = end.base_from_tilted.transpose() * normal;
        let laser = self.rotation.transpose() * plate;
        let by_tilt = end.by_tilt.dot(normal);
        let by_time = by_tilt * beam.speed_rad_s;
        let shared = [
            laser.dot(&Vector3::x().cross(&end.in_laser)),
            laser.dot(&self.pitch_axis.cross(&end.in_laser)),
            plate.dot(&Vector3::z().cross(&end.in_plate)),
            plate.x,
            plate.y,
            plate.z,
            by_time,
            -by_tilt * beam.travel_direction / 2.0,
            laser.dot(&beam.direction),
        ];
        (SVector::from(shared), by_time)
    }
}

#[cfg(test)]
mod tests {
    use super::super::beams::CalibrationBeam;
    use super::{CalibrationValues, KinematicChain, SHARED_UNKNOWNS};
    use crate::geometry::{Mount, RollPitchYaw};
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    fn calibration_values(values: &[f64]) -> CalibrationValues {
        let rotation = RollPitchYaw {
            roll_rad: values[0],
            pitch_rad: values[1],
            yaw_rad: values[2],
        };
        let position = [values[3], values[4], values[5]];
        CalibrationValues {
            mount: Mount::new(
                [0.0, -0.01, 0.05],
                [0.01, 0.0, 0.04],
                [0.0, 0.002, 0.04],
                position,
                rotation,
            ),
            time_offset_s: values[6],
            tilt_backlash_rad: values[7],
        }
    }

    proptest! {
        #[test]
        fn end_points_agree_with_the_mount_and_with_their_derivatives(
            values in proptest::array::uniform9(-0.2..0.2f64),
            pan_rad in -1.5..1.5f64,
            tilt_rad in -0.6..0.5f64,
            azimuth in -2.0..2.0f64,
            range_m in 0.3..4.0f64,
            normal in proptest::array::uniform3(-1.0..1.0f64),
        ) {
            let beam = CalibrationBeam {
                pan_segment: 0,
                scan: 0,
                index: 0,
                direction: Vector3::new(azimuth.cos(), azimuth.sin(), 0.0),
                range_m,
                pan_rad,
                tilt_rad,
                speed_rad_s: 0.3,
                travel_direction: 1.0,
            };
            let normal = Vector3::from(normal);
            let present = calibration_values(&values);
            let endpoint = |values: &[f64], segment_s| KinematicChain::new(&present.mount, values).endpoint(&beam, segment_s).point;
            let tilt = tilt_rad + 0.3 * (values[6] + 0.001) - values[7] / 2.0;
            let expected = present.mount.base_from_laser(pan_rad, tilt)
                * Point3::from(beam.direction * (range_m + values[8]));
            prop_assert!((endpoint(&values, 0.001) - expected).norm() < 1e-12);
            let chain = KinematicChain::new(&present.mount, &values);
            let (shared, by_segment) = chain.derivatives(&beam, &chain.endpoint(&beam, 0.001), &normal);
            let h = 1e-6;
            for i in 0..SHARED_UNKNOWNS {
                let (mut more, mut less) = (values, values);
                more[i] += h;
                less[i] -= h;
                let slope = normal.dot(&(endpoint(&more, 0.001) - endpoint(&less, 0.001))) / (2.0 * h);
                prop_assert!((slope - shared[i]).abs() < 1e-7, "{i}: {slope} {}", shared[i]);
            }
            let slope = normal.dot(&(endpoint(&values, 0.001 + h) - endpoint(&values, 0.001 - h))) / (2.0 * h);
            prop_assert!((slope - by_segment).abs() < 1e-7);
        }
    }
}
