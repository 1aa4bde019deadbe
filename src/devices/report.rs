//! Identity and health of both devices, for `patrold devices` and the status.

use super::constants::BITS_PER_BYTE;
use super::error::DeviceError;
use ptu::{AxisIdentity, HeadIdentity, Health};
use scip::LaserIdentity;
use serde::Serialize;

/// The laser, as it reports itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LaserReport {
    /// Port it answers on.
    pub port: String,
    /// Model.
    pub model: String,
    /// Manufacturer.
    pub vendor: String,
    /// Product line.
    pub product: String,
    /// Serial number.
    pub serial: String,
    /// Firmware version.
    pub firmware: String,
    /// Protocol version.
    pub protocol: String,
    /// Smallest and largest distance, millimetres.
    pub range_mm: [u32; 2],
    /// First and last azimuth it measures, degrees, left positive.
    pub azimuth_deg: [f64; 2],
    /// Beams of a scan.
    pub beams: u32,
    /// Scans per second, nominal.
    pub scans_per_s: f64,
    /// Self-diagnosis.
    pub status: String,
    /// Bit rate of its line; `None`: USB or network.
    pub line_bit_s: Option<u32>,
}

impl LaserReport {
    /// From the identity read at connecting.
    pub fn new(port: &str, identity: &LaserIdentity) -> Self {
        let p = &identity.parameters;
        let degrees = |step: u32| p.angle_rad(f64::from(step)).to_degrees();
        Self {
            port: port.to_owned(),
            model: identity.model.clone(),
            vendor: identity.vendor.clone(),
            product: identity.product.clone(),
            serial: identity.serial.clone(),
            firmware: identity.firmware.clone(),
            protocol: identity.protocol.clone(),
            range_mm: [p.dmin_mm, p.dmax_mm],
            azimuth_deg: [degrees(p.amin), degrees(p.amax)],
            beams: p.amax.saturating_sub(p.amin) + 1,
            scans_per_s: f64::from(p.scan_rpm) / 60.0,
            status: identity.status.clone(),
            line_bit_s: identity.line_bytes_s.map(|bytes_s| bytes_s * BITS_PER_BYTE),
        }
    }
}

/// One axis of the head.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisReport {
    /// Smallest and largest position, counts.
    pub limits_steps: [i32; 2],
    /// The same in degrees, without sign and zero of the configuration.
    pub limits_deg: [f64; 2],
    /// One count, degrees.
    pub step_deg: f64,
    /// Smallest and largest speed, degrees per second.
    pub speed_deg_s: [f64; 2],
    /// Speed up to which no ramp is needed, degrees per second.
    pub base_speed_deg_s: f64,
}

impl AxisReport {
    fn new(axis: &AxisIdentity) -> Self {
        let step_deg = axis.step.radians().to_degrees();
        let degrees = |steps: i32| f64::from(steps) * step_deg;
        Self {
            limits_steps: [axis.limits.min_steps, axis.limits.max_steps],
            limits_deg: [
                degrees(axis.limits.min_steps),
                degrees(axis.limits.max_steps),
            ],
            step_deg,
            speed_deg_s: [degrees(axis.speed_min), degrees(axis.speed_max)],
            base_speed_deg_s: degrees(axis.base_speed),
        }
    }
}

/// The head, as it reports itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeadReport {
    /// Port it answers on.
    pub port: String,
    /// Firmware text, with model and year.
    pub firmware: String,
    /// Pan.
    pub pan: AxisReport,
    /// Tilt.
    pub tilt: AxisReport,
    /// Supply, volts; `None`: the unit does not report it.
    pub supply_v: Option<f64>,
    /// Temperatures, degrees Celsius: controller, on later models pan and tilt.
    pub temperatures_c: Vec<f64>,
    /// Whether its counts correspond to angles.
    pub position_trusted: bool,
}

impl HeadReport {
    /// From the identity read at connecting, and its health now.
    pub fn new(
        port: &str,
        identity: &HeadIdentity,
        health: Option<&Health>,
        trusted: bool,
    ) -> Self {
        let health = health.or(identity.health.as_ref());
        Self {
            port: port.to_owned(),
            firmware: identity.version.clone(),
            pan: AxisReport::new(&identity.pan),
            tilt: AxisReport::new(&identity.tilt),
            supply_v: health.map(|h| h.supply_volts),
            temperatures_c: health.map(|h| h.temperatures_c.clone()).unwrap_or_default(),
            position_trusted: trusted,
        }
    }
}

/// The device on each port, or its error: the failure of one does not hide the other.
#[derive(Debug)]
pub struct DeviceSurvey {
    /// The laser.
    pub laser: Result<LaserReport, DeviceError>,
    /// The head.
    pub ptu: Result<HeadReport, DeviceError>,
    /// How a sweep differs from the configured one, one line each; none if a device failed.
    pub sweep_notes: Vec<String>,
}

/// Both devices.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DevicesReport {
    /// The laser.
    pub laser: LaserReport,
    /// The head.
    pub ptu: HeadReport,
}
