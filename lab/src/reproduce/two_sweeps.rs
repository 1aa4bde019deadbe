//! Two sweeps of one place by the emulated laser on its head: the robot goes away and comes back to about where it was.

use super::constants::{BASE_M, RETURN_ERROR, SITE_TILT_DEG};
use super::{Look, Truth};
use nalgebra::Translation3;
use patrold_engine::geometry::{Pose, RollPitchYaw};
use patrold_sim::world::{
    MountGeometry, NoiseOptions, Robot, SampledView, Scene, SceneError, SweepRows, sample_view,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::time::Duration;

/// What both sweeps gave, and where the second was taken.
pub(super) struct TwoSweeps {
    /// As it was.
    pub before: SampledView,
    /// As it is.
    pub after: SampledView,
    /// Maps places of the scene to the second sweep's frame.
    pub base_from_map: Pose,
}

impl TwoSweeps {
    /// As a look, with what is true of it.
    pub fn look(self, name: String, truth: Option<Truth>, vacated: bool) -> Look {
        Look {
            name,
            reference: self.before.view,
            current: self.after.view,
            truth,
            vacated,
        }
    }
}

/// Sweeps of `rows` rows of the scenes `texts`, before and after; other noise, the robot back to within
/// [`RETURN_ERROR`].
///
/// # Errors
/// A mistake in the scenes' text.
pub(super) fn two_sweeps(
    texts: [&str; 2],
    rows: usize,
    rng: &mut ChaCha8Rng,
) -> Result<TwoSweeps, SceneError> {
    let there = |error: &Pose| Pose::from(Translation3::new(0.0, 0.0, BASE_M)) * error;
    let mut within = |most: f64| rng.random_range(-most..most);
    let [shift_m, turn_deg] = RETURN_ERROR;
    let error = RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: within(turn_deg).to_radians(),
    }
    .with_translation([within(shift_m), within(shift_m), 0.0]);
    let noise_seed: u64 = rng.random();
    let poses = [there(&Pose::identity()), there(&error)];
    let take = |side: usize| -> Result<SampledView, SceneError> {
        let world = Scene::parse(texts[side])?.build(None)?;
        let robot = Robot {
            pose: poses[side],
            mount: MountGeometry::default(),
        };
        let rows = SweepRows::evenly(SITE_TILT_DEG[0], SITE_TILT_DEG[1], rows)
            .starting_at(Duration::from_secs(100 * side as u64));
        let noise = NoiseOptions {
            seed: noise_seed,
            ..NoiseOptions::default()
        };
        Ok(sample_view(&world, &robot, &rows, &noise))
    };
    Ok(TwoSweeps {
        before: take(0)?,
        after: take(1)?,
        base_from_map: poses[1].inverse(),
    })
}
