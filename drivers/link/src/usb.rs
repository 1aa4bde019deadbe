//! Serial ports by USB identity (vendor, product, serial number), as node numbers change with the order of plugging in.

use std::fmt;
use std::str::FromStr;

use crate::LinkError;

/// A serial port of this machine, as the system lists it; the device itself was not queried.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DetectedPort {
    /// Its node, such as `/dev/ttyACM0`.
    pub path: String,
    /// The device behind it, if on USB.
    pub usb: Option<UsbDevice>,
}

/// A device or adapter on USB, from its descriptor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsbDevice {
    /// Vendor id.
    pub vendor: u16,
    /// Product id.
    pub product: u16,
    /// Serial number, if it has one.
    pub serial: Option<String>,
    /// Product name, if it has one.
    pub name: Option<String>,
}

/// A port's name by identity: `usb:VVVV:PPPP` or `usb:VVVV:PPPP:SERIAL`, vendor and product in hexadecimal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsbName {
    vendor: u16,
    product: u16,
    serial: Option<String>,
}

/// A text that is not a port name by USB identity.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0} is not a USB port name: expected usb:VVVV:PPPP or usb:VVVV:PPPP:SERIAL, vendor and product as four hexadecimal digits (lsusb shows them)"
)]
pub struct UsbNameError(String);

impl UsbName {
    /// Whether `text` starts like such a name.
    pub fn has_prefix(text: &str) -> bool {
        text.starts_with("usb:")
    }

    /// The only one of `ports` that matches this name.
    ///
    /// # Errors
    /// [`LinkError::NotFound`] with the ports found instead, [`LinkError::Ambiguous`] with all that match.
    pub fn find_in<'a>(&self, ports: &'a [DetectedPort]) -> Result<&'a DetectedPort, LinkError> {
        let mut matching = ports.iter().filter(|c| self.matches(c));
        match (matching.next(), matching.next()) {
            (Some(only), None) => Ok(only),
            (None, _) => Err(LinkError::NotFound {
                name: self.to_string(),
                detail: match list(ports.iter().filter(|c| c.usb.is_some())) {
                    none if none.is_empty() => "no serial port on USB found".to_owned(),
                    others => format!("on USB: {others}"),
                },
            }),
            (Some(_), Some(_)) => Err(LinkError::Ambiguous {
                name: self.to_string(),
                matching: list(ports.iter().filter(|c| self.matches(c))),
            }),
        }
    }

    /// Vendor id.
    pub fn vendor(&self) -> u16 {
        self.vendor
    }

    /// Whether `port` matches this name.
    pub fn matches(&self, port: &DetectedPort) -> bool {
        port.usb.as_ref().is_some_and(|usb| {
            let named = self.serial.is_none() || self.serial == usb.serial;
            usb.vendor == self.vendor && usb.product == self.product && named
        })
    }
}

impl FromStr for UsbName {
    type Err = UsbNameError;

    fn from_str(text: &str) -> Result<Self, UsbNameError> {
        let bad = || UsbNameError(text.to_owned());
        let mut parts = text.strip_prefix("usb:").ok_or_else(bad)?.splitn(3, ':');
        let mut id = || {
            let digits = parts.next().filter(|d| d.len() == 4);
            let digits = digits.filter(|d| d.bytes().all(|b| b.is_ascii_hexdigit()));
            digits
                .and_then(|d| u16::from_str_radix(d, 16).ok())
                .ok_or_else(bad)
        };
        let (vendor, product) = (id()?, id()?);
        let serial = parts.next().map(str::to_owned);
        if serial.as_ref().is_some_and(String::is_empty) {
            return Err(bad());
        }
        Ok(Self {
            vendor,
            product,
            serial,
        })
    }
}

impl fmt::Display for UsbName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "usb:{:04x}:{:04x}", self.vendor, self.product)?;
        self.serial.iter().try_for_each(|s| write!(f, ":{s}"))
    }
}

impl UsbDevice {
    /// The most specific name that matches it.
    pub fn id(&self) -> UsbName {
        UsbName {
            vendor: self.vendor,
            product: self.product,
            serial: self.serial.clone().filter(|s| !s.is_empty()),
        }
    }
}

impl fmt::Display for DetectedPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.path)?;
        match &self.usb {
            Some(usb) => write!(f, " ({})", usb.id()),
            None => Ok(()),
        }
    }
}

