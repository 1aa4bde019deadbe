//! When something happened, as rows have it.

/// When something happened. The boot id is kept because the wall clock may be wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordTime {
    /// Wall clock, UTC.
    pub at: jiff::Timestamp,
    /// The kernel's boot id.
    pub boot_id: String,
}

impl RecordTime {
    /// RFC 3339 in UTC, always with milliseconds, so that the texts sort as the times.
    pub fn to_rfc3339(&self) -> String {
        time_text(self.at)
    }
}

pub(in crate::store) fn time_text(at: jiff::Timestamp) -> String {
    format!("{at:.3}")
}
