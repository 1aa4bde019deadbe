//! Theta: the revisit's mixture, fitted from Gamma (`docs/novelty.md section 7`).
//!
//! Gamma's components keep their means and covariances; their weights move where the revisit shows another share of the
//! surface than noise and sampling explain. Beams that Gamma does not explain bring new components. A component of Gamma that
//! is partly gone is split, in both mixtures as compared. Mass is the area of visible surface, so that it does not depend on
//! how beams crowd.

mod split_component;

use super::common_surface::{VisibleSurface, WeightedCells, shared_areas};
use super::compared_mixtures::ComparedMixtures;
use super::compared_view::ComparedView;
use super::model::SegmentId;
use super::prediction::most_likely_components;
use super::sampling::WeightEvidence;
use super::{NoveltyError, PreparedView, QuantifySettings, Reference};
use crate::mixture::linalg::Eigen;
use crate::mixture::{Gaussian, Mixture, split_until_flat};
use nalgebra::{Matrix3, Point3, Vector3};
use split_component::split_component;

/// Gamma and Theta as compared, with the segment that each unpaired component belongs to.
pub(super) struct ThetaFit {
    pub compared: ComparedMixtures,
    /// Per component: side and index of its segment.
    pub owners: Vec<Option<SegmentId>>,
}

/// Fits Theta to the current view, starting from the mixture of `reference`, over what both views could see. The views'
/// segments are the beams that Gamma does not explain (current), and those of Gamma that are gone (reference).
///
/// # Errors
/// Mixtures that cannot be fitted.
pub(super) fn fit_theta(
    reference: &Reference,
    views: &[ComparedView<'_>; 2],
    surfaces: &[VisibleSurface; 2],
    settings: &QuantifySettings,
) -> Result<ThetaFit, NoveltyError> {
    let gamma = &reference.gamma.mixture;
    let widened = widen(gamma, views[0].prepared, views[1].prepared);
    let ((of_reference, of_current), (hidden, (unsure, deviating))) = rayon::join(
        || {
            rayon::join(
                || shared_areas(&widened, &surfaces[0].common),
                || shared_areas(&widened, &surfaces[1].common),
            )
        },
        || {
            let deviating = || {
                // In shares of each view's own common surface, so that they compare with its weights.
                let mut joined = WeightedCells::default();
                for surface in surfaces {
                    joined.extend(&surface.deviating, 1.0 / surface.background_m2);
                }
                shared_areas(&widened, &joined)
            };
            let unsure_of_current = || shared_areas(&widened, &surfaces[1].unsure);
            rayon::join(
                || shared_areas(&widened, &surfaces[0].unsure),
                || rayon::join(unsure_of_current, deviating),
            )
        },
    );
    let (common_m2, hidden_m2, unsure_m2) = (of_reference?, hidden?, unsure?);
    let in_range_m2: Vec<f64> = common_m2
        .iter()
        .zip(&hidden_m2)
        .map(|(a, b)| a + b)
        .collect();
    let unsure: Vec<f64> = hidden_m2
        .iter()
        .zip(&unsure_m2)
        .map(|(a, b)| a / surfaces[0].background_m2 + b / surfaces[1].background_m2)
        .collect();
    // The mass of each component that both views could see is Gamma's weight times the share of its surface.
    let visible_share = |k: usize| {
        if in_range_m2[k] > 0.0 {
            (common_m2[k] / in_range_m2[k]).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let background: Vec<f64> = (0..gamma.len())
        .map(|k| gamma.weights[k] * visible_share(k))
        .collect();
    let background_mass: f64 = background.iter().sum();
    let gone = gone_parts(gamma, &views[0], &in_range_m2);
    let gone_mass: f64 = gone.iter().map(|part| part.mass).sum();
    let mut fit = ThetaFit {
        compared: ComparedMixtures::default(),
        owners: Vec::new(),
    };
    if background_mass <= 0.0 {
        return Ok(fit);
    }
    let shares = |areas: &[f64]| -> Vec<f64> {
        let total: f64 = areas.iter().sum();
        areas.iter().map(|a| a / total).collect()
    };
    let stated = shares(&background);
    let theta = WeightEvidence {
        gamma: &stated,
        reference: &shares(&common_m2),
        current: &shares(&of_current?),
        stated: &reference.stated_weights,
        unsure: &unsure,
        deviating: &deviating?,
        samples: [surfaces[0].samples, surfaces[1].samples],
    }
    .theta(settings);

    let gamma_background = background_mass / (background_mass + gone_mass);
    let theta_background = surfaces[1].background_m2 / surfaces[1].total_m2();
    for (k, g) in gamma.components.iter().enumerate() {
        let own: Vec<&GonePart> = gone.iter().filter(|part| part.component == k).collect();
        let masses = [stated[k] * gamma_background, theta[k] * theta_background];
        let mut rest = Some(*g);
        let mut rest_mass = gamma.weights[k];
        let compared_mass = background_mass + gone_mass;
        for part in own {
            // Areas are shared out softly: parts may claim a little more than there is.
            let Some(whole) = rest else { continue };
            let (taken, left) = split_component(&whole, &part.moments, part.mass / rest_mass);
            let mass = match left {
                Some(_) => part.mass / compared_mass,
                None => part.mass / compared_mass + masses[0],
            };
            rest_mass -= part.mass;
            rest = left;
            fit.add(taken, [mass, 0.0], Some((0, part.segment)));
        }
        if let Some(rest) = rest {
            fit.add(rest, masses, None);
        }
    }
    for (index, points) in views[1].segments.iter().enumerate() {
        let mass = surfaces[1].segments_m2[index] / surfaces[1].total_m2();
        let own = segment_mixture(&views[1], points)?;
        for (g, w) in own.components.iter().zip(&own.weights) {
            fit.add(*g, [0.0, mass * w], Some((1, index)));
        }
    }
    Ok(fit)
}

impl ThetaFit {
    fn add(&mut self, gaussian: Gaussian, masses: [f64; 2], owner: Option<SegmentId>) {
        self.compared.push(gaussian, masses);
        self.owners.push(owner);
    }
}

/// The part of one component of Gamma that belongs to one segment of the reference.
struct GonePart {
    component: usize,
    segment: usize,
    /// In the weights of Gamma.
    mass: f64,
    /// Of its cells.
    moments: Gaussian,
}

/// Which parts of Gamma's components the segments of the reference are, in the order of the components.
fn gone_parts(gamma: &Mixture, reference: &ComparedView<'_>, in_range_m2: &[f64]) -> Vec<GonePart> {
    let surfaces = &reference.prepared.surfaces;
    let points = &reference.prepared.view.points;
    let mut parts = Vec::new();
    for (segment, indices) in reference.segments.iter().enumerate() {
        let positions: Vec<Point3<f64>> = indices.iter().map(|i| points[*i]).collect();
        let mut members: Vec<Vec<(Point3<f64>, f64)>> = vec![Vec::new(); gamma.len()];
        for ((i, p), k) in indices
            .iter()
            .zip(&positions)
            .zip(most_likely_components(gamma, &positions))
        {
            let patch = &surfaces.patches[surfaces.patch_of_point[*i] as usize];
            let area_m2 = patch.area_m2 / patch.count.max(1) as f64;
            members[k as usize].push((*p, area_m2));
        }
        for (component, members) in members.into_iter().enumerate() {
            let weighted = members.iter().map(|(p, area_m2)| (p, *area_m2));
            let Some((moments, area_m2)) = Gaussian::from_weighted_points(weighted) else {
                continue;
            };
            // Its share of all surface of the component.
            let share = area_m2 / in_range_m2[component].max(area_m2);
            parts.push(GonePart {
                component,
                segment,
                mass: gamma.weights[component] * share,
                moments,
            });
        }
    }
    parts
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

/// Adds the noise of both views to the components, and along them the row spacing of the coarser view. Points with more noise
/// than a component is thick would be assigned to whichever neighbour is thick enough; and where rows are wide apart, they
/// fall on other components from another pose.
pub(super) fn widen(
    mixture: &Mixture,
    reference: &PreparedView,
    current: &PreparedView,
) -> Mixture {
    let mut widened = mixture.clone();
    let spacing_rad = reference.rays.spacing_rad.max(current.rays.spacing_rad);
    for g in &mut widened.components {
        let range_m = (g.mean - reference.view.origin).norm();
        let sigma_m = reference
            .noise
            .sigma_m(range_m)
            .hypot(current.noise.sigma_m(range_m));
        let across: Vector3<f64> = Eigen::new(&g.covariance).vectors.column(0).into();
        let along = Matrix3::identity() - across * across.transpose();
        g.covariance +=
            Matrix3::identity() * sigma_m.powi(2) + along * (spacing_rad * range_m).powi(2);
    }
    widened
}
