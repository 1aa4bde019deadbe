//! Times for people: local, with the name of the zone.

use jiff::Timestamp;
use jiff::tz::TimeZone;

/// A stamp of the log in local time; one of a clock that was not set says so. What is no time stays as it is.
pub(super) fn local_time(stamp: &str, clock_unset: bool) -> String {
    local_time_in(stamp, clock_unset, &TimeZone::system())
}

fn local_time_in(stamp: &str, clock_unset: bool, zone: &TimeZone) -> String {
    let Ok(at) = stamp.parse::<Timestamp>() else {
        return stamp.to_owned();
    };
    // A machine without a zone: UTC, whatever jiff calls it.
    let zone = if zone.is_unknown() {
        &TimeZone::UTC
    } else {
        zone
    };
    let note = if clock_unset { " (clock not set)" } else { "" };
    let text = at.to_zoned(zone.clone()).strftime("%Y-%m-%d %H:%M:%S %Z");
    format!("{text}{note}")
}

#[cfg(test)]
mod tests {
    use super::local_time_in;
    use jiff::tz::TimeZone;

    #[test]
    fn the_zone_is_named_and_an_unset_clock_noted() {
        let zone = TimeZone::posix("CET-1CEST,M3.5.0,M10.5.0/3").expect("a zone");
        let at = |stamp: &str, unset: bool| local_time_in(stamp, unset, &zone);
        assert_eq!(
            at("2027-01-15T10:00:00.000Z", false),
            "2027-01-15 11:00:00 CET"
        );
        assert_eq!(
            at("2027-07-15T10:00:00.000Z", false),
            "2027-07-15 12:00:00 CEST"
        );
        assert_eq!(
            at("1970-01-01T00:00:07.000Z", true),
            "1970-01-01 01:00:07 CET (clock not set)"
        );
        assert_eq!(at("", false), "");
        let utc = local_time_in("2027-01-15T10:00:00.000Z", false, &TimeZone::unknown());
        assert_eq!(utc, "2027-01-15 10:00:00 UTC");
    }
}
