//! Times as options take them.

use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use jiff::{Span, Timestamp};

/// Reads an RFC 3339 time, a date or a date with a time (UTC), or a time ago (`2h`, `3d`).
pub(super) fn parse_time(text: &str) -> Result<Timestamp, String> {
    parse_time_at(text, Timestamp::now())
}

fn parse_time_at(text: &str, now: Timestamp) -> Result<Timestamp, String> {
    if let Ok(at) = text.parse::<Timestamp>() {
        return Ok(at);
    }
    if let Ok(at) = text.parse::<DateTime>() {
        return TimeZone::UTC
            .to_timestamp(at)
            .map_err(|error| error.to_string());
    }
    let ago = text.parse::<Span>().ok().and_then(|span| {
        let at = now.to_zoned(TimeZone::UTC).checked_sub(span.abs()).ok()?;
        Some(at.timestamp())
    });
    ago.ok_or_else(|| {
        format!("expected a time like 2026-11-22T08:00:00Z, 2026-11-22 or 3h (ago), got {text:?}")
    })
}

#[cfg(test)]
mod tests {
    use super::parse_time_at;
    use jiff::Timestamp;

    #[test]
    fn every_form_is_read() {
        let now: Timestamp = "2026-11-22T12:00:00Z".parse().expect("a time");
        let at = |text: &str| parse_time_at(text, now).map(|t| t.to_string());
        assert_eq!(
            at("2026-11-22T08:00:00+01:00").as_deref(),
            Ok("2026-11-22T07:00:00Z")
        );
        assert_eq!(at("2026-11-20").as_deref(), Ok("2026-11-20T00:00:00Z"));
        assert_eq!(
            at("2026-11-20T10:30:00").as_deref(),
            Ok("2026-11-20T10:30:00Z")
        );
        assert_eq!(at("3h").as_deref(), Ok("2026-11-22T09:00:00Z"));
        assert_eq!(at("2d").as_deref(), Ok("2026-11-20T12:00:00Z"));
        assert!(at("yesterday-ish").is_err());
    }
}
