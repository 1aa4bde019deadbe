//! Compares a view with a reference, step by step (`docs/novelty.md section 1`).

use super::absorbing::absorbing_things;
use super::algorithm1::segment_changes;
use super::alone::{compare_alone, segments_of_pi};
use super::common_surface::VisibleSurface;
use super::coverage::Coverage;
use super::gaps::hide_cut_surfaces;
use super::listing::list_novelties;
use super::mixture_evidence::evidence_from_mixture;
use super::model::SegmentId;
use super::quantified_change::{NoveltyShare, QuantifiedChange};
use super::reference_mixture::fit_view;
use super::segment::segment;
use super::theta::fit_theta;
use super::verdict::{Findings, verdict};
use super::view_pair::ViewPair;
use super::{
    AbsorbingThing, ComparedMixtures, Evidence, EvidenceSource, Novelty, NoveltyError,
    NoveltySettings, PreparedView, Reference, Removal, RevisitModel, Segment, Verdict, Visibility,
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
    /// How much of the reference this visit could judge.
    pub coverage: Coverage,
    /// What gave nothing back where the reference saw surfaces.
    pub absorbing: Vec<AbsorbingThing>,
    /// Gamma and Theta as they entered Eq. 6, in the reference's frame.
    pub compared: ComparedMixtures,
    /// The current view made ready, in its own frame.
    pub current: PreparedView,
    /// Pi of Algorithm 1, in the order in which it was taken, with d_GMM after each removal.
    pub removals: Vec<(Removal, f64)>,
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
    let gamma = &reference.gamma.mixture;
    let mut evidence = match settings.evidence_source {
        // Where no pose is known, the rays say nothing about any point.
        _ if !pair.registration.converged => pair.no_evidence(),
        EvidenceSource::Rays if reference.has_rays => pair.evaluate_evidence(settings),
        EvidenceSource::Rays | EvidenceSource::Mixture => {
            evidence_from_mixture(gamma, &pair, settings)?
        }
    };
    let observers = [pair.observer_of(0), pair.observer_of(1)];
    for side in [0, 1] {
        let (own, observer) = (pair.views[side], &observers[side]);
        hide_cut_surfaces(own, &mut evidence[side], observer, settings);
    }
    let absorbing = match pair.registration.converged {
        true => absorbing_things(
            pair.views[0],
            &evidence[0],
            &observers[0],
            &settings.evidence,
        ),
        false => Vec::new(),
    };
    let visibilities = evidence.each_ref().map(|e| visibilities(e));
    let mut segments = match settings.model {
        RevisitModel::Refit => [0, 1].map(|side| {
            let own = pair.views[side];
            segment(own, &evidence[side], &observers[side], &settings.segment)
        }),
        RevisitModel::Independent { .. } => Default::default(),
    };

    observer(DetectionStage::Distance);
    let mut indices = segments.each_ref().map(|s| point_indices(s));
    let surfaces = [0, 1].map(|side| {
        VisibleSurface::new(&pair.compared_view(side, &visibilities[side], &indices[side]))
    });
    let quantify = &settings.quantify;
    let removed = |compared: &ComparedMixtures| {
        let (ground, extent) = (quantify.ground, settings.removal_extent);
        segment_changes(compared, settings.u_th(), ground, extent)
    };
    let (compared, found, owners) = match settings.model {
        RevisitModel::Refit => {
            let views =
                [0, 1].map(|side| pair.compared_view(side, &visibilities[side], &indices[side]));
            let theta = fit_theta(reference, &views, &surfaces, quantify)?;
            let found = removed(&theta.compared)?;
            (theta.compared, found, theta.owners)
        }
        RevisitModel::Independent { .. } => {
            let theta = fit_view(&current_view, settings, seed)?;
            let compared = compare_alone(gamma, theta, &pair, &evidence)?;
            let found = removed(&compared)?;
            let owners;
            (segments, owners) =
                segments_of_pi(&compared, &found, &pair, &evidence, &settings.segment);
            indices = segments.each_ref().map(|s| point_indices(s));
            (compared, found, owners)
        }
    };
    let masses = segment_masses(&compared, &owners, &segments);
    let surface_m2 = surfaces[0].total_m2().max(surfaces[1].total_m2());
    let mut change = QuantifiedChange {
        d: found.d,
        work_m3: found.d * surface_m2,
        shares: masses.map(|list| {
            let share = |mass| NoveltyShare {
                mass,
                ..NoveltyShare::default()
            };
            list.into_iter().map(share).collect()
        }),
        unexplained: 0.0,
        components: [0, 1].map(|side| compared.present(side).count()),
        overlap: surfaces.each_ref().map(|s| s.overlap),
    };
    change.book(&found, &owners);
    let novelties = list_novelties(
        &segments,
        &pair.views,
        &observers,
        &change,
        &compared,
        &settings.segment,
    );

    let mut labels = vec![false; current.points.len()];
    for i in indices[1].iter().flatten() {
        labels[*i] = true;
    }
    let disagreement = pair.disagreement();
    let coverage = Coverage::new(
        pair.views[0],
        &visibilities[0],
        change.overlap[0],
        &pair.registration.current_from_reference,
    );
    let (verdict, reason) = verdict(
        &Findings {
            registration: &pair.registration,
            disagreement,
            change: &change,
            coverage: &coverage,
            u_th: settings.u_th(),
            novelties: novelties.len(),
            absorbing: &absorbing,
        },
        &settings.verdict,
    );
    let registration = pair.registration;
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
        coverage,
        absorbing,
        registration,
        compared,
        removals: found.removals.into_iter().zip(found.d_after).collect(),
        current: current_view,
    })
}

fn point_indices(segments: &[Segment]) -> Vec<Vec<usize>> {
    segments.iter().map(|s| s.point_indices.clone()).collect()
}

fn visibilities(evidence: &[Evidence]) -> Vec<Visibility> {
    evidence.iter().map(|e| e.visibility).collect()
}

/// Mass of each segment: that of its components.
fn segment_masses(
    compared: &ComparedMixtures,
    owners: &[Option<SegmentId>],
    segments: &[Vec<Segment>; 2],
) -> [Vec<f64>; 2] {
    let mut masses = segments.each_ref().map(|list| vec![0.0; list.len()]);
    for (component, owner) in compared.components.iter().zip(owners) {
        if let Some((side, index)) = owner {
            masses[*side][*index] += component.masses[*side];
        }
    }
    masses
}
