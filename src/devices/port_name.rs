//! Where a device hangs: the configured name, what kind of line that is, which unit it has to be, and how to open it.

use super::constants::{HOKUYO, LASER_BAUDS, TCP_LIMIT};
use super::error::{Device, DeviceError};
use crate::config::Settings;
use link::{Candidate, Link, LinkError, SerialLink, TcpLink, UsbName};
use std::path::{Path, PathBuf};

/// What carries the bytes; decides whether a line rate means something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// A terminal with a line rate: a UART or an adapter.
    Rs232,
    /// USB of the device's own, or a pseudo-terminal: no rate.
    Unpaced,
    /// TCP.
    Tcp,
}

/// A device's port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortName {
    /// Whose.
    pub device: Device,
    /// As configured: a path, `tcp:HOST:PORT`, or `usb:VVVV:PPPP[:SERIAL]`.
    pub name: String,
    /// The configured line rate, bits per second.
    pub baud: u32,
    /// The unit it has to be, by its own words: a laser's serial number, a part of a head's version. `None`: any.
    pub unit: Option<String>,
}

/// One way to open a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Try {
    /// A path, or `tcp:HOST:PORT`.
    pub node: String,
    /// Line rate, bits per second.
    pub baud: u32,
}

impl Try {
    /// Opens it.
    ///
    /// # Errors
    /// [`DeviceError::Port`], with what to do.
    pub fn open(&self, device: Device) -> Result<Box<dyn Link>, DeviceError> {
        let link: Result<Box<dyn Link>, LinkError> = match self.node.strip_prefix("tcp:") {
            Some(address) => TcpLink::connect(address, TCP_LIMIT).map(|l| Box::new(l) as _),
            None => SerialLink::open(&self.node, self.baud).map(|l| Box::new(l) as _),
        };
        link.map_err(|error| DeviceError::Port {
            device,
            source: error.into(),
        })
    }
}

impl PortName {
    /// Whether this port of the machine is meant by it.
    pub fn means(&self, candidate: &Candidate) -> bool {
        match self.name.parse::<UsbName>() {
            Ok(name) => name.fits(candidate),
            Err(_) => node_of(&self.name) == node_of(&candidate.path),
        }
    }

    /// What kind of line it is at this moment.
    pub fn line(&self) -> Line {
        let Ok(name) = self.name.parse::<UsbName>() else {
            return line_of(&self.name);
        };
        let found = link::candidates().unwrap_or_default();
        // All that go by one USB name are of one kind.
        match found.iter().find(|candidate| name.fits(candidate)) {
            Some(candidate) => line_of(&candidate.path),
            None if name.vendor() == HOKUYO => Line::Unpaced,
            None => Line::Rs232,
        }
    }

    /// All ways to open it, at this moment, in the order in which to try them: the nodes that may be meant, each with the
    /// configured rate first, and with that alone where a rate means nothing.
    ///
    /// # Errors
    /// [`DeviceError::Port`] where a name by identity fits nothing, or several of which nothing tells which.
    pub fn tries(&self) -> Result<Vec<Try>, DeviceError> {
        let nodes = self.nodes_now().map_err(|error| DeviceError::Port {
            device: self.device,
            source: error.into(),
        })?;
        let of_node = |node: String| {
            let bauds = self.bauds(line_of(&node)).into_iter();
            bauds.map(move |baud| Try {
                node: node.clone(),
                baud,
            })
        };
        Ok(nodes.into_iter().flat_map(of_node).collect())
    }

    fn bauds(&self, line: Line) -> Vec<u32> {
        let others: &[u32] = match (line, self.device) {
            (Line::Rs232, Device::Laser) => &LASER_BAUDS,
            (Line::Rs232, Device::Head) => &ptu::BAUD_RATES,
            _ => &[],
        };
        let mut bauds = vec![self.baud];
        bauds.extend(others.iter().filter(|b| **b != self.baud));
        bauds
    }

    fn nodes_now(&self) -> Result<Vec<String>, LinkError> {
        if !UsbName::is_meant(&self.name) {
            return Ok(vec![self.name.clone()]);
        }
        let nodes = self.nodes(&link::candidates()?)?;
        if self.unit.is_some() {
            self.free(nodes, link::holders)
        } else {
            Ok(nodes)
        }
    }

