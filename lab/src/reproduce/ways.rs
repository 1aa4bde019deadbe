//! The columns: which engine finds, and which method retrieves.

use patrold_engine::inspect::EngineSettings;
use patrold_engine::shape::{Choice, RansacSource, ShapeSettings};

/// One column of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Way {
    /// patrold's engine, method B.
    Feature,
    /// patrold's engine, method A on the novelty's own points.
    EuclideanPoints,
    /// patrold's engine, method A as printed: 3722 samples on the ellipsoids at one sigma.
    EuclideanSamples,
    /// The published recipe, method B constrained but otherwise literal.
    PaperFeature,
    /// The published recipe, method A.
    PaperEuclidean,
}

impl Way {
    /// Every column, ours first.
    pub const ALL: [Self; 5] = [
        Self::Feature,
        Self::EuclideanPoints,
        Self::EuclideanSamples,
        Self::PaperFeature,
        Self::PaperEuclidean,
    ];

    /// Its word in JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Feature => "feature",
            Self::EuclideanPoints => "euclidean-points",
            Self::EuclideanSamples => "euclidean-samples",
            Self::PaperFeature => "paper-feature",
            Self::PaperEuclidean => "paper-euclidean",
        }
    }

    /// Its settings.
    pub fn settings(self) -> EngineSettings {
        let shaped = |engine: EngineSettings, choice, source: Option<RansacSource>| {
            let shape = ShapeSettings {
                choice,
                ransac_source: source.unwrap_or(engine.shape.ransac_source),
                ..engine.shape
            };
            EngineSettings { shape, ..engine }
        };
        let standard = EngineSettings::standard;
        match self {
            Self::Feature => shaped(standard(), Choice::Covariance, None),
            Self::EuclideanPoints => shaped(standard(), Choice::Ransac, Some(RansacSource::Points)),
            Self::EuclideanSamples => shaped(
                standard(),
                Choice::Ransac,
                Some(ShapeSettings::ideal().ransac_source),
            ),
            Self::PaperFeature => shaped(EngineSettings::paper(), Choice::Covariance, None),
            Self::PaperEuclidean => shaped(EngineSettings::paper(), Choice::Ransac, None),
        }
    }
}
