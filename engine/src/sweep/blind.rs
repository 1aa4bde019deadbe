//! Detects lines with a blind sector: something covers the lens.

use super::constants::{BLIND_PARTS, BLIND_SECTOR_SHARE, MAX_UNKNOWN_SECTOR_RAD};
use crate::scan::{Beam, ScanGeometry};
use std::f64::consts::TAU;

/// Whether a sector of at least [`MAX_UNKNOWN_SECTOR_RAD`] has almost no measurement ([`Beam::Unknown`]). Beams without a
/// return (code 0) do not count: open space gives them too.
pub(super) fn is_blind(values: &[u32], scan_geometry: &ScanGeometry) -> bool {
    let per_rad =
        f64::from(scan_geometry.steps_per_turn) / f64::from(scan_geometry.cluster.max(1)) / TAU;
    let part = (MAX_UNKNOWN_SECTOR_RAD * per_rad / BLIND_PARTS as f64).ceil() as usize;
    let mut run = 0;
    values.chunks_exact(part.max(1)).any(|beams| {
        let unknown = |value: &&u32| {
            Beam::from_raw(**value, scan_geometry.dmin_mm, scan_geometry.dmax_mm) == Beam::Unknown
        };
        let count = beams.iter().filter(unknown).count();
        let blind = count as f64 >= BLIND_SECTOR_SHARE * beams.len() as f64;
        run = if blind { run + 1 } else { 0 };
        run >= BLIND_PARTS
    })
}

#[cfg(test)]
mod tests {
    use super::is_blind;
    use crate::scan::ScanGeometry;

    fn scan_geometry() -> ScanGeometry {
        ScanGeometry {
            steps_per_turn: 1024,
            front_step: 384,
            first_step: 44,
            cluster: 1,
            dmin_mm: 20,
            dmax_mm: 5600,
            period_s: 0.1,
        }
    }

    #[test]
    fn half_a_covered_lens_is_blind_and_a_dark_object_or_a_hall_is_not() {
        let mut values = vec![1500; 682];
        assert!(!is_blind(&values, &scan_geometry()));
        values[341..].fill(7);
        assert!(is_blind(&values, &scan_geometry()));
        values[341..].fill(0);
        assert!(!is_blind(&values, &scan_geometry()), "a hall out of range");
        values[341..].fill(1500);
        // Twenty degrees of a black cupboard.
        values[300..357].fill(7);
        assert!(!is_blind(&values, &scan_geometry()));
        assert!(!is_blind(&[], &scan_geometry()));
    }
}