    /// Those of `nodes` that nobody has open: a device that is only asked whether it is the one wanted may be another
    /// program's, which need not have locked it.
    fn free(
        &self,
        nodes: Vec<String>,
        holders: impl Fn(&str) -> Vec<String>,
    ) -> Result<Vec<String>, LinkError> {
        let mut by = Vec::new();
        let mut is_free = |node: &String| {
            let holders = holders(node);
            let free = holders.is_empty();
            by.extend(holders);
            free
        };
        let free: Vec<String> = nodes.into_iter().filter(|node| is_free(node)).collect();
        if free.is_empty() {
            return Err(LinkError::Busy {
                name: self.name.clone(),
                by: by.join(", "),
            });
        }
        Ok(free)
    }

    /// Which of `candidates` the name may mean. Where several lasers go by it, each is asked for its serial number, if
    /// one is wanted; an adapter is anybody's, and what hangs on another one is not to hear commands of a pan-tilt.
    fn nodes(&self, candidates: &[Candidate]) -> Result<Vec<String>, LinkError> {
        let name: UsbName = self.name.parse().map_err(|error| LinkError::Io {
            name: self.name.clone(),
            source: std::io::Error::new(std::io::ErrorKind::InvalidInput, error),
        })?;
        match name.only(candidates) {
            Ok(candidate) => Ok(vec![candidate.path.clone()]),
            Err(LinkError::Several { .. }) if self.may_ask(&name) => {
                let fitting = candidates.iter().filter(|c| name.fits(c));
                Ok(fitting.map(|c| c.path.clone()).collect())
            }
            Err(error) => Err(error),
        }
    }

    fn may_ask(&self, name: &UsbName) -> bool {
        self.device == Device::Laser && self.unit.is_some() && name.vendor() == HOKUYO
    }

    /// Why a unit that says `told` of itself (laser: serial number; head: version) is not the one wanted, if it is not.
    pub fn other_unit(&self, told: &str) -> Option<DeviceError> {
        let wanted = self.unit.as_deref()?;
        let is_it = match self.device {
            Device::Laser => plain_serial(told) == plain_serial(wanted),
            Device::Head => told.contains(wanted),
        };
        (!is_it).then(|| DeviceError::OtherUnit {
            device: self.device,
            port: self.name.clone(),
            key: self.device.unit_key(),
            expected: wanted.to_owned(),
            got: told.to_owned(),
        })
    }
}

/// Both ports of the configuration.
pub fn ports(settings: &Settings) -> (PortName, PortName) {
    let (laser, head) = (&settings.laser, &settings.ptu);
    let port = |device, name: &String, baud, unit: &Option<String>| PortName {
        device,
        name: name.clone(),
        baud,
        unit: unit.clone(),
    };
    (
        port(Device::Laser, &laser.port, laser.baud, &laser.serial),
        port(Device::Head, &head.port, head.baud, &head.version),
    )
}

/// By the node the path leads to at this moment: `ttyACM*` is the USB of the device itself, `/dev/pts/*` a pseudo-terminal,
/// anything else a serial line.
fn line_of(name: &str) -> Line {
    if name.starts_with("tcp:") {
        return Line::Tcp;
    }
    let node = node_of(name);
    let node = node.to_string_lossy();
    if node.starts_with("/dev/pts/") || node.starts_with("/dev/ttyACM") {
        Line::Unpaced
    } else {
        Line::Rs232
    }
}

