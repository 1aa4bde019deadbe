//! The report of `patrold status`, and its text.

use super::config::sources_text;
use super::local_time::local_time;
use super::table;
use crate::service::replies::StatusReply;
use crate::store::{EventRow, HealthRow, VisitRow};
use serde::Serialize;
use serde_json::Value;

const BYTES_PER_GB: f64 = 1e9;
/// Digits of a number of a device: a tenth of a degree of an angle, a hundredth of a volt or degree Celsius.
const SHOWN_DIGITS: usize = 4;

/// All that `patrold status` reports.
#[derive(Debug, Serialize)]
pub(super) struct StatusReport {
    pub(super) service: ServiceReport,
    pub(super) devices: Vec<DeviceReport>,
    pub(super) waypoints: Vec<WaypointReport>,
    /// Open ones first, then acknowledged ones; the newest of each.
    pub(super) incidents: Vec<IncidentReport>,
    /// Alarms that are not cleared.
    pub(super) standing: i64,
    /// What keeps the watch from seeing, newest first.
    pub(super) health: Vec<HealthRow>,
    pub(super) configuration: ConfigReport,
    pub(super) store: StoreReport,
}

#[derive(Debug, Serialize)]
pub(super) struct ServiceReport {
    pub(super) running: bool,
    /// Nothing listens at its socket; else it may run, and this user may not ask it or it hangs.
    #[serde(skip)]
    pub(super) is_down: bool,
    /// Why it does not answer.
    pub(super) why: Option<String>,
    pub(super) status: Option<StatusReply>,
}

/// What the log knows of a device; what the device itself said is in the service's status.
#[derive(Debug, Serialize)]
pub(super) struct DeviceReport {
    pub(super) device: &'static str,
    pub(super) last_event: Option<EventRow>,
}

#[derive(Debug, Serialize)]
pub(super) struct WaypointReport {
    pub(super) waypoint: String,
    pub(super) reference_version: Option<i64>,
    pub(super) standing_alarms: i64,
    pub(super) last_visit: Option<VisitRow>,
}

#[derive(Debug, Serialize)]
pub(super) struct IncidentReport {
    pub(super) id: i64,
    pub(super) waypoint: String,
    pub(super) state: String,
    pub(super) raised_at: String,
    pub(super) last_seen_at: String,
    pub(super) clock_unset: bool,
    /// A line for each thing.
    pub(super) what: Vec<String>,
}

/// The files as they are now; what is in force is in the service's status.
#[derive(Debug, Serialize)]
pub(super) struct ConfigReport {
    pub(super) mistakes: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(super) struct StoreReport {
    pub(super) dir: String,
    /// Why the log cannot be read.
    pub(super) error: Option<String>,
    pub(super) disk: Option<DiskReport>,
}

#[derive(Debug, Serialize)]
pub(super) struct DiskReport {
    pub(super) free_bytes: u64,
    pub(super) total_bytes: u64,
}

pub(super) fn status_text(report: &StatusReport) -> String {
    let mut lines = service_lines(&report.service);
    lines.extend(device_lines(report));
    lines.extend(configuration_lines(report));
    lines.push(store_line(&report.store));
    for row in &report.health {
        let since = local_time(&row.since, false);
        lines.push(format!(
            "health: {} since {since}: {}",
            row.subject, row.reason
        ));
    }
    if report.standing > 0 {
        lines.push(format!("incidents: {} not cleared", report.standing));
    } else if report.store.error.is_none() {
        lines.push("incidents: none".to_owned());
    }
    for incident in &report.incidents {
        lines.push(format!(
            "  alarm {} at {}, {} since {}: {}",
            incident.id,
            incident.waypoint,
            incident.state,
            local_time(&incident.raised_at, incident.clock_unset),
            incident.what.join("; ")
        ));
    }
    if !report.waypoints.is_empty() {
        lines.push(waypoint_table(&report.waypoints));
    }
    lines.join("\n")
}

fn service_lines(service: &ServiceReport) -> Vec<String> {
    let Some(status) = &service.status else {
        let why = service.why.as_deref().unwrap_or_default();
        let state = if service.is_down { "down" } else { "no answer" };
        return vec![format!("service: {state} ({why})")];
    };
    let mut line = format!(
        "service: up, {}, patrold {} (pid {}), {}, since {}",
        status.robot,
        status.version,
        status.pid,
        status.phase,
        local_time(&status.started_at, false)
    );
    if let Some(current) = &status.current {
        let text = format!("{} {}", current.task, current.waypoint);
        line.push_str(&format!(
            "; doing {}, {} waiting",
            text.trim_end(),
            status.waiting
        ));
    }
    vec![line]
}

fn device_lines(report: &StatusReport) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(status) = &report.service.status {
        let reason = status.devices.reason.iter().map(|why| format!(": {why}"));
        lines.push(format!(
            "devices: {}{}",
            status.devices.state,
            reason.collect::<String>()
        ));
        for device in ["laser", "ptu"] {
            if let Some(Value::Object(figures)) = status.devices.identity.get(device) {
                let figures = figures.iter().filter(|(_, value)| !value.is_null());
                let figures: Vec<String> = figures
                    .filter(|(_, value)| !value.is_object())
                    .map(|(name, value)| format!("{name} {}", short(value)))
                    .collect();
                lines.push(format!("  {device}: {}", figures.join(", ")));
            }
        }
    }
    for device in &report.devices {
        if let Some(event) = &device.last_event {
            lines.push(format!(
                "  last of {}: {} {}: {}",
                device.device,
                local_time(&event.at, event.clock_unset),
                event.level,
                event.text
            ));
        }
    }
    lines
}

