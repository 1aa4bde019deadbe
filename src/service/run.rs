//! Runs the service: setup, the loop over messages, ticks and commands, and the end.

use super::api;
use super::constants::{FLUSH_LIMIT, REPLY_LIMIT, STOP_LIMIT, TICK};
use super::controller::{Controller, Services};
use super::database_check::check_at_start;
use super::error::ServiceError;
use super::lock::StoreLock;
use super::logging::{self, LogLevelHandle};
use super::message::{ServiceCommand, ServiceMessage};
use super::reading_result::reading_result;
use super::replies::{ReloadReply, StatusReply};
use super::scanner::{DeviceNoteSink, ScannerConnector};
use super::scanner_thread::ScannerThread;
use super::socket;
use super::station_scanner::StationConnector;
use super::store_writer::StoreWriter;
use super::systemd::SystemdNotifier;
use crate::config::{LoadedConfig, load, load_last_good};
use crate::patrol::severity::Severity;
use crate::store::{Disk, Ledger, Store, SystemDisk};
use link::Clock;
use std::future::Future;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::mpsc::{self, Receiver, UnboundedSender};
use tokio::sync::{oneshot, watch};
use tokio::time::{MissedTickBehavior, interval, timeout};

/// What a service is built from.
pub struct ServiceParts {
    /// Configuration at the start.
    pub loaded: LoadedConfig,
    /// Read again at a reload; `None` is the default file.
    pub config_path: Option<PathBuf>,
    /// The devices' clock; their deadlines follow it.
    pub clock: Clock,
    /// Connects the laser and the head.
    pub connector: Box<dyn ScannerConnector>,
    /// The disk under the store.
    pub disk: Arc<dyn Disk>,
    /// Lets a reload change the log level; `None` where the embedding program logs.
    pub log: Option<LogLevelHandle>,
}

/// Runs the service with the configuration in `config` (or the default file) until SIGTERM or SIGINT; SIGHUP reloads the
/// configuration. The devices run on `clock`. Where the configuration has mistakes, the last good one is used.
///
/// # Errors
/// Wrong configuration and no good one kept, a store or socket that cannot be used. Absent devices are no error.
pub fn run(config: Option<&Path>, clock: Clock) -> Result<(), ServiceError> {
    let loaded = load(config, &[])
        .or_else(|errors| load_last_good(config, errors))
        .map_err(ServiceError::Config)?;
    let log = logging::start(&loaded.settings.log);
    let system = |what| move |source| ServiceError::System { what, source };
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(system("the asynchronous runtime"))?;
    let parts = ServiceParts {
        loaded,
        config_path: config.map(Path::to_owned),
        connector: Box::new(StationConnector::new(clock.clone())),
        clock,
        disk: Arc::new(SystemDisk),
        log,
    };
    let result = runtime.block_on(async {
        let commands = signals().map_err(system("the signal handlers"))?;
        serve(parts, commands).await
    });
    // Does not wait for a sweep that is being judged.
    runtime.shutdown_background();
    result
}

/// Runs a service inside another program until `shutdown` completes.
///
/// # Errors
/// As [`run`].
pub async fn run_until(
    parts: ServiceParts,
    shutdown: impl Future<Output = ()>,
) -> Result<(), ServiceError> {
    let (commands, receiver) = mpsc::channel(1);
    let stop = async {
        shutdown.await;
        // The service may have ended already.
        let _ = commands.send(ServiceCommand::Stop).await;
        std::future::pending::<()>().await;
    };
    tokio::select! {
        result = serve(parts, receiver) => result,
        () = stop => Ok(()),
    }
}

fn signals() -> std::io::Result<Receiver<ServiceCommand>> {
    let mut hangup = signal(SignalKind::hangup())?;
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let (commands, receiver) = mpsc::channel(4);
    tokio::spawn(async move {
        loop {
            let command = tokio::select! {
                _ = hangup.recv() => ServiceCommand::Reload,
                _ = terminate.recv() => ServiceCommand::Stop,
                _ = interrupt.recv() => ServiceCommand::Stop,
            };
            if commands.send(command).await.is_err() {
                return;
            }
        }
    });
    Ok(receiver)
}

