//! What is allowed and can hardly be meant.

use super::error::{ConfigError, ConfigProblem};
use super::load::LoadedConfig;

/// No object of the recorded pairs moved the mass by more (docs/novelty.md section 8): above it nothing alarms, metres.
const U_TH_CEILING_M: f64 = 0.06;

impl LoadedConfig {
    /// Values that are valid and leave the robot blind, each at its line.
    pub fn warnings(&self) -> Vec<ConfigError> {
        let values = self.layers.values.iter();
        let thresholds = values.filter(|(key, _)| key.ends_with(".u_th_m"));
        let too_high = thresholds.filter_map(|(key, (value, _))| {
            let u_th_m = value.to_json().as_f64().filter(|u| *u > U_TH_CEILING_M)?;
            let (file, line) = self.layers.location(&[key]);
            let text = format!(
                "{key} = {u_th_m} m: hardly any change reaches it, so nothing alarms; objects move the mass by 0.001 to {U_TH_CEILING_M} m"
            );
            Some(ConfigError { file, line, problem: ConfigProblem::Contradiction(text) })
        });
        too_high.collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::config::load;
    use std::fs;

    #[test]
    fn a_threshold_that_nothing_reaches_is_warned_of() {
        let dir = tempfile::tempdir().expect("temp dir");
        let file = dir.path().join("c.toml");
        fs::write(&file, "novelty.u_th_m = 0.06\n[waypoint.hall]\nu_th_m = 0.061\n[waypoint.dock]\nu_th_m = 0.01\n").expect("written");
        let warnings = load(Some(&file), &[]).expect("valid").warnings();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert_eq!(warnings[0].line, 3);
        assert!(
            warnings[0]
                .to_string()
                .contains("waypoint.hall.u_th_m = 0.061 m"),
            "{}",
            warnings[0]
        );
    }
}
