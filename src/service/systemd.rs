//! Notifications to systemd (sd_notify). Without systemd they do nothing.

use super::constants::WATCHDOG_INTERVAL_SHARE;
use sd_notify::NotifyState;
use std::time::{Duration, Instant};

#[derive(Debug)]
pub(super) struct SystemdNotifier {
    /// `None` without a watchdog.
    feed_interval: Option<Duration>,
    last_fed: Option<Instant>,
    status: String,
}

impl SystemdNotifier {
    /// Reads what systemd put into the environment.
    pub(super) fn from_environment() -> Self {
        Self {
            feed_interval: sd_notify::watchdog_enabled()
                .map(|p| p.mul_f64(WATCHDOG_INTERVAL_SHARE)),
            last_fed: None,
            status: String::new(),
        }
    }

    /// Due at every tick.
    #[cfg(test)]
    pub(super) fn with_watchdog() -> Self {
        Self {
            feed_interval: Some(Duration::ZERO),
            last_fed: None,
            status: String::new(),
        }
    }

    #[cfg(test)]
    pub(super) fn last_fed(&self) -> Option<Instant> {
        self.last_fed
    }

    /// At the start, and at the end of a reload.
    pub(super) fn ready(&self) {
        notify(&[NotifyState::Ready]);
    }

    pub(super) fn reloading(&self) {
        match NotifyState::monotonic_usec_now() {
            Ok(now) => notify(&[NotifyState::Reloading, now]),
            Err(error) => tracing::warn!("no monotonic clock: {error}"),
        }
    }

    pub(super) fn stopping(&self) {
        notify(&[NotifyState::Stopping]);
    }

    /// One line on what the service does; sent where it changed.
    pub(super) fn status(&mut self, line: String) {
        if line != self.status {
            notify(&[NotifyState::Status(&line)]);
            self.status = line;
        }
    }

    /// Called at every tick of the loop; notifies the watchdog when due.
    pub(super) fn feed_watchdog(&mut self) {
        let Some(every) = self.feed_interval else {
            return;
        };
        if self.last_fed.is_none_or(|at| at.elapsed() >= every) {
            notify(&[NotifyState::Watchdog]);
            self.last_fed = Some(Instant::now());
        }
    }
}

fn notify(states: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::debug!("systemd not notified: {error}");
    }
}
