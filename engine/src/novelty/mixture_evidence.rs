//! Evidence from the mixtures alone, without rays: a beam that Gamma does not explain is new, a component that the revisit
//! gives no weight is gone. The field of view, and what the mixtures themselves hide, say what could be seen
//! (`docs/novelty.md section 10`).

use super::common_surface::{WeightedCells, shared_areas};
use super::constants::PREDICTED_SIGMAS;
use super::plates::Plates;
use super::prediction::{Prediction, most_likely_components};
use super::theta::widen;
use super::view_pair::ViewPair;
use super::{
    Evidence, EvidenceSettings, NoveltyError, NoveltySettings, QuantifySettings, Visibility,
};
use crate::geometry::SurfacePatch;
use crate::mixture::{Mixture, split_until_flat};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

const MIN_CELLS_PER_TASK: usize = 256;

/// Evidence of the points of both views.
///
/// # Errors
/// Points that cannot be compared with the mixture.
pub(super) fn evidence_from_mixture(
    gamma: &Mixture,
    pair: &ViewPair<'_>,
    settings: &NoveltySettings,
) -> Result<[Vec<Evidence>; 2], NoveltyError> {
    let [reference, current] = pair.views;
    let margin_rad = settings.evidence.field_margin_spacings
        * reference.rays.spacing_rad.max(current.rays.spacing_rad);
    // Gamma predicts cells, so cells are asked: single beams of a cell scatter.
    let predicted = predicted_cells(gamma, pair, settings, PREDICTED_SIGMAS)?;
    let grow_sigmas = settings.segment.grow_sigmas;
    let well_predicted = predicted_cells(gamma, pair, settings, grow_sigmas)?;
    let reference_origin = reference.view.origin;
    let seen_by_reference = cell_visibility(
        pair,
        1,
        &Plates::new(&[gamma], reference_origin, margin_rad),
        &settings.evidence,
    );
    let of_current = (0..predicted.len())
        .map(|cell| {
            let z = match (predicted[cell], well_predicted[cell]) {
                (false, _) => f64::INFINITY,
                (true, false) => grow_sigmas,
                (true, true) => 0.0,
            };
            deviation(z, seen_by_reference[cell], &settings.evidence)
        })
        .collect();

    // What is there beside Gamma hides too, whether it is new or came into view.
    let beside = unexplained(pair, &predicted)?;
    let current_origin = pair.reference_from(1).apply(&current.view.origin);
    let mixtures: Vec<&Mixture> = [gamma].into_iter().chain(&beside).collect();
    let seen_by_current = cell_visibility(
        pair,
        0,
        &Plates::new(&mixtures, current_origin, margin_rad),
        &settings.evidence,
    );
    let weightless = weightless_components(
        gamma,
        pair,
        [&seen_by_current, &seen_by_reference],
        &settings.quantify,
    )?;
    let means: Vec<Point3<f64>> = reference.surfaces.patches.iter().map(|p| p.mean).collect();
    let of_reference = most_likely_components(gamma, &means)
        .into_iter()
        .zip(&seen_by_current)
        .map(|(component, visibility)| {
            let z = if weightless[component as usize] {
                f64::INFINITY
            } else {
                0.0
            };
            deviation(z, *visibility, &settings.evidence)
        })
        .collect();
    let of_cells: [Vec<Evidence>; 2] = [of_reference, of_current];
    Ok([0, 1].map(|side| {
        let cells = &pair.views[side].surfaces.patch_of_point;
        cells
            .iter()
            .map(|cell| of_cells[side][*cell as usize])
            .collect()
    }))
}

