//! The one place where scenes meet the engine.

use super::Look;
use super::constants::ENGINE_SEED;
use super::ways::Way;
use patrold_engine::inspect::{EngineSettings, Inspection, inspect, prepare};
use patrold_engine::novelty::NoveltyError;

/// Milliseconds since some instant; time is the caller's.
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// What the engine said, and how long it took.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Verdict, novelties, shapes.
    pub inspection: Inspection,
    /// Making the reference ready, which a taught one has behind it, milliseconds.
    pub reference_ms: f64,
    /// The whole chain from the current cloud: its mixture, detection, segmentation, retrieval, milliseconds.
    pub chain_ms: f64,
}

/// Lets the engine judge a scene in one of the ways.
///
/// # Errors
/// A cloud with too few points.
pub fn judge(look: &Look, way: Way, clock: Clock<'_>) -> Result<Judged, NoveltyError> {
    judge_by(look, &way.settings(), clock)
}

/// Lets the engine judge a scene by any settings.
pub(super) fn judge_by(
    look: &Look,
    settings: &EngineSettings,
    clock: Clock<'_>,
) -> Result<Judged, NoveltyError> {
    let began = clock();
    let reference = prepare(&look.reference, settings, ENGINE_SEED)?;
    let prepared = clock();
    let inspection = inspect(
        &reference,
        &look.current,
        settings,
        ENGINE_SEED,
        &mut |_| {},
    )?;
    Ok(Judged {
        inspection,
        reference_ms: prepared - began,
        chain_ms: clock() - prepared,
    })
}
