//! The mixture that stands for a reference (Gamma of paper Eq. 6), and how it is fitted (`docs/novelty.md section 3`).

use super::common_surface::{WeightedCells, shared_areas};
use super::constants::{
    MAX_COMPONENTS, MIN_COVERAGE, MIN_NOISE_SAMPLES, PREDICTION_MIN_POINTS, SINGLE_CELL_ROUNDS,
};
use super::noise::STEEP_COS;
use super::prediction::{coverage, unpredicted};
use super::{NoveltyError, NoveltySettings, PreparedView, RevisitModel};
use crate::mixture::{
    ComponentSelection, FitSettings, Gaussian, Mixture, RefitSettings, SplitSettings, Unexplained,
    fit, refit, split_until_flat,
};
use nalgebra::{Matrix3, Point3};

/// What the beams of one component were like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComponentBeams {
    /// Number of beams that ended on it.
    pub count: f64,
    /// Standard deviation of their ranges, metres.
    pub noise_m: f64,
    /// Share of the beams towards it that did not come back, 0 to 1. Of a bare cloud, which does not record them, 0.
    pub lost_share: f64,
}

/// Gamma: the mixture of a reference, with what its beams were like.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReferenceMixture {
    /// Weights are shares of the visible surface; positions are in the reference's frame.
    pub mixture: Mixture,
    /// One per component.
    pub beams: Vec<ComponentBeams>,
}

impl ReferenceMixture {
    /// Fits the mixture of `prepared`. `seed` is for fits with random starts.
    ///
    /// # Errors
    /// Cells that cannot be fitted.
    pub fn fit(
        prepared: &PreparedView,
        settings: &NoveltySettings,
        seed: u64,
    ) -> Result<Self, NoveltyError> {
        let mixture = fit_view(prepared, settings, seed)?;
        Ok(Self {
            beams: component_beams(prepared, &mixture, settings)?,
            mixture,
        })
    }

    /// Whether it can be compared: components, and beams for each.
    ///
    /// # Errors
    /// No component, or another number of beams than of components.
    pub(super) fn check(&self) -> Result<(), NoveltyError> {
        let [components, beams] = [self.mixture.len(), self.beams.len()];
        if components == 0 || components != beams {
            return Err(NoveltyError::BadReferenceMixture { components, beams });
        }
        Ok(())
    }
}

/// The mixture of a view by itself, from the means of its cells, each weighted by its area.
pub(super) fn fit_view(
    prepared: &PreparedView,
    settings: &NoveltySettings,
    seed: u64,
) -> Result<Mixture, NoveltyError> {
    let max_range_m = settings.max_range_m.unwrap_or(f64::INFINITY);
    let (points, areas_m2): (Vec<Point3<f64>>, Vec<f64>) = prepared
        .cells_within(max_range_m)
        .map(|(_, patch)| (patch.mean, patch.area_m2))
        .unzip();
    match settings.model {
        RevisitModel::Refit => fit_until_predicted(prepared, &points, &areas_m2),
        RevisitModel::Independent { max_components } => {
            let bic = FitSettings {
                components: ComponentSelection::Bic {
                    max: max_components,
                },
                seed,
                ..FitSettings::default()
            };
            Ok(fit(&points, None, &bic)?.mixture)
        }
    }
}

/// Splits until flat, runs EM, and adds components where the mixture does not predict a cell to its noise: clutter, poles,
/// edges.
fn fit_until_predicted(
    prepared: &PreparedView,
    points: &[Point3<f64>],
    areas_m2: &[f64],
) -> Result<Mixture, NoveltyError> {
    let flat = FitSettings {
        components: ComponentSelection::Flat(prepared.split_settings()),
        ..FitSettings::default()
    };
    let area_m2 = areas_m2.iter().sum();
    let bounded = |components: usize| {
        let points = points.len();
        match components {
            ..=MAX_COMPONENTS => Ok(()),
            _ => Err(NoveltyError::NoSurfaces { points, components }),
        }
    };
    // Before EM, whose time grows with both.
    if points.len() > MAX_COMPONENTS {
        let split = split_until_flat(points, Some(areas_m2), &prepared.split_settings())?;
        bounded(split.len())?;
    }
    let start = fit(points, Some(areas_m2), &flat)?.mixture;
    let mut mixture = covering(start, area_m2)?;
    for min_points in PREDICTION_MIN_POINTS {
        let missing = unpredicted(&mixture, points, area_m2, prepared)?;
        // Without missing cells this settles the weights alone.
        let settings = RefitSettings {
            split: SplitSettings {
                min_points,
                ..prepared.split_settings()
            },
            ..RefitSettings::default()
        };
        let refitted = refit(
            &mixture,
            points,
            Some(areas_m2),
            Unexplained::Listed(&missing),
            &settings,
        )?;
        mixture = covering(refitted.mixture, area_m2)?;
        bounded(mixture.len())?;
        if missing.is_empty() {
            break;
        }
    }
    // More weights make every other one less, which may take a cell out of what is predicted.
    for _ in 0..SINGLE_CELL_ROUNDS {
        let missing = unpredicted(&mixture, points, area_m2, prepared)?;
        if missing.is_empty() {
            break;
        }
        bounded(mixture.len() + missing.len())?;
        mixture = with_single_cells(mixture, &missing, points, areas_m2)?;
    }
    Ok(mixture)
}

