//! The measurement of one beam.

/// The measurement of one beam. Values below DMIN are codes, not distances (scip2 section 7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Beam {
    /// A return at this range, metres.
    Hit(f64),
    /// Nothing came back (code 0): the beam is free up to the reliable range.
    NoReturn,
    /// No measurement: any other code, or a value beyond the range of the sensor.
    Unknown,
}

impl Beam {
    /// Decodes a raw value: millimetres, or a code below `dmin_mm`.
    pub(crate) fn from_raw(raw: u32, dmin_mm: u32, dmax_mm: u32) -> Self {
        match raw {
            0 => Self::NoReturn,
            code if code < dmin_mm => Self::Unknown,
            range_mm if range_mm <= dmax_mm => Self::Hit(f64::from(range_mm) / 1e3),
            _ => Self::Unknown,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Beam;

    #[test]
    fn codes_are_not_distances() {
        assert_eq!(Beam::from_raw(0, 20, 5600), Beam::NoReturn);
        assert_eq!(Beam::from_raw(7, 20, 5600), Beam::Unknown);
        assert_eq!(Beam::from_raw(19, 20, 5600), Beam::Unknown);
        assert_eq!(Beam::from_raw(20, 20, 5600), Beam::Hit(0.02));
        assert_eq!(Beam::from_raw(5600, 20, 5600), Beam::Hit(5.6));
        assert_eq!(Beam::from_raw(5601, 20, 5600), Beam::Unknown);
    }
}
