//! What a configuration value may be.

use link::UsbName;
use std::fmt;
use toml::de::DeValue;

/// A value of one key.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number.
    Float(f64),
    /// A whole number.
    Integer(i64),
    /// A text.
    Text(String),
    /// True or false.
    Flag(bool),
    /// A list of numbers.
    Floats(Vec<f64>),
}

/// What a key accepts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A finite number between the two bounds, both included.
    Float(f64, f64),
    /// A whole number between the two bounds, both included.
    Integer(i64, i64),
    /// Any text that is not empty.
    Text,
    /// A serial device, `tcp:HOST:PORT`, or `usb:VVVV:PPPP[:SERIAL]`.
    Port,
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// 1 or -1.
    Sign,
    /// True or false.
    Flag,
    /// A list of finite numbers: least and greatest length, then the bounds of each.
    Floats(usize, usize, f64, f64),
}

impl Value {
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

impl fmt::Display for Value {
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

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Float(low, high) => write!(f, "a number from {low} to {high}"),
            Self::Integer(low, high) => write!(f, "a whole number from {low} to {high}"),
            Self::Text => write!(f, "a text"),
            Self::Port => write!(
                f,
                "a serial device, usb:VVVV:PPPP[:SERIAL] with hexadecimal digits, or tcp:HOST:PORT"
            ),
            Self::OneOf(words) => write!(f, "one of \"{}\"", words.join("\", \"")),
            Self::Sign => write!(f, "1 or -1"),
            Self::Flag => write!(f, "true or false"),
            Self::Floats(least, most, low, high) if least == most => {
                write!(f, "a list of {least} numbers from {low} to {high}")
            }
            Self::Floats(least, most, low, high) => {
                write!(
                    f,
                    "a list of {least} to {most} numbers from {low} to {high}"
                )
            }
        }
    }
}

impl Kind {
    /// Reads a TOML value as this kind.
    ///
    /// # Errors
    /// What was found instead, in a few words.
    pub fn read(&self, given: &DeValue<'_>) -> Result<Value, String> {
        match *self {
            Self::Float(low, high) => Ok(Value::Float(within(number(given)?, low, high)?)),
            Self::Integer(low, high) => {
                let n = integer(given).ok_or_else(|| given.type_str().to_owned())?;
                if (low..=high).contains(&n) {
                    Ok(Value::Integer(n))
                } else {
                    Err(n.to_string())
                }
            }
            Self::Text => Ok(Value::Text(text(given)?)),
            Self::Port => match text(given)? {
                name if UsbName::is_meant(&name) && name.parse::<UsbName>().is_err() => {
                    Err(format!("{name:?}"))
                }
                name => Ok(Value::Text(name)),
            },
            Self::OneOf(words) => match given.as_str() {
                Some(text) if words.contains(&text) => Ok(Value::Text(text.to_owned())),
                Some(text) => Err(format!("{text:?}")),
                None => Err(given.type_str().to_owned()),
            },
            Self::Sign => match number(given)? {
                1.0 => Ok(Value::Integer(1)),
                -1.0 => Ok(Value::Integer(-1)),
                other => Err(other.to_string()),
            },
            Self::Flag => given
                .as_bool()
                .map(Value::Flag)
                .ok_or_else(|| given.type_str().to_owned()),
            Self::Floats(least, most, low, high) => {
                let list = given
                    .as_array()
                    .ok_or_else(|| given.type_str().to_owned())?;
                if !(least..=most).contains(&list.len()) {
                    return Err(format!("a list of {}", list.len()));
                }
                let numbers: Result<Vec<f64>, String> = list
                    .iter()
                    .map(|item| within(number(item.get_ref())?, low, high))
                    .collect();
                numbers.map(Value::Floats)
            }
        }
    }
}

fn text(given: &DeValue<'_>) -> Result<String, String> {
    match given.as_str() {
        Some("") => Err("an empty text".to_owned()),
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