/// Runs a service until `commands` stops it or is closed.
///
/// # Errors
/// As [`run`].
pub async fn serve(
    parts: ServiceParts,
    mut commands: Receiver<ServiceCommand>,
) -> Result<(), ServiceError> {
    let settings = &parts.loaded.settings;
    let lock = StoreLock::acquire(&settings.store.dir)?;
    let store = Store::open_on(&settings.store.dir, Arc::clone(&parts.disk))?;
    let mut ledger = Ledger::new(store);
    let start = ledger.start();
    let (listener, socket_file) = socket::listen(&settings.api.socket, settings.api.socket_mode)?;
    let (inbox, mut messages) = mpsc::unbounded_channel();
    let (status, status_reader) = watch::channel(initial_status(&parts.loaded));
    let (stop_api, api_stopped) = oneshot::channel();
    let api_task = tokio::spawn(api::serve(
        listener,
        inbox.clone(),
        status_reader,
        api_stopped,
    ));
    let services = start_services(
        parts.connector,
        parts.clock,
        ledger,
        parts.log,
        &inbox,
        status,
    )?;
    let store_dir = parts.loaded.settings.store.dir.clone();
    let mut controller = Controller::start(services, &parts.loaded);
    controller.report_store_start(&start);
    let damage_inbox = inbox.clone();
    let report = move |text| {
        // The loop may have ended before the check.
        let note = ServiceMessage::Note(Severity::Error, "store".to_owned(), text);
        let _ = damage_inbox.send(note);
    };
    check_at_start(store_dir, report).map_err(thread_error)?;
    controller.notify_ready();

    let mut ticks = interval(TICK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut stop_by = None;
    while !controller.has_exited() && stop_by.is_none_or(|at| Instant::now() < at) {
        tokio::select! {
            Some(message) = messages.recv() => match message {
                ServiceMessage::ReloadRequested(client) => {
                    controller.notify_reloading();
                    read_config(parts.config_path.clone(), inbox.clone(), Some(client));
                }
                message => controller.handle_message(message),
            },
            _ = ticks.tick() => controller.tick(),
            command = commands.recv(), if stop_by.is_none() => match command {
                Some(ServiceCommand::Reload) => {
                    controller.notify_reloading();
                    read_config(parts.config_path.clone(), inbox.clone(), None);
                }
                Some(ServiceCommand::Stop) | None => {
                    stop_by = Some(Instant::now() + STOP_LIMIT);
                    controller.stop();
                }
            },
        }
    }
    drop(socket_file);
    let left = stop_by.map(|at| at.saturating_duration_since(Instant::now()));
    controller.finish(left.unwrap_or_default().max(FLUSH_LIMIT));
    // Refuses new requests and sends the last replies.
    drop((messages, stop_api));
    if timeout(REPLY_LIMIT, api_task).await.is_err() {
        tracing::debug!("a client did not read its reply in time");
    }
    drop(lock);
    Ok(())
}

fn start_services(
    connector: Box<dyn ScannerConnector>,
    clock: Clock,
    ledger: Ledger,
    log: Option<LogLevelHandle>,
    inbox: &UnboundedSender<ServiceMessage>,
    status: watch::Sender<StatusReply>,
) -> Result<Services, ServiceError> {
    let (note_inbox, event_inbox) = (inbox.clone(), inbox.clone());
    let notes = DeviceNoteSink::new(move |severity, device, text| {
        // The loop may have ended before the devices.
        let _ = note_inbox.send(ServiceMessage::Note(severity, device.to_owned(), text));
    });
    let scanner = ScannerThread::spawn(connector, clock, notes, move |event| {
        let _ = event_inbox.send(ServiceMessage::Scanner(event));
    })
    .map_err(thread_error)?;
    Ok(Services {
        scanner,
        writer: StoreWriter::spawn(ledger).map_err(thread_error)?,
        systemd: SystemdNotifier::from_environment(),
        log,
        inbox: inbox.clone(),
        status,
    })
}

fn thread_error(source: std::io::Error) -> ServiceError {
    ServiceError::System {
        what: "a thread",
        source,
    }
}

fn read_config(
    path: Option<PathBuf>,
    inbox: UnboundedSender<ServiceMessage>,
    client: Option<oneshot::Sender<ReloadReply>>,
) {
    tokio::task::spawn_blocking(move || {
        let result = load(path.as_deref(), &[]).map(Box::new);
        // The loop may have ended meanwhile.
        let _ = inbox.send(ServiceMessage::ConfigRead(result, client));
    });
}

fn initial_status(loaded: &LoadedConfig) -> StatusReply {
    let settings = &loaded.settings;
    let config_read = reading_result(loaded);
    StatusReply {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        robot: settings.robot.name.clone(),
        pid: std::process::id(),
        started_at: config_read.at.clone(),
        config_files: config_read.files.clone(),
        config_loaded_at: config_read.at.clone(),
        config_read,
        store_dir: settings.store.dir.display().to_string(),
        ..StatusReply::default()
    }
}

#[cfg(test)]
mod tests {
    use super::initial_status;
    use crate::config::load;
    use crate::service::replies::{DevicesStatus, StatusReply};

    #[test]
    fn the_first_status_says_which_service_runs_under_what() {
        let dir = tempfile::tempdir().expect("temp dir");
        let file = dir.path().join("patrold.toml");
        std::fs::write(
            &file,
            "robot.name = \"rover\"\nstore.dir = \"/srv/patrold\"",
        )
        .expect("written");
        let status = initial_status(&load(Some(&file), &[]).expect("valid"));
        assert!(
            !status.started_at.is_empty() && status.config_read.taken,
            "{status:?}"
        );
        let expected = StatusReply {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            robot: "rover".to_owned(),
            pid: std::process::id(),
            started_at: status.config_read.at.clone(),
            phase: String::new(),
            devices: DevicesStatus::default(),
            current: None,
            waiting: 0,
            config_files: vec![file.display().to_string()],
            config_loaded_at: status.config_read.at.clone(),
            config_read: status.config_read.clone(),
            store_dir: "/srv/patrold".to_owned(),
        };
        assert_eq!(status, expected);
        assert_eq!(status.config_read.files, status.config_files);
    }
}
