//! When a fault happens, and how often.

use std::time::Duration;

/// When a fault happens, for how long, and how often.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FaultTimes {
    /// Key `at`: from when on; `None`: at once.
    pub at: Option<Duration>,
    /// Key `for`: for how long; `None`: for ever, or the time of its kind.
    pub lasting: Option<Duration>,
    /// Key `count`: how often, above 0; `None`: as often as its kind does.
    pub count: Option<u32>,
    /// Key `every`: time from one to the next, above 0; `None`: the time of its kind.
    pub every: Option<Duration>,
}

impl FaultTimes {
    /// The keys that every kind has.
    pub const KEYS: [&'static str; 4] = ["at", "for", "count", "every"];

    /// The same with its start counted from `now`.
    #[must_use]
    pub fn counted_from(mut self, now: Duration) -> Self {
        self.at = Some(self.at.unwrap_or_default().saturating_add(now));
        self
    }

    /// When it begins for a device at `now`: an instant that has passed means at once.
    #[must_use]
    pub fn start(&self, now: Duration) -> Duration {
        self.at.map_or(now, |at| at.max(now))
    }
}

pub(crate) const EXPECTED_TIME: &str = "a time such as 2.5, 2.5s or 300ms";

/// Seconds, of either sign, as `2.5`, `2.5s` or `300ms`.
#[must_use]
pub fn parse_seconds(text: &str) -> Option<f64> {
    let (digits, divisor) = match text.strip_suffix("ms") {
        Some(ms) => (ms, 1e3),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    let seconds: f64 = digits.parse().ok()?;
    (seconds / divisor).is_finite().then_some(seconds / divisor)
}

/// The same, not negative.
#[must_use]
pub fn parse_time(text: &str) -> Option<Duration> {
    Duration::try_from_secs_f64(parse_seconds(text)?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn times_are_seconds_in_three_spellings() {
        for (text, time) in [
            ("2.5", Some(2500 * MS)),
            ("2.5s", Some(2500 * MS)),
            ("300ms", Some(300 * MS)),
            ("0", Some(Duration::ZERO)),
            ("-1", None),
            ("nan", None),
            ("inf", None),
            ("3m", None),
            ("", None),
            ("ms", None),
            ("1e300", None),
        ] {
            assert_eq!(parse_time(text), time, "{text}");
        }
        assert_eq!(parse_seconds("-1500ms"), Some(-1.5));
    }

    #[test]
    fn a_start_counts_from_an_instant_and_never_lies_before_now() {
        let at = |ms| FaultTimes {
            at: Some(ms * MS),
            ..FaultTimes::default()
        };
        assert_eq!(at(20).counted_from(5 * MS).at, Some(25 * MS));
        assert_eq!(FaultTimes::default().counted_from(5 * MS).at, Some(5 * MS));
        assert_eq!(at(20).start(5 * MS), 20 * MS);
        assert_eq!(at(20).start(50 * MS), 50 * MS);
        assert_eq!(FaultTimes::default().start(5 * MS), 5 * MS);
    }
}
