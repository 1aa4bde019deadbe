//! Faults of the emulated devices as text: `device.kind[:key=value,...]`.

use super::plug::UnplugFault;
use std::str::FromStr;
use std::time::Duration;

/// A fault of one of the two emulated devices.
#[derive(Debug, Clone, PartialEq)]
pub enum EmulatedFault {
    /// `laser.KIND`.
    Laser(scip::emulator::LaserFaultSpec),
    /// `ptu.KIND`.
    Head(ptu::emulator::HeadFaultSpec),
    /// `laser.unplug`: the port disappears.
    LaserUnplugged(UnplugFault),
    /// `ptu.unplug`.
    HeadUnplugged(UnplugFault),
}

/// Why a text is no [`EmulatedFault`]; one line that lists what is valid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EmulatedFaultError {
    /// No known device before the first `.`.
    #[error("fault `{0}`: expected laser.KIND or ptu.KIND, KIND for the laser one of {laser}; for the ptu one of {head}", laser = laser_kinds(), head = head_kinds())]
    Device(String),
    /// Unknown fault of the laser, or a wrong key or value.
    #[error("laser: {0}")]
    Laser(#[from] scip::emulator::LaserFaultParseError),
    /// Unknown fault of the head, or a wrong key or value.
    #[error("ptu: {0}")]
    Head(#[from] ptu::emulator::HeadFaultError),
    /// Wrong key or value of `unplug`.
    #[error("{0}")]
    Unplug(String),
}

/// The fault of the port and not of the device on it.
const UNPLUG: &str = "unplug";

fn laser_kinds() -> String {
    let kinds = scip::emulator::LaserFault::kinds().chain([UNPLUG]);
    kinds.collect::<Vec<_>>().join(", ")
}

fn head_kinds() -> String {
    let kinds = ptu::emulator::HeadFaultKind::kinds().chain([UNPLUG]);
    kinds.collect::<Vec<_>>().join(", ")
}

/// The settings of `unplug`; `None` for another fault.
fn parse_unplug(spec: &str) -> Option<Result<UnplugFault, EmulatedFaultError>> {
    let (kind, settings) = spec.split_once(':').unwrap_or((spec, ""));
    (kind.trim() == UNPLUG).then(|| settings.parse().map_err(EmulatedFaultError::Unplug))
}

impl EmulatedFault {
    /// The same with its time counted from `now`.
    pub(super) fn counted_from(mut self, now: Duration) -> Self {
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
            Some(("laser", spec)) => match parse_unplug(spec) {
                Some(unplug) => Ok(Self::LaserUnplugged(unplug?)),
                None => Ok(Self::Laser(spec.parse()?)),
            },
            Some(("ptu", spec)) => match parse_unplug(spec) {
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
    fn both_devices_have_their_faults_and_errors_list_them() {
        let ok = |text: &str| text.parse::<EmulatedFault>().expect("a fault");
        assert!(matches!(
            ok("laser.silence:at=2,for=1"),
            EmulatedFault::Laser(_)
        ));
        assert!(matches!(ok("ptu.event:which=T"), EmulatedFault::Head(_)));
        for (text, expected) in [
            ("camera.off", "garbage"),
            ("laser.off", "silence"),
            ("ptu.off", "stuck"),
            ("nothing", "power-cycle"),
            ("ptu.stuck:where=1", "axis"),
            ("laser.unplug:count=2", "power=kept"),
        ] {
            let error = text.parse::<EmulatedFault>().expect_err(text).to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
        for kind in head_kinds().split(", ") {
            ok(&format!("ptu.{kind}:at=1"));
        }
        for kind in laser_kinds().split(", ") {
            ok(&format!("laser.{kind}:at=1"));
        }
    }
}
