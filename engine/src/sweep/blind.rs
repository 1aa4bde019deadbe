//! Lines of which a whole sector tells nothing: something is on the lens.

use super::constants::{BLIND_SECTOR_SHARE, FEWEST_BLIND_RAD};
use crate::scan::{Beam, Optics};
use std::f64::consts::TAU;

/// Sectors that a line is cut into: a sixteenth of [`FEWEST_BLIND_RAD`] would flicker, a whole one would miss half.
const SECTORS_PER_BLIND: usize = 4;

/// Whether a sector of at least [`FEWEST_BLIND_RAD`] has nearly nothing but codes of a sensor that cannot tell. A
/// direction in which nothing came back (code 0) is not among them: open space looks like that.
pub fn is_blind(values: &[u32], optics: &Optics) -> bool {
    let per_rad = f64::from(optics.steps_per_turn) / f64::from(optics.cluster.max(1)) / TAU;
    let sector = (FEWEST_BLIND_RAD * per_rad / SECTORS_PER_BLIND as f64).ceil() as usize;
    let mut run = 0;
    values.chunks_exact(sector.max(1)).any(|beams| {
        let unknown =
            |value: &&u32| Beam::read(**value, optics.dmin_mm, optics.dmax_mm) == Beam::Unknown;
        let count = beams.iter().filter(unknown).count();
        let blind = count as f64 >= BLIND_SECTOR_SHARE * beams.len() as f64;
        run = if blind { run + 1 } else { 0 };
        run >= SECTORS_PER_BLIND
    })
}

#[cfg(test)]
mod tests {
    use super::is_blind;
    use crate::scan::Optics;

    fn optics() -> Optics {
        Optics {
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
    fn half_a_lens_is_blind_and_a_dark_thing_or_a_hall_is_not() {
        let mut values = vec![1500; 682];
        assert!(!is_blind(&values, &optics()));
        values[341..].fill(7);
        assert!(is_blind(&values, &optics()));
        values[341..].fill(0);
        assert!(!is_blind(&values, &optics()), "a hall beyond reach");
        values[341..].fill(1500);
        // Twenty degrees of a black cupboard.
        values[300..357].fill(7);
        assert!(!is_blind(&values, &optics()));
        assert!(!is_blind(&[], &optics()));
    }
}
