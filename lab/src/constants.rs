//! Constants of both experiments.

/// Seed of the engine; the seed of what it judges is the caller's.
pub(crate) const ENGINE_SEED: u64 = 7;
