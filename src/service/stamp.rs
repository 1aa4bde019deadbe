//! The moment that goes into the log.

use crate::store::Stamp;
use jiff::Timestamp;
use std::fs;

/// Where Linux tells the id of this run of the machine.
const BOOT_ID: &str = "/proc/sys/kernel/random/boot_id";

/// Now, in this run of the machine.
pub fn stamp_now() -> Stamp {
    let boot_id = fs::read_to_string(BOOT_ID).unwrap_or_default();
    Stamp {
        at: Timestamp::now(),
        boot_id: boot_id.trim().to_owned(),
    }
}