/// Which current cells Gamma predicts within `bound_sigmas` of the scatter between both views.
fn predicted_cells(
    gamma: &Mixture,
    pair: &ViewPair<'_>,
    settings: &NoveltySettings,
    bound_sigmas: f64,
) -> Result<Vec<bool>, NoveltyError> {
    let [reference, current] = pair.views;
    let max_range_m = settings.max_range_m.unwrap_or(f64::INFINITY);
    let patches = &current.surfaces.patches;
    let positions: Vec<Point3<f64>> = patches
        .iter()
        .map(|patch| pair.reference_from(1).apply(&patch.mean))
        .collect();
    let origin = &reference.view.origin;
    let spacing_rad = reference.rays.spacing_rad.max(current.rays.spacing_rad);
    let min_cos = settings.evidence.grazing_cos;
    let scatter_m2 = |mean: &Point3<f64>, normal: &Vector3<f64>| {
        let range_m = (mean - origin).norm();
        let between = pair
            .cross_view_noise
            .map_or(0.0, |noise| noise.ranges.sigma_m(range_m));
        let both = reference
            .noise
            .sigma_m(range_m)
            .hypot(current.noise.sigma_m(range_m));
        let of_pose_m2 = pair.registration.covariance_at(mean).trace().max(0.0) / 3.0;
        let rows_m2 = row_spread_m2(&(mean - origin), normal, spacing_rad, min_cos);
        Matrix3::from_diagonal_element(both.max(between).powi(2) + of_pose_m2)
            + rows_m2 / bound_sigmas.powi(2)
    };
    Prediction {
        mixture: gamma,
        area_m2: reference.area_within_m2(max_range_m),
        flat_sigma_m: reference.split_settings().flat_sigma_m,
        bound_sigmas,
    }
    .of_points(&positions, scatter_m2)
}

/// Square of what lies between a beam and the next row where they meet the plane of this `normal` at `sight` from the
/// sensor: a surface goes on between two rows, and another visit's rows fall there.
fn row_spread_m2(
    sight: &Vector3<f64>,
    normal: &Vector3<f64>,
    spacing_rad: f64,
    min_cos: f64,
) -> Matrix3<f64> {
    let range_m = sight.norm();
    let Some(direction) = sight.try_normalize(1e-6) else {
        return Matrix3::zeros();
    };
    let cos = normal.dot(&direction);
    let cos = cos.signum() * cos.abs().max(min_cos);
    // A beam that is turned by one spacing across `direction`; which way the rows go is not known.
    let turned = Matrix3::identity() - direction * direction.transpose();
    let on_plane = Matrix3::identity() - direction * normal.transpose() / cos;
    let step_m = on_plane * turned * (spacing_rad * range_m);
    step_m * step_m.transpose()
}

/// The mixture of what Gamma does not explain in the current view, in the reference's frame; `None` if it explains all.
fn unexplained(pair: &ViewPair<'_>, predicted: &[bool]) -> Result<Option<Mixture>, NoveltyError> {
    let current = pair.views[1];
    let points: Vec<Point3<f64>> = current
        .surfaces
        .patches
        .iter()
        .zip(predicted)
        .filter(|(_, predicted)| !**predicted)
        .map(|(patch, _)| pair.reference_from(1).apply(&patch.mean))
        .collect();
    if points.is_empty() {
        return Ok(None);
    }
    Ok(Some(split_until_flat(
        &points,
        None,
        &current.split_settings(),
    )?))
}

fn deviation(z: f64, visibility: Visibility, settings: &EvidenceSettings) -> Evidence {
    if visibility == Visibility::OnSurface {
        Evidence::from_deviation(z.min(settings.max_sigmas))
    } else {
        Evidence::none(visibility)
    }
}

/// How the other sensor could see each cell of view `side`; `plates` are those of the mixtures before it. What it could see
/// counts as on a surface.
fn cell_visibility(
    pair: &ViewPair<'_>,
    side: usize,
    plates: &Plates,
    settings: &EvidenceSettings,
) -> Vec<Visibility> {
    let own = pair.views[side];
    let observer = pair.observer_of(side);
    let rays = &observer.view.rays;
    let hole_rad = settings.hole_spacings * rays.spacing_rad;
    let free_m = observer.view.free_m(settings);
    let reference_from_own = pair.reference_from(side);
    let visibility = |patch: &SurfacePatch| {
        let offset = observer.observer_from_own.apply(&patch.mean) - rays.origin();
        let range_m = offset.norm();
        let margin_rad =
            settings.field_margin_spacings * rays.spacing_rad + settings.origin_error_m / range_m;
        let in_field = offset.try_normalize(1e-6).is_some_and(|direction| {
            if range_m > free_m {
                return false;
            }
            let around = rays.neighbours(&direction);
            // Beams on all sides; else a hole well within the bounds.
            (around.nearest.is_some_and(|(_, angle)| angle <= hole_rad)
                && around.are_all_around(rays.spacing_rad))
                || rays.field_of_view.contains(&direction, margin_rad)
        });
        if !in_field {
            return Visibility::OutOfView;
        }
        let noise_m = own.noise.sigma_m(range_m);
        if plates.hide(&reference_from_own.apply(&patch.mean), noise_m) {
            Visibility::Occluded
        } else {
            Visibility::OnSurface
        }
    };
    own.surfaces
        .patches
        .par_iter()
        .with_min_len(MIN_CELLS_PER_TASK)
        .map(visibility)
        .collect()
}

