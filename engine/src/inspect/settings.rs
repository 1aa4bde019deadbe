//! The engine's settings. The engines are values of one struct and run the same pipeline.

use super::constants::{
    PAPER_INDEPENDENT_U_TH_M, PAPER_MAX_COMPONENTS, PAPER_U_TH_M, SWEEP_INDEPENDENT_SHARE,
};
use super::engine::Engine;
use crate::novelty;
use crate::shape::ShapeSettings;

/// All settings of the engine.
#[derive(Debug, Clone, PartialEq)]
pub struct EngineSettings {
    /// How changes are found.
    pub novelty: novelty::NoveltySettings,
    /// How shapes are retrieved.
    pub shape: ShapeSettings,
    /// Share of a sweep's points that count as independent; those of a bare cloud all do.
    pub sweep_independent_share: f64,
}

impl EngineSettings {
    /// The settings of `engine`.
    pub fn for_engine(engine: Engine) -> Self {
        match engine {
            Engine::Standard => Self::standard(),
            Engine::Paper => Self::paper(),
            Engine::PaperIndependent => Self::paper_independent(),
        }
    }

    /// patrold's own engine, the default.
    pub fn standard() -> Self {
        Self {
            novelty: novelty::NoveltySettings::default(),
            shape: ShapeSettings::default(),
            sweep_independent_share: SWEEP_INDEPENDENT_SHARE,
        }
    }

    /// The paper's chain made well-posed (`docs/novelty.md section 10`): Theta from Gamma without evidence from rays, shapes
    /// from the mixtures' moments and from samples on their ellipsoids.
    pub fn paper() -> Self {
        Self {
            novelty: novelty::NoveltySettings {
                u_th_m: PAPER_U_TH_M,
                evidence_source: novelty::EvidenceSource::Mixture,
                ..novelty::NoveltySettings::default()
            },
            shape: ShapeSettings::paper(),
            sweep_independent_share: 1.0,
        }
    }

    /// The published recipe to the letter: both views fitted alone, Algorithm 1 on the mixtures.
    pub fn paper_independent() -> Self {
        Self {
            novelty: novelty::NoveltySettings {
                u_th_m: PAPER_INDEPENDENT_U_TH_M,
                model: novelty::RevisitModel::Independent {
                    max_components: PAPER_MAX_COMPONENTS,
                },
                removal_extent: novelty::RemovalExtent::UntilBelowThreshold,
                ..novelty::NoveltySettings::default()
            },
            shape: ShapeSettings::paper_independent(),
            sweep_independent_share: 1.0,
        }
    }
}
