//! The corridor as one readable function: from two looks at a place to what changed, where, of which shape.

use super::settings::EngineSettings;
use crate::geometry::View;
use crate::novelty::{self, Detection, Kind, Novelty, NoveltyError, Reference, detect};
use crate::shape::{BeamDensity, Retrieval, ShapeSettings, retrieve};
use nalgebra::{Unit, Vector3};
use rayon::prelude::*;

/// The step that begins; lets the caller time them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stage {
    /// A step of finding what changed.
    Novelty(novelty::Stage),
    /// Shapes are retrieved.
    Shape,
}

/// What an inspection found.
#[derive(Debug, Clone)]
pub struct Inspection {
    /// Verdict, distance and novelties.
    pub detection: Detection,
    /// What was retrieved for each novelty; `None` where it has too few points for a shape.
    pub retrievals: Vec<Option<Retrieval>>,
}

/// Makes a view ready to be a reference.
///
/// # Errors
/// Too few points to compare anything with.
pub fn prepare(
    view: &View,
    settings: &EngineSettings,
    seed: u64,
) -> Result<Reference, NoveltyError> {
    Reference::prepare(view, &settings.novelty, seed)
}

/// Compares what is seen now with the reference: brings the views together, finds what came and what went,
/// takes their distance, judges it against U_th, and retrieves the shape of each thing found.
///
/// # Errors
/// A view with too few points. All milder trouble is a verdict.
pub fn inspect(
    reference: &Reference,
    current: &View,
    settings: &EngineSettings,
    seed: u64,
    observer: &mut dyn FnMut(Stage),
) -> Result<Inspection, NoveltyError> {
    let mut novelty_stage = |stage| observer(Stage::Novelty(stage));
    let detection = detect(
        reference,
        current,
        &settings.novelty,
        seed,
        &mut novelty_stage,
    )?;

    observer(Stage::Shape);
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
    let then = &reference.prepared.view;
    let current_from_reference = &detection.registration.current_from_reference;
    let (origin, noise, seen_by, tilt_axis) = match novelty.kind {
        Kind::Appeared => (current.origin, current_noise, current, current.tilt_axis),
        Kind::Disappeared => (
            current_from_reference * then.origin,
            reference_noise,
            then,
            then.tilt_axis
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
        density: density(settings.shape.density, tilt_axis),
        ..settings.shape.clone()
    };
    // Too few points for a surface is an answer, not a failure: the novelty stands without a shape.
    retrieve(
        &novelty.places,
        &novelty.rim,
        &novelty.mixture,
        &origin,
        &shape_settings,
        seed,
    )
    .ok()
}

/// Where the sensor was tilted about an axis its lines crowd towards it; otherwise as configured.
fn density(configured: BeamDensity, tilt_axis: Option<Unit<Vector3<f64>>>) -> BeamDensity {
    match (configured, tilt_axis) {
        (BeamDensity::SolidAngle, Some(axis)) => BeamDensity::TiltSweep { axis },
        _ => configured,
    }
}
