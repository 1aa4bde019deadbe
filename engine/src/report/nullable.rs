//! JSON numbers that may be `null`: serde_json writes a number that is not finite as `null`, and these readers take
//! `null` for NaN, so that one bad number never makes a record unreadable.

use serde::{Deserialize, Deserializer};

pub(super) fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}

pub(super) fn vector3<'de, D: Deserializer<'de>>(from: D) -> Result<[f64; 3], D::Error> {
    Ok(<[Option<f64>; 3]>::deserialize(from)?.map(|x| x.unwrap_or(f64::NAN)))
}

pub(super) fn matrix3<'de, D: Deserializer<'de>>(from: D) -> Result<[[f64; 3]; 3], D::Error> {
    let rows = <[[Option<f64>; 3]; 3]>::deserialize(from)?;
    Ok(rows.map(|row| row.map(|x| x.unwrap_or(f64::NAN))))
}
