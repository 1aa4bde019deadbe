//! The configured port of a device: its name, its kind of line, the unit it must be, and the ways to open it.

use super::constants::{HEAD_POWER_UP_BAUD, HOKUYO_VENDOR, LASER_BAUDS, TCP_LIMIT};
use super::error::{Device, DeviceError};
use crate::config::{SettingOrigins, Settings};
use link::{DetectedPort, Link, LinkError, SerialLink, TcpLink, UsbName};
use std::path::{Path, PathBuf};

/// Kind of a line; decides whether a line rate applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LineKind {
    /// UART or USB adapter, with a line rate.
    Rs232,
    /// Of an emulated device, with a line rate or without.
    PseudoTerminal,
    /// Native USB, without a line rate.
    Usb,
    Tcp,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PortConfig {
    pub device: Device,
    /// As configured: a path, `tcp:HOST:PORT`, or `usb:VVVV:PPPP[:SERIAL]`.
    pub name: String,
    /// The configured line rate, bits per second.
    pub baud: u32,
    /// Required unit: serial number of a laser, part of the version string of a head. `None`: any.
    pub unit: Option<String>,
    /// Where name and unit were set.
    pub origins: SettingOrigins,
}

/// One way to open a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct OpenAttempt {
    /// A path, or `tcp:HOST:PORT`.
    pub node: String,
    /// Line rate, bits per second.
    pub baud: u32,
    /// Not the device's: tried only where the others brought garbage, to see what is there instead.
    pub is_of_other_device: bool,
}

impl OpenAttempt {
    /// Lets `attempts` begin with the last good one, if it is among them; the rest follows in its order, round and round.
    pub(super) fn begin_with(attempts: &mut [Self], last_good: Option<&Self>) {
        let at = attempts
            .iter()
            .position(|attempt| Some(attempt) == last_good);
        attempts.rotate_left(at.unwrap_or(0));
    }

    /// # Errors
    /// As the transport.
    pub(super) fn open(&self) -> Result<Box<dyn Link>, LinkError> {
        match self.node.strip_prefix("tcp:") {
            Some(address) => TcpLink::connect(address, TCP_LIMIT).map(|l| Box::new(l) as _),
            None => SerialLink::open(&self.node, self.baud).map(|l| Box::new(l) as _),
        }
    }
}

impl PortConfig {
    /// The key of the port for an error, and where it was set.
    pub(super) fn setting(&self) -> String {
        self.origins.quote(self.device.port_key())
    }

    /// The error of its transport.
    pub(super) fn error(&self, error: LinkError) -> DeviceError {
        DeviceError::Port {
            device: self.device,
            setting: self.setting(),
            source: error.into(),
        }
    }

    /// Whether `candidate` is this port.
    pub(super) fn matches(&self, candidate: &DetectedPort) -> bool {
        match self.name.parse::<UsbName>() {
            Ok(name) => name.matches(candidate),
            Err(_) => resolve_node(&self.name) == resolve_node(&candidate.path),
        }
    }

    /// The kind of line at this moment.
    pub(super) fn line_kind(&self) -> LineKind {
        let Ok(name) = self.name.parse::<UsbName>() else {
            return node_line_kind(&self.name);
        };
        let found = link::detect_ports().unwrap_or_default();
        // All matches of one USB name are of one kind.
        match found.iter().find(|candidate| name.matches(candidate)) {
            Some(candidate) => node_line_kind(&candidate.path),
            None if name.vendor() == HOKUYO_VENDOR => LineKind::Usb,
            None => LineKind::Rs232,
        }
    }

    /// Whether the error of one line rate makes the others worth trying. On a pseudo-terminal a silent head does not: most
    /// emulated ones have the rate of the configuration, and each try takes seconds.
    pub(super) fn tries_other_rates(&self, error: &DeviceError) -> bool {
        match error {
            DeviceError::OtherUnit { .. } | DeviceError::Port { .. } => false,
            DeviceError::WrongDevice { readable, .. } => !readable,
            DeviceError::Silent { .. } => {
                self.device == Device::Laser || self.line_kind() != LineKind::PseudoTerminal
            }
            _ => true,
        }
    }

