//! A mixture as JSON: `{"weights": [K], "means": [K][3], "covs": [K][6]}`, covariances as xx xy xz yy yz zz.

use super::constants::SEMI_DEFINITE_TOLERANCE;
use super::{Gaussian, Mixture, MixtureError};
use nalgebra::{Matrix3, Point3};
use serde::{Deserialize, Serialize};

/// The arrays of the JSON form, in metres and square metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MixtureRecord {
    /// Weights p_k.
    pub weights: Vec<f64>,
    /// Means mu_k, metres.
    pub means: Vec<[f64; 3]>,
    /// Covariances Sigma_k as xx xy xz yy yz zz, square metres.
    pub covs: Vec<[f64; 6]>,
}

/// The JSON form with covariances of either layout.
#[derive(Deserialize)]
struct RawRecord {
    weights: Vec<f64>,
    means: Vec<[f64; 3]>,
    covs: Vec<Covariance>,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "a covariance of another length than 6 numbers or 3 rows of 3"
)]
enum Covariance {
    Six([f64; 6]),
    Rows([[f64; 3]; 3]),
}

impl Covariance {
    /// xx xy xz yy yz zz, each the mean of both triangles.
    fn upper_triangle(&self, component: usize) -> Result<[f64; 6], MixtureError> {
        match self {
            Self::Six(six) => Ok(*six),
            Self::Rows(m) => {
                let largest = m.iter().flatten().fold(0.0, |a: f64, v| a.max(v.abs()));
                let apart = |(r, c): (usize, usize)| (m[r][c] - m[c][r]).abs();
                let sides = [(0, 1), (0, 2), (1, 2)].map(apart);
                if sides.iter().any(|a| *a > SEMI_DEFINITE_TOLERANCE * largest) {
                    let what = format!("covariance {component} is not symmetric");
                    return Err(MixtureError::Record(what));
                }
                let upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
                Ok(upper.map(|(r, c)| 0.5 * (m[r][c] + m[c][r])))
            }
        }
    }
}

impl MixtureRecord {
    /// Reads and checks a mixture. Covariances may also be 3 x 3 rows. Unknown keys are ignored, so that the output of a fit
    /// can be a start.
    ///
    /// # Errors
    /// [`MixtureError::Record`] for text of another form, else as [`Mixture::try_new`].
    pub fn parse(json: &str) -> Result<Mixture, MixtureError> {
        Self::parse_record(json)?.try_into()
    }

    /// The same where the weights may have any sum above zero: the weights as they stand, and the mixture of their shares.
    ///
    /// # Errors
    /// As [`MixtureRecord::parse`], and [`Mixture::from_masses`].
    pub fn parse_masses(json: &str) -> Result<(Vec<f64>, Mixture), MixtureError> {
        let mut record = Self::parse_record(json)?;
        let masses = record.weights.clone();
        let even = 1.0 / masses.len().max(1) as f64;
        record.weights.fill(even);
        let components = Mixture::try_from(record)?.components;
        let mixture = Mixture::from_masses(masses.clone(), components)?;
        Ok((masses, mixture))
    }

    fn parse_record(json: &str) -> Result<Self, MixtureError> {
        let record: RawRecord =
            serde_json::from_str(json).map_err(|e| MixtureError::Record(e.to_string()))?;
        let covs = record.covs.iter().enumerate();
        Ok(Self {
            weights: record.weights,
            means: record.means,
            covs: covs
                .map(|(k, c)| c.upper_triangle(k))
                .collect::<Result<_, _>>()?,
        })
    }
}

impl From<&Mixture> for MixtureRecord {
    fn from(mixture: &Mixture) -> Self {
        let cov = |g: &Gaussian| {
            let c = &g.covariance;
            [
                c[(0, 0)],
                c[(0, 1)],
                c[(0, 2)],
                c[(1, 1)],
                c[(1, 2)],
                c[(2, 2)],
            ]
        };
        Self {
            weights: mixture.weights.clone(),
            means: mixture.components.iter().map(|g| g.mean.into()).collect(),
            covs: mixture.components.iter().map(cov).collect(),
        }
    }
}

