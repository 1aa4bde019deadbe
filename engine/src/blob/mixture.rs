//! Stored form of a mixture: version, then weight, mean and the six entries of the covariance of each component;
//! little-endian f64.

use super::error::BlobError;
use crate::mixture::{Gaussian, Mixture};
use nalgebra::{Matrix3, Point3};

const VERSION: u8 = 1;

/// Encodes a mixture.
pub fn encode_mixture(mixture: &Mixture) -> Vec<u8> {
    let mut bytes = vec![VERSION];
    for (weight, g) in mixture.weights.iter().zip(&mixture.components) {
        let c = &g.covariance;
        let numbers = [
            *weight, g.mean.x, g.mean.y, g.mean.z, c.m11, c.m12, c.m13, c.m22, c.m23, c.m33,
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
/// Another version, or a number of bytes that is no whole number of components.
pub fn decode_mixture(bytes: &[u8]) -> Result<Mixture, BlobError> {
    let error = |expected: &str, got: String| BlobError {
        what: "stored mixture".to_owned(),
        expected: expected.to_owned(),
        got,
    };
    match bytes.first() {
        Some(&VERSION) => {}
        other => return Err(error("version 1", format!("{other:?}"))),
    }
    let (words, extra_bytes) = bytes[1..].as_chunks::<8>();
    let numbers: Vec<f64> = words.iter().map(|w| f64::from_le_bytes(*w)).collect();
    let (components, extra_numbers) = numbers.as_chunks::<10>();
    if !extra_bytes.is_empty() || !extra_numbers.is_empty() {
        return Err(error(
            "10 numbers a component",
            format!("{} bytes", bytes.len()),
        ));
    }
    let mut mixture = Mixture::default();
    for [weight, x, y, z, xx, xy, xz, yy, yz, zz] in components {
        mixture.weights.push(*weight);
        mixture.components.push(Gaussian {
            mean: Point3::new(*x, *y, *z),
            covariance: Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz),
        });
    }
    Ok(mixture)
}

#[cfg(test)]
mod tests {
    use super::{decode_mixture, encode_mixture};
    use crate::mixture::{Gaussian, Mixture};
    use nalgebra::{Matrix3, Point3};

    #[test]
    fn a_mixture_is_decoded_and_truncated_bytes_are_refused() {
        let g = Gaussian {
            mean: Point3::new(1.0, 2.0, 1.0 / 3.0),
            covariance: Matrix3::new(4.0, 0.1, 0.2, 0.1, 5.0, 0.3, 0.2, 0.3, 6.0),
        };
        let mixture = Mixture {
            weights: vec![0.25, 0.75],
            components: vec![g, g],
        };
        let bytes = encode_mixture(&mixture);
        assert_eq!(decode_mixture(&bytes).expect("reads"), mixture);
        assert!(decode_mixture(&bytes[..bytes.len() - 1]).is_err());
        assert!(decode_mixture(&[]).is_err());
        assert_eq!(
            decode_mixture(&encode_mixture(&Mixture::default())).expect("empty"),
            Mixture::default()
        );
    }
}
