//! Two simulated sweeps of one place, between which the robot leaves and returns.

use super::constants::{BASE_HEIGHT_M, RETURN_ERROR, SWEEP_TILT_DEG};
use super::scene_pair::{NoveltyTruth, ScenePair};
use nalgebra::Translation3;
use patrold_engine::geometry::{Pose, RollPitchYaw};
use patrold_sim::world::{
    MountGeometry, NoiseOptions, Scene, SceneError, SimulatedRobot, SimulatedSweep, SweepRows,
    simulate_sweep,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::time::Duration;

/// Two sweeps, and the pose of the second.
pub(super) struct SweepPair {
    pub before: SimulatedSweep,
    pub after: SimulatedSweep,
    /// Maps points of the scene to the frame of the second sweep.
    pub base_from_map: Pose,
}

impl SweepPair {
    /// The scene of these sweeps.
    pub(crate) fn into_scene(
        self,
        name: String,
        truth: Option<NoveltyTruth>,
        vacated: bool,
    ) -> ScenePair {
        ScenePair {
            name,
            reference: self.before.view,
            current: self.after.view,
            truth,
            vacated,
        }
    }
}

/// Sweeps of `rows` rows of the scenes `texts`, before and after; other noise, the robot back to within [`RETURN_ERROR`].
///
/// # Errors
/// A mistake in the scenes' text.
pub(super) fn simulate_sweep_pair(
    texts: [&str; 2],
    rows: usize,
    rng: &mut ChaCha8Rng,
) -> Result<SweepPair, SceneError> {
    let map_from_base =
        |error: &Pose| Pose::from(Translation3::new(0.0, 0.0, BASE_HEIGHT_M)) * error;
    let mut within = |max: f64| rng.random_range(-max..max);
    let [shift_m, turn_deg] = RETURN_ERROR;
    let error = RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: within(turn_deg).to_radians(),
    }
    .with_translation([within(shift_m), within(shift_m), 0.0]);
    let noise_seed: u64 = rng.random();
    let poses = [map_from_base(&Pose::identity()), map_from_base(&error)];
    let sweep = |side: usize| -> Result<SimulatedSweep, SceneError> {
        let world = Scene::parse(texts[side])?.build(None)?;
        let robot = SimulatedRobot {
            map_from_base: poses[side],
            mount: MountGeometry::default(),
        };
        let rows = SweepRows::evenly(SWEEP_TILT_DEG[0], SWEEP_TILT_DEG[1], rows)
            .starting_at(Duration::from_secs(100 * side as u64));
        let noise = NoiseOptions {
            seed: noise_seed,
            ..NoiseOptions::default()
        };
        Ok(simulate_sweep(&world, &robot, &rows, &noise))
    };
    Ok(SweepPair {
        before: sweep(0)?,
        after: sweep(1)?,
        base_from_map: poses[1].inverse(),
    })
}
