//! The columns of the tables: an engine that finds novelties, and a method that retrieves their shapes.

use patrold_engine::inspect::EngineSettings;
use patrold_engine::shape::{MethodChoice, RansacSource, ShapeSettings};

/// One column of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TableColumn {
    /// patrold's engine, method B.
    Feature,
    /// patrold's engine, method A on the points of the novelty.
    EuclideanPoints,
    /// patrold's engine, method A on 3722 samples of the novelty's ellipsoids.
    EuclideanSamples,
    /// The published recipe, method B constrained but otherwise literal.
    PaperFeature,
    /// The published recipe, method A.
    PaperEuclidean,
}

impl TableColumn {
    /// All columns, ours first.
    pub const ALL: [Self; 5] = [
        Self::Feature,
        Self::EuclideanPoints,
        Self::EuclideanSamples,
        Self::PaperFeature,
        Self::PaperEuclidean,
    ];

    /// The name on the command line, in tables and JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Feature => "feature",
            Self::EuclideanPoints => "euclidean-points",
            Self::EuclideanSamples => "euclidean-samples",
            Self::PaperFeature => "paper-feature",
            Self::PaperEuclidean => "paper-euclidean",
        }
    }

    /// Its settings, where method A samples ellipsoids with ellipsoids of `ellipsoid_sigmas` standard deviations.
    pub fn settings(self, ellipsoid_sigmas: f64) -> EngineSettings {
        let with_shapes = |engine: EngineSettings, choice, source: Option<RansacSource>| {
            let shape = ShapeSettings {
                choice,
                ransac_source: source.unwrap_or(engine.shape.ransac_source),
                ..engine.shape
            };
            let shape = shape.with_ellipsoid_sigmas(ellipsoid_sigmas);
            EngineSettings { shape, ..engine }
        };
        let standard = EngineSettings::standard;
        match self {
            Self::Feature => with_shapes(standard(), MethodChoice::Covariance, None),
            Self::EuclideanPoints => {
                with_shapes(standard(), MethodChoice::Ransac, Some(RansacSource::Points))
            }
            Self::EuclideanSamples => with_shapes(
                standard(),
                MethodChoice::Ransac,
                Some(ShapeSettings::paper().ransac_source),
            ),
            Self::PaperFeature => {
                with_shapes(EngineSettings::paper(), MethodChoice::Covariance, None)
            }
            Self::PaperEuclidean => {
                with_shapes(EngineSettings::paper(), MethodChoice::Ransac, None)
            }
        }
    }
}
