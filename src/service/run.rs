//! The service from its first to its last moment: one loop over messages, time and what the world outside wants.

use super::api;
use super::conduct::{Conductor, Hands};
use super::constants::{LAST_WORDS_LIMIT, LAST_WRITES_LIMIT, STOP_LIMIT, TICK};
use super::error::ServiceError;
use super::ledger::Ledger;
use super::lock::StoreLock;
use super::logging::{self, LogLevel};
use super::message::{Control, Message};
use super::replies::StatusReply;
use super::robot::{Connect, Notes};
use super::robot_thread::RobotThread;
use super::socket;
use super::stamp::stamp_now;
use super::station::StationConnect;
use super::systemd::Systemd;
use crate::config::{Loaded, load};
use crate::store::Store;
use link::Clock;
use std::future::Future;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::mpsc::{self, Receiver, UnboundedSender};
use tokio::sync::{oneshot, watch};
use tokio::time::{MissedTickBehavior, interval, timeout};

/// What a service is made of.
pub struct Plan {
    /// The configuration in force at the start.
    pub loaded: Loaded,
    /// The file it came from, read again at a reload.
    pub config: Option<PathBuf>,
    /// The clock of the devices and of every deadline about them.
    pub clock: Clock,
    /// Connects the robot.
    pub connect: Box<dyn Connect>,
    /// Changes how much is logged, where this process logs.
    pub log: Option<LogLevel>,
}

/// Runs the service with the configuration in `config` (or the default file) until SIGTERM or SIGINT; SIGHUP reads
/// the configuration again. The devices live in the time of `clock`.
///
/// # Errors
/// Wrong configuration, a store or socket that cannot be used. Devices that are absent are no error.
pub fn run(config: Option<&Path>, clock: Clock) -> Result<(), ServiceError> {
    let loaded = load(config, &[]).map_err(ServiceError::Config)?;
    let log = logging::start(&loaded.settings.log);
    let system = |what| move |source| ServiceError::System { what, source };
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(system("the asynchronous runtime"))?;
    let plan = Plan {
        loaded,
        config: config.map(Path::to_owned),
        connect: Box::new(StationConnect::new(clock.clone())),
        clock,
        log,
    };
    let ended = runtime.block_on(async {
        let controls = signals().map_err(system("signals"))?;
        serve(plan, controls).await
    });
    // A judgement under way is not waited for.
    runtime.shutdown_background();
    ended
}

/// Runs a service inside another program until `shutdown` is ready.
///
/// # Errors
/// As [`run`].
pub async fn run_until(plan: Plan, shutdown: impl Future<Output = ()>) -> Result<(), ServiceError> {
    let (controls, receiver) = mpsc::channel(1);
    let stop = async {
        shutdown.await;
        // The service may have ended already.
        let _ = controls.send(Control::Stop).await;
        std::future::pending::<()>().await;
    };
    tokio::select! {
        ended = serve(plan, receiver) => ended,
        () = stop => Ok(()),
    }
}

fn signals() -> std::io::Result<Receiver<Control>> {
    let mut hangup = signal(SignalKind::hangup())?;
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let (controls, receiver) = mpsc::channel(4);
    tokio::spawn(async move {
        loop {
            let control = tokio::select! {
                _ = hangup.recv() => Control::Reload,
                _ = terminate.recv() => Control::Stop,
                _ = interrupt.recv() => Control::Stop,
            };
            if controls.send(control).await.is_err() {
                return;
            }
        }
    });
    Ok(receiver)
}

/// Runs a service; `controls` reload and stop it, and its end stops it too.
///
/// # Errors
/// As [`run`].
pub async fn serve(plan: Plan, mut controls: Receiver<Control>) -> Result<(), ServiceError> {
    let settings = Arc::new(plan.loaded.settings.clone());
    let lock = StoreLock::take(&settings.store.dir)?;
    let mut store = Store::open(&settings.store.dir)?;
    store.sweep_orphans()?;
    let (listener, socket_file) = socket::listen(&settings.api.socket, settings.api.socket_mode)?;
    let (inbox, mut messages) = mpsc::unbounded_channel();
    let (status, status_reader) = watch::channel(first_status(&plan.loaded));
    let (stop_web, web_stopped) = oneshot::channel();
    let web = tokio::spawn(api::serve(
        listener,
        inbox.clone(),
        status_reader,
        web_stopped,
    ));
    let hands = hands(plan.connect, plan.clock, store, plan.log, &inbox, status)?;
    let mut conductor = Conductor::start(hands, settings);
    conductor.announce();

    let mut ticks = interval(TICK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut stop_by = None;
    while !conductor.has_exited() && stop_by.is_none_or(|at| Instant::now() < at) {
        tokio::select! {
            Some(message) = messages.recv() => conductor.take(message),
            _ = ticks.tick() => conductor.tick(),
            control = controls.recv(), if stop_by.is_none() => match control {
                Some(Control::Reload) => {
                    conductor.reloading();
                    reread(plan.config.clone(), inbox.clone());
                }
                Some(Control::Stop) | None => {
                    stop_by = Some(Instant::now() + STOP_LIMIT);
                    conductor.stop();
                }
            },
        }
    }
    drop(socket_file);
    let left = stop_by.map(|at| at.saturating_duration_since(Instant::now()));
    conductor.finish(left.unwrap_or_default().max(LAST_WRITES_LIMIT));
    // Nobody takes requests any more; answers that were given are still on their way out.
    drop((messages, stop_web));
    if timeout(LAST_WORDS_LIMIT, web).await.is_err() {
        tracing::debug!("an asker did not read its answer");
    }
    drop(lock);
    Ok(())
}

fn hands(
    connect: Box<dyn Connect>,
    clock: Clock,
    store: Store,
    log: Option<LogLevel>,
    inbox: &UnboundedSender<Message>,
    status: watch::Sender<StatusReply>,
) -> Result<Hands, ServiceError> {
    let thread = |source| ServiceError::System {
        what: "a thread",
        source,
    };
    let (to_loop, from_robot) = (inbox.clone(), inbox.clone());
    let notes = Notes::new(move |level, device, text| {
        // The loop may have ended before the devices.
        let _ = to_loop.send(Message::Note(level, device.to_owned(), text));
    });
    let robot = RobotThread::spawn(connect, clock, notes, move |event| {
        let _ = from_robot.send(Message::Robot(event));
    })
    .map_err(thread)?;
    Ok(Hands {
        robot,
        ledger: Ledger::spawn(store).map_err(thread)?,
        systemd: Systemd::from_environment(),
        log,
        inbox: inbox.clone(),
        status,
    })
}

fn reread(config: Option<PathBuf>, inbox: UnboundedSender<Message>) {
    tokio::task::spawn_blocking(move || {
        let read = load(config.as_deref(), &[]).map(Box::new);
        // The loop may have ended meanwhile.
        let _ = inbox.send(Message::Reread(read));
    });
}

fn first_status(loaded: &Loaded) -> StatusReply {
    let settings = &loaded.settings;
    let now = stamp_now().text();
    StatusReply {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        robot: settings.robot.name.clone(),
        pid: std::process::id(),
        started_at: now.clone(),
        config_files: loaded
            .files
            .iter()
            .map(|f| f.display().to_string())
            .collect(),
        config_loaded_at: now,
        store_dir: settings.store.dir.display().to_string(),
        ..StatusReply::default()
    }
}
