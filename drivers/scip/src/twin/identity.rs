//! Who the sensor says it is: `VV`, `PP`, `II` and the `V` of SCIP1.1 (protocol sections 6, 9 and 12).

use super::constants::{DEFAULT_BAUD, RPM_PER_LEVEL};
use super::profile::{Profile, Scip1Lines, VENDOR};
use super::wire::push_keyed;

/// The lines of `VV`.
pub(super) fn push_version(out: &mut Vec<u8>, profile: &Profile) {
    push_keyed(out, &format!("VEND:{VENDOR}"));
    push_keyed(out, &format!("PROD:{}", profile.product));
    push_keyed(out, &format!("FIRM:{}", profile.firmware));
    push_keyed(out, "PROT:SCIP 2.0");
    push_keyed(out, &format!("SERI:{}", profile.serial));
}

/// The lines of `PP`.
pub(super) fn push_parameters(out: &mut Vec<u8>, profile: &Profile) {
    push_keyed(out, &format!("MODL:{}", profile.model));
    push_keyed(out, &format!("DMIN:{}", profile.min_range_mm));
    push_keyed(out, &format!("DMAX:{}", profile.max_range_mm));
    push_keyed(out, &format!("ARES:{}", profile.steps_per_revolution));
    push_keyed(out, &format!("AMIN:{}", profile.first_step));
    push_keyed(out, &format!("AMAX:{}", profile.last_step));
    push_keyed(out, &format!("AFRT:{}", profile.front_step));
    push_keyed(out, &format!("SCAN:{}", profile.speed_rpm));
}

/// What `II` tells besides the model.
pub(super) struct Condition {
    pub(super) laser: bool,
    pub(super) speed_level: u8,
    pub(super) sensitive: bool,
    pub(super) baud: u32,
    pub(super) timer: u32,
    pub(super) trouble: bool,
}

/// The lines of `II`. How a changed speed or bit rate is worded is not known: the plain value stands then.
pub(super) fn push_condition(out: &mut Vec<u8>, profile: &Profile, condition: &Condition) {
    push_keyed(out, &format!("MODL:{}", profile.model));
    push_keyed(
        out,
        if condition.laser {
            "LASR:ON"
        } else {
            "LASR:OFF"
        },
    );
    if condition.speed_level == 0 {
        push_keyed(
            out,
            &format!(
                "SCSP:Initial({}[rpm])<-Default setting by user",
                profile.speed_rpm
            ),
        );
    } else {
        push_keyed(
            out,
            &format!("SCSP:{}[rpm]", speed_rpm(profile, condition.speed_level)),
        );
    }
    push_keyed(
        out,
        match (condition.laser, condition.sensitive) {
            (false, _) => "MESM:IDLE",
            (true, false) => "MESM:CLASSIC",
            (true, true) => "MESM:Measuring by Sensitive Mode",
        },
    );
    match profile.usb_only_text {
        Some(text) => push_keyed(out, &format!("SBPS:{text}")),
        None if condition.baud == DEFAULT_BAUD => {
            push_keyed(
                out,
                &format!("SBPS:{DEFAULT_BAUD}[bps]<-Default setting by user"),
            );
        }
        None => push_keyed(out, &format!("SBPS:{}[bps]", condition.baud)),
    }
    push_keyed(out, &format!("TIME:{:06X}", condition.timer));
    push_keyed(
        out,
        if condition.trouble {
            "STAT:Trouble!! Error No. =[00->33]"
        } else {
            "STAT:Sensor works well."
        },
    );
}

/// The motor's speed at a level of `CR`.
pub(super) fn speed_rpm(profile: &Profile, level: u8) -> u32 {
    profile
        .speed_rpm
        .saturating_sub(RPM_PER_LEVEL * u32::from(level))
}

/// The lines of the SCIP1.1 `V`; no sums.
pub(super) fn push_scip1_version(out: &mut Vec<u8>, profile: &Profile, lines: &Scip1Lines) {
    let text = format!(
        "VEND:{VENDOR}\nPROD:{}\n{}\n{}\nSERI:{}\n{}\n",
        profile.product, lines.firmware, lines.protocol, profile.serial, lines.status
    );
    out.extend_from_slice(text.as_bytes());
}
