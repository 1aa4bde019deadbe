//! The serial ports of this machine: what sits behind them, who has them open, and whether one of them is a device's.

use super::error::PortError;
use super::port_name::{PortName, ports};
use crate::config::Settings;
use link::Candidate;
use serde::Serialize;

/// One serial port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PortReport {
    /// Its node.
    pub path: String,
    /// The device or adapter behind it, where that is on USB, by the fullest name that `laser.port` and `ptu.port` take.
    pub usb: Option<String>,
    /// What that calls itself.
    pub product: Option<String>,
    /// Programs that have it open, as far as this user may know.
    pub held_by: Vec<String>,
    /// The keys of the configuration that mean it.
    pub configured_as: Vec<&'static str>,
}

/// All of them, by path; asks nothing of the devices.
///
/// # Errors
/// [`PortError`] where the system does not tell.
pub fn inventory(settings: &Settings) -> Result<Vec<PortReport>, PortError> {
    let found = link::candidates()?;
    let (laser, head) = ports(settings);
    Ok(told(&found, &[laser, head], link::holders))
}

fn told(
    candidates: &[Candidate],
    names: &[PortName],
    holders: impl Fn(&str) -> Vec<String>,
) -> Vec<PortReport> {
    let report = |candidate: &Candidate| PortReport {
        path: candidate.path.clone(),
        usb: candidate.usb.as_ref().map(|usb| usb.id().to_string()),
        product: candidate.usb.as_ref().and_then(|usb| usb.name.clone()),
        held_by: holders(&candidate.path),
        configured_as: names
            .iter()
            .filter(|name| name.means(candidate))
            .map(|name| name.device.port_key())
            .collect(),
    };
    candidates.iter().map(report).collect()
}

#[cfg(test)]
mod tests {
    use super::told;
    use crate::config::Settings;
    use crate::devices::port_name::ports;
    use link::{Candidate, UsbDevice};

    #[test]
    fn every_port_says_what_it_is_who_has_it_and_whose_it_is() {
        let adapter = |path: &str, serial: &str| Candidate {
            path: path.to_owned(),
            usb: Some(UsbDevice {
                vendor: 0x0403,
                product: 0x6001,
                serial: Some(serial.to_owned()),
                name: Some("FT232R USB UART".to_owned()),
            }),
        };
        let board = Candidate {
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
        let (laser, head) = ports(&settings);
        let holders = |path: &str| match path {
            "/dev/ttyUSB0" => vec!["ModemManager (pid 7)".to_owned()],
            _ => Vec::new(),
        };
        let all = told(&there, &[laser, head], holders);
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