    /// All ways to open the port at this moment, in the order to try: the matching nodes, each with the configured line rate
    /// first, and only with that where line rates do not apply.
    ///
    /// # Errors
    /// [`DeviceError::Port`] where a `usb:` name matches nothing, or several ports that cannot be told apart.
    pub(super) fn attempts(&self) -> Result<Vec<OpenAttempt>, DeviceError> {
        let nodes = self.current_nodes().map_err(|error| self.error(error))?;
        let attempts_at = |node: String| {
            let line = node_line_kind(&node);
            // A pan-tilt on the laser's port is recognised at its own rate alone.
            let foreign = has_rate(line) && self.device == Device::Laser;
            let foreign = foreign.then_some(HEAD_POWER_UP_BAUD);
            let bauds = self.bauds(line);
            let foreign = foreign.filter(|baud| !bauds.contains(baud));
            let own = bauds.into_iter().map(|baud| (baud, false));
            own.chain(foreign.map(|baud| (baud, true)))
                .map(move |(baud, is_of_other_device)| OpenAttempt {
                    node: node.clone(),
                    baud,
                    is_of_other_device,
                })
        };
        Ok(nodes.into_iter().flat_map(attempts_at).collect())
    }

    fn bauds(&self, line: LineKind) -> Vec<u32> {
        let others: &[u32] = match self.device {
            _ if !has_rate(line) => &[],
            Device::Laser => &LASER_BAUDS,
            Device::Head => &ptu::BAUD_RATES,
        };
        let mut bauds = vec![self.baud];
        bauds.extend(others.iter().filter(|b| **b != self.baud));
        bauds
    }

    fn current_nodes(&self) -> Result<Vec<String>, LinkError> {
        if !UsbName::has_prefix(&self.name) {
            return Ok(vec![self.name.clone()]);
        }
        let nodes = self.nodes(&link::detect_ports()?)?;
        if self.unit.is_some() {
            self.filter_unheld(nodes, link::holders)
        } else {
            Ok(nodes)
        }
    }

