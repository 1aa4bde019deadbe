//! Fig. 3: an object in the corridor, both clouds as mixtures, and d_GMM while Algorithm 1 removes Gaussians.

use super::constants::MAX_REMOVED;
use super::scene_pair::ScenePair;
use crate::constants::ENGINE_SEED;
use patrold_engine::distance::{DistanceError, GroundDistance, emd};
use patrold_engine::geometry::View;
use patrold_engine::inspect::{EngineSettings, prepare};
use patrold_engine::mixture::{
    Mixture, MixtureError, RefitSettings, SplitSettings, Unexplained, refit,
};
use patrold_engine::novelty::{NoveltyError, NoveltySettings, PreparedView};
use serde::Serialize;

/// Why the figure cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum RemovalError {
    /// A cloud with too few points.
    #[error(transparent)]
    Novelty(#[from] NoveltyError),
    /// A cloud without a mixture.
    #[error(transparent)]
    Mixture(#[from] MixtureError),
    /// Mixtures without a distance.
    #[error(transparent)]
    Distance(#[from] DistanceError),
}

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
    /// d_GMM of another view without an object, metres: the effect of beams that fall elsewhere. With 400 beams it may be
    /// as large as that of an object, so that no threshold on whole mixtures separates them.
    pub unchanged_m: f64,
    /// Gaussians of the reference and of the revisit.
    pub components: [usize; 2],
    /// d_GMM of the whole mixtures, metres.
    pub d_gmm_m: f64,
    /// Removed Gaussians in order; ends below U_th or where no removal brings the mixtures nearer.
    #[serde(rename = "removed")]
    pub steps: Vec<RemovalStep>,
}

/// Runs Algorithm 1 as printed on the mixtures of `scene`; `unchanged` is another view of its reference. It removes the
/// Gaussian without which d_GMM is least (line 4 leaves open how change is quantified). The mixture of the revisit is that
/// of the reference with new Gaussians for what it does not explain, because two independent fits of one place differ as
/// much as an object does. An object beside a wall may be explained by the Gaussian of the wall: then that is removed
/// first.
///
/// # Errors
/// Clouds with too few points.
pub fn remove_gaussians(
    scene: &ScenePair,
    unchanged: &View,
) -> Result<GaussianRemoval, RemovalError> {
    let settings = EngineSettings::standard();
    let reference = prepare(&scene.reference, &settings, ENGINE_SEED)?;
    let explained = Unexplained::Listed(&[]);
    let refitting = refit_settings(&reference.prepared);
    let points = &scene.reference.points;
    let gamma = refit(&reference.mixture, points, None, explained, &refitting)?.mixture;
    let theta = revisit_mixture(&gamma, &scene.current, &settings.novelty, &refitting)?;
    let ground = settings.novelty.quantify.ground;
    let u_th_m = settings.novelty.u_th();
    let unchanged = revisit_mixture(&gamma, unchanged, &settings.novelty, &refitting)?;

    let whole = emd(&theta, &gamma, ground)?.d;
    let (mut d, mut rest, mut steps) = (whole, theta.clone(), Vec::new());
    while d >= u_th_m && rest.len() > 1 && steps.len() < MAX_REMOVED {
        let Some((removed, next_d, next_rest)) = nearest_without_one(&rest, &gamma, ground)? else {
            break;
        };
        if next_d >= d {
            break;
        }
        let gaussian = rest.components[removed];
        let own = theta.components.iter().position(|g| *g == gaussian);
        steps.push(RemovalStep {
            mean: gaussian.mean.coords.into(),
            weight: own.map_or(0.0, |k| theta.weights[k]),
            of_object: scene.truth.as_ref().is_some_and(|t| {
                let longest = t.size_m.iter().fold(0.0_f64, |a, s| a.max(*s));
                (gaussian.mean - t.centre).norm() <= longest / 2.0
            }),
            d_gmm_m: next_d,
        });
        (d, rest) = (next_d, next_rest);
    }
    Ok(GaussianRemoval {
        u_th_m,
        unchanged_m: emd(&unchanged, &gamma, ground)?.d,
        components: [gamma.len(), theta.len()],
        d_gmm_m: whole,
        steps,
    })
}

fn refit_settings(view: &PreparedView) -> RefitSettings {
    let at_m = view.median_range_m;
    let spacing_m = (view.rays.spacing_rad * at_m).max(view.surfaces.cell_m);
    RefitSettings {
        split: SplitSettings::for_data(view.noise.sigma_m(at_m), spacing_m),
        ..RefitSettings::default()
    }
}

fn revisit_mixture(
    gamma: &Mixture,
    current: &View,
    settings: &NoveltySettings,
    refitting: &RefitSettings,
) -> Result<Mixture, RemovalError> {
    let view = PreparedView::new(current, "current", &settings.evidence)?;
    let noise_m2 = view.noise.sigma_m(view.median_range_m).powi(2);
    let unexplained = match Unexplained::default() {
        Unexplained::Beyond { sigmas, .. } => Unexplained::Beyond { sigmas, noise_m2 },
        listed @ Unexplained::Listed(_) => listed,
    };
    Ok(refit(gamma, &current.points, None, unexplained, refitting)?.mixture)
}

/// The Gaussian whose removal leaves the rest nearest to `gamma`, the distance, and the rest.
fn nearest_without_one(
    theta: &Mixture,
    gamma: &Mixture,
    ground: GroundDistance,
) -> Result<Option<(usize, f64, Mixture)>, RemovalError> {
    let mut best: Option<(usize, f64, Mixture)> = None;
    for k in 0..theta.len() {
        let (mut weights, mut components) = (theta.weights.clone(), theta.components.clone());
        weights.remove(k);
        components.remove(k);
        if weights.iter().sum::<f64>() <= 0.0 {
            continue;
        }
        let rest = Mixture::from_masses(weights, components)?;
        let d = emd(&rest, gamma, ground)?.d;
        if best.as_ref().is_none_or(|(_, least, _)| d < *least) {
            best = Some((k, d, rest));
        }
    }
    Ok(best)
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
    fn every_removal_brings_the_mixtures_nearer_and_mostly_the_object_is_first() {
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
                assert!(!removal.steps.is_empty(), "{removal:?}");
                let mut d = removal.d_gmm_m;
                for step in &removal.steps {
                    assert!(step.d_gmm_m < d, "{removal:?}");
                    d = step.d_gmm_m;
                }
                if removal.components[1] > removal.components[0] {
                    own += 1;
                    first += usize::from(removal.steps[0].of_object);
                }
            }
        }
        // One beside a wall may be explained by the Gaussian of the wall, the first reason of failure in the paper.
        assert!(own >= 12, "{own} of 18 objects have Gaussians of their own");
        // Not always: beams that fall elsewhere may have a larger effect than the object (1 of 15 here).
        assert!(5 * first >= 4 * own, "the object first in {first} of {own}");
    }
}
