//! The content of Fig. 3 to 6 for one scene.

use super::scene_pair::ScenePair;
use crate::constants::ENGINE_SEED;
use nalgebra::Point3;
use patrold_engine::inspect::{EngineSettings, inspect, prepare};
use patrold_engine::mixture::Gaussian;
use patrold_engine::novelty::{Novelty, NoveltyError, NoveltyKind};
use patrold_engine::shape::ransac::surface_samples;
use patrold_engine::shape::{RansacSource, Retrieval, Shape, ShapeSettings};

/// One scene as its figures show it; frame of the current view, metres.
#[derive(Debug, Clone)]
pub struct ScenePicture {
    /// Name of the scene.
    pub name: String,
    /// The reference cloud, in its own frame.
    pub before: Vec<Point3<f64>>,
    /// The Gaussians of the reference, in its frame.
    pub before_gaussians: Vec<Gaussian>,
    /// The same in the frame of the current view.
    pub kept_gaussians: Vec<Gaussian>,
    /// Points of the current cloud that did not change.
    pub unchanged: Vec<Point3<f64>>,
    /// What appeared, in the order of the list.
    pub appeared: Vec<AppearedPicture>,
}

/// One novelty that appeared.
#[derive(Debug, Clone)]
pub struct AppearedPicture {
    /// Its points.
    pub points: Vec<Point3<f64>>,
    /// Its Gaussians.
    pub gaussians: Vec<Gaussian>,
    /// Samples of their ellipsoids, the input of method A as printed.
    pub samples: Vec<Point3<f64>>,
    /// Shape by method A on these samples.
    pub euclidean: Option<Shape>,
    /// Shape by method B.
    pub feature: Option<Shape>,
}

/// The answer of the standard engine to a scene, with the shapes of both methods: A on samples, as in the paper's figures.
///
/// # Errors
/// A cloud with too few points.
pub fn scene_picture(scene: &ScenePair) -> Result<ScenePicture, NoveltyError> {
    let standard = EngineSettings::standard();
    let settings = EngineSettings {
        shape: ShapeSettings {
            ransac_source: ShapeSettings::paper().ransac_source,
            ..standard.shape
        },
        ..standard
    };
    let reference = prepare(&scene.reference, &settings, ENGINE_SEED)?;
    let found = inspect(
        &reference,
        &scene.current,
        &settings,
        ENGINE_SEED,
        &mut |_| {},
    )?;
    let before_gaussians = reference.gamma.mixture.components.clone();
    let pose = &found.detection.registration.current_from_reference;
    let listed = found.detection.novelties.iter().zip(&found.retrievals);
    let labelled = scene.current.points.iter().zip(&found.detection.labels);
    Ok(ScenePicture {
        name: scene.name.clone(),
        before: scene.reference.points.clone(),
        kept_gaussians: before_gaussians
            .iter()
            .map(|g| g.transformed(pose))
            .collect(),
        before_gaussians,
        unchanged: labelled
            .filter(|(_, new)| !**new)
            .map(|(p, _)| *p)
            .collect(),
        appeared: listed
            .filter(|(novelty, _)| novelty.kind == NoveltyKind::Appeared)
            .map(|(novelty, retrieval)| {
                appeared(novelty, retrieval.as_ref(), settings.shape.ransac_source)
            })
            .collect(),
    })
}

fn appeared(
    novelty: &Novelty,
    retrieval: Option<&Retrieval>,
    source: RansacSource,
) -> AppearedPicture {
    AppearedPicture {
        points: novelty.points.clone(),
        gaussians: novelty.mixture.components.clone(),
        samples: match source {
            RansacSource::Ellipsoids { samples, scale } => {
                surface_samples(&novelty.mixture, samples, scale, ENGINE_SEED).0
            }
            RansacSource::Points => Vec::new(),
        },
        euclidean: retrieval.and_then(|r| r.ransac.clone()),
        feature: retrieval.and_then(|r| r.covariance.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::{RansacSource, ShapeSettings, scene_picture};
    use crate::reproduce::{
        BeamLayout, CorridorNoise, CorridorObject, CorridorScene, PointDensity,
    };

    #[test]
    fn every_point_is_drawn_once_and_samples_lie_on_the_ellipsoids_of_the_novelty() {
        let corridor = CorridorScene {
            object: CorridorObject::Sphere,
            noise: CorridorNoise::Fine,
            density: PointDensity::Many,
            beams: BeamLayout::Rows,
            number: 1,
        };
        let scene = corridor.simulate(3).expect("a scene");
        let picture = scene_picture(&scene).expect("points");
        assert_eq!(picture.appeared.len(), 1);
        let new = &picture.appeared[0];
        let drawn = picture.unchanged.len() + new.points.len();
        assert_eq!(drawn, scene.current.points.len());
        assert_eq!(picture.before_gaussians.len(), picture.kept_gaussians.len());
        // The number of paper section V.
        assert_eq!(new.samples.len(), 3722);
        let distances = |p: &nalgebra::Point3<f64>| {
            let squared = new.gaussians.iter().filter_map(|g| {
                let d = p - g.mean;
                Some(d.dot(&g.covariance.lu().solve(&d)?))
            });
            squared.map(f64::sqrt).collect::<Vec<_>>()
        };
        let RansacSource::Ellipsoids { scale, .. } = ShapeSettings::paper().ransac_source else {
            panic!("the paper's method A has samples");
        };
        for sample in &new.samples {
            let on = distances(sample)
                .into_iter()
                .any(|d| (d - scale).abs() < 1e-6);
            assert!(on, "{sample}");
        }
    }
}
