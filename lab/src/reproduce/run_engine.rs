//! Runs the engine on scenes.

use super::scene_pair::ScenePair;
use super::table_column::TableColumn;
use crate::constants::ENGINE_SEED;
use crate::timing::{MillisClock, Timed, timed};
use patrold_engine::inspect::{EngineSettings, Inspection, inspect, prepare};
use patrold_engine::novelty::NoveltyError;

/// The answer to a scene of the engine and method of a column: verdict, novelties, shapes. Where method A samples ellipsoids,
/// they are of `ellipsoid_sigmas` standard deviations.
///
/// # Errors
/// A cloud with too few points.
pub fn run_engine(
    scene: &ScenePair,
    column: TableColumn,
    ellipsoid_sigmas: f64,
    clock: MillisClock<'_>,
) -> Result<Timed<Inspection>, NoveltyError> {
    run_with_settings(scene, &column.settings(ellipsoid_sigmas), clock)
}

/// The answer to a scene with any settings.
pub(super) fn run_with_settings(
    scene: &ScenePair,
    settings: &EngineSettings,
    clock: MillisClock<'_>,
) -> Result<Timed<Inspection>, NoveltyError> {
    timed(
        clock,
        || prepare(&scene.reference, settings, ENGINE_SEED),
        |prepared| inspect(prepared, &scene.current, settings, ENGINE_SEED, &mut |_| {}),
    )
}
