//! The serial ports of this machine: what is connected, who has them open, and which are configured.

use super::error::PortError;
use super::port_config::{PortConfig, configured_ports};
use crate::config::Settings;
use link::DetectedPort;
use serde::Serialize;

/// One serial port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PortReport {
    /// Device node.
    pub path: String,
    /// USB device or adapter, as the fullest name that `laser.port` and `ptu.port` accept.
    pub usb: Option<String>,
    /// USB product name.
    pub product: Option<String>,
    /// Programs that have it open, as far as this user may see.
    pub held_by: Vec<String>,
    /// Configuration keys that name it.
    pub configured_as: Vec<&'static str>,
}

/// All serial ports, by path. Sends nothing to the devices.
///
/// # Errors
/// The system does not list them.
pub fn inventory(settings: &Settings) -> Result<Vec<PortReport>, PortError> {
    let found = link::detect_ports()?;
    let (laser, head) = configured_ports(settings);
    Ok(port_reports(&found, &[laser, head], link::holders))
}

fn port_reports(
    candidates: &[DetectedPort],
    names: &[PortConfig],
    holders: impl Fn(&str) -> Vec<String>,
) -> Vec<PortReport> {
    let report = |candidate: &DetectedPort| PortReport {
        path: candidate.path.clone(),
        usb: candidate.usb.as_ref().map(|usb| usb.id().to_string()),
        product: candidate.usb.as_ref().and_then(|usb| usb.name.clone()),
        held_by: holders(&candidate.path),
        configured_as: names
            .iter()
            .filter(|name| name.matches(candidate))
            .map(|name| name.device.port_key())
            .collect(),
    };
    candidates.iter().map(report).collect()
}

#[cfg(test)]
mod tests {
    use super::port_reports;
    use crate::config::Settings;
    use crate::devices::port_config::configured_ports;
    use link::{DetectedPort, UsbDevice};

    #[test]
    fn each_port_is_listed_with_device_holders_and_configuration_key() {
        let adapter = |path: &str, serial: &str| DetectedPort {
            path: path.to_owned(),
            usb: Some(UsbDevice {
                vendor: 0x0403,
                product: 0x6001,
                serial: Some(serial.to_owned()),
                name: Some("FT232R USB UART".to_owned()),
            }),
        };
        let board = DetectedPort {
            path: "/dev/ttyS0".to_owned(),
            usb: None,
        };
        let there = [
            board,
            adapter("/dev/ttyUSB0", "A1"),
            adapter("/dev/ttyUSB1", "A2"),
        ];
        let mut settings = Settings::defaults();
        settings.laser.port = "/dev/ttyS0".to_owned();
        settings.ptu.port = "usb:0403:6001:A2".to_owned();
        let (laser, head) = configured_ports(&settings);
        let holders = |path: &str| match path {
            "/dev/ttyUSB0" => vec!["ModemManager (pid 7)".to_owned()],
            _ => Vec::new(),
        };
        let all = port_reports(&there, &[laser, head], holders);
        let keys: Vec<&[&str]> = all
            .iter()
            .map(|port| port.configured_as.as_slice())
            .collect();
        assert_eq!(keys, [&["laser.port"][..], &[], &["ptu.port"]]);
        assert_eq!((&all[0].usb, &all[0].product), (&None, &None));
        assert_eq!(all[1].usb.as_deref(), Some("usb:0403:6001:A1"));
        assert_eq!(all[1].held_by, ["ModemManager (pid 7)"]);
        assert!(all[2].held_by.is_empty());
    }
}
