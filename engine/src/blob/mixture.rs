//! Stored form of a reference's mixture: version, then of each component its weight, mean, the six entries of its covariance,
//! and what its beams were like; little-endian f64 (`docs/contract.md`).

use super::error::BlobError;
use crate::mixture::{Gaussian, Mixture};
use crate::novelty::{ComponentBeams, ReferenceMixture};
use nalgebra::{Matrix3, Point3};

/// Version of the form. Version 1 had no beams.
const VERSION: u8 = 2;

/// Numbers of a component: weight, mean (3), covariance (6), count, noise and lost share of its beams.
const NUMBERS: usize = 13;

/// Whether these bytes are of a version before the one that is read: the mixture is to be made anew from its view.
pub fn is_outdated_mixture(bytes: &[u8]) -> bool {
    bytes.first().is_some_and(|version| *version < VERSION)
}

/// Encodes the mixture of a reference.
pub fn encode_mixture(gamma: &ReferenceMixture) -> Vec<u8> {
    let mut bytes = vec![VERSION];
    let mixture = &gamma.mixture;
    for ((weight, g), beams) in mixture
        .weights
        .iter()
        .zip(&mixture.components)
        .zip(&gamma.beams)
    {
        let c = &g.covariance;
        let numbers: [f64; NUMBERS] = [
            *weight,
            g.mean.x,
            g.mean.y,
            g.mean.z,
            c.m11,
            c.m12,
            c.m13,
            c.m22,
            c.m23,
            c.m33,
            beams.count,
            beams.noise_m,
            beams.lost_share,
        ];
        for x in numbers {
            bytes.extend_from_slice(&x.to_le_bytes());
        }
    }
    bytes
}

/// Decodes what [`encode_mixture`] wrote.
///
/// # Errors
/// Another version, a number of bytes that is no whole number of components, or numbers that are no mixture.
pub fn decode_mixture(bytes: &[u8]) -> Result<ReferenceMixture, BlobError> {
    let error = |expected: &str, got: String| BlobError {
        what: "stored mixture".to_owned(),
        expected: expected.to_owned(),
        got,
    };
    match bytes.first() {
        Some(&VERSION) => {}
        other => return Err(error(&format!("version {VERSION}"), format!("{other:?}"))),
    }
    let (words, extra_bytes) = bytes[1..].as_chunks::<8>();
    let numbers: Vec<f64> = words.iter().map(|w| f64::from_le_bytes(*w)).collect();
    let (components, extra_numbers) = numbers.as_chunks::<NUMBERS>();
    if !extra_bytes.is_empty() || !extra_numbers.is_empty() {
        return Err(error(
            &format!("{NUMBERS} numbers a component"),
            format!("{} bytes", bytes.len()),
        ));
    }
    let (mut weights, mut gaussians, mut beams) = (Vec::new(), Vec::new(), Vec::new());
    for [
        weight,
        x,
        y,
        z,
        xx,
        xy,
        xz,
        yy,
        yz,
        zz,
        count,
        noise_m,
        lost_share,
    ] in components
    {
        weights.push(*weight);
        gaussians.push(Gaussian {
            mean: Point3::new(*x, *y, *z),
            covariance: Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz),
        });
        beams.push(ComponentBeams {
            count: *count,
            noise_m: *noise_m,
            lost_share: *lost_share,
        });
    }
    if weights.is_empty() {
        return Ok(ReferenceMixture::default());
    }
    let mixture = Mixture::from_masses(weights, gaussians)
        .map_err(|problem| error("a mixture", problem.to_string()))?;
    Ok(ReferenceMixture { mixture, beams })
}

#[cfg(test)]
mod tests {
    use super::{decode_mixture, encode_mixture, is_outdated_mixture};
    use crate::mixture::{Gaussian, Mixture};
    use crate::novelty::{ComponentBeams, ReferenceMixture};
    use nalgebra::{Matrix3, Point3};

    fn gamma() -> ReferenceMixture {
        let at = |x: f64| Gaussian {
            mean: Point3::new(x, 2.0, 1.0 / 3.0),
            covariance: Matrix3::new(4.0, 0.1, 0.2, 0.1, 5.0, 0.3, 0.2, 0.3, 6.0),
        };
        let beams = |count: f64| ComponentBeams {
            count,
            noise_m: 0.01 / count,
            lost_share: 0.1,
        };
        ReferenceMixture {
            mixture: Mixture {
                weights: vec![0.25, 0.75],
                components: vec![at(1.0), at(-7.0)],
            },
            beams: vec![beams(30.0), beams(400.0)],
        }
    }

    #[test]
    fn a_mixture_is_decoded_and_other_bytes_are_refused() {
        let bytes = encode_mixture(&gamma());
        assert_eq!(decode_mixture(&bytes).expect("reads"), gamma());
        assert!(decode_mixture(&bytes[..bytes.len() - 1]).is_err());
        assert!(decode_mixture(&bytes[..bytes.len() - 8]).is_err());
        assert!(decode_mixture(&[]).is_err());
        let empty = ReferenceMixture::default();
        assert_eq!(
            decode_mixture(&encode_mixture(&empty)).expect("empty"),
            empty
        );
        let mut negative = gamma();
        negative.mixture.weights[0] = -0.25;
        assert!(decode_mixture(&encode_mixture(&negative)).is_err());
    }

    #[test]
    fn an_earlier_version_is_outdated_and_a_later_one_is_not() {
        let mut bytes = encode_mixture(&gamma());
        assert!(!is_outdated_mixture(&bytes));
        bytes[0] = 1;
        assert!(is_outdated_mixture(&bytes) && decode_mixture(&bytes).is_err());
        bytes[0] = 3;
        assert!(!is_outdated_mixture(&bytes) && decode_mixture(&bytes).is_err());
    }
}
