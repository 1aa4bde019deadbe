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
            name_by_identity(&mut settings, configured, &ports, link::socket_link);
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
                .chain(not_asked(&ports))
                .collect();
            Err(Failure::Failed(lines.join("\n")))
        }
    }
}

/// The ports that a program has open, and which; `None`: there are none.
fn not_asked(ports: &[PortReport]) -> Option<String> {
    let held = ports.iter().filter(|port| !port.held_by.is_empty());
    let held = held.map(|port| format!("{} ({})", port.path, port.held_by.join(", ")));
    let held: Vec<String> = held.collect();
    (!held.is_empty()).then(|| {
        format!(
            "not asked, as programs have them open: {}; end those where a device is on one of them",
            held.join(", ")
        )
    })
}

/// Gives each port the name that stays where plugs change their order: its USB identity, unless somebody configured the port.
/// Of two lasers of one identity the serial number decides, which is configured too; of two adapters the socket.
fn name_by_identity(
    settings: &mut Settings,
    configured: &Settings,
    ports: &[PortReport],
    socket_link: impl Fn(&str) -> Option<String>,
) {
    let identity = |port: &str| {
        let is_configured = [&configured.laser.port, &configured.ptu.port].map(|name| name == port);
        let found = ports.iter().find(|report| report.path == port);
        found
            .filter(|_| is_configured == [false; 2])
            .and_then(|report| report.usb.clone())
    };
    if let Some(usb) = identity(&settings.laser.port) {
        settings.laser.port = usb;
    }
    if let Some(usb) = identity(&settings.ptu.port) {
        let with_serial = format!("{usb}:");
        let names = ports.iter().filter_map(|report| report.usb.as_ref());
        let matching = names.filter(|other| **other == usb || other.starts_with(&with_serial));
        if matching.count() == 1 {
            settings.ptu.port = usb;
        } else if let Some(link) = socket_link(&settings.ptu.port) {
            settings.ptu.port = link;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Candidates, name_by_identity, not_asked};
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
        let text = not_asked(&ports).expect("B is held");
        assert!(text.contains(": B (minicom); "), "{text}");
        assert_eq!(not_asked(&ports[2..]), None);
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

    /// The names that the ports `laser` and `head` get.
    fn named(laser: &str, head: &str, ports: &[PortReport], links: &[(&str, &str)]) -> [String; 2] {
        let mut found = settings();
        found.laser.port = laser.to_owned();
        found.ptu.port = head.to_owned();
        let link = |node: &str| {
            let link = links.iter().find(|(of, _)| *of == node)?;
            Some(link.1.to_owned())
        };
        name_by_identity(&mut found, &settings(), ports, link);
        [found.laser.port, found.ptu.port]
    }

    #[test]
    fn a_port_is_named_by_what_stays() {
        let ports = [
            port("/dev/ttyACM0", Some("usb:15d1:0000"), false),
            port("/dev/ttyUSB0", Some("usb:0403:6001:A1"), false),
            port("/dev/ttyUSB1", Some("usb:0403:6001:A2"), false),
            port("/dev/ttyS0", None, false),
            port("L", Some("usb:067b:2303"), false),
        ];
        let links = [("/dev/ttyUSB0", "by-path/0"), ("/dev/ttyS0", "by-path/1")];
        let name = |laser, head| named(laser, head, &ports, &links);
        assert_eq!(
            name("/dev/ttyACM0", "/dev/ttyUSB0"),
            ["usb:15d1:0000", "usb:0403:6001:A1"]
        );
        assert_eq!(name("/dev/ttyS0", "P"), ["/dev/ttyS0", "P"]);
        // Somebody has configured it by its path.
        assert_eq!(name("L", "/dev/ttyS0"), ["L", "/dev/ttyS0"]);
    }

    #[test]
    fn of_two_adapters_of_one_identity_the_socket_is_named() {
        let twins = [
            port("/dev/ttyACM0", Some("usb:15d1:0000"), false),
            port("/dev/ttyACM1", Some("usb:15d1:0000"), false),
            port("/dev/ttyUSB0", Some("usb:067b:2303"), false),
            port("/dev/ttyUSB1", Some("usb:067b:2303"), false),
        ];
        let links = [
            ("/dev/ttyUSB0", "by-path/0"),
            ("/dev/ttyUSB1", "by-path/1"),
            ("/dev/ttyACM1", "by-path/2"),
        ];
        let expected = ["usb:15d1:0000", "by-path/1"];
        assert_eq!(
            named("/dev/ttyACM1", "/dev/ttyUSB1", &twins, &links),
            expected
        );
        // Without udev the path is all there is.
        let expected = ["usb:15d1:0000", "/dev/ttyUSB1"];
        assert_eq!(named("/dev/ttyACM1", "/dev/ttyUSB1", &twins, &[]), expected);
        // A name without a serial number is that of one with it, too.
        let mut one_has_a_number = twins.clone();
        one_has_a_number[2].usb = Some("usb:067b:2303:A1".to_owned());
        let name = |head| named("/dev/ttyACM1", head, &one_has_a_number, &links)[1].clone();
        assert_eq!(name("/dev/ttyUSB0"), "usb:067b:2303:A1");
        assert_eq!(name("/dev/ttyUSB1"), "by-path/1");
    }
}
