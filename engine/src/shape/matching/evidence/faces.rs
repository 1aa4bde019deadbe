//! Points per visible face against the beams that meet it. By distances alone a thin side face could take the noisy points
//! of a plate's edge, though hardly a beam meets it.

use super::residuals::max_outliers;
use crate::shape::constants::FACE_NOISE_POINTS;
use crate::shape::matching::fit::Observation;
use crate::shape::matching::moments::beam_weight;
use crate::shape::primitive::{Cuboid, Primitive};
use crate::shape::settings::SurfaceModel;
use nalgebra::Point3;

/// Visible faces of a primitive at most.
pub(super) const MAX_FACES: usize = 3;

/// -2 ln of the multinomial likelihood ratio between the share of the points next to every face and the share of the beams
/// that meet it (the G statistic), for the effective number of points; 0 for a primitive of one face, and for whole
/// surfaces.
pub(in crate::shape::matching) fn face_share_cost(
    observed: &Observation,
    primitive: &Primitive,
) -> f64 {
    let has_faces = matches!(
        primitive,
        Primitive::Cylinder(_) | Primitive::Cuboid(_) | Primitive::Cone(_)
    );
    if !has_faces || observed.surface == SurfaceModel::Ideal {
        return 0.0;
    }
    let beams = beams_per_face(observed, primitive);
    g_statistic(
        &points_per_face(observed, primitive),
        &beams,
        observed.effective_points,
    )
}

/// Beams that meet each face, up to a common factor.
pub(super) fn beams_per_face(observed: &Observation, primitive: &Primitive) -> [f64; MAX_FACES] {
    let mut beams = [0.0; MAX_FACES];
    primitive.for_each_visible(&observed.sensor, &mut |element| {
        let face = primitive.visible_face(&element.position, &observed.sensor);
        beams[face] += beam_weight(&element, &observed.sensor, &observed.density);
    });
    beams
}

/// Whether the points show a single face of the box: no more than outliers are farther than `limit_m` behind the face with
/// most points.
pub(in crate::shape::matching) fn shows_one_face(
    observed: &Observation,
    cuboid: &Cuboid,
    limit_m: f64,
) -> bool {
    let on = points_per_face(observed, &Primitive::Cuboid(*cuboid));
    let first = (0..MAX_FACES).max_by(|&a, &b| on[a].total_cmp(&on[b]));
    let behind = |p: &&Point3<f64>| {
        let distance_m = first.map(|axis| cuboid.face_distance_m(p, axis, &observed.sensor));
        distance_m.is_some_and(|distance_m| distance_m < -limit_m)
    };
    let behind = observed.points.iter().filter(behind).count();
    behind as f64 <= max_outliers(observed.points.len())
}

fn points_per_face(observed: &Observation, primitive: &Primitive) -> [f64; MAX_FACES] {
    let mut on = [0.0; MAX_FACES];
    for p in &observed.points {
        on[primitive.visible_face(p, &observed.sensor)] += 1.0;
    }
    on
}

/// 2 n sum p ln(p / q) of the shares p of `points` and q of `beams`; q is at least that of `FACE_NOISE_POINTS`, since noise
/// brings a point or two over every edge.
fn g_statistic(points: &[f64; MAX_FACES], beams: &[f64; MAX_FACES], count: f64) -> f64 {
    let (all_points, all_beams): (f64, f64) = (points.iter().sum(), beams.iter().sum());
    if !(all_points > 0.0 && all_beams > 0.0) {
        return 0.0;
    }
    let least = FACE_NOISE_POINTS / all_points;
    let shares = points.iter().zip(beams);
    let sum: f64 = shares
        .filter(|(n, _)| **n > 0.0)
        .map(|(n, w)| {
            let share = n / all_points;
            share * (share / (w / all_beams).max(least)).ln()
        })
        .sum();
    (2.0 * count * sum).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::g_statistic;

    #[test]
    fn expected_shares_cost_nothing_and_others_their_likelihood_ratio() {
        assert!(g_statistic(&[30.0, 70.0, 0.0], &[0.3, 0.7, 0.0], 100.0).abs() < 1e-9);
        // scipy.stats.power_divergence([40, 60], [30, 70], lambda_="log-likelihood"): 4.5165
        let g = g_statistic(&[40.0, 60.0, 0.0], &[0.3, 0.7, 0.0], 100.0);
        assert!((g - 4.516_5).abs() < 1e-3, "{g}");
        assert!(g_statistic(&[0.0; 3], &[0.3, 0.7, 0.0], 100.0).abs() < 1e-12);
    }

    #[test]
    fn a_face_that_no_beam_meets_may_have_a_point_or_two() {
        let few = g_statistic(&[98.0, 2.0, 0.0], &[1.0, 0.0, 0.0], 100.0);
        let many = g_statistic(&[90.0, 10.0, 0.0], &[1.0, 0.0, 0.0], 100.0);
        assert!(few < 2.0, "{few}");
        assert!(many > 15.0, "{many}");
    }
}
