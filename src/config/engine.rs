//! From the configuration to the engine's settings.

use super::settings::Settings;
use patrold_engine::distance::GroundDistance;
use patrold_engine::inspect::EngineSettings;
use patrold_engine::shape::MethodChoice;
use serde_json::json;

/// As written in configuration and JSON.
pub fn ground_name(ground: GroundDistance) -> &'static str {
    match ground {
        GroundDistance::W2 => "w2",
        GroundDistance::Euclid => "euclid",
        GroundDistance::Fm => "fm",
    }
}

impl Settings {
    /// The engine's settings, with the threshold of `waypoint`.
    pub fn engine_settings(&self, waypoint: Option<&str>) -> EngineSettings {
        let mut engine = EngineSettings::for_engine(self.novelty.engine);
        engine.novelty.quantify.ground = self.novelty.ground;
        engine.novelty.max_range_m = self.novelty.max_range_m;
        engine.novelty.verdict.min_coverage = self.novelty.min_coverage;
        engine.novelty.u_th_m = self.u_th(waypoint);
        engine.novelty.u_th_fm = self.u_th(waypoint);
        engine.shape.choice = match self.shape.method.as_str() {
            "covariance" => MethodChoice::Covariance,
            "ransac" => MethodChoice::Ransac,
            _ => MethodChoice::Auto,
        };
        engine
    }

    /// What a verdict or reference depends on besides threshold and seed, as JSON; stored with both.
    pub fn engine_json(&self) -> String {
        let novelty = &self.novelty;
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "engine": novelty.engine.as_str(),
            "ground": ground_name(novelty.ground),
            "max_range_m": novelty.max_range_m,
            "min_coverage": novelty.min_coverage,
            "shape": self.shape.method,
        })
        .to_string()
    }
}
