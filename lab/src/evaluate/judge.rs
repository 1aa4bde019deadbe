//! The one place where pairs meet the engine.

use super::pair::Pair;
use nalgebra::Point3;
use patrold_engine::geometry::View;
use patrold_engine::novelty::{Detection, NoveltyError, Reference, Settings, detect};

/// Seed of the engine.
const SEED: u64 = 7;

/// Which engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Engine {
    /// patrold's own.
    Standard,
    /// The published recipe.
    Paper,
}

impl Engine {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Paper => "paper",
        }
    }

    /// Its settings.
    pub fn settings(self) -> Settings {
        match self {
            Self::Standard => patrold_engine::inspect::EngineSettings::standard().novelty,
            Self::Paper => patrold_engine::inspect::EngineSettings::paper().novelty,
        }
    }
}

/// What of a sweep the engine is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Given {
    /// Points alone, as in a recorded file.
    Bare,
    /// Also where nothing came back, the stated noise and the tilt axis, as a sweep of our own.
    Sweep,
}

impl Given {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Bare => "bare",
            Self::Sweep => "sweep",
        }
    }

    /// What the engine sees of `view`: bare clouds pass through float32, as files do.
    pub fn of(self, view: &View) -> View {
        match self {
            Self::Sweep => view.clone(),
            Self::Bare => {
                let filed = |p: &Point3<f64>| p.map(|c| f64::from(c as f32));
                View::bare(view.points.iter().map(filed).collect(), view.origin)
            }
        }
    }
}

/// Milliseconds since some instant; time is the caller's.
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// What the engine said, and how long it took.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Verdict, novelties, registration.
    pub detection: Detection,
    /// Making the reference ready, milliseconds.
    pub prepare_ms: f64,
    /// From the revisit's view to the verdict, without shapes, milliseconds.
    pub verdict_ms: f64,
}

/// Lets the engine judge a pair.
///
/// # Errors
/// A sweep with too few points.
pub fn judge(
    pair: &Pair,
    given: Given,
    settings: &Settings,
    clock: Clock<'_>,
) -> Result<Judged, NoveltyError> {
    let [then, now] = [0, 1].map(|side| given.of(&pair.sweeps[side].view));
    let began = clock();
    let reference = Reference::prepare(&then, settings, SEED)?;
    let prepared = clock();
    let detection = detect(&reference, &now, settings, SEED, &mut |_| {})?;
    Ok(Judged {
        detection,
        prepare_ms: prepared - began,
        verdict_ms: clock() - prepared,
    })
}
