//! What systemd is told. Without systemd every message goes nowhere.

use super::constants::WATCHDOG_SHARE;
use sd_notify::NotifyState;
use std::time::{Duration, Instant};

/// The line to systemd.
#[derive(Debug)]
pub struct Systemd {
    feed_every: Option<Duration>,
    fed: Option<Instant>,
    status: String,
}

impl Systemd {
    /// Asks the environment what systemd wants.
    pub fn from_environment() -> Self {
        Self {
            feed_every: sd_notify::watchdog_enabled().map(|p| p.mul_f64(WATCHDOG_SHARE)),
            fed: None,
            status: String::new(),
        }
    }

    /// The service answers; also the end of a reload.
    pub fn ready(&self) {
        tell(&[NotifyState::Ready]);
    }

    /// The configuration is being read again.
    pub fn reloading(&self) {
        match NotifyState::monotonic_usec_now() {
            Ok(now) => tell(&[NotifyState::Reloading, now]),
            Err(error) => tracing::warn!("no monotonic clock: {error}"),
        }
    }

    /// The service is ending.
    pub fn stopping(&self) {
        tell(&[NotifyState::Stopping]);
    }

    /// One line about what the service does; said when it changes.
    pub fn status(&mut self, line: String) {
        if line != self.status {
            tell(&[NotifyState::Status(&line)]);
            self.status = line;
        }
    }

    /// Called in every turn of the loop that does the work; feeds the watchdog when due.
    pub fn alive(&mut self) {
        let Some(every) = self.feed_every else { return };
        if self.fed.is_none_or(|at| at.elapsed() >= every) {
            tell(&[NotifyState::Watchdog]);
            self.fed = Some(Instant::now());
        }
    }
}

fn tell(states: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::debug!("systemd is not told: {error}");
    }
}
