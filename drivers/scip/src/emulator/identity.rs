//! Replies with identity and condition: `VV`, `PP`, `II` and the `V` of SCIP 1.1 (scip2 sections 6, 9 and 12).

use super::constants::{DEFAULT_BAUD, RPM_PER_LEVEL};
use super::profile::{LaserGeneration, LaserProfile, Scip1Lines};
use super::wire::{push_keyed, push_number};

/// Writes `KEY:value;` lines with the sums of a profile.
struct KeyedLines<'a> {
    out: &'a mut Vec<u8>,
    profile: &'a LaserProfile,
}

impl KeyedLines<'_> {
    fn push(&mut self, key: &str, value: impl std::fmt::Display) {
        push_keyed(self.out, &format!("{key}:{value}"), self.profile.keyed_sum);
    }
}

/// The lines of `VV`.
pub(super) fn push_version(out: &mut Vec<u8>, profile: &LaserProfile) {
    let mut lines = KeyedLines { out, profile };
    lines.push("VEND", profile.vendor);
    lines.push("PROD", profile.product);
    lines.push("FIRM", &profile.firmware);
    lines.push("PROT", profile.protocol);
    lines.push("SERI", &profile.serial);
}

/// The lines of `PP`; those of Ethernet models include `PROT`.
pub(super) fn push_parameters(out: &mut Vec<u8>, profile: &LaserProfile) {
    let mut lines = KeyedLines { out, profile };
    lines.push("MODL", profile.model);
    lines.push("DMIN", profile.min_range_mm);
    lines.push("DMAX", profile.max_range_mm);
    if profile.generation.is_ethernet() {
        lines.push("PROT", profile.protocol);
    }
    lines.push("ARES", profile.steps_per_revolution);
    lines.push("AMIN", profile.first_step);
    lines.push("AMAX", profile.last_step);
    lines.push("AFRT", profile.front_step);
    lines.push("SCAN", profile.speed_rpm);
}

/// What `II` reports besides the model.
pub(super) struct DeviceCondition {
    pub(super) laser_on: bool,
    pub(super) speed_level: u8,
    pub(super) sensitive: bool,
    pub(super) baud: u32,
    pub(super) timer: u32,
    pub(super) trouble: bool,
    pub(super) firmware_update: bool,
}

/// The lines of `II`. The text of a changed speed or bit rate is not known: the plain value.
pub(super) fn push_info(out: &mut Vec<u8>, profile: &LaserProfile, condition: &DeviceCondition) {
    let ethernet = profile.generation.is_ethernet();
    let mut lines = KeyedLines { out, profile };
    lines.push("MODL", profile.model);
    lines.push("LASR", if condition.laser_on { "ON" } else { "OFF" });
    if ethernet {
        lines.push("SCSP", profile.speed_rpm);
    } else if condition.speed_level == 0 {
        lines.push(
            "SCSP",
            format!(
                "Initial({}[rpm])<-Default setting by user",
                profile.speed_rpm
            ),
        );
    } else {
        let rpm = speed_rpm(profile, condition.speed_level);
        lines.push("SCSP", format!("{rpm}[rpm]"));
    }
    lines.push("MESM", mode(profile.generation, condition));
    match profile.usb_only_text {
        Some(text) => lines.push("SBPS", text),
        None if condition.baud == DEFAULT_BAUD => lines.push(
            "SBPS",
            format!("{DEFAULT_BAUD}[bps]<-Default setting by user"),
        ),
        None => lines.push("SBPS", format!("{}[bps]", condition.baud)),
    }
    if ethernet {
        let mut time = Vec::new();
        push_number(&mut time, condition.timer, 4);
        lines.push("TIME", String::from_utf8_lossy(&time));
    } else {
        lines.push("TIME", format!("{:06X}", condition.timer));
    }
    lines.push(
        "STAT",
        match (condition.trouble, profile.generation) {
            (true, _) => "Trouble!! Error No. =[00->33]",
            (false, LaserGeneration::Ethernet) => "sensor is working normally",
            (false, _) => "Sensor works well.",
        },
    );
    if condition.firmware_update {
        lines.push("UDST", "F/W update mode (CPU clock is 6MHz)");
    }
}

/// `MESM`. The texts of the UTM are not on record: those of the URG.
fn mode(generation: LaserGeneration, condition: &DeviceCondition) -> &'static str {
    match (condition.laser_on, condition.sensitive, generation) {
        (_, _, LaserGeneration::Ethernet) | (true, true, _) => "Measuring by Sensitive Mode",
        (false, ..) => "IDLE",
        (true, false, _) => "CLASSIC",
    }
}

/// Speed at a level of `CR`.
pub(super) fn speed_rpm(profile: &LaserProfile, level: u8) -> u32 {
    profile
        .speed_rpm
        .saturating_sub(RPM_PER_LEVEL * u32::from(level))
}

/// The lines of the SCIP 1.1 `V`, without sums.
pub(super) fn push_scip1_version(out: &mut Vec<u8>, profile: &LaserProfile, lines: &Scip1Lines) {
    let text = format!(
        "VEND:{}\nPROD:{}\n{}\n{}\nSERI:{}\n{}\n",
        profile.vendor,
        profile.product,
        lines.firmware,
        lines.protocol,
        profile.serial,
        lines.status
    );
    out.extend_from_slice(text.as_bytes());
}