/// Components of Gamma that the current view gives less than one cell, where so little is no chance.
fn weightless_components(
    gamma: &Mixture,
    pair: &ViewPair<'_>,
    visibility: [&[Visibility]; 2],
    settings: &QuantifySettings,
) -> Result<Vec<bool>, NoveltyError> {
    let widened = widen(gamma, pair.views[0], pair.views[1]);
    let mut expected_and_found: [Vec<f64>; 2] = Default::default();
    for side in [0, 1] {
        let patches = &pair.views[side].surfaces.patches;
        let reference_from_own = pair.reference_from(side);
        let mut cells = WeightedCells::default();
        for (patch, visibility) in patches.iter().zip(visibility[side]) {
            // A current cell that the reference could not see holds a component all the same.
            if side == 1 || *visibility == Visibility::OnSurface {
                cells.push(reference_from_own.apply(&patch.mean), 1.0);
            }
        }
        expected_and_found[side] = shared_areas(&widened, &cells)?;
    }
    let [expected, found] = expected_and_found;
    // None where n are expected has the probability exp(-n); as rare as `weight_sigmas` of a normal distribution.
    let least = 0.5 * settings.weight_sigmas.powi(2);
    Ok(expected
        .into_iter()
        .zip(found)
        .map(|(expected, found)| found < 1.0 && expected > least)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::row_spread_m2;
    use nalgebra::{Matrix3, Vector3};

    const SPACING_RAD: f64 = 1e-3;

    #[test]
    fn rows_on_a_floor_lie_apart_as_their_beams_meet_it() {
        // At the height h over the floor, a turn by a at the ground distance x moves the foot by a (h^2 + x^2) / h.
        let (height_m, ground_m) = (1.2, 3.0);
        let sight = Vector3::new(ground_m, 0.0, -height_m);
        let spread = row_spread_m2(&sight, &Vector3::z(), SPACING_RAD, 0.01);
        let step_m = SPACING_RAD * (height_m * height_m + ground_m * ground_m) / height_m;
        assert!((spread[(0, 0)].sqrt() / step_m - 1.0).abs() < 1e-9);
        let across_m = SPACING_RAD * sight.norm();
        assert!((spread[(1, 1)].sqrt() / across_m - 1.0).abs() < 1e-9);
        assert!(spread[(2, 2)].abs() < 1e-18);
        let turned_over = row_spread_m2(&sight, &-Vector3::z(), SPACING_RAD, 0.01);
        assert!((spread - turned_over).norm() < 1e-15);
    }

    #[test]
    fn a_wall_straight_ahead_has_the_row_spacing_and_no_limit_is_passed() {
        let ahead = row_spread_m2(
            &Vector3::new(2.0, 0.0, 0.0),
            &Vector3::x(),
            SPACING_RAD,
            0.1,
        );
        let expected = Matrix3::from_diagonal(&Vector3::new(0.0, 4e-6, 4e-6));
        assert!((ahead - expected).norm() < 1e-18);
        // Met edge on, the rows would be infinitely far apart: as at the least cosine.
        let edge = row_spread_m2(
            &Vector3::new(2.0, 0.0, 0.0),
            &Vector3::z(),
            SPACING_RAD,
            0.1,
        );
        assert!((edge[(0, 0)].sqrt() - 2e-2).abs() < 1e-9);
        assert_eq!(
            row_spread_m2(&Vector3::zeros(), &Vector3::z(), SPACING_RAD, 0.1),
            Matrix3::zeros()
        );
    }
}
