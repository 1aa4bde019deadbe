//! A counted mixture as JSON: the form of a mixture with `"beams": [K]` and `"surface_m2"`.

use super::{CountedMixture, MixtureError, MixtureRecord};
use serde::{Deserialize, Serialize};

/// The arrays of the JSON form.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CountedMixtureRecord {
    /// Weights, means, covariances.
    #[serde(flatten)]
    pub mixture: MixtureRecord,
    /// Beams of each component.
    pub beams: Vec<f64>,
    /// Area of which the weights are shares, square metres.
    pub surface_m2: f64,
}

/// What may stand beside a mixture.
#[derive(Deserialize)]
struct RawCounts {
    beams: Option<Vec<f64>>,
    points: Option<f64>,
    surface_m2: Option<f64>,
}

impl CountedMixtureRecord {
    /// Reads and checks a mixture with its beams. Without `beams` each component has its weight's share of `points` (which
    /// `patrold fit` writes), without that of one beam. Without `surface_m2` the area is derived
    /// ([`CountedMixture::try_new`]). Other keys are ignored.
    ///
    /// # Errors
    /// As [`MixtureRecord::parse`] and [`CountedMixture::try_new`].
    pub fn parse(json: &str) -> Result<CountedMixture, MixtureError> {
        let mixture = MixtureRecord::parse(json)?;
        let counts: RawCounts =
            serde_json::from_str(json).map_err(|e| MixtureError::Record(e.to_string()))?;
        match counts.beams {
            Some(beams) => CountedMixture::try_new(mixture, beams, counts.surface_m2),
            None => {
                let total = counts.points.unwrap_or(1.0);
                CountedMixture::with_total_beams(mixture, total, counts.surface_m2)
            }
        }
    }
}

impl From<&CountedMixture> for CountedMixtureRecord {
    fn from(counted: &CountedMixture) -> Self {
        Self {
            mixture: counted.mixture().into(),
            beams: counted.beams().to_vec(),
            surface_m2: counted.surface_m2(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::CountedMixtureRecord;
    use crate::mixture::MixtureError;

    const BARE: &str = r#"{"weights":[0.25,0.75],"means":[[0.0,1.0,2.0],[30.0,4.0,5.0]],"covs":[[1.0,0.1,0.2,2.0,0.3,3.0],[1.0,0.0,0.0,1.0,0.0,0.0]]"#;

    fn with(keys: &str) -> String {
        format!("{BARE}{keys}}}")
    }

    #[test]
    fn beams_are_read_or_follow_from_the_points() {
        let beams = |keys: &str| {
            let counted = CountedMixtureRecord::parse(&with(keys)).expect("sound");
            counted.beams().to_vec()
        };
        assert_eq!(beams(""), [0.25, 0.75]);
        assert_eq!(beams(r#","points":400"#), [100.0, 300.0]);
        assert_eq!(beams(r#","points":400,"beams":[7,9.5]"#), [7.0, 9.5]);
        let text = with(r#","beams":[7.0,9.5],"surface_m2":12.5"#);
        let counted = CountedMixtureRecord::parse(&text).expect("sound");
        let again = serde_json::to_string(&CountedMixtureRecord::from(&counted));
        assert_eq!(again.expect("serialises"), text);
    }

    #[test]
    fn counts_that_are_none_are_refused() {
        let refused = |keys: &str| CountedMixtureRecord::parse(&with(keys)).expect_err("refused");
        assert!(matches!(
            refused(r#","beams":[1.0,0.0]"#),
            MixtureError::BadBeams { component: 1, .. }
        ));
        assert!(matches!(
            refused(r#","points":0"#),
            MixtureError::BadBeams { component: 0, .. }
        ));
        assert!(matches!(
            refused(r#","beams":"many""#),
            MixtureError::Record(_)
        ));
        assert!(matches!(
            refused(r#","surface_m2":0"#),
            MixtureError::BadSetting { .. }
        ));
    }
}
