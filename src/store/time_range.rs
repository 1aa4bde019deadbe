//! Stretches of time as filters of the log. A record that was stamped before the clock was set has no known time: no stretch
//! leaves it out.

use super::connection::time_text;
use jiff::Timestamp;

/// Stamps below it come from a clock that was not set: no robot ran this program before. RFC 3339, as rows have it; the
/// partial indices of migration 0005 have the same text.
pub(super) const CLOCK_SET_FROM: &str = "2026-01-01T00:00:00.000Z";

/// A stretch of wall time, both ends included; `None`: open.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TimeRange {
    /// First instant.
    pub since: Option<Timestamp>,
    /// Last instant.
    pub until: Option<Timestamp>,
}

impl TimeRange {
    /// Whether it leaves nothing out.
    pub fn is_all(&self) -> bool {
        self.since.is_none() && self.until.is_none()
    }

    /// Both ends as rows have their stamps, for rows whose clock was set.
    pub(super) fn bounds(&self) -> [String; 2] {
        let since = self.since.map_or_else(String::new, time_text);
        let since = since.max(CLOCK_SET_FROM.to_owned());
        // Above every digit.
        let until = self.until.map_or_else(|| "~".to_owned(), time_text);
        [since, until]
    }
}

/// Whether a stamp of a row comes from a clock that was not set.
pub(super) fn is_clock_unset(stamp: &str) -> bool {
    stamp < CLOCK_SET_FROM
}

#[cfg(test)]
mod tests {
    use super::{CLOCK_SET_FROM, TimeRange, is_clock_unset};

    #[test]
    fn the_indices_of_the_migration_have_the_same_limit() {
        let migration = include_str!("../../migrations/0005_log_queries.sql");
        let limit = format!("WHERE at < '{CLOCK_SET_FROM}'");
        assert_eq!(migration.matches(&limit).count(), 2);
    }

    #[test]
    fn a_stamp_of_1970_is_unset_and_one_of_now_is_not() {
        assert!(is_clock_unset("1970-01-01T00:00:07.000Z"));
        assert!(is_clock_unset("2025-12-31T23:59:59.999Z"));
        assert!(!is_clock_unset(CLOCK_SET_FROM));
    }

    #[test]
    fn bounds_never_reach_below_the_first_known_time() {
        let range = TimeRange {
            since: "2020-01-01T00:00:00Z".parse().ok(),
            until: None,
        };
        let [since, until] = range.bounds();
        assert_eq!(since, CLOCK_SET_FROM);
        assert!(until.as_str() > "9999-12-31T23:59:59.999Z");
        assert!(TimeRange::default().is_all() && !range.is_all());
    }
}
