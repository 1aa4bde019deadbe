//! The sweeps of a calibration: up and down at two speeds, at three pans (sweep-geometry section 5).

use super::constants::{
    CALIBRATION_FAST_PAIRS, CALIBRATION_FAST_RAD_S, CALIBRATION_PAN_RAD, CALIBRATION_SLOW_RAD_S,
};
use super::plan::SweepRequest;
use crate::config::SweepMode;

/// The sweeps of a calibration over the tilt range of `request`. With `several_pans` false the head keeps the first pan of
/// the request; the pitch of the laser is not observable then.
pub fn calibration_requests(request: &SweepRequest, several_pans: bool) -> Vec<SweepRequest> {
    let speeds = std::iter::once(CALIBRATION_SLOW_RAD_S).chain(std::iter::repeat_n(
        CALIBRATION_FAST_RAD_S,
        CALIBRATION_FAST_PAIRS,
    ));
    let middle = request.pans_rad.first().copied().unwrap_or(0.0);
    let pans_rad = if several_pans {
        [-1.0, 0.0, 1.0]
            .map(|side| middle + side * CALIBRATION_PAN_RAD)
            .to_vec()
    } else {
        vec![middle]
    };
    let ends = (request.tilt_from_rad, request.tilt_to_rad);
    let (low, high) = (ends.0.min(ends.1), ends.0.max(ends.1));
    speeds
        .flat_map(|speed_rad_s| [(low, high, speed_rad_s), (high, low, speed_rad_s)])
        .map(|(tilt_from_rad, tilt_to_rad, speed_rad_s)| SweepRequest {
            mode: SweepMode::Continuous,
            tilt_from_rad,
            tilt_to_rad,
            speed_rad_s,
            pans_rad: pans_rad.clone(),
            ..request.clone()
        })
        .collect()
}
