//! Faults of the emulated devices as text: `device.kind[:key=value,...]`.

use std::str::FromStr;

/// A fault of one of the two twins.
#[derive(Debug, Clone, PartialEq)]
pub enum EmulatedFault {
    /// `laser.KIND`.
    Laser(scip::twin::FaultSpec),
    /// `ptu.KIND`.
    Head(ptu::twin::FaultSpec),
}

/// Why a text is no [`EmulatedFault`]; one line with what would be one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EmulatedFaultError {
    /// Nothing valid before the point.
    #[error("fault `{0}`: expected laser.KIND or ptu.KIND, KIND for the laser one of {laser}; for the ptu one of {head}", laser = laser_kinds(), head = HEAD_KINDS)]
    Device(String),
    /// A laser's fault that does not exist or has other keys.
    #[error("laser: {0}")]
    Laser(#[from] scip::twin::FaultParseError),
    /// A head's fault that does not exist or has other keys.
    #[error("ptu: {0}")]
    Head(#[from] ptu::twin::FaultError),
}

/// The kinds of the head's twin, in the order of its documentation.
const HEAD_KINDS: &str = "lost-steps, stuck, slow, event, text, echo, verbose, silence, lost-byte, garbage-byte, reset-fails, power-cycle, wrong-baud";

fn laser_kinds() -> String {
    scip::twin::Fault::kinds().collect::<Vec<_>>().join(", ")
}

impl FromStr for EmulatedFault {
    type Err = EmulatedFaultError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.trim().split_once('.') {
            Some(("laser", spec)) => Ok(Self::Laser(spec.parse()?)),
            Some(("ptu", spec)) => Ok(Self::Head(spec.parse()?)),
            _ => Err(EmulatedFaultError::Device(text.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{EmulatedFault, HEAD_KINDS};

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
        ] {
            let told = text.parse::<EmulatedFault>().expect_err(text).to_string();
            assert!(told.contains(word) && !told.contains('\n'), "{told}");
        }
        for kind in HEAD_KINDS.split(", ") {
            ok(&format!("ptu.{kind}"));
        }
    }
}
