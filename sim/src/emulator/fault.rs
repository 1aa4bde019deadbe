//! Faults of the emulated devices as text: `device.kind[:key=value,...]`.

use super::plug::Unplug;
use std::str::FromStr;
use std::time::Duration;

/// A fault of one of the two twins.
#[derive(Debug, Clone, PartialEq)]
pub enum EmulatedFault {
    /// `laser.KIND`.
    Laser(scip::twin::FaultSpec),
    /// `ptu.KIND`.
    Head(ptu::twin::FaultSpec),
    /// `laser.unplug`: its port vanishes.
    LaserUnplugged(Unplug),
    /// `ptu.unplug`.
    HeadUnplugged(Unplug),
}

/// Why a text is no [`EmulatedFault`]; one line with what would be one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EmulatedFaultError {
    /// Nothing valid before the point.
    #[error("fault `{0}`: expected laser.KIND or ptu.KIND, KIND for the laser one of {laser}; for the ptu one of {head}", laser = laser_kinds(), head = head_kinds())]
    Device(String),
    /// A laser's fault that does not exist or has other keys.
    #[error("laser: {0}")]
    Laser(#[from] scip::twin::FaultParseError),
    /// A head's fault that does not exist or has other keys.
    #[error("ptu: {0}")]
    Head(#[from] ptu::twin::FaultError),
    /// A plug pulled with other keys.
    #[error("{0}")]
    Plug(String),
}

/// The fault that concerns a port and not what hangs on it.
const UNPLUG: &str = "unplug";

fn laser_kinds() -> String {
    let kinds = scip::twin::Fault::kinds().chain([UNPLUG]);
    kinds.collect::<Vec<_>>().join(", ")
}

fn head_kinds() -> String {
    let kinds = ptu::twin::FaultKind::kinds().chain([UNPLUG]);
    kinds.collect::<Vec<_>>().join(", ")
}

/// The settings of `unplug`, if that is the fault.
fn unplug(spec: &str) -> Option<Result<Unplug, EmulatedFaultError>> {
    let (kind, settings) = spec.split_once(':').unwrap_or((spec, ""));
    (kind.trim() == UNPLUG).then(|| settings.parse().map_err(EmulatedFaultError::Plug))
}

impl EmulatedFault {
    /// The same with its time counted from `now`, at which it is given.
    pub(super) fn given_at(mut self, now: Duration) -> Self {
        match &mut self {
            Self::Laser(spec) => spec.at = spec.at.saturating_add(now),
            Self::Head(spec) => spec.at = spec.at.map(|at| at.saturating_add(now)),
            Self::LaserUnplugged(unplug) | Self::HeadUnplugged(unplug) => {
                unplug.at = unplug.at.saturating_add(now);
            }
        }
        self
    }
}

impl FromStr for EmulatedFault {
    type Err = EmulatedFaultError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.trim().split_once('.') {
            Some(("laser", spec)) => match unplug(spec) {
                Some(unplug) => Ok(Self::LaserUnplugged(unplug?)),
                None => Ok(Self::Laser(spec.parse()?)),
            },
            Some(("ptu", spec)) => match unplug(spec) {
                Some(unplug) => Ok(Self::HeadUnplugged(unplug?)),
                None => Ok(Self::Head(spec.parse()?)),
            },
            _ => Err(EmulatedFaultError::Device(text.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{EmulatedFault, head_kinds, laser_kinds};

    #[test]
    fn both_devices_have_their_faults_and_mistakes_list_them() {
        let ok = |text: &str| text.parse::<EmulatedFault>().expect("a fault");
        assert!(matches!(
            ok("laser.silence:at=2,for=1"),
            EmulatedFault::Laser(_)
        ));
        assert!(matches!(ok("ptu.event:which=T"), EmulatedFault::Head(_)));
        for (text, word) in [
            ("camera.off", "garbage"),
            ("laser.off", "silence"),
            ("ptu.off", "stuck"),
            ("nothing", "power-cycle"),
            ("ptu.stuck:where=1", "axis"),
            ("laser.unplug:count=2", "power=kept"),
        ] {
            let told = text.parse::<EmulatedFault>().expect_err(text).to_string();
            assert!(told.contains(word) && !told.contains('\n'), "{told}");
        }
        for kind in head_kinds().split(", ") {
            ok(&format!("ptu.{kind}:at=1"));
        }
        for kind in laser_kinds().split(", ") {
            ok(&format!("laser.{kind}:at=1"));
        }
    }
}
