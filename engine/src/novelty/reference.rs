//! A reference, with the mixture of its view.

use super::{NoveltyError, NoveltySettings, PreparedView, RevisitModel};
use crate::geometry::{PlaneIndex, View};
use crate::mixture::{ComponentSelection, FitSettings, Mixture, fit, split_until_flat};
use nalgebra::Point3;

/// A reference prepared for any number of comparisons.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The view, with its rays, surfaces and noise.
    pub prepared: PreparedView,
    /// Its flat cells, indexed for registration.
    pub(crate) planes: PlaneIndex,
    /// Its mixture (Gamma of Algorithm 1).
    pub mixture: Mixture,
}

impl Reference {
    /// Prepares `view`; `seed` is for fits with random starts.
    ///
    /// # Errors
    /// A view with too few points or with coordinates that are not finite.
    pub fn prepare(
        view: &View,
        settings: &NoveltySettings,
        seed: u64,
    ) -> Result<Self, NoveltyError> {
        let prepared = PreparedView::new(view, "reference", &settings.evidence)?;
        let mixture = fit_view(&prepared, settings, seed)?;
        Ok(Self {
            planes: PlaneIndex::new(&prepared.surfaces),
            prepared,
            mixture,
        })
    }
}

/// The mixture of a view by itself, from the means of its cells.
pub(super) fn fit_view(
    prepared: &PreparedView,
    settings: &NoveltySettings,
    seed: u64,
) -> Result<Mixture, NoveltyError> {
    let max_range_m = settings.max_range_m.unwrap_or(f64::INFINITY);
    let means: Vec<Point3<f64>> = prepared
        .surfaces
        .patches
        .iter()
        .map(|p| p.mean)
        .filter(|p| (p - prepared.view.origin).norm() <= max_range_m)
        .collect();
    Ok(match settings.model {
        RevisitModel::Refit => split_until_flat(&means, None, &prepared.split_settings())?,
        RevisitModel::Independent { max_components } => {
            let bic = FitSettings {
                components: ComponentSelection::Bic {
                    max: max_components,
                },
                seed,
                ..FitSettings::default()
            };
            fit(&means, None, &bic)?.mixture
        }
    })
}
