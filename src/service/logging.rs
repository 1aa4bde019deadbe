//! Logging: to the journal with fields of its own, or to standard error.

use crate::config::LogConfig;
use std::io::{self, IsTerminal as _};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;
use tracing_subscriber::{EnvFilter, Layer as _, Registry, fmt, reload};

/// Changes the log level of the running process.
#[derive(Debug, Clone)]
pub struct LogLevelHandle(reload::Handle<EnvFilter, Registry>);

impl LogLevelHandle {
    pub(super) fn set(&self, level: &str) {
        if let Err(error) = self.0.reload(filter(level)) {
            tracing::warn!("log.level unchanged: {error}");
        }
    }
}

/// Starts logging; `None` where the process has a logger already.
///
/// The journal gets the fields WAYPOINT, VERDICT, D_GMM, ALARM_ID and DEVICE. Colour only on a terminal, and not where
/// NO_COLOR is set.
pub(super) fn start(settings: &LogConfig) -> Option<LogLevelHandle> {
    let (filter, handle) = reload::Layer::new(filter(&settings.level));
    let journal = wants_journal(&settings.to, std::env::var_os("JOURNAL_STREAM").is_some())
        .then(journald)
        .transpose();
    let output = match journal {
        Ok(Some(journal)) => journal.boxed(),
        Ok(None) => to_stderr().boxed(),
        Err(error) => {
            eprintln!("patrold: no journal ({error}), logging to standard error");
            to_stderr().boxed()
        }
    };
    let started = tracing_subscriber::registry()
        .with(filter)
        .with(output)
        .try_init();
    started.is_ok().then_some(LogLevelHandle(handle))
}

type Filtered = tracing_subscriber::layer::Layered<reload::Layer<EnvFilter, Registry>, Registry>;

fn to_stderr() -> Box<dyn tracing_subscriber::Layer<Filtered> + Send + Sync> {
    let plain = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    fmt::layer()
        .with_writer(io::stderr)
        .with_ansi(!plain && io::stderr().is_terminal())
        .with_target(false)
        .boxed()
}

fn journald() -> io::Result<tracing_journald::Layer> {
    let layer = tracing_journald::layer()?;
    Ok(layer
        .with_field_prefix(None)
        .with_syslog_identifier("patrold".to_owned()))
}

fn filter(level: &str) -> EnvFilter {
    // Other crates log warnings only.
    EnvFilter::new(format!("warn,patrold={level}"))
}

fn wants_journal(to: &str, under_systemd: bool) -> bool {
    match to {
        "journald" => true,
        "stderr" => false,
        _ => under_systemd,
    }
}

#[cfg(test)]
mod tests {
    use super::wants_journal;

    #[test]
    fn auto_follows_systemd() {
        assert!(wants_journal("auto", true));
        assert!(!wants_journal("auto", false));
        assert!(wants_journal("journald", false));
        assert!(!wants_journal("stderr", true));
    }
}
