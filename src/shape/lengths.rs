//! Lengths from the extent of the points, where these lie densely enough to show it better than
//! the moments do: real surfaces are not covered as evenly as the moments suppose.

use super::constants::{BOUNDS, EXTENT_NOISE, LOG_VARIANCE_MISFIT};
use super::covariance::Candidate;
use super::primitive::{Cylinder, Plane, Primitive};
use super::ransac::smallest_rectangle;
use nalgebra::Point3;

/// The candidate with its lengths (a plane's sides, a cylinder's length) weighted by inverse
/// variance with the extent of `near`, its points. The extent of n points on a surface of area S
/// falls short by their spacing sqrt(S / n) on average and is uncertain by as much.
pub(super) fn measured(candidate: Candidate, near: &[Point3<f64>], noise_m: f64) -> Candidate {
    if near.is_empty() {
        return candidate;
    }
    match candidate.primitive {
        Primitive::Sphere(_) => candidate,
        Primitive::Cylinder(c) => cylinder(candidate, &c, near, noise_m),
        Primitive::Plane(p) => plane(candidate, &p.longer_first(), near, noise_m),
    }
}

fn uncertainty_m(spacing_m: f64, noise_m: f64) -> f64 {
    spacing_m.hypot(EXTENT_NOISE * noise_m)
}

/// Weight of the extent against the moments. The misfit of the moments is their part that dense
/// points do not cure; sampling hurts both alike.
fn weight(length_m: f64, extent_sd_m: f64) -> f64 {
    let misfit = length_m * LOG_VARIANCE_MISFIT / 2.0;
    let (m, e) = (misfit.powi(2), extent_sd_m.powi(2));
    m / (m + e).max(f64::MIN_POSITIVE)
}

fn cylinder(
    mut candidate: Candidate,
    c: &Cylinder,
    near: &[Point3<f64>],
    noise_m: f64,
) -> Candidate {
    let area = std::f64::consts::PI * c.radius_m * c.length_m;
    let spacing = (area / near.len() as f64).sqrt();
    let heights = near.iter().map(|p| (p - c.centre).dot(&c.axis));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    let extent_sd = uncertainty_m(spacing, noise_m);
    let w = weight(c.length_m, extent_sd);
    let length = c.length_m + w * (high - low + spacing - c.length_m);
    candidate.size_sd_m[2] *= (1.0 - w).sqrt();
    candidate.primitive = Primitive::Cylinder(Cylinder {
        centre: c.centre + c.axis.as_ref() * (w * f64::midpoint(low, high)),
        length_m: BOUNDS.cylinder_length_m.clamp(length),
        ..*c
    });
    candidate
}

fn plane(mut candidate: Candidate, p: &Plane, near: &[Point3<f64>], noise_m: f64) -> Candidate {
    let rectangle = smallest_rectangle(p, near);
    let spacing = (p.sides_m[0] * p.sides_m[1] / near.len() as f64).sqrt();
    let extent_sd = uncertainty_m(spacing, noise_m);
    let w = [0, 1].map(|k| weight(p.sides_m[k], extent_sd));
    let sides = [0, 1].map(|k| {
        let side = p.sides_m[k] + w[k] * (rectangle.sides_m[k] + spacing - p.sides_m[k]);
        BOUNDS.plane_side_m.clamp(side)
    });
    for k in [0, 1] {
        candidate.size_sd_m[k] *= (1.0 - w[k]).sqrt();
    }
    let by_extent = f64::midpoint(w[0], w[1]);
    candidate.primitive = Primitive::Plane(Plane {
        centre: p.centre + (rectangle.centre - p.centre) * by_extent,
        // A turn cannot be half one and half the other: the sides nearly are the same, or the
        // rectangle is nearly square and either will do.
        rotation: if by_extent > 0.5 {
            rectangle.rotation
        } else {
            p.rotation
        },
        sides_m: sides,
    });
    candidate
}
