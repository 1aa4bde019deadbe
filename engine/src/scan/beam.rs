//! What one beam says.

/// One beam's reading (SCIP 2.0, scip2 section 7: values below DMIN are codes, not distances).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beam {
    /// Something at this range, metres.
    Hit(f64),
    /// Nothing came back (code 0): free up to the reliable range.
    Nothing,
    /// The sensor cannot tell (every other code, or a value beyond its range).
    Unknown,
}

impl Beam {
    /// Reads a raw value in millimetres or a code below `dmin_mm`.
    pub fn read(raw: u32, dmin_mm: u32, dmax_mm: u32) -> Self {
        match raw {
            0 => Self::Nothing,
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
    fn codes_are_never_distances() {
        assert_eq!(Beam::read(0, 20, 5600), Beam::Nothing);
        assert_eq!(Beam::read(7, 20, 5600), Beam::Unknown);
        assert_eq!(Beam::read(19, 20, 5600), Beam::Unknown);
        assert_eq!(Beam::read(20, 20, 5600), Beam::Hit(0.02));
        assert_eq!(Beam::read(5600, 20, 5600), Beam::Hit(5.6));
        assert_eq!(Beam::read(5601, 20, 5600), Beam::Unknown);
    }
}
