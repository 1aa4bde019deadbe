//! The plugs of the emulated devices: unplugged at an instant, plugged in later, perhaps under another name. Pure.

use super::constants::{MAX_PENDING_UNPLUGS, UNPLUG_PERIOD};
use fault_text::{FaultKeys, FaultTextError, FaultTimes};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

/// A device unplugged for a time: `unplug[:as=PATH,power=kept|lost]` and the keys of every fault ([`fault_text`]).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnplugFault {
    /// When, how long (`None`: for ever), how often (once), the time from one to the next (1 s).
    pub times: FaultTimes,
    /// The link under which the port returns; `None`: the old one. A terminal is a new node either way.
    pub link: Option<PathBuf>,
    /// The device keeps its power and its state (a hub or an adapter dropped out); else it starts anew.
    pub keeps_power: bool,
}

impl FromStr for UnplugFault {
    type Err = FaultTextError;

    fn from_str(text: &str) -> Result<Self, FaultTextError> {
        let keys = FaultKeys::split(text, &[("unplug", &["as", "power"])])?;
        Ok(Self {
            times: keys.times()?,
            link: keys.get("as", None, "a path", |path| {
                (!path.is_empty()).then(|| Some(path.into()))
            })?,
            keeps_power: keys.get("power", false, "kept or lost", |power| match power {
                "kept" => Some(true),
                "lost" => Some(false),
                _ => None,
            })?,
        })
    }
}

/// One time without the plug.
#[derive(Debug)]
struct PendingUnplug {
    at: Duration,
    duration: Option<Duration>,
    link: Option<PathBuf>,
    keeps_power: bool,
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
    pending: Vec<PendingUnplug>,
    /// The present one, and when it ends.
    unplugged: Option<(PendingUnplug, Duration)>,
    link: Option<PathBuf>,
}

impl Plug {
    pub(super) fn add(&mut self, unplug: UnplugFault) {
        let times = unplug.times;
        let mut at = times.at.unwrap_or_default();
        for _ in 0..times.count.unwrap_or(1) {
            if self.pending.len() >= MAX_PENDING_UNPLUGS {
                break;
            }
            self.pending.push(PendingUnplug {
                at,
                duration: times.lasting,
                link: unplug.link.clone(),
                keeps_power: unplug.keeps_power,
            });
            at = at.saturating_add(times.every.unwrap_or(UNPLUG_PERIOD));
        }
        self.pending.sort_by_key(|unplug| unplug.at);
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
        let mut add = |text: &str| plug.add(text.parse().expect("valid"));
        add("unplug:at=5");
        add("unplug:at=1000ms,for=2s,as=/dev/other,power=kept");
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
    fn unplugged_again_and_again() {
        let mut plug = Plug::default();
        plug.add(
            "unplug:at=1,for=500ms,count=3,every=4"
                .parse()
                .expect("valid"),
        );
        let mut events = Vec::new();
        while let Some(at) = plug.next_event() {
            assert!(plug.poll_event(at).is_some());
            events.push(at.as_millis());
        }
        assert_eq!(events, [1000, 1500, 5000, 5500, 9000, 9500]);
    }

    #[test]
    fn errors_have_one_line() {
        for keys in [
            "at=-1",
            "for=x",
            "as=",
            "power=half",
            "count=0",
            "pin=1",
            "at",
        ] {
            let text = format!("unplug:{keys}");
            let error = text.parse::<UnplugFault>().expect_err(&text).to_string();
            assert!(error.contains("unplug") && !error.contains('\n'), "{error}");
        }
    }
}
