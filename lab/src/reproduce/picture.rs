//! What Fig. 5 and 6 show of one scene.

use super::Look;
use super::judge::judge_by;
use nalgebra::Point3;
use patrold_engine::inspect::EngineSettings;
use patrold_engine::mixture::Gaussian;
use patrold_engine::novelty::{Kind, NoveltyError};
use patrold_engine::shape::Shape;

/// One scene as its figure shows it; places in the current view's frame, metres.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The scene.
    pub name: String,
    /// The cloud as it was, in its own frame.
    pub before: Vec<Point3<f64>>,
    /// What of the cloud as it is did not change.
    pub same: Vec<Point3<f64>>,
    /// What came.
    pub came: Vec<Point3<f64>>,
    /// The Gaussians of what came.
    pub gaussians: Vec<Gaussian>,
    /// Method A's shapes of it, from the novelty's own points.
    pub euclidean: Vec<Shape>,
    /// Method B's.
    pub feature: Vec<Shape>,
}

/// Lets the standard engine judge a scene by both methods.
///
/// # Errors
/// A cloud with too few points.
pub fn picture(look: &Look) -> Result<Picture, NoveltyError> {
    let found = judge_by(look, &EngineSettings::standard(), &|| 0.0)?.inspection;
    let listed = found.detection.novelties.iter().zip(&found.retrievals);
    let came: Vec<_> = listed.filter(|(n, _)| n.kind == Kind::Appeared).collect();
    let shapes = || came.iter().filter_map(|(_, r)| r.as_ref());
    let labelled = look.current.points.iter().zip(&found.detection.labels);
    Ok(Picture {
        name: look.name.clone(),
        before: look.reference.points.clone(),
        same: labelled
            .filter(|(_, new)| !**new)
            .map(|(p, _)| *p)
            .collect(),
        gaussians: came
            .iter()
            .flat_map(|(n, _)| n.mixture.components.clone())
            .collect(),
        euclidean: shapes().filter_map(|r| r.ransac.clone()).collect(),
        feature: shapes().filter_map(|r| r.covariance.clone()).collect(),
        came: came
            .iter()
            .flat_map(|(n, _)| n.places.iter().copied())
            .collect(),
    })
}
