//! Options that select a stretch of the log.

use super::time_arg;
use crate::store::TimeRange;
use clap::Args;
use jiff::Timestamp;

#[derive(Debug, Clone, Copy, Args)]
pub(super) struct RangeArgs {
    /// Only from this time on: RFC 3339, a date or time (local), today, yesterday, or -3h (ago)
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = time_arg::parse_time)]
    since: Option<Timestamp>,
    /// Only up to this time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = time_arg::parse_time)]
    until: Option<Timestamp>,
}

impl RangeArgs {
    pub(super) fn range(&self) -> TimeRange {
        TimeRange {
            since: self.since,
            until: self.until,
        }
    }
}
