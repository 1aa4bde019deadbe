//! The score by which fits are compared: -2 ln odds, up to a constant.

use super::evidence::faces::{face_share_cost, shows_one_face};
use super::fit::{MatchedPrimitive, Observation};
use crate::shape::constants::{
    FORM_PENALTY, MIN_AXIS_TO_VIEW_RAD, MIN_LENGTH_TO_WIDTH, OUTLIER_SIGMAS, PLATE_THICKNESS_SHARE,
    ROUGHNESS_SHARE,
};
use crate::shape::primitive::Primitive;
use nalgebra::{Unit, Vector3};

/// (n/2) d_FM^2 + mean term + points + cost of the face shares + k ln n + penalty of the form.
pub(super) fn score(
    observed: &Observation,
    fit: &MatchedPrimitive,
    view: &Unit<Vector3<f64>>,
) -> f64 {
    let k = fit.primitive.parameter_count() as f64;
    let faces = face_share_cost(observed, &fit.primitive);
    fit.cost
        + k * observed.effective_points.ln()
        + faces
        + form_penalty(observed, &fit.primitive, view)
}

/// What a class pays where this form of it differs from another class by an edge only.
pub(super) fn form_penalty(
    observed: &Observation,
    primitive: &Primitive,
    view: &Unit<Vector3<f64>>,
) -> f64 {
    match primitive {
        Primitive::Cylinder(c) => {
            let along_view = c.axis.dot(view).abs() > MIN_AXIS_TO_VIEW_RAD.cos();
            if c.length_m < MIN_LENGTH_TO_WIDTH * 2.0 * c.radius_m || along_view {
                FORM_PENALTY
            } else {
                0.0
            }
        }
        Primitive::Cuboid(b) => {
            // Expected noise or the one about the box itself, whichever is more.
            let reach_m = OUTLIER_SIGMAS
                * expected_sd_m(observed).max(typical_distance_m(observed, primitive));
            if shows_one_face(observed, b, reach_m) {
                FORM_PENALTY
            } else {
                0.0
            }
        }
        _ => 0.0,
    }
}

/// Standard deviation of a point about the surface of its own class: noise and roughness, metres.
pub(super) fn expected_sd_m(observed: &Observation) -> f64 {
    observed.noise_m.hypot(ROUGHNESS_SHARE * observed.scale_m)
}

/// Standard deviation of the points about the surface from their median distance, corrected for the number of
/// parameters, metres.
pub(super) fn typical_distance_m(observed: &Observation, primitive: &Primitive) -> f64 {
    let mut distances: Vec<f64> = observed
        .points
        .iter()
        .map(|p| observed.distance_m(primitive, p).abs())
        .collect();
    distances.sort_by(f64::total_cmp);
    let median = distances.get(distances.len() / 2).copied();
    let n = distances.len() as f64;
    let free = (n - primitive.parameter_count() as f64).max(1.0);
    median.unwrap_or(f64::INFINITY) / 0.6745 * (n / free).sqrt()
}

/// Whether a box is so thin that it is reported as a plane, however well it also fits what is beside the plane.
pub(super) fn is_plate(primitive: &Primitive) -> bool {
    let [_, second, third] = primitive.size_m();
    matches!(primitive, Primitive::Cuboid(_)) && third < PLATE_THICKNESS_SHARE * second
}
