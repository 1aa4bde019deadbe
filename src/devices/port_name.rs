//! Where a device hangs: the configured name, what kind of line that is, and how to open it.

use super::constants::{LASER_BAUDS, TCP_LIMIT};
use super::error::{Device, DeviceError};
use link::{Link, SerialLink, TcpLink};
use std::path::Path;

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
    /// As configured: a path, or `tcp:HOST:PORT`.
    pub name: String,
    /// The configured line rate, bits per second.
    pub baud: u32,
}

impl PortName {
    /// What kind of line it is: by the node the configured path leads to at this moment (`ttyACM*` is the USB of the
    /// device itself, `/dev/pts/*` a pseudo-terminal, anything else a serial line).
    pub fn line(&self) -> Line {
        if self.name.starts_with("tcp:") {
            return Line::Tcp;
        }
        let path = Path::new(&self.name);
        let node = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let node = node.to_string_lossy();
        if node.starts_with("/dev/pts/") || node.starts_with("/dev/ttyACM") {
            Line::Unpaced
        } else {
            Line::Rs232
        }
    }

    /// Rates to try, the configured one first; one only where the rate means nothing.
    pub fn bauds(&self) -> Vec<u32> {
        let others: &[u32] = match (self.line(), self.device) {
            (Line::Rs232, Device::Laser) => &LASER_BAUDS,
            (Line::Rs232, Device::Head) => &ptu::BAUD_RATES,
            _ => &[],
        };
        let mut bauds = vec![self.baud];
        bauds.extend(others.iter().filter(|b| **b != self.baud));
        bauds
    }

    /// Opens it.
    ///
    /// # Errors
    /// [`DeviceError::Port`], with what to do.
    pub fn open(&self, baud: u32) -> Result<Box<dyn Link>, DeviceError> {
        let link: Result<Box<dyn Link>, link::LinkError> = match self.name.strip_prefix("tcp:") {
            Some(address) => TcpLink::connect(address, TCP_LIMIT).map(|l| Box::new(l) as _),
            None => SerialLink::open(&self.name, baud).map(|l| Box::new(l) as _),
        };
        link.map_err(|error| DeviceError::Port {
            device: self.device,
            source: error.into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Device, Line, PortName};
    use crate::devices::error::{DeviceError, PortError};

    fn port(device: Device, name: &str) -> PortName {
        PortName {
            device,
            name: name.to_owned(),
            baud: 9600,
        }
    }

    #[test]
    fn rates_are_searched_only_where_they_mean_something() {
        let laser = port(Device::Laser, "/dev/ttyUSB7");
        assert_eq!(laser.line(), Line::Rs232);
        assert_eq!(laser.bauds()[..2], [9600, 19_200]);
        let head = port(Device::Head, "/dev/ttyS9").bauds();
        assert_eq!(head.iter().filter(|b| **b == 9600).count(), 1);
        assert_eq!(port(Device::Laser, "/dev/ttyACM0").bauds(), [9600]);
        assert_eq!(port(Device::Laser, "tcp:host:1").line(), Line::Tcp);
    }

    #[test]
    fn a_missing_port_says_its_name_and_key() {
        let error = port(Device::Head, "/dev/no-such-port").open(9600).err();
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
