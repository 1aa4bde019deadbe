//! The engine's settings: `standard` and `paper` are two rows of one struct and walk the same corridor.

use super::constants::{PAPER_MOST_COMPONENTS, SWEEP_INDEPENDENT_SHARE};
use crate::novelty;
use crate::shape::ShapeSettings;

/// Everything the engine may be told.
#[derive(Debug, Clone, PartialEq)]
pub struct EngineSettings {
    /// How changes are found.
    pub novelty: novelty::Settings,
    /// How shapes are retrieved.
    pub shape: ShapeSettings,
    /// Share of a sweep's points that count as independent; a bare cloud's all do.
    pub sweep_independent_share: f64,
}

impl EngineSettings {
    /// patrold's own engine.
    pub fn standard() -> Self {
        Self {
            novelty: novelty::Settings::default(),
            shape: ShapeSettings::default(),
            sweep_independent_share: SWEEP_INDEPENDENT_SHARE,
        }
    }

    /// The published recipe, made well-posed: both clouds fitted alone, Algorithm 1 on the mixtures, shapes from
    /// the mixtures' moments and from samples on their ellipsoids.
    pub fn paper() -> Self {
        Self {
            novelty: novelty::Settings {
                segmentation: novelty::Segmentation::Mixture,
                model: novelty::Model::Independent {
                    most: PAPER_MOST_COMPONENTS,
                },
                ..novelty::Settings::default()
            },
            shape: ShapeSettings::ideal(),
            sweep_independent_share: 1.0,
        }
    }
}
