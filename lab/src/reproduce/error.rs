//! Why a scene cannot be made.

use patrold_sim::world::SceneError;

/// Why a scene cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LookError {
    /// A mistake in its text.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Nothing that was drawn for it shows as many points as it should.
    #[error(
        "scene {name}: none of {tries} things drawn shows {least} to {most} points, try another seed"
    )]
    Points {
        /// The scene.
        name: String,
        /// Things drawn.
        tries: usize,
        /// Fewest points.
        least: usize,
        /// Most points.
        most: usize,
    },
    /// Nothing that was drawn for it stands clear of what is there.
    #[error(
        "scene {name}: none of {tries} things drawn stands clear of the walls, try another seed"
    )]
    NotClear {
        /// The scene.
        name: String,
        /// Things drawn.
        tries: usize,
    },
}
