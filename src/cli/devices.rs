//! `patrold devices`: the connected devices and their state, and all serial ports.

use super::failure::{CommandResult, DONE, FAILED, Failure};
use super::{config, output, signals, value_parsers};
use crate::devices::{
    AxisReport, DeviceError, HeadReport, LaserReport, PortReport, Station, inventory,
};
use clap::Args;
use link::Clock;
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;
use std::sync::mpsc;

#[derive(Debug, Args)]
pub(super) struct DevicesArgs {
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// For emulated devices: device seconds per second of wall time, as given to `emulate`
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = value_parsers::parse_time_scale)]
    time_scale: f64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// Reports both devices, with an error in place of one that does not answer; the exit code is then [`FAILED`].
pub(super) fn run(args: &DevicesArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    // Before the ports are opened, so that this process is not listed as their user.
    let ports = inventory(&settings).unwrap_or_else(|error| {
        eprintln!("patrold: serial ports cannot be listed: {error}");
        Vec::new()
    });
    let (notes, _) = mpsc::channel();
    let cancel = signals::cancel_on_signal()?;
    let clock = Clock::scaled(args.time_scale);
    let survey = Station::survey(&settings, clock, notes, &cancel).map_err(Failure::failed)?;
    let (laser, ptu) = (survey.laser, survey.ptu);
    if args.json {
        output::json(&json!({
            "laser": device_json(&laser, &settings.laser.port),
            "ptu": device_json(&ptu, &settings.ptu.port),
            "ports": ports,
            "sweep_notes": survey.sweep_notes,
        }))?;
    } else {
        output::line(match &laser {
            Ok(report) => laser_text(report),
            Err(error) => format!("laser: {error}"),
        })?;
        output::line(match &ptu {
            Ok(report) => head_text(report),
            Err(error) => format!("pan-tilt: {error}"),
        })?;
        for note in &survey.sweep_notes {
            output::line(format!("sweep: {note}"))?;
        }
        output::line(ports_text(&ports))?;
    }
    Ok(if laser.is_ok() && ptu.is_ok() {
        DONE
    } else {
        FAILED
    })
}

/// A device's report, or why there is none.
pub(super) fn device_json(
    report: &Result<impl Serialize, DeviceError>,
    port: &str,
) -> serde_json::Value {
    match report {
        Ok(report) => json!(report),
        Err(error) => json!({"port": port, "error": error.to_string()}),
    }
}

fn ports_text(ports: &[PortReport]) -> String {
    if ports.is_empty() {
        return "ports: no serial port with a device found".to_owned();
    }
    let line = |port: &PortReport| {
        let mut parts = vec![port.usb.clone().unwrap_or_else(|| "not on USB".to_owned())];
        parts.extend(port.product.clone());
        if !port.held_by.is_empty() {
            parts.push(format!("in use by {}", port.held_by.join(", ")));
        }
        parts.extend(port.configured_as.iter().map(|key| (*key).to_owned()));
        format!("\n  {}: {}", port.path, parts.join(", "))
    };
    format!("ports:{}", ports.iter().map(line).collect::<String>())
}

fn laser_text(report: &LaserReport) -> String {
    let [near, far] = report.range_mm;
    let [right, left] = report.azimuth_deg;
    let line = match report.line_bit_s {
        Some(bit_s) => format!(", line of {bit_s} bit/s"),
        None => String::new(),
    };
    format!(
        "laser: {} on {}{line}\n  serial {}, firmware {}, {}\n  {} beams from {right:.1} to {left:.1} deg, {near} to {far} mm, {} scans/s\n  {}",
        report.product,
        report.port,
        report.serial,
        report.firmware,
        report.protocol,
        report.beams,
        report.scans_per_s,
        report.status
    )
}

fn head_text(report: &HeadReport) -> String {
    let axis = |name: &str, axis: &AxisReport| {
        let [low, high] = axis.limits_deg;
        let [slow, fast] = axis.speed_deg_s;
        format!(
            "  {name} {low:.1} to {high:.1} deg by {:.4}, {slow:.2} to {fast:.1} deg/s",
            axis.step_deg
        )
    };
    let mut lines = vec![
        format!("pan-tilt: {} on {}", report.firmware, report.port),
        axis("pan", &report.pan),
        axis("tilt", &report.tilt),
    ];
    let temperatures: Vec<String> = report
        .temperatures_c
        .iter()
        .map(|c| format!("{c:.0} degC"))
        .collect();
    if let Some(volts) = report.supply_v {
        lines.push(format!(
            "  supply {volts:.1} V, {}",
            temperatures.join(", ")
        ));
    }
    lines.join("\n")
}