    /// Those of `nodes` that no program has open. A device that is only probed may belong to another program, which need
    /// not have locked it.
    fn filter_unheld(
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

    /// The nodes of `candidates` that the name matches. Several lasers are allowed if their serial numbers decide; several
    /// adapters are not, because an unknown device must not receive pan-tilt commands.
    fn nodes(&self, candidates: &[DetectedPort]) -> Result<Vec<String>, LinkError> {
        let name: UsbName = self.name.parse().map_err(|error| LinkError::Io {
            name: self.name.clone(),
            source: std::io::Error::new(std::io::ErrorKind::InvalidInput, error),
        })?;
        match name.find_in(candidates) {
            Ok(candidate) => Ok(vec![candidate.path.clone()]),
            Err(LinkError::Ambiguous { .. }) if self.may_probe(&name) => {
                let fitting = candidates.iter().filter(|c| name.matches(c));
                Ok(fitting.map(|c| c.path.clone()).collect())
            }
            Err(error) => Err(error),
        }
    }

    fn may_probe(&self, name: &UsbName) -> bool {
        self.device == Device::Laser && self.unit.is_some() && name.vendor() == HOKUYO_VENDOR
    }

    /// The error if a unit that reports `reported` (laser: serial number; head: version) is not the required one.
    pub(super) fn unit_mismatch(&self, reported: &str) -> Option<DeviceError> {
        let wanted = self.unit.as_deref()?;
        let is_it = match self.device {
            Device::Laser => normalized_serial(reported) == normalized_serial(wanted),
            Device::Head => reported.contains(wanted),
        };
        (!is_it).then(|| DeviceError::OtherUnit {
            device: self.device,
            port: self.name.clone(),
            setting: self.origins.quote(self.device.unit_key()),
            expected: wanted.to_owned(),
            got: reported.to_owned(),
        })
    }
}

/// The ports of laser and head.
pub(super) fn configured_ports(settings: &Settings) -> (PortConfig, PortConfig) {
    let (laser, head) = (&settings.laser, &settings.ptu);
    let port = |device, name: &String, baud, unit: &Option<String>| PortConfig {
        device,
        name: name.clone(),
        baud,
        unit: unit.clone(),
        origins: settings.origins.clone(),
    };
    (
        port(Device::Laser, &laser.port, laser.baud, &laser.serial),
        port(Device::Head, &head.port, head.baud, &head.version),
    )
}

/// By the node that the path resolves to: `ttyACM*` is native USB, `/dev/pts/*` a pseudo-terminal, anything else a serial
/// line.
fn node_line_kind(name: &str) -> LineKind {
    if name.starts_with("tcp:") {
        return LineKind::Tcp;
    }
    let node = resolve_node(name);
    let node = node.to_string_lossy();
    if node.starts_with("/dev/pts/") {
        LineKind::PseudoTerminal
    } else if node.starts_with("/dev/ttyACM") {
        LineKind::Usb
    } else {
        LineKind::Rs232
    }
}

/// Whether there may be a line rate.
fn has_rate(line: LineKind) -> bool {
    matches!(line, LineKind::Rs232 | LineKind::PseudoTerminal)
}

fn resolve_node(path: &str) -> PathBuf {
    let path = Path::new(path);
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Old units print `0` instead of the first letter (scip2 section 13).
fn normalized_serial(serial: &str) -> String {
    let serial = serial.trim().to_ascii_uppercase();
    match serial.strip_prefix('H') {
        Some(rest) => format!("0{rest}"),
        None => serial,
    }
}

#[cfg(test)]
mod tests {
    use super::{Device, LineKind, OpenAttempt, PortConfig};
    use crate::config::{ConfigFile, ConfigLayers, SettingOrigins, Settings};
    use crate::devices::error::{DeviceError, PortError};
    use link::{DetectedPort, LinkError, UsbDevice};

    fn port(device: Device, name: &str) -> PortConfig {
        PortConfig {
            device,
            name: name.to_owned(),
            baud: 9600,
            unit: None,
            origins: SettingOrigins::default(),
        }
    }

    fn bauds(port: &PortConfig) -> Vec<u32> {
        let attempts = port.attempts().expect("a path is tried");
        attempts.into_iter().map(|attempt| attempt.baud).collect()
    }

    /// Two lasers of one make and two adapters of one make.
    fn robot() -> Vec<DetectedPort> {
        let on_usb = |(path, vendor, product): (&str, u16, u16)| DetectedPort {
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
    fn several_lasers_are_probed_and_adapters_never() {
        let mut laser = port(Device::Laser, "usb:15d1:0000");
        let several = |found| matches!(found, Err(LinkError::Ambiguous { .. }));
        assert!(several(laser.nodes(&robot())), "nothing decides which");
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
    fn ports_held_by_another_program_are_not_probed() {
        let laser = port(Device::Laser, "usb:15d1:0000");
        let both = || vec!["/dev/ttyACM0".to_owned(), "/dev/ttyACM1".to_owned()];
        let nobody = |_: &str| Vec::new();
        assert_eq!(laser.filter_unheld(both(), nobody).expect("both"), both());
        let one = |node: &str| match node {
            "/dev/ttyACM0" => vec!["navigator (pid 7)".to_owned()],
            _ => Vec::new(),
        };
        assert_eq!(laser.filter_unheld(both(), one).expect("one"), both()[1..]);
        let error = laser
            .filter_unheld(both()[..1].to_vec(), one)
            .expect_err("held");
        assert!(error.to_string().contains("navigator (pid 7)"), "{error}");
    }

    #[test]
    fn a_unit_is_recognized_by_serial_number_or_version() {
        let mut laser = port(Device::Laser, "/dev/ttyACM0");
        assert_eq!(laser.unit_mismatch("H0706400"), None, "any will do");
        laser.unit = Some("H0706400".to_owned());
        for (reported, is_it) in [
            ("H0706400", true),
            ("00706400", true),
            ("h0706400 ", true),
            ("H0706401", false),
            ("", false),
        ] {
            assert_eq!(laser.unit_mismatch(reported).is_none(), is_it, "{reported}");
        }
        let text = laser.unit_mismatch("H0900001").map(|e| e.to_string());
        let text = text.unwrap_or_default();
        for part in ["H0900001", "H0706400", "laser.serial", "/dev/ttyACM0"] {
            assert!(text.contains(part), "{text}");
        }
        let mut head = port(Device::Head, "/dev/ttyUSB0");
        head.unit = Some("v2.12".to_owned());
        assert_eq!(
            head.unit_mismatch("Pan-Tilt Controller v2.12.1d1(C14/E)"),
            None
        );
        assert!(head.unit_mismatch("Pan-Tilt Controller v1.09").is_some());
    }

    #[test]
    fn line_rates_are_searched_only_where_they_apply() {
        let laser = port(Device::Laser, "/dev/ttyUSB7");
        assert_eq!(laser.line_kind(), LineKind::Rs232);
        assert_eq!(bauds(&laser)[..2], [9600, 19_200]);
        let mut laser = laser;
        laser.baud = 57_600;
        let attempts = laser.attempts().expect("a path is tried");
        let last = attempts.last().expect("some");
        assert!(last.is_of_other_device && last.baud == 9600, "{last:?}");
        let foreign = attempts.iter().filter(|attempt| attempt.is_of_other_device);
        assert_eq!((attempts.len(), foreign.count()), (7, 1));
        let head = bauds(&port(Device::Head, "/dev/ttyS9"));
        assert_eq!(head.iter().filter(|b| **b == 9600).count(), 1);
        assert_eq!(bauds(&port(Device::Laser, "/dev/ttyACM0")), [9600]);
        assert_eq!(bauds(&port(Device::Head, "tcp:host:1")), [9600]);
        let terminal = port(Device::Head, "/dev/pts/7");
        assert_eq!(terminal.line_kind(), LineKind::PseudoTerminal);
        assert_eq!(bauds(&terminal), head);
        assert_eq!(port(Device::Laser, "tcp:host:1").line_kind(), LineKind::Tcp);
    }

    #[test]
    fn other_rates_are_tried_where_the_rate_may_be_wrong() {
        let wrong = |device, readable| DeviceError::WrongDevice {
            device,
            port: String::new(),
            setting: String::new(),
            detail: String::new(),
            readable,
        };
        let silent = |device| DeviceError::Silent {
            device,
            port: String::new(),
            setting: String::new(),
            detail: String::new(),
        };
        let fault = DeviceError::Fault {
            device: Device::Head,
            port: String::new(),
            detail: String::new(),
        };
        for (device, node, on_silence) in [
            (Device::Laser, "/dev/ttyUSB7", true),
            (Device::Head, "/dev/ttyUSB7", true),
            (Device::Laser, "/dev/pts/7", true),
            (Device::Head, "/dev/pts/7", false),
        ] {
            let port = port(device, node);
            assert_eq!(
                port.tries_other_rates(&silent(device)),
                on_silence,
                "{node}"
            );
            assert!(port.tries_other_rates(&wrong(device, false)));
            assert!(!port.tries_other_rates(&wrong(device, true)));
            assert!(port.tries_other_rates(&fault));
            let absent = DeviceError::Port {
                device,
                setting: String::new(),
                source: PortError::NoSuchPort(String::new()),
            };
            assert!(!port.tries_other_rates(&absent));
        }
    }

    #[test]
    fn the_error_of_a_missing_port_has_its_name_and_the_file_that_set_it() {
        let mut layers = ConfigLayers::defaults();
        for (path, port) in [
            ("by-hand.toml", "tcp:10.0.0.2:4001"),
            ("drop-in.toml", "/dev/no-such-port"),
        ] {
            let text = format!("ptu.port = {port:?}\n");
            let path = path.into();
            assert_eq!(layers.add(&ConfigFile { path, text }), []);
        }
        let settings = Settings::from_layers(&layers).expect("valid");
        let (_, head) = super::configured_ports(&settings);
        let attempts = head.attempts().expect("a path is tried");
        let error = attempts[0].open().err().map(|error| head.error(error));
        let Some(DeviceError::Port { source, .. }) = &error else {
            panic!("{error:?}");
        };
        assert!(matches!(source, PortError::NoSuchPort(_)));
        let text = error.map(|e| e.to_string()).unwrap_or_default();
        assert!(
            text.starts_with(
                "pan-tilt (ptu.port, set by drop-in.toml:1, which wins over by-hand.toml:1): no device at /dev/no-such-port:"
            ),
            "{text}"
        );
    }

    #[test]
    fn the_attempt_that_worked_last_comes_first() {
        let attempt = |baud| OpenAttempt {
            node: "/dev/ttyUSB7".to_owned(),
            baud,
            is_of_other_device: false,
        };
        let order = |last_good: Option<OpenAttempt>| {
            let mut attempts = [115_200, 19_200, 57_600].map(attempt);
            OpenAttempt::begin_with(&mut attempts, last_good.as_ref());
            attempts.map(|attempt| attempt.baud)
        };
        assert_eq!(order(None), [115_200, 19_200, 57_600]);
        assert_eq!(order(Some(attempt(115_200))), [115_200, 19_200, 57_600]);
        assert_eq!(order(Some(attempt(19_200))), [19_200, 57_600, 115_200]);
        // That node is gone.
        assert_eq!(order(Some(attempt(9600))), [115_200, 19_200, 57_600]);
    }
}
