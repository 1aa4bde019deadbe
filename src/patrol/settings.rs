//! The engine's settings: `standard` and `paper` are two rows of one struct and walk the same corridor.

use crate::novelty;
use crate::shape::ShapeSettings;

/// Share of a sweep's points that count as independent: noise is correlated along the scan by .48, .28, .13 at
/// 1, 2, 3 steps (scip2 section 11), so n points weigh as n / (1 + 2 (.48 + .28 + .13)).
const SWEEP_INDEPENDENT_SHARE: f64 = 1.0 / (1.0 + 2.0 * (0.48 + 0.28 + 0.13));

/// Most components of a mixture in the paper's way; its corridor of 400 points has some ten surfaces, a real
/// scan more.
const PAPER_MOST_COMPONENTS: usize = 30;

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
