//! Logging: to the journal with fields of its own, or to standard error.

use crate::config::LogConfig;
use std::ffi::OsStr;
use std::fmt::{self, Debug};
use std::io::{self, IsTerminal as _};
use tracing::field::Field;
use tracing_subscriber::fmt as subscriber_fmt;
use tracing_subscriber::fmt::format::{Writer, debug_fn};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;
use tracing_subscriber::{EnvFilter, Layer as _, Registry, reload};

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
/// The journal gets the fields MESSAGE_ID, WAYPOINT, VERDICT, D_GMM, ALARM_ID and DEVICE. Colour only on a terminal, and not where
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
    let no_color = std::env::var_os("NO_COLOR");
    subscriber_fmt::layer()
        .with_writer(io::stderr)
        .with_ansi(wants_color(no_color.as_deref(), io::stderr().is_terminal()))
        .with_target(false)
        .fmt_fields(debug_fn(write_field))
        .boxed()
}

/// The message, then the other fields. MESSAGE_ID is for programs that read the journal.
fn write_field(to: &mut Writer<'_>, field: &Field, value: &dyn Debug) -> fmt::Result {
    match field.name() {
        "message" => write!(to, "{value:?}"),
        "MESSAGE_ID" => Ok(()),
        name => write!(to, " {name}={value:?}"),
    }
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

/// A variable that is empty counts as not set (<https://no-color.org>).
fn wants_color(no_color: Option<&OsStr>, is_terminal: bool) -> bool {
    is_terminal && no_color.is_none_or(OsStr::is_empty)
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
    use super::{wants_color, wants_journal, write_field};
    use crate::service::captured_log::LogText;
    use tracing_subscriber::fmt::format::debug_fn;

    #[test]
    fn standard_error_has_every_field_but_the_message_id() {
        let text = LogText::default();
        let writer = text.clone();
        let subscriber = tracing_subscriber::fmt()
            .with_writer(move || writer.clone())
            .with_ansi(false)
            .with_target(false)
            .without_time()
            .fmt_fields(debug_fn(write_field))
            .finish();
        tracing::subscriber::with_default(subscriber, || {
            tracing::warn!(MESSAGE_ID = "00", WAYPOINT = %"hall", D_GMM = 0.5, "hall: changed");
        });
        assert_eq!(
            text.text().trim(),
            "WARN hall: changed WAYPOINT=hall D_GMM=0.5"
        );
    }

    #[test]
    fn color_is_for_terminals_whose_user_does_not_refuse_it() {
        assert!(wants_color(None, true));
        assert!(wants_color(Some("".as_ref()), true));
        assert!(!wants_color(Some("1".as_ref()), true));
        assert!(!wants_color(None, false));
    }

    #[test]
    fn auto_follows_systemd() {
        assert!(wants_journal("auto", true));
        assert!(!wants_journal("auto", false));
        assert!(wants_journal("journald", false));
        assert!(!wants_journal("stderr", true));
    }
}
