//! Why a scene cannot be used.

/// Why a scene cannot be used; one line each.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// A mistake in a file.
    #[error("{file}:{line}: {message}")]
    At {
        /// Name of the scene file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong there, with the key.
        message: String,
    },
    /// A file could not be read.
    #[error("scene `{file}`: {message}")]
    Load {
        /// Name of the scene file.
        file: String,
        /// The reader's message.
        message: String,
    },
    /// The scene needs the points of its cloud.
    #[error("scene needs the points of `{file}`, got {got}")]
    Cloud {
        /// File that the scene names.
        file: String,
        /// What was given instead.
        got: &'static str,
    },
}
