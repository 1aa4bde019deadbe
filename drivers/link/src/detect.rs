//! The serial ports of this machine, as the kernel and udev list them; the devices themselves are not queried.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::LinkError;
use crate::usb::{DetectedPort, UsbDevice};

/// Where Linux lists its terminals, below the root.
const TERMINALS: &str = "sys/class/tty";
/// Their nodes.
const NODES: &str = "dev";
/// Where udev links each serial port on USB by the socket that it is plugged into.
const SOCKET_LINKS: &str = "dev/serial/by-path";
/// `type` of a UART that the kernel has a name for and the machine has not (PORT_UNKNOWN of serial_core.h).
const NO_UART: &str = "0";

/// All serial ports of this machine with a device behind them, by path; pseudo-terminals and the console are left out.
///
/// # Errors
/// [`LinkError::Io`] if the system cannot list them.
pub fn detect_ports() -> Result<Vec<DetectedPort>, LinkError> {
    ports_below(Path::new("/"))
}

/// The link to `node` by the socket that it is plugged into: it stays where two adapters have one USB identity.
pub fn socket_link(node: &str) -> Option<String> {
    socket_link_below(Path::new("/"), Path::new(node))
}

fn ports_below(root: &Path) -> Result<Vec<DetectedPort>, LinkError> {
    let terminals = root.join(TERMINALS);
    let listed = match fs::read_dir(&terminals) {
        Ok(listed) => listed,
        // A container may have no such folder.
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => {
            return Err(LinkError::Io {
                name: terminals.display().to_string(),
                source,
            });
        }
    };
    let mut found: Vec<DetectedPort> = listed
        .flatten()
        .filter_map(|terminal| {
            let node = root.join(NODES).join(terminal.file_name());
            port(&terminal.path(), &node)
        })
        .collect();
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// `terminal`: its folder in sysfs. `None` where nothing is behind it, or no node leads there.
fn port(terminal: &Path, node: &Path) -> Option<DetectedPort> {
    let device = terminal.join("device").canonicalize().ok()?;
    let usb = device.ancestors().find_map(usb_device);
    let is_uart = || attribute(terminal, "type").is_some_and(|kind| kind != NO_UART);
    let is_port = node.exists() && (usb.is_some() || is_uart());
    is_port.then(|| DetectedPort {
        path: node.display().to_string(),
        usb,
    })
}

/// The USB device whose folder this is.
fn usb_device(folder: &Path) -> Option<UsbDevice> {
    let id = |name| u16::from_str_radix(&attribute(folder, name)?, 16).ok();
    Some(UsbDevice {
        vendor: id("idVendor")?,
        product: id("idProduct")?,
        serial: attribute(folder, "serial"),
        name: attribute(folder, "product"),
    })
}

/// A file of sysfs: one line.
fn attribute(folder: &Path, name: &str) -> Option<String> {
    let text = fs::read_to_string(folder.join(name)).ok()?;
    Some(text.trim().to_owned())
}

fn socket_link_below(root: &Path, node: &Path) -> Option<String> {
    let node = node.canonicalize().ok()?;
    let links = fs::read_dir(root.join(SOCKET_LINKS)).ok()?.flatten();
    let leads_there = |link: &PathBuf| link.canonicalize().is_ok_and(|end| end == node);
    // One port has several names where udev knows several bus numbers.
    let link = links.map(|l| l.path()).filter(leads_there).min()?;
    Some(link.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::{detect_ports, ports_below, socket_link_below};
    use std::fs;
    use std::os::unix::fs::symlink;
    use std::path::Path;

    /// A machine in a folder, with the links that sysfs and udev make.
    struct Machine(tempfile::TempDir);

    impl Machine {
        fn new() -> Self {
            let machine = Self(tempfile::tempdir().expect("temp dir"));
            for folder in ["sys/class/tty", "dev/serial/by-path"] {
                fs::create_dir_all(machine.root().join(folder)).expect("made");
            }
            machine
        }

        fn root(&self) -> &Path {
            self.0.path()
        }

        fn write(&self, folder: &str, attributes: &[(&str, &str)]) {
            let folder = self.root().join("sys/devices").join(folder);
            fs::create_dir_all(&folder).expect("made");
            for (name, value) in attributes {
                fs::write(folder.join(name), format!("{value}\n")).expect("written");
            }
        }

        /// A terminal `name` of the device in `folder`, with its node.
        fn terminal(&self, name: &str, folder: &str, attributes: &[(&str, &str)]) {
            let at = format!("{folder}/tty/{name}");
            self.write(&at, attributes);
            let real = self.root().join("sys/devices").join(&at);
            symlink("../..", real.join("device")).expect("linked");
            let listed = self.root().join("sys/class/tty").join(name);
            symlink(format!("../../devices/{at}"), listed).expect("linked");
            fs::write(self.node(name), "").expect("written");
        }

        fn node(&self, name: &str) -> std::path::PathBuf {
            self.root().join("dev").join(name)
        }

        fn link(&self, name: &str, node: &str) {
            let link = self.root().join("dev/serial/by-path").join(name);
            symlink(format!("../../{node}"), link).expect("linked");
        }

        /// Node and full USB name of each port.
        fn ports(&self) -> Vec<(String, Option<String>)> {
            let found = ports_below(self.root()).expect("listed");
            let dev = format!("{}/dev/", self.root().display());
            let port = found.into_iter().map(|port| {
                let node = port.path.strip_prefix(&dev).expect("a node").to_owned();
                (node, port.usb.map(|usb| usb.id().to_string()))
            });
            port.collect()
        }
    }

    /// The folders are those of a PC with the laser's own USB (cdc_acm) and two adapters (usb-serial) of one make, of which
    /// one has a serial number; the board has one UART, and the kernel names for more.
    #[test]
    fn ports_are_those_of_usb_devices_and_of_uarts_that_are_there() {
        let machine = Machine::new();
        let usb = "pci0000:00/0000:00:14.0/usb1";
        let hub = [("idVendor", "1d6b"), ("idProduct", "0002")];
        machine.write(usb, &hub);
        let laser = [
            ("idVendor", "15d1"),
            ("idProduct", "0000"),
            ("product", "URG-Series USB Driver"),
        ];
        machine.write(&format!("{usb}/1-1"), &laser);
        machine.terminal("ttyACM0", &format!("{usb}/1-1/1-1:1.0"), &[]);
        let adapter = [("idVendor", "0403"), ("idProduct", "6001")];
        machine.write(&format!("{usb}/1-2"), &adapter);
        machine.write(&format!("{usb}/1-2"), &[("serial", "A1B2C3D4")]);
        machine.terminal("ttyUSB1", &format!("{usb}/1-2/1-2:1.0/ttyUSB1"), &[]);
        machine.write(&format!("{usb}/1-3/1-3.4"), &adapter);
        let second = format!("{usb}/1-3/1-3.4/1-3.4:1.0/ttyUSB0");
        machine.terminal("ttyUSB0", &second, &[]);
        machine.terminal("ttyS0", "pnp0/00:01/00:01:0/00:01:0.0", &[("type", "4")]);
        let none = "platform/serial8250/serial8250:0/serial8250:0.1";
        machine.terminal("ttyS1", none, &[("type", "0")]);
        machine.terminal("hvc0", "pci0000:00/0000:00:05.0/virtio1", &[]);
        // A virtual console has no device, and this adapter no node.
        fs::create_dir_all(machine.root().join("sys/class/tty/tty0")).expect("made");
        fs::write(machine.node("tty0"), "").expect("written");
        machine.terminal("ttyUSB7", &format!("{usb}/1-2/1-2:1.1/ttyUSB7"), &[]);
        fs::remove_file(machine.node("ttyUSB7")).expect("removed");

        let expected = [
            ("ttyACM0", Some("usb:15d1:0000")),
            ("ttyS0", None),
            ("ttyUSB0", Some("usb:0403:6001")),
            ("ttyUSB1", Some("usb:0403:6001:A1B2C3D4")),
        ];
        let expected = expected.map(|(node, usb)| (node.to_owned(), usb.map(str::to_owned)));
        assert_eq!(machine.ports(), expected);
        let names = ports_below(machine.root()).expect("listed");
        let names = names.into_iter().map(|port| port.usb.and_then(|u| u.name));
        let names: Vec<_> = names.collect();
        assert_eq!(names[0].as_deref(), Some("URG-Series USB Driver"));
        assert!(names[1..].iter().all(Option::is_none), "{names:?}");
    }

    #[test]
    fn a_machine_without_a_list_of_terminals_has_no_ports() {
        let empty = tempfile::tempdir().expect("temp dir");
        assert_eq!(ports_below(empty.path()).expect("none"), []);
    }

    #[test]
    fn a_port_is_linked_by_its_socket() {
        let machine = Machine::new();
        for name in ["ttyUSB0", "ttyUSB1", "ttyS0"] {
            fs::write(machine.node(name), "").expect("written");
        }
        machine.link("pci-0000:00:14.0-usbv2-0:2:1.0-port0", "ttyUSB0");
        machine.link("pci-0000:00:14.0-usb-0:2:1.0-port0", "ttyUSB0");
        machine.link("pci-0000:00:14.0-usb-0:3:1.0-port0", "ttyUSB1");
        machine.link("pci-0000:00:14.0-usb-0:4:1.0-port0", "ttyUSB9");
        let link = |name: &str| {
            let link = socket_link_below(machine.root(), &machine.node(name))?;
            let (_, name) = link.rsplit_once('/').expect("a path");
            Some(name.to_owned())
        };
        let at = |socket: &str| Some(format!("pci-0000:00:14.0-usb-0:{socket}:1.0-port0"));
        assert_eq!(
            ["ttyUSB0", "ttyUSB1", "ttyS0"].map(link),
            [at("2"), at("3"), None]
        );
    }

    #[test]
    fn ports_of_this_machine_are_listed_in_order_without_pseudo_terminals() {
        let here = detect_ports().expect("listed");
        assert!(here.is_sorted_by(|a, b| a.path < b.path), "{here:?}");
        assert!(
            here.iter()
                .all(|c| c.path.starts_with("/dev/") && !c.path.contains("/pts/"))
        );
    }
}
