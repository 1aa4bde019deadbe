//! Whether the points share themselves among the faces in sight as the beams would. Distances alone
//! let a thin side face take the noisy points of a plate's edge; so few beams could meet it that
//! the tally tells.

use super::constants::FACE_FLOOR_POINTS;
use super::matching::Observed;
use super::moments::seen_weight;
use super::primitive::{Cuboid, Primitive};
use super::remains::strays;
use super::settings::SurfaceModel;
use nalgebra::Point3;

/// Faces of one primitive in sight at most.
pub(super) const FACES: usize = 3;

/// -2 ln of the multinomial likelihood ratio between the share of the points next to every face and
/// the share of the beams that meet it (the G statistic), for the points' effective number; 0 for a
/// primitive of one face, and where the whole surface is shown.
pub(super) fn tally_cost(observed: &Observed, primitive: &Primitive) -> f64 {
    let faced = matches!(
        primitive,
        Primitive::Cylinder(_) | Primitive::Cuboid(_) | Primitive::Cone(_)
    );
    if !faced || observed.surface == SurfaceModel::Ideal {
        return 0.0;
    }
    let beams = beams_on(observed, primitive);
    g_statistic(&points_on(observed, primitive), &beams, observed.count)
}

/// Beams that meet every face, up to a common factor.
pub(super) fn beams_on(observed: &Observed, primitive: &Primitive) -> [f64; FACES] {
    let mut beams = [0.0; FACES];
    primitive.visible(&observed.sensor, &mut |patch| {
        let face = primitive.seen_face(&patch.at, &observed.sensor);
        beams[face] += seen_weight(&patch, &observed.sensor, &observed.density);
    });
    beams
}

/// Whether no more of the points lie farther than `limit_m` behind the box's face with most of them
/// than strays do: they show one face, and noise.
pub(super) fn shows_one_face(observed: &Observed, cuboid: &Cuboid, limit_m: f64) -> bool {
    let on = points_on(observed, &Primitive::Cuboid(*cuboid));
    let first = (0..FACES).max_by(|&a, &b| on[a].total_cmp(&on[b]));
    let behind = |p: &&Point3<f64>| {
        let over_m = first.map(|axis| cuboid.over_face_m(p, axis, &observed.sensor));
        over_m.is_some_and(|over_m| over_m < -limit_m)
    };
    let behind = observed.points.iter().filter(behind).count();
    behind as f64 <= strays(observed.points.len())
}

fn points_on(observed: &Observed, primitive: &Primitive) -> [f64; FACES] {
    let mut on = [0.0; FACES];
    for p in &observed.points {
        on[primitive.seen_face(p, &observed.sensor)] += 1.0;
    }
    on
}

/// 2 n sum p ln(p / q) of the shares p of `points` and q of `beams`; q is at least that of
/// `FACE_FLOOR_POINTS`, since noise brings a point or two over every edge.
fn g_statistic(points: &[f64; FACES], beams: &[f64; FACES], count: f64) -> f64 {
    let (all_points, all_beams): (f64, f64) = (points.iter().sum(), beams.iter().sum());
    if !(all_points > 0.0 && all_beams > 0.0) {
        return 0.0;
    }
    let least = FACE_FLOOR_POINTS / all_points;
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
    fn a_tally_as_expected_costs_nothing_and_a_skewed_one_its_likelihood_ratio() {
        assert!(g_statistic(&[30.0, 70.0, 0.0], &[0.3, 0.7, 0.0], 100.0).abs() < 1e-9);
        // scipy.stats.power_divergence([40, 60], [30, 70], lambda_="log-likelihood"): 4.5165
        let g = g_statistic(&[40.0, 60.0, 0.0], &[0.3, 0.7, 0.0], 100.0);
        assert!((g - 4.516_5).abs() < 1e-3, "{g}");
        assert!(g_statistic(&[0.0; 3], &[0.3, 0.7, 0.0], 100.0).abs() < 1e-12);
    }

    #[test]
    fn a_face_that_no_beam_meets_bears_a_point_or_two() {
        let few = g_statistic(&[98.0, 2.0, 0.0], &[1.0, 0.0, 0.0], 100.0);
        let many = g_statistic(&[90.0, 10.0, 0.0], &[1.0, 0.0, 0.0], 100.0);
        assert!(few < 2.0, "{few}");
        assert!(many > 15.0, "{many}");
    }
}
