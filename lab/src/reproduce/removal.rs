//! Fig. 3: an object in the corridor, both clouds as mixtures, and d_GMM while Algorithm 1 removes Gaussians.

use super::scene_pair::ScenePair;
use crate::constants::ENGINE_SEED;
use patrold_engine::geometry::View;
use patrold_engine::inspect::EngineSettings;
use patrold_engine::novelty::{NoveltyError, Reference, RemovalExtent, detect, segment_changes};
use serde::Serialize;

/// One iteration of Algorithm 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RemovalStep {
    /// Mean of the removed Gaussian, metres.
    pub mean: [f64; 3],
    /// Its weight in the whole mixture.
    pub weight: f64,
    /// Whether that mean lies within half the length of the true object of its centre.
    #[serde(rename = "of_thing")]
    pub of_object: bool,
    /// d_GMM of the remaining mixture, metres.
    pub d_gmm_m: f64,
}

/// Fig. 3 as numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GaussianRemoval {
    /// Threshold at which the loop ends, metres.
    pub u_th_m: f64,
    /// d_GMM of another view without an object, metres: the effect of beams that fall elsewhere.
    pub unchanged_m: f64,
    /// Gaussians of the reference and of the revisit.
    pub components: [usize; 2],
    /// d_GMM of the whole mixtures, metres.
    pub d_gmm_m: f64,
    /// Removed Gaussians in order; ends below U_th or where no candidate is left.
    #[serde(rename = "removed")]
    pub steps: Vec<RemovalStep>,
}

/// Runs Algorithm 1 on the mixtures of `scene` as the engine compares them; `unchanged` is another view of its
/// reference. An object beside a wall may be explained by the Gaussian of the wall.
///
/// # Errors
/// Clouds with too few points.
pub fn remove_gaussians(
    scene: &ScenePair,
    unchanged: &View,
) -> Result<GaussianRemoval, NoveltyError> {
    let settings = EngineSettings::standard().novelty;
    let ground = settings.quantify.ground;
    let reference = Reference::prepare(&scene.reference, &settings, ENGINE_SEED)?;
    let against = |view: &View| detect(&reference, view, &settings, ENGINE_SEED, &mut |_| {});
    let compared = against(&scene.current)?.compared;
    let extent = RemovalExtent::UntilBelowThreshold;
    let found = segment_changes(&compared, settings.u_th(), ground, extent)?;
    let steps = found.removals.iter().zip(&found.d_after);
    Ok(GaussianRemoval {
        u_th_m: settings.u_th(),
        unchanged_m: against(unchanged)?.d_gmm,
        components: [0, 1].map(|side| compared.present(side).count()),
        d_gmm_m: found.d,
        steps: steps
            .map(|(removal, d_gmm_m)| {
                let component = &compared.components[removal.component];
                let mean = component.gaussian.mean;
                RemovalStep {
                    mean: mean.coords.into(),
                    weight: component.masses[removal.side],
                    of_object: scene.truth.as_ref().is_some_and(|t| {
                        let longest = t.size_m.iter().fold(0.0_f64, |a, s| a.max(*s));
                        (mean - t.centre).norm() <= longest / 2.0
                    }),
                    d_gmm_m: *d_gmm_m,
                }
            })
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::remove_gaussians;
    use crate::reproduce::{
        BeamLayout, CorridorNoise, CorridorObject, CorridorScene, PointDensity,
    };

    fn corridor(object: CorridorObject, number: usize) -> CorridorScene {
        CorridorScene {
            object,
            noise: CorridorNoise::Fine,
            density: PointDensity::Many,
            beams: BeamLayout::Rows,
            number,
        }
    }

    #[test]
    fn the_object_is_taken_out_first_until_the_rest_is_below_the_threshold() {
        let empty = corridor(CorridorObject::Nothing, 0)
            .simulate(5)
            .expect("a scene");
        let (mut own, mut first) = (0, 0);
        for number in 0..6 {
            for object in [
                CorridorObject::Sphere,
                CorridorObject::Cylinder,
                CorridorObject::Plane,
            ] {
                let scene = corridor(object, number).simulate(5).expect("a scene");
                let removal = remove_gaussians(&scene, &empty.current).expect("a figure");
                let Some(last) = removal.steps.last() else {
                    continue;
                };
                own += 1;
                first += usize::from(removal.steps[0].of_object);
                assert!(last.d_gmm_m < removal.d_gmm_m, "{removal:?}");
            }
        }
        // One beside a wall may be explained by the Gaussian of the wall, the first reason of failure in the paper.
        assert!(own >= 12, "{own} of 18 objects have Gaussians of their own");
        assert!(5 * first >= 4 * own, "the object first in {first} of {own}");
    }
}
