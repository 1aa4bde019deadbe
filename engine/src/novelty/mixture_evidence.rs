//! Evidence from the mixtures alone, without rays: a beam that Gamma does not explain is new, a component that the revisit
//! gives no weight is gone, and only the field of view says what could be seen (`docs/novelty.md section 10`).

use super::common_surface::{WeightedCells, shared_areas};
use super::prediction::{most_likely_components, sigmas_from};
use super::theta::widen;
use super::view_pair::ViewPair;
use super::{
    Evidence, EvidenceSettings, NoveltyError, NoveltySettings, QuantifySettings, Visibility,
};
use crate::mixture::Mixture;
use nalgebra::Point3;

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
    let max_range_m = settings.max_range_m.unwrap_or(f64::INFINITY);
    let in_view = [0, 1].map(|side| points_in_view(pair, side, &settings.evidence));
    // Gamma predicts cells, so cells are asked: single beams of a cell scatter.
    let positions: Vec<Point3<f64>> = current
        .surfaces
        .patches
        .iter()
        .map(|patch| pair.reference_from(1).apply(&patch.mean))
        .collect();
    let origin = &reference.view.origin;
    let area_m2 = reference.area_within_m2(max_range_m);
    let sigmas = sigmas_from(gamma, &positions, area_m2, reference, |mean| {
        let range_m = (mean - origin).norm();
        let between = pair
            .cross_view_noise
            .map_or(0.0, |noise| noise.ranges.sigma_m(range_m));
        let both = reference
            .noise
            .sigma_m(range_m)
            .hypot(current.noise.sigma_m(range_m));
        both.max(between).powi(2) + pair.registration.covariance_at(mean).trace().max(0.0) / 3.0
    })?;
    let of_current = current
        .surfaces
        .patch_of_point
        .iter()
        .zip(&in_view[1])
        .map(|(cell, in_view)| deviation(sigmas[*cell as usize], *in_view, &settings.evidence))
        .collect();

    let weightless = weightless_components(gamma, pair, &in_view, &settings.quantify)?;
    let means: Vec<Point3<f64>> = reference.surfaces.patches.iter().map(|p| p.mean).collect();
    let component_of_cell = most_likely_components(gamma, &means);
    let of_reference = reference
        .surfaces
        .patch_of_point
        .iter()
        .zip(&in_view[0])
        .map(|(cell, in_view)| {
            let gone = weightless[component_of_cell[*cell as usize] as usize];
            deviation(
                if gone { f64::INFINITY } else { 0.0 },
                *in_view,
                &settings.evidence,
            )
        })
        .collect();
    Ok([of_reference, of_current])
}

fn deviation(z: f64, in_view: bool, settings: &EvidenceSettings) -> Evidence {
    if !in_view {
        return Evidence::none(Visibility::OutOfView);
    }
    Evidence::from_deviation(z.min(settings.max_sigmas))
}

/// Which points of view `side` lie surely in the field of view of the other.
fn points_in_view(pair: &ViewPair<'_>, side: usize, settings: &EvidenceSettings) -> Vec<bool> {
    let observer = pair.observer_of(side);
    let field = &observer.view.rays.field_of_view;
    let points = &pair.views[side].view.points;
    points
        .iter()
        .map(|p| {
            let offset = observer.observer_from_own.apply(p) - observer.view.rays.origin();
            let margin_rad = settings.field_margin_spacings * observer.view.rays.spacing_rad
                + settings.origin_error_m / offset.norm();
            offset
                .try_normalize(1e-6)
                .is_some_and(|direction| field.contains(&direction, margin_rad))
        })
        .collect()
}

/// Components of Gamma that the current view gives less than one cell, where so little is no chance.
fn weightless_components(
    gamma: &Mixture,
    pair: &ViewPair<'_>,
    in_view: &[Vec<bool>; 2],
    settings: &QuantifySettings,
) -> Result<Vec<bool>, NoveltyError> {
    let widened = widen(gamma, pair.views[0], pair.views[1]);
    let mut expected_and_found: [Vec<f64>; 2] = Default::default();
    for side in [0, 1] {
        let surfaces = &pair.views[side].surfaces;
        let reference_from_own = pair.reference_from(side);
        let mut visible = vec![false; surfaces.patches.len()];
        for (cell, in_view) in surfaces.patch_of_point.iter().zip(&in_view[side]) {
            visible[*cell as usize] |= *in_view;
        }
        let mut cells = WeightedCells::default();
        for (patch, visible) in surfaces.patches.iter().zip(visible) {
            if visible {
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
