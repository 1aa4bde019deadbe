//! Thresholds at which nothing of the past alarms.

use super::failure::Failure;
use crate::alarm::ThresholdStudy;
use crate::config::{Settings, ground_name};
use crate::store::{Store, TimeRange};

/// For each waypoint of the log at which the threshold in force would have raised no alarm of the past, a line that says so.
pub(super) fn never_alarming(settings: &Settings, store: &Store) -> Result<Vec<String>, Failure> {
    let ground = ground_name(settings.novelty.ground);
    let mut warnings = Vec::new();
    for row in store.waypoints()? {
        let u_th = settings.u_th(Some(&row.name));
        let mut study = ThresholdStudy::new([u_th]);
        store.each_past_alarm(&row.name, &TimeRange::default(), ground, &mut |past| {
            study.add(past)
        })?;
        if study.effects().iter().any(|effect| effect.never_alarms()) {
            warnings.push(never_alarms_text(&row.name, u_th, study.alarms().all));
        }
    }
    Ok(warnings)
}

pub(super) fn never_alarms_text(waypoint: &str, u_th: f64, alarms: u64) -> String {
    format!(
        "{waypoint}: with U_th {u_th} none of its {alarms} alarms would have been raised; see patrold tune --waypoint {waypoint}"
    )
}