impl TryFrom<MixtureRecord> for Mixture {
    type Error = MixtureError;

    fn try_from(record: MixtureRecord) -> Result<Self, MixtureError> {
        let expected = record.weights.len();
        for (array, got) in [("means", record.means.len()), ("covs", record.covs.len())] {
            if got != expected {
                return Err(MixtureError::LengthsDiffer {
                    array,
                    got,
                    like: "weights",
                    expected,
                });
            }
        }
        let components = record
            .means
            .iter()
            .zip(&record.covs)
            .map(|(mean, &[xx, xy, xz, yy, yz, zz])| Gaussian {
                mean: Point3::from(*mean),
                covariance: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            })
            .collect();
        Mixture::try_new(record.weights, components)
    }
}

#[cfg(test)]
mod tests {
    use super::MixtureRecord;
    use crate::mixture::MixtureError;

    const TWO: &str = r#"{"weights":[0.25,0.75],"means":[[0.0,1.0,2.0],[3.0,4.0,5.0]],"covs":[[1.0,0.1,0.2,2.0,0.3,3.0],[1.0,0.0,0.0,1.0,0.0,0.0]]}"#;

    #[test]
    fn json_round_trip_gives_the_same_text() {
        let mixture = MixtureRecord::parse(TWO).expect("sound");
        assert_eq!(mixture.components[0].covariance[(2, 1)], 0.3);
        let text = serde_json::to_string(&MixtureRecord::from(&mixture)).expect("serialises");
        assert_eq!(text, TWO);
        let rows = TWO.replace(
            "[1.0,0.1,0.2,2.0,0.3,3.0]",
            "[[1.0,0.1,0.2],[0.1,2.0,0.3],[0.2,0.3,3.0]]",
        );
        assert_eq!(MixtureRecord::parse(&rows), Ok(mixture));
        let bent = rows.replace("[0.1,2.0,0.3]", "[0.2,2.0,0.3]");
        assert_eq!(
            MixtureRecord::parse(&bent),
            Err(MixtureError::Record(
                "covariance 0 is not symmetric".to_owned()
            ))
        );
    }

    #[test]
    fn masses_are_kept_as_they_stand() {
        let text = TWO.replace("0.25,0.75", "2.0,6.0");
        let (masses, mixture) = MixtureRecord::parse_masses(&text).expect("sound");
        assert_eq!(masses, [2.0, 6.0]);
        assert_eq!(Ok(mixture), MixtureRecord::parse(TWO));
        for wrong in ["0.0,0.0", "-1.0,2.0", "1.0"] {
            let text = TWO.replace("0.25,0.75", wrong);
            assert!(MixtureRecord::parse_masses(&text).is_err(), "{wrong}");
        }
    }

    #[test]
    fn bad_records_are_refused() {
        let refused = |text: &str| MixtureRecord::parse(text).expect_err("refused");
        let e = refused(&TWO.replace("[3.0,4.0,5.0]", "[3.0,4.0]"));
        assert!(
            matches!(&e, MixtureError::Record(m) if m.contains("length")),
            "{e}"
        );
        let e = refused(&TWO.replace("[0.25,0.75]", "[1.0]"));
        assert_eq!(
            e.to_string(),
            "`means` has 2 entries, expected 1 as `weights`"
        );
        let e = refused(&TWO.replace("0.75", "0.5"));
        assert_eq!(
            e.to_string(),
            "weights sum to 0.75, expected 1 within 0.000001"
        );
        let e = refused(&TWO.replace("0.25,0.75", "-0.25,1.25"));
        assert_eq!(
            e,
            MixtureError::BadWeight {
                component: 0,
                got: -0.25
            }
        );
        let e = refused(&TWO.replace("[1.0,0.1", "[1.0,5.1"));
        assert!(matches!(
            e,
            MixtureError::NotSemiDefinite { component: 0, .. }
        ));
        assert!(matches!(
            refused(&TWO.replace("0.25", "NaN")),
            MixtureError::Record(_)
        ));
        assert!(matches!(
            refused(&TWO.replace("0.25", "1e999")),
            MixtureError::Record(_)
        ));
    }
}
