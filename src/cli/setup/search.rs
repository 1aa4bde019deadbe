//! Which ports the laser and the pan-tilt are on.

use crate::cli::failure::Failure;
use crate::config::Settings;
use crate::devices::{
    Cancel, DeviceError, HeadReport, LaserReport, PortReport, Station, inventory,
};
use link::Clock;
use std::sync::mpsc;

/// Both devices, and the settings with their ports.
pub(super) struct FoundDevices {
    pub settings: Settings,
    pub laser: LaserReport,
    pub head: HeadReport,
}

/// What a port may be.
struct Candidates {
    /// As configured, then the other one's, then those that nobody names and nobody has open.
    laser: Vec<String>,
    head: Vec<String>,
}

impl Candidates {
    fn new(settings: &Settings, ports: &[PortReport]) -> Self {
        let (laser, head) = (settings.laser.port.clone(), settings.ptu.port.clone());
        let free = ports
            .iter()
            .filter(|port| port.held_by.is_empty() && port.configured_as.is_empty());
        let free: Vec<String> = free.map(|port| port.path.clone()).collect();
        let with_free = |configured: [&String; 2]| {
            let ports = configured.into_iter().chain(&free);
            ports.cloned().collect()
        };
        Self {
            laser: with_free([&laser, &head]),
            head: with_free([&head, &laser]),
        }
    }

    /// The next pair to try; a device that is found keeps its port.
    fn next(&mut self, laser: Option<&str>, head: Option<&str>) -> Option<[String; 2]> {
        if let Some(port) = laser {
            self.laser = vec![port.to_owned()];
        }
        if let Some(port) = head {
            self.head = vec![port.to_owned()];
        }
        let wanted = self.laser.first()?.clone();
        let Some(at) = self.head.iter().position(|port| *port != wanted) else {
            // No port is left for the pan-tilt beside this one.
            if laser.is_some() {
                return None;
            }
            self.laser.remove(0);
            return self.next(laser, head);
        };
        let other = self.head[at].clone();
        if laser.is_none() {
            self.laser.remove(0);
        }
        if head.is_none() {
            self.head.remove(at);
        }
        Some([wanted, other])
    }
}

/// Asks the configured ports, then those exchanged, then the other serial ports, until both devices have answered.
///
/// # Errors
/// A device that answers nowhere, with what its configured port said.
pub(super) fn find(
    configured: &Settings,
    clock: &Clock,
    cancel: &Cancel,
) -> Result<FoundDevices, Failure> {
    let ports = inventory(configured).unwrap_or_default();
    let mut candidates = Candidates::new(configured, &ports);
    let mut settings = configured.clone();
    let (mut laser, mut head) = (None, None);
    let mut first_errors: [Option<DeviceError>; 2] = [None, None];
    loop {
        let found = |port: &String, is_found: bool| is_found.then(|| port.clone());
        let laser_port = found(&settings.laser.port, laser.is_some());
        let head_port = found(&settings.ptu.port, head.is_some());
        let Some([laser_port, head_port]) =
            candidates.next(laser_port.as_deref(), head_port.as_deref())
        else {
            break;
        };
        (settings.laser.port, settings.ptu.port) = (laser_port, head_port);
        let (notes, _) = mpsc::channel();
        let survey =
            Station::survey(&settings, clock.clone(), notes, cancel).map_err(Failure::failed)?;
        match survey.laser {
            Ok(report) => laser = Some(report),
            Err(error) => drop(first_errors[0].get_or_insert(error)),
        }
        match survey.ptu {
            Ok(report) => head = Some(report),
            Err(error) => drop(first_errors[1].get_or_insert(error)),
        }
        if laser.is_some() && head.is_some() {
            break;
        }
    }
    match (laser, head) {
        (Some(laser), Some(head)) => {
            settings.laser.port = identity(&settings.laser.port, configured, &ports);
            settings.ptu.port = identity(&settings.ptu.port, configured, &ports);
            Ok(FoundDevices {
                settings,
                laser,
                head,
            })
        }
        (laser, head) => {
            let missing = [laser.is_none(), head.is_none()];
            let errors = first_errors.into_iter().zip(missing);
            let lines: Vec<String> = errors
                .filter(|(_, is_missing)| *is_missing)
                .filter_map(|(error, _)| Some(error?.to_string()))
                .collect();
            Err(Failure::Failed(lines.join("\n")))
        }
    }
}

/// The name that stays where plugs change their order: the USB identity of the port, else what was configured, else its path.
fn identity(port: &str, configured: &Settings, ports: &[PortReport]) -> String {
    let is_configured = [&configured.laser.port, &configured.ptu.port].contains(&&port.to_owned());
    let report = ports.iter().find(|report| report.path == port);
    match report.and_then(|report| report.usb.clone()) {
        Some(usb) if !is_configured => usb,
        _ => port.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Candidates, identity};
    use crate::config::Settings;
    use crate::devices::PortReport;

    fn port(path: &str, usb: Option<&str>, held: bool) -> PortReport {
        PortReport {
            path: path.to_owned(),
            usb: usb.map(str::to_owned),
            product: None,
            held_by: if held {
                vec!["minicom".to_owned()]
            } else {
                Vec::new()
            },
            configured_as: Vec::new(),
        }
    }

    fn settings() -> Settings {
        let mut settings = Settings::defaults();
        settings.laser.port = "L".to_owned();
        settings.ptu.port = "P".to_owned();
        settings
    }

    #[test]
    fn configured_ports_come_first_then_exchanged_then_free_ones() {
        let ports = [
            port("A", None, false),
            port("B", None, true),
            port("C", None, false),
        ];
        let mut candidates = Candidates::new(&settings(), &ports);
        let mut pairs = Vec::new();
        while let Some([laser, head]) = candidates.next(None, None) {
            pairs.push(format!("{laser}{head}"));
        }
        assert_eq!(pairs, ["LP", "PL", "AC", "CA"]);
        // A laser that is found stays; the pan-tilt is looked for at each other port.
        let mut candidates = Candidates::new(&settings(), &ports);
        candidates.next(None, None);
        let mut heads = Vec::new();
        while let Some([laser, head]) = candidates.next(Some("L"), None) {
            assert_eq!(laser, "L");
            heads.push(head);
        }
        assert_eq!(heads, ["A", "C"]);
    }

    #[test]
    fn a_port_is_named_by_what_stays() {
        let ports = [
            port("/dev/ttyUSB0", Some("usb:0403:6001:A1"), false),
            port("/dev/ttyS0", None, false),
        ];
        let name = |of| identity(of, &settings(), &ports);
        assert_eq!(name("/dev/ttyUSB0"), "usb:0403:6001:A1");
        assert_eq!(name("/dev/ttyS0"), "/dev/ttyS0");
        assert_eq!(name("L"), "L");
    }
}
