//! Compares a view with a reference, step by step (`docs/novelty.md section 1`).

use super::algorithm1;
use super::listing::list_novelties;
use super::quantify::quantify;
use super::reference::fit_view;
use super::segment::segment;
use super::verdict::{Findings, verdict};
use super::view_pair::ViewPair;
use super::{
    Evidence, Novelty, NoveltyError, NoveltySettings, PreparedView, Reference, RevisitModel,
    Segment, Segmentation, Verdict, Visibility,
};
use crate::geometry::{NoiseLaw, Registration, View};

/// A step of a detection, reported when it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DetectionStage {
    /// The current view is prepared.
    Fit,
    /// The views are registered.
    Register,
    /// Visibility and segmentation.
    Segment,
    /// d_GMM is computed.
    Distance,
}

/// Result of a detection.
#[derive(Debug, Clone)]
pub struct Detection {
    /// The answer.
    pub verdict: Verdict,
    /// Why this verdict, in one line.
    pub reason: String,
    /// d_GMM (paper Eq. 6), in the unit of the ground distance: metres, none for `fm`.
    pub d_gmm: f64,
    /// The part of d_GMM that no novelty explains.
    pub unexplained: f64,
    /// d_GMM times the visible surface, m^3.
    pub work_m3: f64,
    /// The threshold (paper Eq. 7), in the unit of d_GMM.
    pub u_th: f64,
    /// Listed novelties: disappeared, then appeared.
    pub novelties: Vec<Novelty>,
    /// For each current point, whether it belongs to an appeared novelty.
    pub labels: Vec<bool>,
    /// Pose of the reference in the current frame, and range drift.
    pub registration: Registration,
    /// Distance between surfaces that both views saw, over what their noise explains.
    pub disagreement: f64,
    /// Number of components with mass: reference, current.
    pub components: [usize; 2],
    /// Range noise: reference, current.
    pub noise: [NoiseLaw; 2],
    /// Share of each view's surface that the other could see: reference, current.
    pub overlap: [f64; 2],
}

/// Compares `current` with `reference`. `seed` is for fits with random starts; `observer` is called when a step begins.
///
/// # Errors
/// A view with too few points or with coordinates that are not finite; a mixture that cannot be fitted. Everything milder is
/// a verdict.
pub fn detect(
    reference: &Reference,
    current: &View,
    settings: &NoveltySettings,
    seed: u64,
    observer: &mut dyn FnMut(DetectionStage),
) -> Result<Detection, NoveltyError> {
    observer(DetectionStage::Fit);
    let current_view = PreparedView::new(current, "current", &settings.evidence)?;
    let reference_view = &reference.prepared;

    observer(DetectionStage::Register);
    let pair = ViewPair::register(reference, &current_view, settings);

    observer(DetectionStage::Segment);
    let evidence = pair.evaluate_evidence(settings);
    let observers = [pair.observer_of(0), pair.observer_of(1)];
    let (segments, algorithm1_distance) = match settings.segmentation {
        Segmentation::Evidence => {
            let segments = [
                segment(
                    reference_view,
                    &evidence[0],
                    &observers[0],
                    &settings.segment,
                ),
                segment(
                    &current_view,
                    &evidence[1],
                    &observers[1],
                    &settings.segment,
                ),
            ];
            (segments, None)
        }
        Segmentation::Mixture => {
            let own_mixture = match settings.model {
                RevisitModel::Refit => None,
                RevisitModel::Independent { .. } => Some(fit_view(&current_view, settings, seed)?),
            };
            let found =
                algorithm1::run(&reference.mixture, own_mixture, &pair, &evidence, settings)?;
            let distance = (found.d, found.contributions, found.components);
            (found.segments, Some(distance))
        }
    };

    observer(DetectionStage::Distance);
    let indices = [point_indices(&segments[0]), point_indices(&segments[1])];
    let visibilities = evidence.each_ref().map(|e| visibilities(e));
    let views = [
        pair.compared_view(0, &visibilities[0], &indices[0]),
        pair.compared_view(1, &visibilities[1], &indices[1]),
    ];
    let mut change = quantify(&reference.mixture, &views[0], &views[1], &settings.quantify)?;
    if let Some((d, contributions, components)) = algorithm1_distance {
        change.replace_distance(d, contributions, components);
    }
    let novelties = list_novelties(&segments, &views, &observers, &change, &settings.segment)?;

    let mut labels = vec![false; current.points.len()];
    for i in indices[1].iter().flatten() {
        labels[*i] = true;
    }
    let disagreement = pair.disagreement();
    let (verdict, reason) = verdict(
        &Findings {
            registration: &pair.registration,
            disagreement,
            change: &change,
            u_th: settings.u_th(),
            novelties: novelties.len(),
        },
        &settings.verdict,
    );
    Ok(Detection {
        verdict,
        reason,
        d_gmm: change.d,
        unexplained: change.unexplained,
        work_m3: change.work_m3,
        u_th: settings.u_th(),
        novelties,
        labels,
        disagreement,
        components: change.components,
        noise: [reference_view.noise, current_view.noise],
        overlap: change.overlap,
        registration: pair.registration,
    })
}

fn point_indices(segments: &[Segment]) -> Vec<Vec<usize>> {
    segments.iter().map(|s| s.point_indices.clone()).collect()
}

fn visibilities(evidence: &[Evidence]) -> Vec<Visibility> {
    evidence.iter().map(|e| e.visibility).collect()
}
