//! The plugs of the emulated devices: pulled at an instant, put in again later, perhaps under another name. Pure.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

/// A plug pulled: `unplug[:at=,for=,as=,power=]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unplug {
    /// When.
    pub at: Duration,
    /// For how long; `None` for ever.
    pub lasting: Option<Duration>,
    /// The link under which the port comes back; `None`: the old one. A terminal is a new node either way.
    pub link: Option<PathBuf>,
    /// The device keeps its power and what it was doing (a hub or an adapter dropped out); else it starts anew.
    pub keeps_power: bool,
}

impl FromStr for Unplug {
    type Err = String;

    /// Reads the settings after `unplug:`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut unplug = Self {
            at: Duration::ZERO,
            lasting: None,
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
                Some(("for", value)) => unplug.lasting = Some(seconds("for", value)?),
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

/// Most pulls that wait; further ones are ignored.
const MOST_WAITING: usize = 64;

/// What happened to a plug.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PlugEvent {
    /// Pulled; if the device lost its power by it.
    Pulled { power_lost: bool },
    /// Put in again.
    PutIn { power_back: bool },
}

/// One plug.
#[derive(Debug, Default)]
pub(super) struct Plug {
    waiting: Vec<Unplug>,
    /// The pull that holds, and when it ends.
    pulled: Option<(Unplug, Duration)>,
    link: Option<PathBuf>,
}

impl Plug {
    /// Sets a pull.
    pub(super) fn add(&mut self, unplug: Unplug) {
        if self.waiting.len() < MOST_WAITING {
            self.waiting.push(unplug);
            self.waiting.sort_by_key(|unplug| unplug.at);
        }
    }

    /// Whether it is in.
    pub(super) fn is_in(&self) -> bool {
        self.pulled.is_none()
    }

    /// The link under which it came back last, if that was told.
    pub(super) fn link(&self) -> Option<&Path> {
        self.link.as_deref()
    }

    /// When something happens next.
    pub(super) fn next_event(&self) -> Option<Duration> {
        match &self.pulled {
            Some((_, until)) => Some(*until).filter(|until| *until != Duration::MAX),
            None => self.waiting.first().map(|unplug| unplug.at),
        }
    }

    /// The next thing that has happened by `now`.
    pub(super) fn happen(&mut self, now: Duration) -> Option<PlugEvent> {
        if let Some((unplug, _)) = self.pulled.take_if(|(_, until)| *until <= now) {
            self.link = unplug.link.or(self.link.take());
            return Some(PlugEvent::PutIn {
                power_back: !unplug.keeps_power,
            });
        }
        if self.pulled.is_some() || self.waiting.first()?.at > now {
            return None;
        }
        let unplug = self.waiting.remove(0);
        let from = now.max(unplug.at);
        let until = unplug
            .lasting
            .map_or(Duration::MAX, |lasting| from.saturating_add(lasting));
        let power_lost = !unplug.keeps_power;
        self.pulled = Some((unplug, until));
        Some(PlugEvent::Pulled { power_lost })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Duration = Duration::from_secs(1);

    #[test]
    fn pulled_put_in_and_pulled_again() {
        let mut plug = Plug::default();
        plug.add("at=5".parse().expect("valid"));
        plug.add(
            "at=1,for=2,as=/dev/other,power=kept"
                .parse()
                .expect("valid"),
        );
        assert_eq!((plug.next_event(), plug.happen(S / 2)), (Some(S), None));
        let pulled = |power_lost| Some(PlugEvent::Pulled { power_lost });
        assert_eq!(plug.happen(S), pulled(false));
        assert!(!plug.is_in() && plug.happen(2 * S).is_none());
        assert_eq!(plug.next_event(), Some(3 * S));
        assert_eq!(
            plug.happen(3 * S),
            Some(PlugEvent::PutIn { power_back: false })
        );
        assert_eq!(plug.link(), Some(Path::new("/dev/other")));
        assert_eq!(plug.happen(9 * S), pulled(true));
        assert_eq!((plug.next_event(), plug.happen(99 * S)), (None, None));
    }

    #[test]
    fn mistakes_are_told_in_one_line() {
        for text in ["at=-1", "for=x", "as=", "power=half", "count=2", "at"] {
            let told = text.parse::<Unplug>().expect_err(text);
            assert!(told.contains("unplug") && !told.contains('\n'), "{told}");
        }
    }
}