/// Adds a component for each of the cells `missing`.
fn with_single_cells(
    mixture: Mixture,
    missing: &[usize],
    points: &[Point3<f64>],
    areas_m2: &[f64],
) -> Result<Mixture, NoveltyError> {
    let total_m2: f64 = areas_m2.iter().sum();
    let Mixture {
        mut weights,
        mut components,
    } = mixture;
    for i in missing {
        weights.push(areas_m2[*i] / total_m2);
        components.push(Gaussian {
            mean: points[*i],
            // That of a cube whose faces have the area.
            covariance: Matrix3::from_diagonal_element(areas_m2[*i] / 12.0),
        });
    }
    Ok(Mixture::from_masses(weights, components)?)
}

/// Without the components that EM left without mass, or that cover next to nothing of what they span.
fn covering(mixture: Mixture, area_m2: f64) -> Result<Mixture, NoveltyError> {
    let (weights, components) = mixture
        .weights
        .into_iter()
        .zip(mixture.components)
        .filter(|(weight, g)| coverage(g, weight * area_m2) >= MIN_COVERAGE)
        .unzip();
    Ok(Mixture::from_masses(weights, components)?)
}

/// What the beams of `prepared` were like. Each cell's beams are shared out among the components as its area is.
///
/// # Errors
/// Cells that cannot be shared out.
fn component_beams(
    prepared: &PreparedView,
    mixture: &Mixture,
    settings: &NoveltySettings,
) -> Result<Vec<ComponentBeams>, NoveltyError> {
    let surfaces = &prepared.surfaces;
    let origin = &prepared.view.origin;
    let cells = surfaces.patches.len();
    let (mut samples, mut squares, mut lost) =
        (vec![0.0; cells], vec![0.0; cells], vec![0.0; cells]);
    for (p, cell) in prepared.view.points.iter().zip(&surfaces.patch_of_point) {
        let patch = &surfaces.patches[*cell as usize];
        let beam = p - origin;
        let incidence_cos = patch.normal.dot(&beam).abs() / beam.norm().max(1e-9);
        if patch.flat && incidence_cos > STEEP_COS {
            samples[*cell as usize] += 1.0;
            squares[*cell as usize] += (patch.height_m(p) / incidence_cos).powi(2);
        }
    }
    let within_rad = settings.evidence.hole_spacings * prepared.rays.spacing_rad;
    for direction in &prepared.view.no_return {
        if let Some(ray) = prepared.rays.nearest_return(direction, within_rad) {
            lost[surfaces.patch_of_point[ray] as usize] += 1.0;
        }
    }
    let shared = |amount: &dyn Fn(usize) -> f64| {
        let mut weighted = WeightedCells::default();
        for (cell, patch) in surfaces.patches.iter().enumerate() {
            if amount(cell) > 0.0 {
                weighted.push(patch.mean, amount(cell));
            }
        }
        shared_areas(mixture, &weighted)
    };
    let counts = shared(&|cell| surfaces.patches[cell].count as f64)?;
    let samples = shared(&|cell| samples[cell])?;
    let squares = shared(&|cell| squares[cell])?;
    let lost = shared(&|cell| lost[cell])?;
    Ok((0..mixture.len())
        .map(|k| ComponentBeams {
            count: counts[k],
            noise_m: if samples[k] >= MIN_NOISE_SAMPLES {
                (squares[k] / samples[k]).sqrt()
            } else {
                let range_m = (mixture.components[k].mean - origin).norm();
                prepared.noise.sigma_m(range_m)
            },
            lost_share: lost[k] / (lost[k] + counts[k]).max(1.0),
        })
        .collect())
}
