//! What a row has for the mixture of its reference: sound, of an earlier version, or damaged.

use super::super::checksum::sha256_hex;
use patrold_engine::blob::{decode_mixture, is_outdated_mixture};
use patrold_engine::novelty::ReferenceMixture;

/// The stored mixture of a reference. The checksum column decides what is damage.
#[derive(Debug, Clone, PartialEq)]
pub enum StoredMixture {
    /// The checksum matches.
    Intact {
        /// Gamma.
        gamma: ReferenceMixture,
        /// What it was made by, as JSON.
        model: String,
    },
    /// Stored by an earlier version: without checksum or model, or in an earlier form.
    Outdated,
    /// The checksum differs, or the bytes are no mixture.
    Damaged {
        /// Which, for a person to read.
        why: String,
    },
}

impl StoredMixture {
    /// From the columns `mixture`, `mixture_sha256` and `model`.
    pub(in crate::store) fn from_row(
        bytes: &[u8],
        checksum: Option<&str>,
        model: Option<String>,
    ) -> Self {
        let Some(checksum) = checksum else {
            return Self::Outdated;
        };
        let got = sha256_hex(bytes);
        if got != checksum {
            let why = format!("its SHA-256 is {got}, stored with it is {checksum}");
            return Self::Damaged { why };
        }
        if is_outdated_mixture(bytes) {
            return Self::Outdated;
        }
        match (decode_mixture(bytes), model) {
            (Err(error), _) => Self::Damaged {
                why: error.to_string(),
            },
            (Ok(gamma), _) if gamma.mixture.is_empty() => Self::Damaged {
                why: "it has no components".to_owned(),
            },
            (Ok(_), None) => Self::Outdated,
            (Ok(gamma), Some(model)) => Self::Intact { gamma, model },
        }
    }

    /// `intact`, `outdated` or `damaged`.
    pub fn state(&self) -> &'static str {
        match self {
            Self::Intact { .. } => "intact",
            Self::Outdated => "outdated",
            Self::Damaged { .. } => "damaged",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{StoredMixture, sha256_hex};
    use nalgebra::{Matrix3, Point3};
    use patrold_engine::blob::encode_mixture;
    use patrold_engine::mixture::{Gaussian, Mixture};
    use patrold_engine::novelty::{ComponentBeams, ReferenceMixture};

    fn gamma() -> ReferenceMixture {
        let beams = ComponentBeams {
            count: 30.0,
            noise_m: 0.01,
            lost_share: 0.1,
        };
        let ball = Gaussian {
            mean: Point3::new(1.0, 2.0, 3.0),
            covariance: Matrix3::identity(),
        };
        ReferenceMixture {
            mixture: Mixture {
                weights: vec![1.0],
                components: vec![ball],
            },
            beams: vec![beams],
        }
    }

    fn read(bytes: &[u8], checksum: Option<&str>, model: Option<&str>) -> StoredMixture {
        StoredMixture::from_row(bytes, checksum, model.map(str::to_owned))
    }

    #[test]
    fn the_checksum_tells_damage_and_its_absence_age() {
        let bytes = encode_mixture(&gamma());
        let sum = sha256_hex(&bytes);
        let intact = StoredMixture::Intact {
            gamma: gamma(),
            model: "m".to_owned(),
        };
        assert_eq!(read(&bytes, Some(&sum), Some("m")), intact);
        assert_eq!(read(&bytes, Some(&sum), None), StoredMixture::Outdated);
        assert_eq!(read(&bytes, None, Some("m")), StoredMixture::Outdated);
        let mut other = bytes.clone();
        for at in [0, 1, bytes.len() - 1] {
            other[at] ^= 1;
            let damaged = read(&other, Some(&sum), Some("m"));
            assert_eq!(damaged.state(), "damaged", "byte {at}");
            other[at] ^= 1;
        }
    }

    #[test]
    fn an_earlier_form_is_outdated_and_what_does_not_decode_is_damaged() {
        let with_sum = |bytes: &[u8]| read(bytes, Some(&sha256_hex(bytes)), Some("m"));
        let mut earlier = encode_mixture(&gamma());
        earlier[0] = 1;
        assert_eq!(with_sum(&earlier), StoredMixture::Outdated);
        let mut later = earlier;
        later[0] = 99;
        assert_eq!(with_sum(&later).state(), "damaged");
        assert_eq!(with_sum(&[]).state(), "damaged");
        let empty = encode_mixture(&ReferenceMixture::default());
        let damaged = StoredMixture::Damaged {
            why: "it has no components".to_owned(),
        };
        assert_eq!(with_sum(&empty), damaged);
    }
}