/// Where a path leads to at this moment.
fn node_of(path: &str) -> PathBuf {
    let path = Path::new(path);
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Old units print `0` in place of the first letter (scip2 section 13).
fn plain_serial(serial: &str) -> String {
    let serial = serial.trim().to_ascii_uppercase();
    match serial.strip_prefix('H') {
        Some(rest) => format!("0{rest}"),
        None => serial,
    }
}

#[cfg(test)]
mod tests {
    use super::{Device, Line, PortName};
    use crate::devices::error::{DeviceError, PortError};
    use link::{Candidate, LinkError, UsbDevice};

    fn port(device: Device, name: &str) -> PortName {
        PortName {
            device,
            name: name.to_owned(),
            baud: 9600,
            unit: None,
        }
    }

    fn bauds(port: &PortName) -> Vec<u32> {
        let tries = port.tries().expect("a path is tried");
        tries.into_iter().map(|this| this.baud).collect()
    }

    /// Two lasers of one make and two adapters of one make.
    fn robot() -> Vec<Candidate> {
        let on_usb = |(path, vendor, product): (&str, u16, u16)| Candidate {
            path: path.to_owned(),
            usb: Some(UsbDevice {
                vendor,
                product,
                serial: None,
                name: None,
            }),
        };
        [
            ("/dev/ttyACM0", 0x15d1, 0x0000),
            ("/dev/ttyACM1", 0x15d1, 0x0000),
            ("/dev/ttyUSB0", 0x067b, 0x2303),
            ("/dev/ttyUSB1", 0x067b, 0x2303),
        ]
        .map(on_usb)
        .into()
    }

    #[test]
    fn several_lasers_are_asked_for_the_one_wanted_and_adapters_never() {
        let mut laser = port(Device::Laser, "usb:15d1:0000");
        let several = |found| matches!(found, Err(LinkError::Several { .. }));
        assert!(several(laser.nodes(&robot())), "which, nothing tells");
        laser.unit = Some("H0706400".to_owned());
        let both = ["/dev/ttyACM0", "/dev/ttyACM1"];
        assert_eq!(laser.nodes(&robot()).expect("both"), both);
        assert_eq!(laser.nodes(&robot()[1..]).expect("one"), both[1..]);
        let mut head = port(Device::Head, "usb:067b:2303");
        head.unit = Some("D46".to_owned());
        assert!(several(head.nodes(&robot())));
        assert_eq!(head.nodes(&robot()[..3]).expect("one"), ["/dev/ttyUSB0"]);
        laser.name = "usb:067b:2303".to_owned();
        assert!(
            several(laser.nodes(&robot())),
            "a laser on one of two adapters"
        );
        laser.name = "usb:15d1".to_owned();
        assert!(matches!(laser.nodes(&robot()), Err(LinkError::Io { .. })));
    }

    #[test]
    fn what_another_program_has_open_is_not_asked_who_it_is() {
        let laser = port(Device::Laser, "usb:15d1:0000");
        let both = || vec!["/dev/ttyACM0".to_owned(), "/dev/ttyACM1".to_owned()];
        let nobody = |_: &str| Vec::new();
        assert_eq!(laser.free(both(), nobody).expect("both"), both());
        let one = |node: &str| match node {
            "/dev/ttyACM0" => vec!["navigator (pid 7)".to_owned()],
            _ => Vec::new(),
        };
        assert_eq!(laser.free(both(), one).expect("one"), both()[1..]);
        let error = laser.free(both()[..1].to_vec(), one).expect_err("held");
        assert!(error.to_string().contains("navigator (pid 7)"), "{error}");
    }

    #[test]
    fn a_unit_is_known_by_its_own_words() {
        let mut laser = port(Device::Laser, "/dev/ttyACM0");
        assert_eq!(laser.other_unit("H0706400"), None, "any will do");
        laser.unit = Some("H0706400".to_owned());
        for (told, is_it) in [
            ("H0706400", true),
            ("00706400", true),
            ("h0706400 ", true),
            ("H0706401", false),
            ("", false),
        ] {
            assert_eq!(laser.other_unit(told).is_none(), is_it, "{told}");
        }
        let text = laser.other_unit("H0900001").map(|e| e.to_string());
        let text = text.unwrap_or_default();
        for part in ["H0900001", "H0706400", "laser.serial", "/dev/ttyACM0"] {
            assert!(text.contains(part), "{text}");
        }
        let mut head = port(Device::Head, "/dev/ttyUSB0");
        head.unit = Some("v2.12".to_owned());
        assert_eq!(
            head.other_unit("Pan-Tilt Controller v2.12.1d1(C14/E)"),
            None
        );
        assert!(head.other_unit("Pan-Tilt Controller v1.09").is_some());
    }

    #[test]
    fn rates_are_searched_only_where_they_mean_something() {
        let laser = port(Device::Laser, "/dev/ttyUSB7");
        assert_eq!(laser.line(), Line::Rs232);
        assert_eq!(bauds(&laser)[..2], [9600, 19_200]);
        let head = bauds(&port(Device::Head, "/dev/ttyS9"));
        assert_eq!(head.iter().filter(|b| **b == 9600).count(), 1);
        assert_eq!(bauds(&port(Device::Laser, "/dev/ttyACM0")), [9600]);
        assert_eq!(port(Device::Laser, "tcp:host:1").line(), Line::Tcp);
    }

    #[test]
    fn a_missing_port_says_its_name_and_key() {
        let head = port(Device::Head, "/dev/no-such-port");
        let tries = head.tries().expect("a path is tried");
        let error = tries[0].open(head.device).err();
        let Some(DeviceError::Port { source, .. }) = &error else {
            panic!("{error:?}");
        };
        assert!(matches!(source, PortError::NoSuchPort(_)));
        let text = error.map(|e| e.to_string()).unwrap_or_default();
        assert!(
            text.contains("/dev/no-such-port") && text.contains("ptu.port"),
            "{text}"
        );
    }
}
