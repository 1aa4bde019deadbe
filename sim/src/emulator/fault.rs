//! Faults of the emulated devices as text: `device.kind[:key=value,...]`.

use super::plug::UnplugFault;
use fault_text::FaultTextError;
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
    /// Unknown fault of the device, or a wrong key or value.
    #[error("{device}: {source}")]
    Fault {
        /// `laser` or `ptu`.
        device: &'static str,
        /// What is wrong.
        source: FaultTextError,
    },
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

/// Whether it is the fault of a port.
fn is_unplug(spec: &str) -> bool {
    let (kind, _) = spec.split_once(':').unwrap_or((spec, ""));
    kind.trim() == UNPLUG
}

impl EmulatedFault {
    /// The same with its time counted from `now`.
    pub(super) fn counted_from(mut self, now: Duration) -> Self {
        let times = match &mut self {
            Self::Laser(spec) => &mut spec.times,
            Self::Head(spec) => &mut spec.times,
            Self::LaserUnplugged(unplug) | Self::HeadUnplugged(unplug) => &mut unplug.times,
        };
        *times = times.counted_from(now);
        self
    }
}

impl FromStr for EmulatedFault {
    type Err = EmulatedFaultError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let of = |device| move |source| EmulatedFaultError::Fault { device, source };
        match text.trim().split_once('.') {
            Some(("laser", spec)) if is_unplug(spec) => {
                spec.parse().map(Self::LaserUnplugged).map_err(of("laser"))
            }
            Some(("laser", spec)) => spec.parse().map(Self::Laser).map_err(of("laser")),
            Some(("ptu", spec)) if is_unplug(spec) => {
                spec.parse().map(Self::HeadUnplugged).map_err(of("ptu"))
            }
            Some(("ptu", spec)) => spec.parse().map(Self::Head).map_err(of("ptu")),
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
            ("laser.unplug:pin=2", "at, for, count, every, as, power"),
            ("ptu.unplug:power=half", "ptu: fault `unplug`"),
        ] {
            let error = text.parse::<EmulatedFault>().expect_err(text).to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
        // One grammar for all of them.
        let times = "at=300ms,for=2,count=2,every=1.5s";
        for kind in head_kinds().split(", ") {
            ok(&format!("ptu.{kind}:{times}"));
            ok(&format!("ptu.{}:{times}", kind.replace('-', "_")));
        }
        for kind in laser_kinds().split(", ") {
            ok(&format!("laser.{kind}:{times}"));
            ok(&format!("laser.{}:{times}", kind.replace('-', "_")));
        }
    }
}
