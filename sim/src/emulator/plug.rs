//! The plugs of the emulated devices: unplugged at an instant, plugged in later, perhaps under another name. Pure.

use super::constants::MAX_PENDING_UNPLUGS;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

/// A device unplugged for a time: `unplug[:at=,for=,as=,power=]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnplugFault {
    /// Time from the start, or from the instant at which it is injected.
    pub at: Duration,
    /// `None`: for ever.
    pub duration: Option<Duration>,
    /// The link under which the port returns; `None`: the old one. A terminal is a new node either way.
    pub link: Option<PathBuf>,
    /// The device keeps its power and its state (a hub or an adapter dropped out); else it starts anew.
    pub keeps_power: bool,
}

impl FromStr for UnplugFault {
    type Err = String;

    /// Reads the settings after `unplug:`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut unplug = Self {
            at: Duration::ZERO,
            duration: None,
            link: None,
            keeps_power: false,
        };
        let seconds = |key: &str, value: &str| {
            let span = value.parse().ok().map(Duration::try_from_secs_f64);
            span.and_then(Result::ok).ok_or_else(|| {
                format!("fault `unplug`: expected {key} to be seconds, got `{value}`")
            })
        };
        for setting in text.split(',').map(str::trim).filter(|s| !s.is_empty()) {
            match setting.split_once('=') {
                Some(("at", value)) => unplug.at = seconds("at", value)?,
                Some(("for", value)) => unplug.duration = Some(seconds("for", value)?),
                Some(("as", path)) if !path.is_empty() => unplug.link = Some(path.into()),
                Some(("power", "kept")) => unplug.keeps_power = true,
                Some(("power", "lost")) => unplug.keeps_power = false,
                _ => {
                    return Err(format!(
                        "fault `unplug`: expected at=, for=, as=PATH, power=kept or power=lost, got `{setting}`"
                    ));
                }
            }
        }
        Ok(unplug)
    }
}

/// A change of a plug.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PlugEvent {
    Unplugged { power_lost: bool },
    PluggedIn { power_back: bool },
}

#[derive(Debug, Default)]
pub(super) struct Plug {
    /// By time.
    pending: Vec<UnplugFault>,
    /// The present fault, and when it ends.
    unplugged: Option<(UnplugFault, Duration)>,
    link: Option<PathBuf>,
}

impl Plug {
    pub(super) fn add(&mut self, unplug: UnplugFault) {
        if self.pending.len() < MAX_PENDING_UNPLUGS {
            self.pending.push(unplug);
            self.pending.sort_by_key(|unplug| unplug.at);
        }
    }

    pub(super) fn is_plugged_in(&self) -> bool {
        self.unplugged.is_none()
    }

    /// The link under which it returned last, if that fault named one.
    pub(super) fn link(&self) -> Option<&Path> {
        self.link.as_deref()
    }

    pub(super) fn next_event(&self) -> Option<Duration> {
        match &self.unplugged {
            Some((_, until)) => Some(*until).filter(|until| *until != Duration::MAX),
            None => self.pending.first().map(|unplug| unplug.at),
        }
    }

    /// The next change that is due by `now`.
    pub(super) fn poll_event(&mut self, now: Duration) -> Option<PlugEvent> {
        if let Some((unplug, _)) = self.unplugged.take_if(|(_, until)| *until <= now) {
            self.link = unplug.link.or(self.link.take());
            return Some(PlugEvent::PluggedIn {
                power_back: !unplug.keeps_power,
            });
        }
        if self.unplugged.is_some() || self.pending.first()?.at > now {
            return None;
        }
        let unplug = self.pending.remove(0);
        let from = now.max(unplug.at);
        let until = unplug
            .duration
            .map_or(Duration::MAX, |duration| from.saturating_add(duration));
        let power_lost = !unplug.keeps_power;
        self.unplugged = Some((unplug, until));
        Some(PlugEvent::Unplugged { power_lost })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Duration = Duration::from_secs(1);

    #[test]
    fn unplugged_plugged_in_and_unplugged_again() {
        let mut plug = Plug::default();
        plug.add("at=5".parse().expect("valid"));
        plug.add(
            "at=1,for=2,as=/dev/other,power=kept"
                .parse()
                .expect("valid"),
        );
        assert_eq!((plug.next_event(), plug.poll_event(S / 2)), (Some(S), None));
        let unplugged = |power_lost| Some(PlugEvent::Unplugged { power_lost });
        assert_eq!(plug.poll_event(S), unplugged(false));
        assert!(!plug.is_plugged_in() && plug.poll_event(2 * S).is_none());
        assert_eq!(plug.next_event(), Some(3 * S));
        assert_eq!(
            plug.poll_event(3 * S),
            Some(PlugEvent::PluggedIn { power_back: false })
        );
        assert_eq!(plug.link(), Some(Path::new("/dev/other")));
        assert_eq!(plug.poll_event(9 * S), unplugged(true));
        assert_eq!((plug.next_event(), plug.poll_event(99 * S)), (None, None));
    }

    #[test]
    fn errors_have_one_line() {
        for text in ["at=-1", "for=x", "as=", "power=half", "count=2", "at"] {
            let error = text.parse::<UnplugFault>().expect_err(text);
            assert!(error.contains("unplug") && !error.contains('\n'), "{error}");
        }
    }
}
