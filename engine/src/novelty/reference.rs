//! A reference: its mixture and its view, ready for any number of comparisons.

use super::stored_view::{Contradictions, view_of_mixture};
use super::{NoveltyError, NoveltySettings, PreparedView, ReferenceMixture};
use crate::geometry::{PlaneIndex, View};

/// A reference prepared for any number of comparisons.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The view as the mixture has it, with its rays, surfaces and noise.
    pub prepared: PreparedView,
    /// Its flat cells, indexed for registration.
    pub(crate) planes: PlaneIndex,
    /// Its mixture: Gamma of paper Eq. 6.
    pub gamma: ReferenceMixture,
    /// Points of the view that the mixture does not have, and components of which the view has no surface. Both are 0 for a
    /// mixture that was fitted to this view.
    pub contradictions: [usize; 2],
    /// Components whose weight differs from the surface that the view shows of them.
    pub(super) stated_weights: Vec<bool>,
    /// Whether the view's rays were looked along; those to samples of a mixture were not.
    pub(super) has_rays: bool,
}

impl Reference {
    /// Fits the mixture of `view` and prepares both; `seed` is for fits with random starts.
    ///
    /// # Errors
    /// A view with too few points or with coordinates that are not finite.
    pub fn prepare(
        view: &View,
        settings: &NoveltySettings,
        seed: u64,
    ) -> Result<Self, NoveltyError> {
        let prepared = PreparedView::new(view, "reference", &settings.evidence)?;
        let gamma = ReferenceMixture::fit(&prepared, settings, seed)?;
        Ok(Self::new(prepared, gamma, [0; 2]))
    }

    /// Prepares a stored mixture with the view that it was fitted to. Nothing is fitted. Where the two differ, the mixture
    /// decides what was there (`docs/novelty.md section 3`).
    ///
    /// # Errors
    /// A view with too few points or with coordinates that are not finite; a mixture without components.
    pub fn from_stored(
        view: &View,
        gamma: ReferenceMixture,
        settings: &NoveltySettings,
    ) -> Result<Self, NoveltyError> {
        gamma.check()?;
        let prepared = PreparedView::new(view, "reference", &settings.evidence)?;
        if !settings.model.is_refit() {
            return Ok(Self::new(prepared, gamma, [0; 2]));
        }
        let found = Contradictions::find(&prepared, &gamma, settings)?;
        let stated_weights = found.stated_weights.clone();
        if found.is_empty() {
            return Ok(Self {
                stated_weights,
                ..Self::new(prepared, gamma, [0; 2])
            });
        }
        let counts = [found.unknown_points.len(), found.unseen_components.len()];
        let resolved = found.resolve(view, &gamma);
        let mut prepared = PreparedView::new(&resolved, "reference", &settings.evidence)?;
        prepared.first_denied_ray = resolved.points.len() + view.no_return.len();
        Ok(Self {
            stated_weights,
            ..Self::new(prepared, gamma, counts)
        })
    }

    /// Prepares a mixture without a view: points on its components stand for the beams, and evidence comes from the mixture
    /// (`docs/novelty.md section 10`). `frame` says where the sensor was and what its ranges were like; its points are not
    /// read.
    ///
    /// # Errors
    /// A mixture without components.
    pub fn from_mixture_alone(
        frame: &View,
        gamma: ReferenceMixture,
        settings: &NoveltySettings,
    ) -> Result<Self, NoveltyError> {
        gamma.check()?;
        let view = view_of_mixture(frame, &gamma);
        let prepared = PreparedView::new(&view, "reference", &settings.evidence)?;
        let unseen = gamma.mixture.len();
        Ok(Self {
            has_rays: false,
            ..Self::new(prepared, gamma, [0, unseen])
        })
    }

    /// Surface that the view shows, square metres.
    pub fn visible_area_m2(&self) -> f64 {
        self.prepared.area_within_m2(f64::INFINITY)
    }

    fn new(prepared: PreparedView, gamma: ReferenceMixture, contradictions: [usize; 2]) -> Self {
        Self {
            stated_weights: vec![false; gamma.mixture.len()],
            has_rays: true,
            planes: PlaneIndex::new(&prepared.surfaces),
            prepared,
            gamma,
            contradictions,
        }
    }
}
