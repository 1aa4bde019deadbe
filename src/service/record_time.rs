//! The time of a record in the store.

use crate::store::RecordTime;
use jiff::Timestamp;
use std::fs;

/// random(4).
const BOOT_ID: &str = "/proc/sys/kernel/random/boot_id";

/// Wall time now, with the id of this boot.
pub fn record_time_now() -> RecordTime {
    let boot_id = fs::read_to_string(BOOT_ID).unwrap_or_default();
    RecordTime {
        at: Timestamp::now(),
        boot_id: boot_id.trim().to_owned(),
    }
}
