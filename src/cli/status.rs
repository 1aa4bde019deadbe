//! `patrold status`: service, devices, waypoints, incidents, configuration and disk. What the service does not answer is read from
//! the store.

use super::client::NoStatus;
use super::failure::{CommandResult, DONE, Failure};
use super::status_report::{
    ConfigReport, DeviceReport, DiskReport, IncidentReport, ServiceReport, StatusReport,
    StoreReport, WaypointReport, status_text,
};
use super::{alarm_report, client, output};
use crate::alarm::AlarmState;
use crate::config::{Settings, load_leniently};
use crate::devices::Device;
use crate::store::{AlarmFilter, AlarmRow, EventFilter, Store, TimeRange, VisitFilter};
use clap::Args;
use std::path::{Path, PathBuf};

/// Devices as the event log names them.
const DEVICES: [&str; 3] = [Device::Laser.section(), Device::Head.section(), "devices"];
/// Incidents listed; all are counted.
const MAX_INCIDENTS: u32 = 100;

#[derive(Debug, Args)]
pub(super) struct StatusArgs {
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &StatusArgs) -> CommandResult {
    let report = report(args.config.as_deref())?;
    if args.json {
        output::json(&report)?;
    } else {
        output::line(status_text(&report))?;
    }
    Ok(DONE)
}

pub(super) fn report(config: Option<&Path>) -> Result<StatusReport, Failure> {
    let (settings, mistakes) = load_leniently(config)?;
    let service = match client::request_status(&settings.api.socket)? {
        Ok(status) => ServiceReport {
            running: true,
            is_down: false,
            why: None,
            status: Some(status),
        },
        Err(NoStatus { is_down, why }) => ServiceReport {
            running: false,
            is_down,
            why: Some(why),
            status: None,
        },
    };
    let mut report = StatusReport {
        service,
        devices: Vec::new(),
        waypoints: Vec::new(),
        incidents: Vec::new(),
        standing: 0,
        health: Vec::new(),
        configuration: ConfigReport {
            mistakes: mistakes.iter().map(ToString::to_string).collect(),
        },
        store: store_report(&settings.store.dir),
    };
    if let Err(failure) = read_log(&settings, &mut report) {
        report.store.error = Some(failure.to_string());
    }
    Ok(report)
}

fn read_log(settings: &Settings, report: &mut StatusReport) -> Result<(), Failure> {
    let store = Store::open_for_reading(&settings.store.dir)?;
    for device in DEVICES {
        let filter = EventFilter {
            device: Some(device.to_owned()),
            ..EventFilter::from(1)
        };
        report.devices.push(DeviceReport {
            device,
            last_event: store.events(filter)?.pop(),
        });
    }
    for waypoint in store.waypoints()? {
        let filter = VisitFilter {
            range: TimeRange::default(),
            waypoint: Some(waypoint.name.clone()),
            verdict: None,
            limit: 1,
        };
        report.waypoints.push(WaypointReport {
            last_visit: store.visits(&filter)?.pop(),
            waypoint: waypoint.name,
            reference_version: waypoint.reference_version,
            standing_alarms: waypoint.standing_alarms,
        });
        report.standing += waypoint.standing_alarms;
    }
    report.health = store.health(true, MAX_INCIDENTS)?;
    for state in [AlarmState::Open, AlarmState::Acknowledged] {
        let filter = AlarmFilter {
            state: Some(state),
            limit: Some(MAX_INCIDENTS),
            ..AlarmFilter::default()
        };
        report
            .incidents
            .extend(store.alarms(&filter)?.into_iter().map(incident));
    }
    Ok(())
}

fn incident(alarm: AlarmRow) -> IncidentReport {
    IncidentReport {
        what: alarm_report::current(&alarm)
            .iter()
            .map(alarm_report::novelty_text)
            .collect(),
        id: alarm.id,
        waypoint: alarm.waypoint,
        state: alarm.state,
        raised_at: alarm.raised_at,
        last_seen_at: alarm.last_seen_at,
        clock_unset: alarm.clock_unset,
    }
}

fn store_report(dir: &Path) -> StoreReport {
    let disk = rustix::fs::statvfs(dir).ok().map(|disk| DiskReport {
        free_bytes: disk.f_bavail.saturating_mul(disk.f_frsize),
        total_bytes: disk.f_blocks.saturating_mul(disk.f_frsize),
    });
    StoreReport {
        dir: dir.display().to_string(),
        error: None,
        disk,
    }
}
