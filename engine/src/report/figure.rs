//! Figures in JSON: what is not finite is written `null`, and `null` reads as not a number, so that one odd
//! figure never makes a whole record unreadable.

use serde::{Deserialize, Deserializer};

/// Reads a figure.
pub fn one<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}

/// Reads three figures.
pub fn three<'de, D: Deserializer<'de>>(from: D) -> Result<[f64; 3], D::Error> {
    Ok(<[Option<f64>; 3]>::deserialize(from)?.map(|x| x.unwrap_or(f64::NAN)))
}

/// Reads three rows of three figures.
pub fn nine<'de, D: Deserializer<'de>>(from: D) -> Result<[[f64; 3]; 3], D::Error> {
    let rows = <[[Option<f64>; 3]; 3]>::deserialize(from)?;
    Ok(rows.map(|row| row.map(|x| x.unwrap_or(f64::NAN))))
}
