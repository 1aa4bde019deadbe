//! The demo's stage: the emulated devices, and the true service between their terminals and its socket.

use super::building::{Place, world};
use crate::cli::client;
use crate::cli::failure::Failure;
use crate::config::load;
use crate::service::{Plan, StationConnect, run_until};
use link::Clock;
use patrold_sim::emulator::{Emulation, EmulationOptions, Emulator, EmulatorPorts};
use patrold_sim::world::{Stand, World};
use serde::de::DeserializeOwned;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tokio::sync::oneshot;

/// A mean lag of the emulated devices, in their own time, above which the demo runs slower: the head tilts 0.1 deg
/// in it at 5 deg/s.
const MOST_LAG_S: f64 = 0.02;
/// How much slower.
const SLOW_DOWN: f64 = 0.6;
/// Wall time within which the service must listen.
const LISTEN_LIMIT: Duration = Duration::from_secs(10);

/// Emulator and service, running.
pub struct Stage {
    clock: Clock,
    emulator: Emulator,
    socket: PathBuf,
    stop: Option<oneshot::Sender<()>>,
    service: Option<JoinHandle<Result<(), String>>>,
}

impl Stage {
    /// Hangs both devices on pseudo-terminals and starts the service on them, everything in the folder `state`.
    ///
    /// # Errors
    /// No pseudo-terminals, or the service does not come up.
    pub fn open(
        state: &Path,
        places: &[Place],
        time_scale: f64,
        seed: u64,
    ) -> Result<Self, Failure> {
        let first = places
            .first()
            .ok_or_else(|| Failure::Failed("the building is empty".to_owned()))?;
        let clock = Clock::scaled(time_scale);
        let (laser, head) = (state.join("laser"), state.join("ptu"));
        let ports = EmulatorPorts {
            laser: Some(&laser),
            head: Some(&head),
            laser_tcp: None,
        };
        let emulation = Emulation::new(
            EmulationOptions::seeded(seed),
            world(&first.before)?,
            first.before.map_from_base,
            clock.now(),
        );
        let emulator =
            Emulator::start(emulation, &ports, clock.clone()).map_err(Failure::failed)?;
        let socket = state.join("patrold.sock");
        let config = state.join("patrold.toml");
        let text = configuration(&emulator, state, &socket);
        fs::write(&config, text)
            .map_err(|error| Failure::Failed(format!("{}: {error}", config.display())))?;
        let (stop, stopped) = oneshot::channel();
        let service = serve(&config, clock.clone(), stopped)?;
        let mut stage = Self {
            clock,
            emulator,
            socket,
            stop: Some(stop),
            service: Some(service),
        };
        stage.wait_for_socket()?;
        Ok(stage)
    }

    /// Puts the robot and what stands around it in place; runs slower if the devices lagged meanwhile.
    ///
    /// # Errors
    /// None so far; the service may have gone.
    pub fn arrange(&mut self, world: Arc<World>, stand: Stand) -> Result<(), Failure> {
        if self.emulator.take_lag().mean_s > MOST_LAG_S {
            self.slow_down();
        }
        self.emulator.set_world(world);
        self.emulator.drive_to(stand);
        self.check_service()
    }

    /// Asks the service for a visit or a reference and waits for the outcome.
    ///
    /// # Errors
    /// The service's refusal.
    pub fn ask<T: DeserializeOwned>(
        &mut self,
        path: &'static str,
        waypoint: &str,
    ) -> Result<T, Failure> {
        client::ask_at(&self.socket, path, waypoint)
    }

    /// Runs slower from now on, and says so.
    pub fn slow_down(&self) {
        let scale = self.clock.scale() * SLOW_DOWN;
        self.clock.set_scale(scale);
        eprintln!("patrold: this machine lags; time runs {scale:.1} times as fast from now on");
    }

    /// How fast time runs now.
    pub fn time_scale(&self) -> f64 {
        self.clock.scale()
    }

    /// Ends the service as SIGTERM would.
    ///
    /// # Errors
    /// What the service ended with.
    pub fn close(mut self) -> Result<(), Failure> {
        self.stop_service().map_err(Failure::Failed)
    }

    fn wait_for_socket(&mut self) -> Result<(), Failure> {
        let until = Instant::now() + LISTEN_LIMIT;
        while !self.socket.exists() {
            self.check_service()?;
            if Instant::now() > until {
                return Err(Failure::Failed(format!(
                    "the service does not listen at {}",
                    self.socket.display()
                )));
            }
            thread::sleep(Duration::from_millis(20));
        }
        Ok(())
    }

    fn check_service(&mut self) -> Result<(), Failure> {
        if self.service.as_ref().is_some_and(JoinHandle::is_finished) {
            self.stop_service().map_err(Failure::Failed)?;
            return Err(Failure::Failed("the service ended by itself".to_owned()));
        }
        Ok(())
    }

    fn stop_service(&mut self) -> Result<(), String> {
        if let Some(stop) = self.stop.take() {
            // The service may have ended already.
            let _ = stop.send(());
        }
        match self.service.take().map(JoinHandle::join) {
            None => Ok(()),
            Some(Ok(ended)) => ended,
            Some(Err(_)) => Err("the service panicked".to_owned()),
        }
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        // Its outcome was told by close, or another failure is on its way.
        let _ = self.stop_service();
    }
}

fn configuration(emulator: &Emulator, state: &Path, socket: &Path) -> String {
    let quoted = |text: &str| format!("{text:?}");
    format!(
        "[robot]\nname = \"demo\"\n\n[laser]\nport = {}\n\n[ptu]\nport = {}\n\n[store]\ndir = {}\n\n[api]\nsocket = {}\n",
        quoted(emulator.laser_port()),
        quoted(emulator.head_port()),
        quoted(&state.display().to_string()),
        quoted(&socket.display().to_string()),
    )
}

fn serve(
    config: &Path,
    clock: Clock,
    stopped: oneshot::Receiver<()>,
) -> Result<JoinHandle<Result<(), String>>, Failure> {
    let loaded = load(Some(config), &[])?;
    let plan = Plan {
        loaded,
        config: Some(config.to_owned()),
        connect: Box::new(StationConnect::new(clock.clone())),
        clock,
        log: None,
    };
    let run = move || {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .map_err(|error| error.to_string())?;
        let shutdown = async {
            // A stage that is gone ends the service too.
            let _ = stopped.await;
        };
        runtime
            .block_on(run_until(plan, shutdown))
            .map_err(|error| error.to_string())
    };
    thread::Builder::new()
        .name("service".to_owned())
        .spawn(run)
        .map_err(Failure::failed)
}
