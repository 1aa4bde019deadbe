//! The head is open loop: its counts say where it was told to be. Before a verdict the static structure must fit at the
//! angles that they say; where it does not, the head may have lost steps, and only a calibration tells.
//!
//! Lost before the sweep, they turn the whole view about an axis of the head: the registration says by how much, and a
//! robot that stopped askew looks the same until the head was homed. Lost in its middle, they bend the view: what came
//! later is turned against what came before, and no pose puts both on the reference.

use super::constants::{LEAST_BEND_RAD, MOST_SHIFT_M, OTHER_PLACE};
use crate::novelty::{Detection, Reference};
use crate::sweep::Sweep;

/// Turns from which steps count as lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suspicion {
    /// About the pan axis, radians.
    pub pan_rad: f64,
    /// About the tilt axis, radians.
    pub tilt_rad: f64,
}

/// Why the head's angles are doubted.
#[derive(Debug, Clone, PartialEq)]
pub enum Doubt {
    /// All of the view is turned: lost steps before the sweep, or a robot that stands askew.
    Turned(String),
    /// It is another place that was seen: no matter of the head.
    Elsewhere(String),
    /// A part of the view is turned against the rest, whatever the robot did.
    Bent(String),
}

impl Doubt {
    /// In one line.
    pub fn reason(&self) -> &str {
        match self {
            Self::Turned(reason) | Self::Elsewhere(reason) | Self::Bent(reason) => reason,
        }
    }
}

/// Whether the head's angles are to be doubted, after `detection` laid `sweep` on `reference`.
pub fn doubt(
    reference: &Reference,
    sweep: &Sweep,
    detection: &Detection,
    suspicion: &Suspicion,
) -> Option<Doubt> {
    let registration = &detection.registration;
    if !registration.converged {
        return Some(Doubt::Turned(format!(
            "the place does not fit at the head's angles: {:.0} % of the flat surfaces agree",
            100.0 * registration.share
        )));
    }
    if let Some(bend) = super::bend::find(&reference.landmarks, sweep, registration) {
        let [forward_m, left_m] = bend.shift_m;
        let lost = bend.pan_rad.abs() >= suspicion.pan_rad.min(LEAST_BEND_RAD)
            || bend.tilt_rad.abs() >= suspicion.tilt_rad.min(LEAST_BEND_RAD);
        if lost || forward_m.hypot(left_m) >= MOST_SHIFT_M {
            return Some(Doubt::Bent(format!(
                "the head lost steps or the robot moved in the middle of the sweep: after {:.0} % of it everything lies {:.1} deg of pan, {:.1} deg of tilt and {:.0} cm off the reference",
                100.0 * bend.after,
                bend.pan_rad.to_degrees(),
                bend.tilt_rad.to_degrees(),
                100.0 * forward_m.hypot(left_m)
            )));
        }
    }
    let overlap = detection.overlap[0].max(detection.overlap[1]);
    if registration.share < OTHER_PLACE.0 && overlap < OTHER_PLACE.1 {
        return Some(Doubt::Elsewhere(format!(
            "this looks like another place: {:.0} % of the flat surfaces agree, and neither view saw more than {:.0} % of the other",
            100.0 * registration.share,
            100.0 * overlap
        )));
    }
    let turn = registration.current_from_reference.rotation.scaled_axis();
    let tilt_rad = match sweep.view.tilt_axis {
        Some(axis) => turn.dot(&axis),
        // Axes of several pans: any of them.
        None => turn.xy().norm(),
    };
    let turned = turn.z.abs() >= suspicion.pan_rad || tilt_rad.abs() >= suspicion.tilt_rad;
    turned.then(|| {
        Doubt::Turned(format!(
            "the place lies {:.1} deg of pan and {:.1} deg of tilt off the reference: lost steps, or the robot stands askew",
            turn.z.to_degrees(),
            tilt_rad.to_degrees()
        ))
    })
}
