//! The whole comparison, step by step.

use super::{Evidence, Judge, NoveltyError, Prepared, Settings, Thing, noise, segment};
use crate::geometry::{Pose, Registration, register};

/// What stands out.
pub struct Found {
    pub registration: Registration,
    pub between: Option<noise::Between>,
    pub appeared: Vec<Thing>,
    pub disappeared: Vec<Thing>,
    pub now: Vec<Evidence>,
    pub then: Vec<Evidence>,
}

/// Finds.
pub fn find(
    reference: &Prepared,
    current: &Prepared,
    settings: &Settings,
) -> Result<Found, NoveltyError> {
    let gate_m = gate_m(reference, current);
    let registration = register(
        &reference.surfaces,
        &current.surfaces,
        &Pose::identity(),
        gate_m,
        &settings.registration,
    );
    let current_from_reference = registration.current_from_reference;
    let reference_from_current = current_from_reference.inverse();
    let between = noise::between(
        &reference.surfaces,
        &reference.view.origin,
        &current.view.points,
        &registration,
        2.0 * gate_m,
    );
    let now = Judge {
        other: reference,
        other_from_own: reference_from_current,
        own_noise: current.noise,
        between,
        registration: &registration,
        reference_from_own: reference_from_current,
        settings: &settings.evidence,
    }
    .judge(&current.view.points, &current.view.origin);
    let then = Judge {
        other: current,
        other_from_own: current_from_reference,
        own_noise: reference.noise,
        between,
        registration: &registration,
        reference_from_own: Pose::identity(),
        settings: &settings.evidence,
    }
    .judge(&reference.view.points, &reference.view.origin);
    Ok(Found {
        appeared: segment(current, &now, &settings.segment),
        disappeared: segment(reference, &then, &settings.segment),
        registration,
        between,
        now,
        then,
    })
}

/// Distance within which surfaces count as the same: three sigmas of both at the median range, and
/// no less than 2 cm, the size of what surfaces bend by within a cell.
fn gate_m(reference: &Prepared, current: &Prepared) -> f64 {
    let middle = |p: &Prepared| {
        let mut r: Vec<f64> = (0..p.view.points.len())
            .map(|i| p.rays.range_m(i))
            .collect();
        let at = r.len() / 2;
        *r.select_nth_unstable_by(at, f64::total_cmp).1
    };
    let sigma = reference
        .noise
        .sigma_m(middle(reference))
        .hypot(current.noise.sigma_m(middle(current)));
    (3.0 * sigma).max(0.02)
}
