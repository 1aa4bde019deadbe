//! Times as options take them. What names no zone is local time.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use jiff::{Span, ToSpan as _, Zoned};

/// Reads an RFC 3339 time, a date or a date with a time (local), `today`, `yesterday`, or a time ago (`-1h`, `2h`, `3d`).
pub(super) fn parse_time(text: &str) -> Result<Timestamp, String> {
    parse_time_at(text, &Zoned::now())
}

fn parse_time_at(text: &str, now: &Zoned) -> Result<Timestamp, String> {
    let midnight = |ago: Span| {
        let at = now.checked_sub(ago).and_then(|then| then.start_of_day());
        at.map(|at| at.timestamp())
            .map_err(|error| error.to_string())
    };
    match text {
        "now" => return Ok(now.timestamp()),
        "today" => return midnight(0.days()),
        "yesterday" => return midnight(1.day()),
        _ => {}
    }
    if let Ok(at) = text.parse::<Timestamp>() {
        return Ok(at);
    }
    if let Ok(at) = text.parse::<DateTime>() {
        return local(now.time_zone(), at);
    }
    let ago = text.parse::<Span>().ok().and_then(|span| {
        let at = now.checked_sub(span.abs()).ok()?;
        Some(at.timestamp())
    });
    ago.ok_or_else(|| {
        format!("expected a time like 2026-11-22T08:00:00Z, 2026-11-22, today, yesterday or -3h, got {text:?}")
    })
}

fn local(zone: &TimeZone, at: DateTime) -> Result<Timestamp, String> {
    zone.to_timestamp(at).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::parse_time_at;
    use jiff::tz::TimeZone;
    use jiff::{Timestamp, Zoned};

    fn noon_in(zone: &str) -> Zoned {
        let now: Timestamp = "2026-11-22T12:00:00Z".parse().expect("a time");
        now.to_zoned(TimeZone::posix(zone).expect("a zone"))
    }

    #[test]
    fn every_form_is_read() {
        let now = noon_in("UTC0");
        let at = |text: &str| parse_time_at(text, &now).map(|t| t.to_string());
        for (text, expected) in [
            ("2026-11-22T08:00:00+01:00", "2026-11-22T07:00:00Z"),
            ("2026-11-20", "2026-11-20T00:00:00Z"),
            ("2026-11-20T10:30:00", "2026-11-20T10:30:00Z"),
            ("3h", "2026-11-22T09:00:00Z"),
            ("-3h", "2026-11-22T09:00:00Z"),
            ("-90m", "2026-11-22T10:30:00Z"),
            ("2d", "2026-11-20T12:00:00Z"),
            ("now", "2026-11-22T12:00:00Z"),
            ("today", "2026-11-22T00:00:00Z"),
            ("yesterday", "2026-11-21T00:00:00Z"),
        ] {
            assert_eq!(at(text).as_deref(), Ok(expected), "{text}");
        }
        assert!(at("yesterday-ish").is_err());
    }

    #[test]
    fn what_names_no_zone_is_local() {
        // Two hours east, and one hour more in summer.
        let now = noon_in("EET-2EEST,M3.5.0/3,M10.5.0/4");
        let at = |text: &str| parse_time_at(text, &now).map(|t| t.to_string());
        assert_eq!(at("today").as_deref(), Ok("2026-11-21T22:00:00Z"));
        assert_eq!(at("yesterday").as_deref(), Ok("2026-11-20T22:00:00Z"));
        assert_eq!(
            at("2026-07-01T03:00").as_deref(),
            Ok("2026-07-01T00:00:00Z")
        );
        assert_eq!(
            at("2026-07-01T03:00:00Z").as_deref(),
            Ok("2026-07-01T03:00:00Z")
        );
    }
}
