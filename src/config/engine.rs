//! From the configuration's few knobs to the engine's settings.

use super::settings::{EngineMode, Settings};
use patrold_engine::distance::Ground;
use patrold_engine::inspect::EngineSettings;
use patrold_engine::shape::Choice;
use serde_json::json;

impl EngineMode {
    /// The word of the configuration and of JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Paper => "paper",
        }
    }
}

/// The ground distance in the word of the configuration and of JSON.
pub(super) fn ground_word(ground: Ground) -> &'static str {
    match ground {
        Ground::W2 => "w2",
        Ground::Euclid => "euclid",
        Ground::Fm => "fm",
    }
}

impl Settings {
    /// The engine's settings at a waypoint, or those of no waypoint in particular.
    pub fn engine(&self, waypoint: Option<&str>) -> EngineSettings {
        let mut engine = match self.novelty.engine {
            EngineMode::Standard => EngineSettings::standard(),
            EngineMode::Paper => EngineSettings::paper(),
        };
        engine.novelty.quantify.ground = self.novelty.ground;
        engine.novelty.max_range_m = self.novelty.max_range_m;
        engine.novelty.u_th_m = self.u_th(waypoint);
        engine.novelty.u_th_fm = self.u_th(waypoint);
        engine.shape.choice = match self.shape.method.as_str() {
            "covariance" => Choice::Covariance,
            "ransac" => Choice::Ransac,
            _ => Choice::Auto,
        };
        engine
    }

    /// What a stored verdict or reference depends on beside the threshold and the seed, as JSON: the form that the
    /// log keeps.
    pub fn engine_json(&self) -> String {
        let novelty = &self.novelty;
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "engine": novelty.engine.word(),
            "ground": ground_word(novelty.ground),
            "max_range_m": novelty.max_range_m,
            "shape": self.shape.method,
        })
        .to_string()
    }
}
