//! The parts of a fault's text.

use crate::error::FaultTextError;
use crate::times::{EXPECTED_TIME, FaultTimes, parse_time};

/// A kind of fault: its name, and the keys that it has beside those of [`FaultTimes`].
pub type FaultKind = (&'static str, &'static [&'static str]);

/// The keys of one fault; each is of its kind.
#[derive(Debug, Clone)]
pub struct FaultKeys<'a> {
    kind: &'static str,
    pairs: Vec<(&'a str, &'a str)>,
}

impl<'a> FaultKeys<'a> {
    /// Splits `text`, whose kind must be one of `kinds`.
    ///
    /// # Errors
    /// An unknown kind or key, or a part without `=`.
    pub fn split(text: &'a str, kinds: &[FaultKind]) -> Result<Self, FaultTextError> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        let name = name.trim().replace('_', "-");
        let Some((kind, own)) = kinds.iter().find(|(kind, _)| *kind == name) else {
            let valid: Vec<&str> = kinds.iter().map(|(kind, _)| *kind).collect();
            return Err(FaultTextError::Kind {
                got: name,
                valid: valid.join(", "),
            });
        };
        let mut pairs = Vec::new();
        for part in rest.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (key, value) = part
                .split_once('=')
                .ok_or_else(|| FaultTextError::NotAPair {
                    kind: name.clone(),
                    got: part.to_owned(),
                })?;
            let (key, value) = (key.trim(), value.trim());
            if !FaultTimes::KEYS.contains(&key) && !own.contains(&key) {
                let valid = FaultTimes::KEYS.iter().chain(*own).copied();
                return Err(FaultTextError::Key {
                    kind: name,
                    key: key.to_owned(),
                    valid: valid.collect::<Vec<_>>().join(", "),
                });
            }
            pairs.push((key, value));
        }
        Ok(Self { kind, pairs })
    }

    /// The kind, as in its table.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// Times and count.
    ///
    /// # Errors
    /// A value that is not valid.
    pub fn times(&self) -> Result<FaultTimes, FaultTextError> {
        let time = |key| {
            self.get(key, None, EXPECTED_TIME, |value| {
                parse_time(value).map(Some)
            })
        };
        let every = self.get("every", None, "a time above 0", |value| {
            parse_time(value).filter(|time| !time.is_zero()).map(Some)
        })?;
        let count = self.get("count", None, "a whole number above 0", |value| {
            value.parse().ok().filter(|count| *count > 0).map(Some)
        })?;
        Ok(FaultTimes {
            at: time("at")?,
            lasting: time("for")?,
            count,
            every,
        })
    }

    /// The last value of `key`, or the default. `read` gives `None` for what is not `expected`.
    ///
    /// # Errors
    /// A value that is not valid.
    pub fn get<T>(
        &self,
        key: &str,
        default: T,
        expected: &'static str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Result<T, FaultTextError> {
        let Some((_, value)) = self.pairs.iter().rev().find(|(k, _)| *k == key) else {
            return Ok(default);
        };
        read(value).ok_or_else(|| FaultTextError::Value {
            kind: self.kind.to_owned(),
            key: key.to_owned(),
            expected,
            got: (*value).to_owned(),
        })
    }

    /// `true` or `false`; false by default.
    ///
    /// # Errors
    /// Another value.
    pub fn flag(&self, key: &str) -> Result<bool, FaultTextError> {
        self.get(key, false, "true or false", |value| value.parse().ok())
    }

    /// A whole number from 0.
    ///
    /// # Errors
    /// Another value.
    pub fn whole(&self, key: &str, default: u32) -> Result<u32, FaultTextError> {
        self.get(key, default, "a whole number from 0", |v| v.parse().ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const KINDS: [FaultKind; 2] = [("silence", &["deaf"]), ("bad-sum", &[])];

    #[test]
    fn a_text_is_a_kind_and_its_keys() {
        let keys = FaultKeys::split(
            " silence : at=300ms, for = 2s,count=3,every=10,deaf=true,deaf=false",
            &KINDS,
        )
        .expect("valid");
        assert_eq!((keys.kind(), keys.flag("deaf")), ("silence", Ok(false)));
        let times = FaultTimes {
            at: Some(Duration::from_millis(300)),
            lasting: Some(Duration::from_secs(2)),
            count: Some(3),
            every: Some(Duration::from_secs(10)),
        };
        assert_eq!(keys.times(), Ok(times));
        let bare = FaultKeys::split("bad_sum", &KINDS).expect("valid");
        assert_eq!(
            (bare.kind(), bare.times()),
            ("bad-sum", Ok(FaultTimes::default()))
        );
        assert_eq!(bare.whole("skip", 7), Ok(7));
    }

    #[test]
    fn errors_list_what_is_valid() {
        let error = |text: &str| {
            let keys = FaultKeys::split(text, &KINDS);
            let error = keys.and_then(|keys| {
                keys.flag("deaf")?;
                keys.times()
            });
            error.expect_err(text).to_string()
        };
        for (text, expected) in [
            (
                "melt:at=1",
                "expected a fault (silence, bad-sum), got `melt`",
            ),
            (
                "bad-sum:deaf=true",
                "fault `bad-sum` has no key `deaf`; valid keys: at, for, count, every",
            ),
            (
                "silence:mute=1",
                "fault `silence` has no key `mute`; valid keys: at, for, count, every, deaf",
            ),
            (
                "silence:at",
                "fault `silence`: expected `key=value`, got `at`",
            ),
            (
                "silence:deaf=1",
                "fault `silence`: expected deaf to be true or false, got `1`",
            ),
            (
                "silence:for=-1",
                "fault `silence`: expected for to be a time such as 2.5, 2.5s or 300ms, got `-1`",
            ),
            (
                "silence:count=0",
                "fault `silence`: expected count to be a whole number above 0, got `0`",
            ),
            (
                "silence:every=0",
                "fault `silence`: expected every to be a time above 0, got `0`",
            ),
        ] {
            assert_eq!(error(text), expected);
        }
    }
}
