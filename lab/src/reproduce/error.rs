//! Why a scene cannot be simulated.

use patrold_sim::world::SceneError;

/// Why a scene cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScenePairError {
    /// A mistake in its text.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No object drawn shows as many points as it should.
    #[error(
        "scene {name}: none of {tries} objects drawn shows {min} to {max} points, try another seed"
    )]
    Points {
        /// Name of the scene.
        name: String,
        /// Objects drawn.
        tries: usize,
        /// Fewest points.
        min: usize,
        /// Most points.
        max: usize,
    },
    /// No object drawn is clear of the walls.
    #[error("scene {name}: none of {tries} objects drawn is clear of the walls, try another seed")]
    NotClear {
        /// Name of the scene.
        name: String,
        /// Objects drawn.
        tries: usize,
    },
}
