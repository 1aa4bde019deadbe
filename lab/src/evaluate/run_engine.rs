//! Runs the engine on pairs.

use super::constants::SAMPLE_REACH_M;
use super::pair::SimulatedPair;
use crate::constants::ENGINE_SEED;
use crate::timing::{MillisClock, Timed, timed};
use nalgebra::Point3;
use patrold_engine::geometry::{PointGrid, View};
use patrold_engine::novelty::{
    Detection, Novelty, NoveltyError, NoveltyKind, NoveltySettings, Reference, detect,
};
use std::collections::HashSet;

/// What the engine gets of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EngineInput {
    /// Points alone, as in a recorded file.
    Bare,
    /// Also empty directions, stated noise and tilt axis, as in a sweep of our own.
    Sweep,
}

impl EngineInput {
    /// The name in tables and JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Bare => "bare",
            Self::Sweep => "sweep",
        }
    }

    /// The part of `view` that the engine gets; bare clouds are rounded to float32, as in files.
    pub fn of_view(self, view: &View) -> View {
        match self {
            Self::Sweep => view.clone(),
            Self::Bare => {
                let rounded = |p: &Point3<f64>| p.map(|c| f64::from(c as f32));
                View::from_points(view.points.iter().map(rounded).collect(), view.origin)
            }
        }
    }
}

/// What is kept of a reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum KeptReference {
    /// Mixture and view, as in the store.
    View,
    /// The mixture alone, with the position of the sensor and its noise.
    Mixture,
}

impl KeptReference {
    /// The name in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::View => "view",
            Self::Mixture => "mixture",
        }
    }

    fn prepare(self, view: &View, settings: &NoveltySettings) -> Result<Reference, NoveltyError> {
        let fitted = Reference::prepare(view, settings, ENGINE_SEED)?;
        match self {
            Self::View => Reference::from_stored(view, fitted.gamma, settings),
            Self::Mixture => Reference::from_mixture_alone(view, fitted.gamma, settings),
        }
    }
}

/// The engine's answer to a pair, without shapes.
///
/// # Errors
/// A sweep with too few points.
pub fn run_engine(
    pair: &SimulatedPair,
    input: EngineInput,
    kept: KeptReference,
    settings: &NoveltySettings,
    clock: MillisClock<'_>,
) -> Result<Timed<Detection>, NoveltyError> {
    let [reference, current] = [0, 1].map(|side| input.of_view(&pair.sweeps[side].view));
    timed(
        clock,
        || kept.prepare(&reference, settings),
        |prepared| {
            let mut answer = detect(prepared, &current, settings, ENGINE_SEED, &mut |_| {})?;
            if kept == KeptReference::Mixture {
                let samples = &prepared.prepared.view.points;
                to_points_of_view(&mut answer.novelties, samples, &reference);
            }
            Ok(answer)
        },
    )
}

/// The truth is known of the points of `view`: what disappeared among the `samples` of its mixture is given by the points
/// nearest to them.
fn to_points_of_view(novelties: &mut [Novelty], samples: &[Point3<f64>], view: &View) {
    let grid = PointGrid::new(samples, SAMPLE_REACH_M);
    let nearest_sample: Vec<Option<usize>> = view
        .points
        .iter()
        .map(|p| grid.nearest(p, SAMPLE_REACH_M).map(|(sample, _)| sample))
        .collect();
    for novelty in novelties {
        if novelty.kind == NoveltyKind::Disappeared {
            let own: HashSet<usize> = novelty.point_indices.iter().copied().collect();
            novelty.point_indices = (0..view.points.len())
                .filter(|i| nearest_sample[*i].is_some_and(|sample| own.contains(&sample)))
                .collect();
        }
    }
}
