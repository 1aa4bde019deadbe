//! Finds lost steps of the head (`docs/novelty.md section 11`). The head is open loop: its counts are what was commanded.
//!
//! Steps lost before the sweep rotate the whole view about an axis of the head; a robot that stopped askew looks the same,
//! and only homing distinguishes them. Steps lost during the sweep bend the view: no pose lays both parts on the reference.

use super::constants::{
    MIN_BEND_RAD, MIN_BEND_SHIFT_M, OTHER_PLACE_AGREEMENT, OTHER_PLACE_OVERLAP,
};
use crate::novelty::{Detection, Reference};
use crate::sweep::Sweep;

/// Rotations of the whole view from which lost steps are suspected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostStepThresholds {
    /// About the pan axis, radians.
    pub pan_rad: f64,
    /// About the tilt axis, radians.
    pub tilt_rad: f64,
}

/// How a sweep does not fit the reference, each with its reason in one line.
#[derive(Debug, Clone, PartialEq)]
pub enum Mismatch {
    /// The whole view is rotated, or does not fit: steps lost before the sweep, or a robot that stands askew.
    Rotated(String),
    /// Another place was seen; the head is not at fault.
    OtherPlace(String),
    /// One part of the view is rotated or shifted against the rest: steps lost, or the robot moved, during the sweep.
    Bent(String),
}

impl Mismatch {
    /// The reason, in one line.
    pub fn reason(&self) -> &str {
        match self {
            Self::Rotated(reason) | Self::OtherPlace(reason) | Self::Bent(reason) => reason,
        }
    }
}

/// How `sweep` does not fit `reference` at the angles of the head, if so; `detection` is their comparison.
pub fn find_mismatch(
    reference: &Reference,
    sweep: &Sweep,
    detection: &Detection,
    thresholds: &LostStepThresholds,
) -> Option<Mismatch> {
    let registration = &detection.registration;
    if !registration.converged {
        return Some(Mismatch::Rotated(format!(
            "the place does not fit at the head's angles: {:.0} % of the flat surfaces agree",
            100.0 * registration.agreement
        )));
    }
    if let Some(bend) = super::bend::find(&reference.planes, sweep, registration) {
        let [forward_m, left_m] = bend.shift_m;
        let lost = bend.pan_rad.abs() >= thresholds.pan_rad.min(MIN_BEND_RAD)
            || bend.tilt_rad.abs() >= thresholds.tilt_rad.min(MIN_BEND_RAD);
        if lost || forward_m.hypot(left_m) >= MIN_BEND_SHIFT_M {
            return Some(Mismatch::Bent(format!(
                "the head lost steps or the robot moved in the middle of the sweep: after {:.0} % of it everything lies {:.1} deg of pan, {:.1} deg of tilt and {:.0} cm off the reference",
                100.0 * bend.after,
                bend.pan_rad.to_degrees(),
                bend.tilt_rad.to_degrees(),
                100.0 * forward_m.hypot(left_m)
            )));
        }
    }
    let overlap = detection.overlap[0].max(detection.overlap[1]);
    if registration.agreement < OTHER_PLACE_AGREEMENT && overlap < OTHER_PLACE_OVERLAP {
        return Some(Mismatch::OtherPlace(format!(
            "this looks like another place: {:.0} % of the flat surfaces agree, and neither view saw more than {:.0} % of the other",
            100.0 * registration.agreement,
            100.0 * overlap
        )));
    }
    let rotation = registration.current_from_reference.rotation.scaled_axis();
    let tilt_rad = match sweep.view.tilt_axis {
        Some(axis) => rotation.dot(&axis),
        // A sweep at several pans has several tilt axes: any of them.
        None => rotation.xy().norm(),
    };
    let rotated = rotation.z.abs() >= thresholds.pan_rad || tilt_rad.abs() >= thresholds.tilt_rad;
    rotated.then(|| {
        Mismatch::Rotated(format!(
            "the place lies {:.1} deg of pan and {:.1} deg of tilt off the reference: lost steps, or the robot stands askew",
            rotation.z.to_degrees(),
            tilt_rad.to_degrees()
        ))
    })
}
