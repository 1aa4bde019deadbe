//! The identity of a connected laser.

use crate::command::parameters::LaserParameters;

/// From the replies to `VV`, `PP` and `II`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LaserIdentity {
    /// `MODL`.
    pub model: String,
    /// `VEND`.
    pub vendor: String,
    /// `PROD`.
    pub product: String,
    /// `FIRM`.
    pub firmware: String,
    /// `PROT`.
    pub protocol: String,
    /// `SERI`, as sent. Old units send `0` for the first letter: compare the digits only.
    pub serial: String,
    /// The numbers of `PP`.
    pub parameters: LaserParameters,
    /// `STAT` of `II`.
    pub status: String,
    /// Bytes per second of the line, where it has a rate: as given in the options, or as `SBPS` of `II` names it where the
    /// replies came as slowly as that (over USB `SBPS` names a rate too).
    pub line_bytes_s: Option<u32>,
}

/// Model names with intensity (scip2 sections 6 and 10).
const MODELS_WITH_INTENSITY: [&str; 3] = ["UTM-", "UST-", "UXM-"];

impl LaserIdentity {
    /// Whether the model is known to measure intensity.
    #[must_use]
    pub fn has_intensity(&self) -> bool {
        let names = [&self.model, &self.product];
        MODELS_WITH_INTENSITY
            .iter()
            .any(|known| names.iter().any(|name| name.contains(known)))
    }
}
