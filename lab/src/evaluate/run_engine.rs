//! Runs the engine on pairs.

use super::pair::SimulatedPair;
use crate::constants::ENGINE_SEED;
use crate::timing::{MillisClock, Timed, timed};
use nalgebra::Point3;
use patrold_engine::geometry::View;
use patrold_engine::novelty::{Detection, NoveltyError, NoveltySettings, Reference, detect};

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
        |prepared| detect(prepared, &current, settings, ENGINE_SEED, &mut |_| {}),
    )
}
