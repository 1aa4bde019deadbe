//! `patrold devices`: who answers on the ports, and how they are.

use super::failure::{DONE, FAILED, Outcome};
use super::{config, output, signals};
use crate::devices::{
    AxisReport, DeviceError, HeadReport, LaserReport, PortReport, Station, inventory,
};
use clap::Args;
use link::Clock;
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;
use std::sync::mpsc;

/// Arguments of `devices`.
#[derive(Debug, Args)]
pub struct DevicesArgs {
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Seconds of the devices per second of the wall, for emulated devices that run at X times the wall's pace
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = super::emulate::scale)]
    time_scale: f64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// Runs `devices`. One that does not answer is told in its place; then the command has failed.
pub fn run(args: &DevicesArgs) -> Outcome {
    let settings = config::settings(args.config.as_deref())?;
    // Before the ports are opened: afterwards this program would be among those that have them.
    let ports = inventory(&settings).unwrap_or_else(|error| {
        eprintln!("patrold: ports are not listed: {error}");
        Vec::new()
    });
    let (notes, _) = mpsc::channel();
    let cancel = signals::cancel_on_signal()?;
    let (laser, ptu) = Station::survey(&settings, Clock::scaled(args.time_scale), notes, &cancel)
        .map_err(super::failure::Failure::failed)?;
    if args.json {
        output::json(&json!({
            "laser": answer(&laser, &settings.laser.port),
            "ptu": answer(&ptu, &settings.ptu.port),
            "ports": ports,
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
        output::line(ports_text(&ports))?;
    }
    Ok(if laser.is_ok() && ptu.is_ok() {
        DONE
    } else {
        FAILED
    })
}

fn answer(report: &Result<impl Serialize, DeviceError>, port: &str) -> serde_json::Value {
    match report {
        Ok(report) => json!(report),
        Err(error) => json!({"port": port, "error": error.to_string()}),
    }
}

fn ports_text(ports: &[PortReport]) -> String {
    if ports.is_empty() {
        return "ports: no serial port with a device behind it".to_owned();
    }
    let line = |port: &PortReport| {
        let mut said = vec![port.usb.clone().unwrap_or_else(|| "not on USB".to_owned())];
        said.extend(port.product.clone());
        if !port.held_by.is_empty() {
            said.push(format!("in use by {}", port.held_by.join(", ")));
        }
        said.extend(port.configured_as.iter().map(|key| (*key).to_owned()));
        format!("\n  {}: {}", port.path, said.join(", "))
    };
    format!("ports:{}", ports.iter().map(line).collect::<String>())
}

fn laser_text(report: &LaserReport) -> String {
    let [near, far] = report.range_mm;
    let [right, left] = report.azimuth_deg;
    format!(
        "laser: {} on {}\n  serial {}, firmware {}, {}\n  {} beams from {right:.1} to {left:.1} deg, {near} to {far} mm, {} scans/s\n  {}",
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
    let warm: Vec<String> = report
        .temperatures_c
        .iter()
        .map(|c| format!("{c:.0} degC"))
        .collect();
    if let Some(volts) = report.supply_v {
        lines.push(format!("  supply {volts:.1} V, {}", warm.join(", ")));
    }
    lines.join("\n")
}
