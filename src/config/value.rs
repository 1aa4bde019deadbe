//! Values of configuration keys, and the kinds of value that a key accepts.

use link::UsbName;
use std::fmt;
use toml::de::DeValue;

/// A value of one key.
#[derive(Debug, Clone, PartialEq)]
pub enum ConfigValue {
    /// A number.
    Float(f64),
    /// A whole number.
    Integer(i64),
    /// A string.
    Text(String),
    /// True or false.
    Flag(bool),
    /// A list of numbers.
    Floats(Vec<f64>),
}

/// What a key accepts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ValueKind {
    /// A finite number between the two bounds, both included.
    Float(f64, f64),
    /// A whole number between the two bounds, both included.
    Integer(i64, i64),
    /// A string that is not empty.
    Text,
    /// A serial device, `usb:VVVV:PPPP[:SERIAL]` or `tcp:HOST:PORT`.
    Port,
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// 1 or -1.
    Sign,
    /// True or false.
    Flag,
    /// A list of finite numbers: shortest and longest length, then the bounds of each number.
    Floats(usize, usize, f64, f64),
}

impl ConfigValue {
    /// The value as JSON.
    pub fn to_json(&self) -> serde_json::Value {
        match self {
            Self::Float(x) => serde_json::json!(x),
            Self::Integer(n) => serde_json::json!(n),
            Self::Text(text) => serde_json::json!(text),
            Self::Flag(flag) => serde_json::json!(flag),
            Self::Floats(list) => serde_json::json!(list),
        }
    }
}

impl fmt::Display for ConfigValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Float(x) => write!(f, "{x:?}"),
            Self::Integer(n) => write!(f, "{n}"),
            Self::Text(text) => write!(f, "{text:?}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Floats(list) => write!(f, "{list:?}"),
        }
    }
}

impl fmt::Display for ValueKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Float(low, high) => write!(f, "a number from {low} to {high}"),
            Self::Integer(low, high) => write!(f, "a whole number from {low} to {high}"),
            Self::Text => write!(f, "a string"),
            Self::Port => write!(
                f,
                "a serial device, usb:VVVV:PPPP[:SERIAL] with hexadecimal digits, or tcp:HOST:PORT"
            ),
            Self::OneOf(words) => write!(f, "one of \"{}\"", words.join("\", \"")),
            Self::Sign => write!(f, "1 or -1"),
            Self::Flag => write!(f, "true or false"),
            Self::Floats(min, max, low, high) if min == max => {
                write!(f, "a list of {min} numbers from {low} to {high}")
            }
            Self::Floats(min, max, low, high) => {
                write!(f, "a list of {min} to {max} numbers from {low} to {high}")
            }
        }
    }
}

impl ValueKind {
    /// Reads a TOML value as this kind.
    ///
    /// # Errors
    /// What was found instead, in a few words.
    pub fn parse(&self, given: &DeValue<'_>) -> Result<ConfigValue, String> {
        match *self {
            Self::Float(low, high) => Ok(ConfigValue::Float(within(number(given)?, low, high)?)),
            Self::Integer(low, high) => {
                let n = integer(given).ok_or_else(|| given.type_str().to_owned())?;
                if (low..=high).contains(&n) {
                    Ok(ConfigValue::Integer(n))
                } else {
                    Err(n.to_string())
                }
            }
            Self::Text => Ok(ConfigValue::Text(text(given)?)),
            Self::Port => {
                let name = text(given)?;
                if is_port_name(&name) {
                    Ok(ConfigValue::Text(name))
                } else {
                    Err(format!("{name:?}"))
                }
            }
            Self::OneOf(words) => match given.as_str() {
                Some(text) if words.contains(&text) => Ok(ConfigValue::Text(text.to_owned())),
                Some(text) => Err(format!("{text:?}")),
                None => Err(given.type_str().to_owned()),
            },
            Self::Sign => match number(given)? {
                1.0 => Ok(ConfigValue::Integer(1)),
                -1.0 => Ok(ConfigValue::Integer(-1)),
                other => Err(other.to_string()),
            },
            Self::Flag => given
                .as_bool()
                .map(ConfigValue::Flag)
                .ok_or_else(|| given.type_str().to_owned()),
            Self::Floats(min, max, low, high) => {
                let list = given
                    .as_array()
                    .ok_or_else(|| given.type_str().to_owned())?;
                if !(min..=max).contains(&list.len()) {
                    return Err(format!("a list of {}", list.len()));
                }
                let numbers: Result<Vec<f64>, String> = list
                    .iter()
                    .map(|item| within(number(item.get_ref())?, low, high))
                    .collect();
                numbers.map(ConfigValue::Floats)
            }
        }
    }
}

/// Whether the name is a path, a whole USB name, or `tcp:` with a host and a port from 1 to 65535.
fn is_port_name(name: &str) -> bool {
    if UsbName::has_prefix(name) {
        return name.parse::<UsbName>().is_ok();
    }
    let Some(address) = name.strip_prefix("tcp:") else {
        return true;
    };
    address.rsplit_once(':').is_some_and(|(host, port)| {
        !host.is_empty()
            && port.starts_with(|c| ('1'..='9').contains(&c))
            && port.parse::<u16>().is_ok()
    })
}

fn text(given: &DeValue<'_>) -> Result<String, String> {
    match given.as_str() {
        Some("") => Err("an empty string".to_owned()),
        Some(text) => Ok(text.to_owned()),
        None => Err(given.type_str().to_owned()),
    }
}

fn within(x: f64, low: f64, high: f64) -> Result<f64, String> {
    if x.is_finite() && (low..=high).contains(&x) {
        Ok(x)
    } else {
        Err(format!("{x}"))
    }
}

fn number(given: &DeValue<'_>) -> Result<f64, String> {
    if let Some(n) = integer(given) {
        return Ok(n as f64);
    }
    let float = given
        .as_float()
        .ok_or_else(|| given.type_str().to_owned())?;
    float
        .as_str()
        .parse()
        .map_err(|_| float.as_str().to_owned())
}

fn integer(given: &DeValue<'_>) -> Option<i64> {
    let n = given.as_integer()?;
    i64::from_str_radix(n.as_str(), n.radix()).ok()
}

#[cfg(test)]
mod tests {
    use super::{ValueKind, is_port_name};

    #[test]
    fn a_port_is_a_path_a_usb_name_or_an_address() {
        for name in [
            "/dev/ttyS0",
            "usb:15d1:0000",
            "usb:0403:6001:A1B2",
            "tcp:10.0.0.2:10940",
            "tcp:serial-server:1",
            "tcp:[fe80::1]:65535",
        ] {
            assert!(is_port_name(name), "{name}");
        }
        for name in [
            "usb:nothing",
            "usb:15d1:0000:",
            "tcp:",
            "tcp:host",
            "tcp:host:",
            "tcp::4001",
            "tcp:host:0",
            "tcp:host:08",
            "tcp:host:+8",
            "tcp:host:65536",
            "tcp:host:http",
        ] {
            assert!(!is_port_name(name), "{name}");
        }
        assert!(ValueKind::Port.to_string().ends_with("or tcp:HOST:PORT"));
    }
}
