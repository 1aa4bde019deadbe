//! The pipeline as one function: two views of a place to what changed, where, and of which shape.

use super::settings::EngineSettings;
use crate::geometry::View;
use crate::novelty::{
    Detection, DetectionStage, Novelty, NoveltyError, NoveltyKind, Reference, detect,
};
use crate::shape::{BeamDensity, Retrieval, ShapeSettings, retrieve};
use nalgebra::{Unit, Vector3};
use rayon::prelude::*;

/// A step of an inspection, reported when it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InspectionStage {
    /// A step of the detection.
    Detection(DetectionStage),
    /// Retrieval of shapes.
    Shape,
}

/// Result of an inspection.
#[derive(Debug, Clone)]
pub struct Inspection {
    /// Verdict, distance and novelties.
    pub detection: Detection,
    /// Shape of each novelty, in their order; `None` where it has too few points for one.
    pub retrievals: Vec<Option<Retrieval>>,
}

/// Prepares a view as a reference for any number of inspections. `seed` is for fits with random starts.
///
/// # Errors
/// Too few points, or coordinates that are not finite.
pub fn prepare(
    view: &View,
    settings: &EngineSettings,
    seed: u64,
) -> Result<Reference, NoveltyError> {
    Reference::prepare(view, &settings.novelty, seed)
}

/// Compares `current` with `reference`: registers the views, finds novelties, takes d_GMM, compares it with U_th, and
/// retrieves the shape of each novelty. `observer` is called when a step begins.
///
/// # Errors
/// A view with too few points, or with coordinates that are not finite. Everything milder is a verdict.
pub fn inspect(
    reference: &Reference,
    current: &View,
    settings: &EngineSettings,
    seed: u64,
    observer: &mut dyn FnMut(InspectionStage),
) -> Result<Inspection, NoveltyError> {
    let mut novelty_stage = |stage| observer(InspectionStage::Detection(stage));
    let detection = detect(
        reference,
        current,
        &settings.novelty,
        seed,
        &mut novelty_stage,
    )?;

    observer(InspectionStage::Shape);
    let retrievals = detection
        .novelties
        .par_iter()
        .map(|novelty| shape_of(novelty, &detection, reference, current, settings, seed))
        .collect();
    Ok(Inspection {
        detection,
        retrievals,
    })
}

fn shape_of(
    novelty: &Novelty,
    detection: &Detection,
    reference: &Reference,
    current: &View,
    settings: &EngineSettings,
    seed: u64,
) -> Option<Retrieval> {
    let [reference_noise, current_noise] = detection.noise;
    let reference_view = &reference.prepared.view;
    let current_from_reference = &detection.registration.current_from_reference;
    let (origin, noise, seen_by, tilt_axis) = match novelty.kind {
        NoveltyKind::Appeared => (current.origin, current_noise, current, current.tilt_axis),
        NoveltyKind::Disappeared => (
            current_from_reference * reference_view.origin,
            reference_noise,
            reference_view,
            reference_view
                .tilt_axis
                .map(|axis| current_from_reference.rotation * axis),
        ),
    };
    let independent_share = match seen_by.noise {
        Some(_) => settings.sweep_independent_share,
        None => 1.0,
    };
    let shape_settings = ShapeSettings {
        noise,
        independent_share,
        density: beam_density(settings.shape.density, tilt_axis),
        ..settings.shape.clone()
    };
    // Too few points for a shape is no failure of the inspection.
    retrieve(
        &novelty.points,
        &novelty.surroundings,
        &novelty.mixture,
        &origin,
        &shape_settings,
        seed,
    )
    .ok()
}

/// Scan lines of a tilted sensor crowd towards the tilt axis; otherwise the density is as configured.
fn beam_density(configured: BeamDensity, tilt_axis: Option<Unit<Vector3<f64>>>) -> BeamDensity {
    match (configured, tilt_axis) {
        (BeamDensity::SolidAngle, Some(axis)) => BeamDensity::TiltSweep { axis },
        _ => configured,
    }
}
