//! What a guard says about an alarm after having been there.

use std::fmt;

/// A guard's answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AlarmAnswer {
    /// Something had changed.
    Confirmed,
    /// Nothing had changed.
    FalseAlarm,
}

impl AlarmAnswer {
    /// As in the database and in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::FalseAlarm => "false_alarm",
        }
    }

    /// From the text of [`AlarmAnswer::as_str`].
    pub fn from_text(text: &str) -> Option<Self> {
        [Self::Confirmed, Self::FalseAlarm]
            .into_iter()
            .find(|answer| answer.as_str() == text)
    }
}

impl fmt::Display for AlarmAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Confirmed => "confirmed",
            Self::FalseAlarm => "a false alarm",
        })
    }
}
