//! Finds lost steps of the head (`docs/novelty.md section 11`). The head is open loop: its counts are what was commanded.
//!
//! Steps lost before the sweep turn the whole view about an axis of the head; a robot that stopped askew looks the same, and
//! the registration takes either out. Steps lost during the sweep bend the view: no pose lays both parts on the reference.

use super::constants::{
    MIN_BEND_RAD, MIN_BEND_SHIFT_M, OTHER_PLACE_AGREEMENT, OTHER_PLACE_OVERLAP,
};
use crate::novelty::{Detection, Reference, unmatched_reason};
use crate::sweep::Sweep;

/// How far a whole view lies turned against its reference about the axes of the head, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewTurn {
    /// About the pan axis.
    pub pan_rad: f64,
    /// About the tilt axis; `None`: the sweep has several pans, and so several of them.
    pub tilt_rad: Option<f64>,
}

/// How a sweep does not fit the reference, each with its reason in one line.
#[derive(Debug, Clone, PartialEq)]
pub enum Mismatch {
    /// No pose lays the view on the reference: steps lost before the sweep, or a robot that stands elsewhere.
    Unregistered(String),
    /// Another place was seen; the head is not at fault.
    OtherPlace(String),
    /// One part of the view is rotated or shifted against the rest: steps lost, or the robot moved, during the sweep.
    Bent(String),
}

impl Mismatch {
    /// The reason, in one line.
    pub fn reason(&self) -> &str {
        match self {
            Self::Unregistered(reason) | Self::OtherPlace(reason) | Self::Bent(reason) => reason,
        }
    }
}

/// How far `sweep` lies turned, as its registration found.
pub fn view_turn(sweep: &Sweep, detection: &Detection) -> ViewTurn {
    let rotation = detection
        .registration
        .current_from_reference
        .rotation
        .scaled_axis();
    ViewTurn {
        pan_rad: rotation.z,
        tilt_rad: sweep.view.tilt_axis.map(|axis| rotation.dot(&axis)),
    }
}

/// How `sweep` does not fit `reference` at the angles of the head, if so; `detection` is their comparison. From a tilt of
/// `max_tilt_rad` on a sweep of several pans does not fit: each is turned about an axis of its own.
pub fn find_mismatch(
    reference: &Reference,
    sweep: &Sweep,
    detection: &Detection,
    max_tilt_rad: f64,
) -> Option<Mismatch> {
    let registration = &detection.registration;
    if let Some(reason) = unmatched_reason(registration) {
        return Some(Mismatch::Unregistered(format!(
            "the place does not fit at the head's angles: {reason}"
        )));
    }
    if let Some(bend) = super::bend::find(&reference.planes, sweep, registration) {
        let [forward_m, left_m] = bend.shift_m;
        let lost = bend.pan_rad.abs() >= MIN_BEND_RAD || bend.tilt_rad.abs() >= MIN_BEND_RAD;
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
    let tilt_rad = rotation.xy().norm();
    (sweep.view.tilt_axis.is_none() && tilt_rad >= max_tilt_rad).then(|| {
        Mismatch::Unregistered(format!(
            "the place lies {:.1} deg of tilt off the reference, at several pans: lost steps, or the robot stands askew",
            tilt_rad.to_degrees()
        ))
    })
}
