//! Runs the engine on scenes.

use super::scene_pair::ScenePair;
use super::table_column::TableColumn;
use crate::constants::ENGINE_SEED;
use crate::timing::{MillisClock, Timed, timed};
use patrold_engine::inspect::{Inspection, inspect, prepare};
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
    let settings = column.settings(ellipsoid_sigmas);
    timed(
        clock,
        || prepare(&scene.reference, &settings, ENGINE_SEED),
        |prepared| {
            inspect(
                prepared,
                &scene.current,
                &settings,
                ENGINE_SEED,
                &mut |_| {},
            )
        },
    )
}