fn short(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(short).collect::<Vec<_>>().join(" "),
        Value::Number(number) if number.is_f64() => {
            number.as_f64().map_or_else(String::new, short_number)
        }
        other => other.to_string(),
    }
}

/// With the digits that matter to a reader.
fn short_number(x: f64) -> String {
    let before_point = x.abs().max(1.0).log10().floor() as usize + 1;
    let decimals = SHOWN_DIGITS.saturating_sub(before_point);
    let text = format!("{x:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn configuration_lines(report: &StatusReport) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(status) = &report.service.status {
        lines.push(format!(
            "configuration: {}, in force since {}",
            sources_text(&status.config_files),
            local_time(&status.config_loaded_at, false)
        ));
        let read = &status.config_read;
        if !read.taken {
            lines.push(format!(
                "  NOT taken at {}; the one above stays in force:",
                local_time(&read.at, false)
            ));
            lines.extend(read.mistakes.iter().map(|mistake| format!("    {mistake}")));
            return lines;
        }
    }
    if !report.configuration.mistakes.is_empty() {
        lines.push(
            "configuration on disk: has mistakes, a start or reload would not take it".to_owned(),
        );
        let mistakes = report.configuration.mistakes.iter();
        lines.extend(mistakes.map(|mistake| format!("    {mistake}")));
    } else if report.service.status.is_none() {
        lines.push("configuration on disk: valid".to_owned());
    }
    lines
}

fn store_line(store: &StoreReport) -> String {
    let disk = match &store.disk {
        Some(disk) => format!(
            "{:.1} of {:.1} GB free",
            disk.free_bytes as f64 / BYTES_PER_GB,
            disk.total_bytes as f64 / BYTES_PER_GB
        ),
        None => "no such folder".to_owned(),
    };
    let error = store
        .error
        .iter()
        .map(|error| format!("; the log cannot be read: {error}"));
    format!("store: {}, {disk}{}", store.dir, error.collect::<String>())
}

fn waypoint_table(waypoints: &[WaypointReport]) -> String {
    let mut rows = table::table(&["waypoint", "last visit", "verdict", "alarms", "reason"]);
    for waypoint in waypoints {
        let [at, verdict, reason] = match &waypoint.last_visit {
            Some(visit) => [
                local_time(&visit.at, visit.clock_unset),
                visit.verdict.replace('_', " "),
                visit.reason.clone(),
            ],
            None => ["never", "-", "-"].map(str::to_owned),
        };
        rows.add_row([
            waypoint.waypoint.clone(),
            at,
            verdict,
            waypoint.standing_alarms.to_string(),
            reason,
        ]);
    }
    rows.to_string()
}

#[cfg(test)]
mod tests {
    use super::{ServiceReport, service_lines, short};
    use serde_json::json;

    #[test]
    fn numbers_of_devices_have_the_digits_that_matter() {
        let azimuth = json!([-119.882_812_499_999_99, 119.882_812_499_999_99]);
        assert_eq!(short(&azimuth), "-119.9 119.9");
        let temperatures = json!([37.777_777_777_777_78, 0.0, -3.333_333_333_333_333_5]);
        assert_eq!(short(&temperatures), "37.78 0 -3.333");
        assert_eq!(
            short(&json!([10.0, 682, 24.5, 12_345.678])),
            "10 682 24.5 12346"
        );
    }

    #[test]
    fn only_a_service_that_is_not_there_is_down() {
        let silent = |is_down| {
            service_lines(&ServiceReport {
                running: false,
                is_down,
                why: Some("p.sock: a reason".to_owned()),
                status: None,
            })
        };
        assert_eq!(silent(true), ["service: down (p.sock: a reason)"]);
        assert_eq!(silent(false), ["service: no answer (p.sock: a reason)"]);
    }
}
