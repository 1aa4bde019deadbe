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

#[cfg(test)]
mod tests {
    use super::super::settings::Settings;
    use patrold_engine::distance::GroundDistance;
    use patrold_engine::inspect::Engine;
    use patrold_engine::shape::MethodChoice;

    #[test]
    fn each_key_reaches_the_engine() {
        let defaults = Settings::defaults().engine_settings(None);
        let mut settings = Settings::defaults();
        settings.novelty.engine = Engine::Paper;
        settings.novelty.ground = GroundDistance::Euclid;
        settings.novelty.max_range_m = Some(2.5);
        settings.novelty.min_coverage = 0.8;
        settings.novelty.u_th_m = 0.004;
        settings.set_u_th("hall", 0.003);
        let novelty = settings.engine_settings(None).novelty;
        assert_ne!(novelty.evidence_source, defaults.novelty.evidence_source);
        assert_eq!(novelty.quantify.ground, GroundDistance::Euclid);
        assert_eq!(novelty.max_range_m, Some(2.5));
        assert_eq!(novelty.verdict.min_coverage, 0.8);
        assert_eq!(novelty.u_th_m, 0.004);
        assert_eq!(settings.engine_settings(Some("hall")).novelty.u_th_m, 0.003);
        assert_eq!(settings.engine_settings(Some("yard")).novelty.u_th_m, 0.004);
        for (method, choice) in [
            ("auto", MethodChoice::Auto),
            ("covariance", MethodChoice::Covariance),
            ("ransac", MethodChoice::Ransac),
        ] {
            method.clone_into(&mut settings.shape.method);
            assert_eq!(
                settings.engine_settings(None).shape.choice,
                choice,
                "{method}"
            );
        }
    }
}
