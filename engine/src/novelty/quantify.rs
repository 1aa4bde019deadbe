//! d_GMM between what both views could see (paper Eq. 6), and each novelty's part of it (`docs/novelty.md section 7`).
//!
//! Both views are weighed on the reference's components, whose shapes are frozen; each novelty has components of its own, on
//! its side alone. Weights that differ by no more than sampling explains count as equal. Mass is the area of visible
//! surface, so that it does not depend on how beams crowd.

use super::common_surface::{VisibleSurface, uncertain_weights};
use super::compared_view::ComparedView;
use super::ledger::Ledger;
use super::quantified_change::{NoveltyShare, QuantifiedChange};
use super::sampling::explained_by_sampling;
use super::{NoveltyError, PreparedView, QuantifySettings};
use crate::mixture::{Mixture, split_until_flat};
use nalgebra::{Matrix3, Point3};

/// d_GMM between two views. `mixture` is the reference's, in its frame.
///
/// # Errors
/// Mixtures that cannot be fitted or compared.
pub(super) fn quantify(
    mixture: &Mixture,
    reference: &ComparedView<'_>,
    current: &ComparedView<'_>,
    settings: &QuantifySettings,
) -> Result<QuantifiedChange, NoveltyError> {
    let (of_reference, of_current) = rayon::join(
        || VisibleSurface::new(reference),
        || VisibleSurface::new(current),
    );
    let surfaces = [of_reference, of_current];
    let mut change = QuantifiedChange {
        d: 0.0,
        work_m3: 0.0,
        surface_m2: surfaces[0].total_m2().max(surfaces[1].total_m2()),
        appeared: vec![NoveltyShare::default(); current.segments.len()],
        disappeared: vec![NoveltyShare::default(); reference.segments.len()],
        unexplained: 0.0,
        components: [0; 2],
        overlap: [surfaces[0].overlap, surfaces[1].overlap],
    };
    if surfaces.iter().any(|s| s.background_m2 <= 0.0) {
        return Ok(change);
    }
    let widened = widen(mixture, reference.prepared, current.prepared);
    let ((of_reference, of_current), (unsure, deviating)) = rayon::join(
        || {
            rayon::join(
                || surfaces[0].background_weights(&widened),
                || surfaces[1].background_weights(&widened),
            )
        },
        || {
            rayon::join(
                || uncertain_weights(&widened, &surfaces, |s| &s.unsure),
                || uncertain_weights(&widened, &surfaces, |s| &s.deviating),
            )
        },
    );
    let (weights, unsure, deviating) = ([of_reference?, of_current?], unsure?, deviating?);
    let [of_reference, of_current] = explained_by_sampling(
        weights,
        &unsure,
        &deviating,
        [surfaces[0].samples, surfaces[1].samples],
        settings,
    );
    let mut ledger = Ledger::default();
    for (k, g) in mixture.components.iter().enumerate() {
        let masses = [
            of_reference[k] * surfaces[0].background_m2 / surfaces[0].total_m2(),
            of_current[k] * surfaces[1].background_m2 / surfaces[1].total_m2(),
        ];
        for (count, mass) in change.components.iter_mut().zip(masses) {
            *count += usize::from(mass > 0.0);
        }
        ledger.add(*g, masses, None);
    }
    for (side, view) in [reference, current].into_iter().enumerate() {
        for (index, points) in view.segments.iter().enumerate() {
            let mass = surfaces[side].segments_m2[index] / surfaces[side].total_m2();
            let own = segment_mixture(view, points)?;
            for (g, w) in own.components.iter().zip(&own.weights) {
                let mut masses = [0.0; 2];
                masses[side] = mass * w;
                change.components[side] += 1;
                ledger.add(*g, masses, Some((side, index)));
            }
            let shares = if side == 0 {
                &mut change.disappeared
            } else {
                &mut change.appeared
            };
            shares[index].mass = mass;
        }
    }
    ledger.settle(settings.ground, &mut change)?;
    change.work_m3 = change.d * change.surface_m2;
    Ok(change)
}

/// Mixture of one segment, in the reference's frame.
fn segment_mixture(
    view: &ComparedView<'_>,
    point_indices: &[usize],
) -> Result<Mixture, NoveltyError> {
    let points: Vec<Point3<f64>> = point_indices
        .iter()
        .map(|i| {
            view.reference_from_own
                .apply(&view.prepared.view.points[*i])
        })
        .collect();
    Ok(split_until_flat(
        &points,
        None,
        &view.prepared.split_settings(),
    )?)
}

/// Adds the noise of both views to the components. Points with more noise than a component is thick would be assigned to
/// whichever neighbour is thick enough.
fn widen(mixture: &Mixture, reference: &PreparedView, current: &PreparedView) -> Mixture {
    let mut widened = mixture.clone();
    for g in &mut widened.components {
        let range_m = (g.mean - reference.view.origin).norm();
        let sigma_m = reference
            .noise
            .sigma_m(range_m)
            .hypot(current.noise.sigma_m(range_m));
        g.covariance += Matrix3::identity() * sigma_m.powi(2);
    }
    widened
}
