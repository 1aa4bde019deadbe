//! The service from its first to its last moment: one loop over messages, time and what the world outside wants.

use super::api;
use super::conduct::{Conductor, Hands};
use super::constants::{STOP_LIMIT, TICK};
use super::error::ServiceError;
use super::ledger::Ledger;
use super::lock::StoreLock;
use super::logging::LogLevel;
use super::message::{Control, Message};
use super::replies::StatusReply;
use super::robot::{Connect, Notes};
use super::robot_thread::RobotThread;
use super::socket;
use super::stamp::stamp_now;
use super::systemd::Systemd;
use crate::config::{Loaded, load};
use crate::devices::Clock;
use crate::store::Store;
use std::future::Future;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::{self, Receiver, UnboundedReceiver, UnboundedSender};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval};

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

/// Runs a service; `controls` reload and stop it, and its end stops it too.
///
/// # Errors
/// As [`run`].
pub async fn serve(plan: Plan, mut controls: Receiver<Control>) -> Result<(), ServiceError> {
    let settings = Arc::new(plan.loaded.settings.clone());
    let lock = StoreLock::take(&settings.store.dir)?;
    let store = Store::open(&settings.store.dir)?;
    let (listener, socket_file) = socket::listen(&settings.api.socket, settings.api.socket_mode)?;
    let (inbox, mut messages) = mpsc::unbounded_channel();
    let (status, status_reader) = watch::channel(first_status(&plan.loaded));
    let web = tokio::spawn(api::serve(listener, inbox.clone(), status_reader));
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
    conductor.finish();
    // Answers that were given are still on their way out.
    linger(&mut messages).await;
    web.abort();
    drop(lock);
    Ok(())
}

/// Leaves the web tasks a moment to write their last answers.
async fn linger(messages: &mut UnboundedReceiver<Message>) {
    messages.close();
    tokio::time::sleep(Duration::from_millis(50)).await;
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
