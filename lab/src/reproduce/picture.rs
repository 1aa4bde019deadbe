//! The content of Fig. 5 and 6 for one scene.

use super::run_engine::run_with_settings;
use super::scene_pair::ScenePair;
use nalgebra::Point3;
use patrold_engine::inspect::EngineSettings;
use patrold_engine::mixture::Gaussian;
use patrold_engine::novelty::{NoveltyError, NoveltyKind};
use patrold_engine::shape::Shape;

/// One scene as its figure shows it; frame of the current view, metres.
#[derive(Debug, Clone)]
pub struct ScenePicture {
    /// Name of the scene.
    pub name: String,
    /// The reference cloud, in its own frame.
    pub before: Vec<Point3<f64>>,
    /// Points of the current cloud that did not change.
    pub unchanged: Vec<Point3<f64>>,
    /// Points that appeared.
    pub appeared: Vec<Point3<f64>>,
    /// The Gaussians of what appeared.
    pub gaussians: Vec<Gaussian>,
    /// Shapes by method A, from the points of the novelties.
    pub euclidean: Vec<Shape>,
    /// Shapes by method B.
    pub feature: Vec<Shape>,
}

/// The answer of the standard engine to a scene, with the shapes of both methods.
///
/// # Errors
/// A cloud with too few points.
pub fn scene_picture(scene: &ScenePair) -> Result<ScenePicture, NoveltyError> {
    let found = run_with_settings(scene, &EngineSettings::standard(), &|| 0.0)?.answer;
    let listed = found.detection.novelties.iter().zip(&found.retrievals);
    let appeared: Vec<_> = listed
        .filter(|(n, _)| n.kind == NoveltyKind::Appeared)
        .collect();
    let shapes = || appeared.iter().filter_map(|(_, r)| r.as_ref());
    let labelled = scene.current.points.iter().zip(&found.detection.labels);
    Ok(ScenePicture {
        name: scene.name.clone(),
        before: scene.reference.points.clone(),
        unchanged: labelled
            .filter(|(_, new)| !**new)
            .map(|(p, _)| *p)
            .collect(),
        gaussians: appeared
            .iter()
            .flat_map(|(n, _)| n.mixture.components.clone())
            .collect(),
        euclidean: shapes().filter_map(|r| r.ransac.clone()).collect(),
        feature: shapes().filter_map(|r| r.covariance.clone()).collect(),
        appeared: appeared
            .iter()
            .flat_map(|(n, _)| n.points.iter().copied())
            .collect(),
    })
}
