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
            // It names the device.
            Err(error) => error.to_string(),
        })?;
        output::line(match &ptu {
            Ok(report) => head_text(report),
            Err(error) => error.to_string(),
        })?;
        for note in &survey.sweep_notes {
            output::line(format!("sweep: {note}"))?;
        }
        if let Some(text) = ports_text(&ports, [&settings.laser.port, &settings.ptu.port]) {
            output::line(text)?;
        }
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

/// The serial ports. That there is none matters only where a device is on one.
fn ports_text(ports: &[PortReport], configured: [&str; 2]) -> Option<String> {
    if ports.is_empty() {
        let is_serial = |name: &&str| !name.starts_with("tcp:");
        let wants_one = configured.iter().any(is_serial);
        return wants_one.then(|| "ports: no serial port with a device found".to_owned());
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
    Some(format!(
        "ports:{}",
        ports.iter().map(line).collect::<String>()
    ))
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

#[cfg(test)]
mod tests {
    use super::ports_text;
    use crate::devices::PortReport;

    #[test]
    fn no_serial_port_is_said_only_where_a_device_is_on_one() {
        let (laser, head) = ("tcp:10.0.0.2:10940", "tcp:10.0.0.3:4001");
        assert_eq!(ports_text(&[], [laser, head]), None);
        for serial in [[laser, "/dev/ttyUSB0"], ["usb:15d1:0000", head]] {
            assert!(ports_text(&[], serial).is_some_and(|text| text.contains("no serial port")));
        }
        let free = PortReport {
            path: "/dev/ttyS0".to_owned(),
            usb: None,
            product: None,
            held_by: Vec::new(),
            configured_as: Vec::new(),
        };
        let listed = ports_text(&[free], [laser, head]).expect("listed");
        assert_eq!(listed, "ports:\n  /dev/ttyS0: not on USB");
    }
}
