//! The view of a reference as its stored mixture has it: the mixture decides which surfaces are there, the view how far each
//! direction was seen (`docs/novelty.md section 3`).

use super::common_surface::{WeightedCells, shared_areas};
use super::constants::{MIN_VIEW_SHARE, SAMPLE_BOUNDS};
use super::prediction::unpredicted;
use super::{NoveltyError, NoveltySettings, PreparedView, ReferenceMixture};
use crate::geometry::View;
use crate::mixture::Gaussian;
use crate::mixture::linalg::Eigen;
use nalgebra::{Point3, Unit, Vector3};

/// Where a stored mixture and its view differ.
pub(super) struct Contradictions {
    /// Points of the view that the mixture does not predict.
    pub unknown_points: Vec<usize>,
    /// Components of which the view has no surface.
    pub unseen_components: Vec<usize>,
    /// Of each component, whether its weight differs from that of the surface that the view shows of it by more than
    /// `weight_sigmas` standard deviations of as many samples as there are cells.
    pub stated_weights: Vec<bool>,
}

impl Contradictions {
    /// Compares `gamma` with the view that it was made from. A mixture that was fitted to this view has none.
    ///
    /// # Errors
    /// Cells that cannot be compared.
    pub(super) fn find(
        prepared: &PreparedView,
        gamma: &ReferenceMixture,
        settings: &NoveltySettings,
    ) -> Result<Self, NoveltyError> {
        let surfaces = &prepared.surfaces;
        let max_range_m = settings.max_range_m.unwrap_or(f64::INFINITY);
        let (cells, means): (Vec<usize>, Vec<Point3<f64>>) = prepared
            .cells_within(max_range_m)
            .map(|(cell, patch)| (cell, patch.mean))
            .unzip();
        let area_m2 = prepared.area_within_m2(max_range_m);
        let mut unknown = vec![false; surfaces.patches.len()];
        for i in unpredicted(&gamma.mixture, &means, area_m2, prepared)? {
            unknown[cells[i]] = true;
        }
        let shown = shown_weights(prepared, gamma, max_range_m)?;
        let stated = &gamma.mixture.weights;
        let limit = settings.quantify.weight_sigmas.powi(2);
        let samples = shown.samples;
        Ok(Self {
            unknown_points: (0..prepared.view.points.len())
                .filter(|i| unknown[surfaces.patch_of_point[*i] as usize])
                .collect(),
            unseen_components: (0..stated.len())
                .filter(|k| shown.weights[*k] < MIN_VIEW_SHARE * stated[*k])
                .collect(),
            stated_weights: stated
                .iter()
                .zip(&shown.weights)
                .map(|(stated, shown)| {
                    (stated - shown).powi(2) * samples > limit * shown.max(1.0 / samples)
                })
                .collect(),
        })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.unknown_points.is_empty() && self.unseen_components.is_empty()
    }

    /// The view without what the mixture does not have, and with what it has beside. A beam that ended where the mixture has
    /// nothing counts as one without a return.
    pub(super) fn resolve(&self, view: &View, gamma: &ReferenceMixture) -> View {
        let mut unknown = vec![false; view.points.len()];
        for i in &self.unknown_points {
            unknown[*i] = true;
        }
        let mut resolved = View {
            points: Vec::with_capacity(view.points.len()),
            no_return: view.no_return.clone(),
            ..view.clone()
        };
        for (p, unknown) in view.points.iter().zip(unknown) {
            if unknown {
                resolved
                    .no_return
                    .extend(Unit::try_new(p - view.origin, 1e-9));
            } else {
                resolved.points.push(*p);
            }
        }
        for k in &self.unseen_components {
            resolved.points.extend(sample_component(
                &gamma.mixture.components[*k],
                gamma.beams[*k].count,
            ));
        }
        resolved
    }
}

/// The weights that a view gives to the components of its mixture.
struct ShownWeights {
    weights: Vec<f64>,
    /// As many equal samples they are worth: the cells.
    samples: f64,
}

fn shown_weights(
    prepared: &PreparedView,
    gamma: &ReferenceMixture,
    max_range_m: f64,
) -> Result<ShownWeights, NoveltyError> {
    let mut cells = WeightedCells::default();
    for (_, patch) in prepared.cells_within(max_range_m) {
        cells.push(patch.mean, patch.area_m2);
    }
    let samples = cells.points.len() as f64;
    let shown_m2 = shared_areas(&gamma.mixture, &cells)?;
    let total_m2: f64 = shown_m2.iter().sum();
    Ok(ShownWeights {
        weights: shown_m2
            .into_iter()
            .map(|area_m2| area_m2 / total_m2)
            .collect(),
        samples,
    })
}

/// The view that a mixture stands for where no view was kept: points on every component, as many as it had beams. `frame` says
/// where the sensor was and what its ranges were like; its own points are not read.
pub(super) fn view_of_mixture(frame: &View, gamma: &ReferenceMixture) -> View {
    let points = gamma
        .mixture
        .components
        .iter()
        .zip(&gamma.beams)
        .flat_map(|(g, beams)| sample_component(g, beams.count))
        .collect();
    View {
        points,
        no_return: Vec::new(),
        ..frame.clone()
    }
}

/// Evenly spread points in the box of the component's variances, without chance.
pub(super) fn sample_component(
    g: &Gaussian,
    count: f64,
) -> impl Iterator<Item = Point3<f64>> + use<> {
    // Fractional parts of multiples of the powers of the plastic-number generalisation in three dimensions (root of
    // x^4 = x + 1): a sequence of low discrepancy.
    const STEP: f64 = 1.220_744_084_605_759_6;
    let mean = g.mean;
    let axes = Eigen::new(&g.covariance);
    // A uniform box of half side a has the variance a^2 / 3.
    let half_sides: [f64; 3] = std::array::from_fn(|axis| {
        let variance: f64 = axes.values[axis];
        (3.0 * variance.max(0.0)).sqrt()
    });
    let directions: [Vector3<f64>; 3] =
        std::array::from_fn(|axis| axes.vectors.column(axis).into());
    let count = if count.is_finite() { count } else { 0.0 };
    let count = count.clamp(SAMPLE_BOUNDS[0], SAMPLE_BOUNDS[1]) as usize;
    (1..=count).map(move |i| {
        let offset = (0..3).fold(Vector3::zeros(), |sum, axis| {
            // The widest axes get the steps of the lowest discrepancy.
            let step = STEP.powi(axis as i32 - 3);
            let unit = (0.5 + i as f64 * step).fract();
            sum + directions[axis] * half_sides[axis] * (2.0 * unit - 1.0)
        });
        mean + offset
    })
}
