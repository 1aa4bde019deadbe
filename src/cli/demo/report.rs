//! The report of the demo: the alarm log, and each true change with the novelty that matches it.

use super::building::DemoWaypoint;
use super::truth::{ChangeMatch, match_novelties, true_changes};
use crate::cli::failure::Failure;
use crate::cli::{alarm_report, table};
use crate::service::replies::VisitReply;
use crate::store::{AlarmFilter, AlarmRow, Store};
use patrold_engine::report::NoveltyRecord;
use serde_json::json;
use std::path::Path;

/// Width of the report: every terminal has it.
const COLUMNS: u16 = 80;

struct WaypointReport {
    waypoint: &'static str,
    changes: Vec<ChangeMatch>,
    /// Novelties that match no true change.
    stray: Vec<NoveltyRecord>,
    /// Whether each true change has one alarm, and there is no other.
    alarmed: bool,
}

pub(super) struct DemoReport {
    waypoints: Vec<WaypointReport>,
    quiet_visits: Vec<VisitReply>,
    alarms: Vec<AlarmRow>,
}

impl DemoReport {
    /// Reads the alarm log of the store in `state` and compares it with the true changes.
    pub(super) fn new(
        waypoints: &[DemoWaypoint],
        quiet_visits: Vec<VisitReply>,
        state: &Path,
    ) -> Result<Self, Failure> {
        let alarms = Store::open_for_reading(state)?.alarms(&AlarmFilter::default())?;
        let mut reports = Vec::new();
        for waypoint in waypoints {
            let raised: Vec<&AlarmRow> = alarms
                .iter()
                .filter(|a| a.waypoint == waypoint.name)
                .collect();
            let novelties: Vec<NoveltyRecord> =
                raised.iter().flat_map(|a| a.novelties.clone()).collect();
            let one_each = raised.iter().all(|a| a.novelties.len() == 1);
            let (changes, stray) = match_novelties(true_changes(waypoint)?, &novelties);
            reports.push(WaypointReport {
                waypoint: waypoint.name,
                alarmed: one_each && raised.len() == changes.len(),
                changes,
                stray,
            });
        }
        Ok(Self {
            waypoints: reports,
            quiet_visits,
            alarms,
        })
    }

    /// Whether every quiet visit was quiet, and every true change has one alarm of its own and there is no other, each
    /// with a shape of about the right size.
    pub(super) fn is_correct(&self) -> bool {
        let is_correct = |report: &WaypointReport| {
            report.alarmed
                && report.stray.is_empty()
                && report
                    .changes
                    .iter()
                    .all(|c| c.novelty.is_some() && c.sane_shape)
        };
        self.quiet_visits.iter().all(|v| v.verdict == "quiet")
            && self.waypoints.iter().all(is_correct)
    }

    pub(super) fn text(&self) -> String {
        let mut rows = table::table(&[
            "waypoint",
            "true change",
            "reported",
            "off (m)",
            "shape (m)",
            "",
        ]);
        for report in &self.waypoints {
            for change in &report.changes {
                rows.add_row(change_cells(report.waypoint, change));
            }
            for stray in &report.stray {
                let reported = format!("{} at {}", stray.kind, table::format_point(stray.centre));
                rows.add_row([report.waypoint, "nothing", &reported, "", "", "FALSE"]);
            }
        }
        let mut alarms = alarm_report::alarm_table(&self.alarms);
        for table in [&mut rows, &mut alarms] {
            table.set_width(COLUMNS);
        }
        let conclusion = if self.is_correct() {
            "exactly the true changes were alarmed"
        } else {
            "the alarms are NOT exactly the true changes"
        };
        format!("\nalarm log\n{alarms}\n\nagainst the truth\n{rows}\n\n{conclusion}")
    }

    pub(super) fn json(&self, seed: u64, time_scale: f64) -> serde_json::Value {
        let changed: Vec<_> = self
            .waypoints
            .iter()
            .map(|r| json!({"waypoint": r.waypoint, "alarmed": r.alarmed, "told": r.changes, "stray": r.stray}))
            .collect();
        let quiet: Vec<_> = self
            .quiet_visits
            .iter()
            .map(|v| json!({"waypoint": v.waypoint, "verdict": v.verdict, "reason": v.reason, "d_gmm": v.d_gmm}))
            .collect();
        json!({
            "correct": self.is_correct(),
            "seed": seed,
            "time_scale": time_scale,
            "quiet": quiet,
            "changed": changed,
            "alarms": self.alarms,
        })
    }
}

fn change_cells(waypoint: &str, change: &ChangeMatch) -> [String; 6] {
    let shape = change.novelty.as_ref().and_then(|n| n.shape.as_ref());
    [
        waypoint.to_owned(),
        format!("{} {}", change.truth.name, change.truth.kind),
        change
            .novelty
            .as_ref()
            .map_or_else(|| "not reported".to_owned(), |n| n.kind.clone()),
        change
            .off_m
            .map_or_else(String::new, |off| format!("{off:.2}")),
        shape.map_or_else(String::new, |s| {
            format!("{} {}", s.class, table::format_point(s.size))
        }),
        if change.novelty.is_some() && change.sane_shape {
            "ok"
        } else {
            "MISSED"
        }
        .to_owned(),
    ]
}