fn list<'a>(ports: impl Iterator<Item = &'a DetectedPort>) -> String {
    let names: Vec<String> = ports.map(ToString::to_string).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::{DetectedPort, UsbDevice, UsbName};
    use crate::LinkError;
    use proptest::prelude::*;

    fn on_usb(path: &str, vendor: u16, product: u16, serial: Option<&str>) -> DetectedPort {
        DetectedPort {
            path: path.to_owned(),
            usb: Some(UsbDevice {
                vendor,
                product,
                serial: serial.map(str::to_owned),
                name: None,
            }),
        }
    }

    /// A robot with two lasers of one make, two adapters of one make, and a UART of the board.
    fn robot() -> Vec<DetectedPort> {
        vec![
            on_usb("/dev/ttyACM0", 0x15d1, 0x0000, None),
            on_usb("/dev/ttyACM1", 0x15d1, 0x0000, None),
            on_usb("/dev/ttyUSB0", 0x0403, 0x6001, Some("A1B2C3D4")),
            on_usb("/dev/ttyUSB1", 0x0403, 0x6001, Some("A1:ZZ")),
            DetectedPort {
                path: "/dev/ttyS0".to_owned(),
                usb: None,
            },
        ]
    }

    fn name(text: &str) -> UsbName {
        text.parse().expect(text)
    }

    #[test]
    fn a_device_is_found_wherever_it_was_plugged_in() {
        let mut there = robot();
        let wanted = name("usb:0403:6001:A1B2C3D4");
        assert_eq!(wanted.find_in(&there).expect("there").path, "/dev/ttyUSB0");
        there[2].path = "/dev/ttyUSB7".to_owned();
        assert_eq!(wanted.find_in(&there).expect("there").path, "/dev/ttyUSB7");
        let with_colon = name("usb:0403:6001:A1:ZZ");
        assert_eq!(
            with_colon.find_in(&there).expect("there").path,
            "/dev/ttyUSB1"
        );
    }

    #[test]
    fn a_missing_device_is_reported_with_the_ports_found_instead() {
        let error = name("usb:067b:2303")
            .find_in(&robot())
            .expect_err("not there");
        let text = error.to_string();
        assert!(matches!(error, LinkError::NotFound { .. }));
        assert!(
            text.contains("usb:067b:2303")
                && text.contains("/dev/ttyUSB0 (usb:0403:6001:A1B2C3D4)"),
            "{text}"
        );
        assert!(!text.contains("ttyS0"), "{text}");
        let text = name("usb:067b:2303")
            .find_in(&[])
            .expect_err("none")
            .to_string();
        assert!(text.contains("no serial port on USB"), "{text}");
    }

    #[test]
    fn an_ambiguous_name_is_refused() {
        let error = name("usb:15d1:0000").find_in(&robot()).expect_err("two");
        let text = error.to_string();
        assert!(matches!(error, LinkError::Ambiguous { .. }));
        assert!(
            text.contains("/dev/ttyACM0") && text.contains("/dev/ttyACM1"),
            "{text}"
        );
        assert!(matches!(
            name("usb:0403:6001").find_in(&robot()),
            Err(LinkError::Ambiguous { .. })
        ));
    }

    #[test]
    fn a_text_that_is_not_a_usb_name_is_refused() {
        for text in [
            "usb:",
            "usb:15d1",
            "usb:15d1:",
            "usb:15d1:0",
            "usb:15d1:00000",
            "usb:15dg:0000",
            "usb:+5d1:0000",
            "usb:15d1:0000:",
            "/dev/ttyACM0",
            "15d1:0000",
            "USB:15d1:0000",
        ] {
            let error = text.parse::<UsbName>().expect_err(text).to_string();
            assert!(
                error.contains(text) && error.contains("usb:VVVV:PPPP"),
                "{error}"
            );
        }
    }

    proptest! {
        #[test]
        fn a_device_matches_its_own_name(
            vendor: u16, product: u16, serial in proptest::option::of("[!-~]{1,12}")
        ) {
            let there = [on_usb("/dev/ttyUSB3", vendor, product, serial.as_deref())];
            let id = there[0].usb.as_ref().expect("usb").id();
            let written: UsbName = id.to_string().parse().expect("its own words");
            prop_assert_eq!(&written, &id);
            prop_assert_eq!(written.find_in(&there).expect("it"), &there[0]);
        }
    }
}
