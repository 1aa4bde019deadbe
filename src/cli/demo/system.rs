//! The system of the demo: emulated devices on pseudo-terminals and the real service connected to them.

use super::building::{DemoWaypoint, build_world};
use crate::cli::failure::Failure;
use crate::cli::{client, files, output};
use crate::config::load;
use crate::service::{ServiceParts, StationConnector, run_until};
use crate::store::SystemDisk;
use link::Clock;
use patrold_sim::emulator::{Emulation, EmulationOptions, Emulator, EmulatorPorts};
use patrold_sim::world::{Pose2d, World};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tokio::sync::oneshot;

/// Mean lag of the emulated devices, in device time, above which time is slowed down. The head tilts 0.1 deg in it at
/// 5 deg/s.
const MAX_MEAN_LAG_S: f64 = 0.02;
/// Teaching, quiet, changed.
const ROUNDS: usize = 3;
/// Factor on the time scale when this machine lags.
const SLOW_DOWN_FACTOR: f64 = 0.6;
/// Time speeds up again where the lag is below this share of the limit.
const SPEED_UP_SHARE: f64 = 0.4;
/// A machine under load is the usual reason of an attempt that failed: devices that miss their time look broken.
const MAY_BE_TOO_SLOW: &str = "this machine may be too slow to keep the devices' time";
/// Printed when time is slowed down first.
const AGAINST_LAG: &str = "what devices miss is swept again; to be faster, end what else runs here, or give a lower --time-scale";
/// The lowest time scale that the command takes.
pub(super) const MIN_TIME_SCALE: f64 = 0.1;
/// Wall time within which the service must listen.
const LISTEN_TIMEOUT: Duration = Duration::from_secs(10);

/// The running emulator and service.
pub(super) struct DemoSystem {
    clock: Clock,
    /// As asked for; never faster.
    wanted_time_scale: f64,
    /// The lowest so far.
    lowest_time_scale: f64,
    emulator: Emulator,
    socket: PathBuf,
    /// Of the robot: this one, and all of them.
    stops: (usize, usize),
    stop: Option<oneshot::Sender<()>>,
    service: Option<JoinHandle<Result<(), String>>>,
}

impl DemoSystem {
    /// Starts the emulator and the service, with all their files in the folder `state`.
    ///
    /// # Errors
    /// No pseudo-terminals, or the service does not start.
    pub(super) fn start(
        state: &Path,
        waypoints: &[DemoWaypoint],
        time_scale: f64,
        seed: u64,
    ) -> Result<Self, Failure> {
        let first = waypoints
            .first()
            .ok_or_else(|| Failure::Failed("the demo has no waypoint".to_owned()))?;
        let clock = Clock::scaled(time_scale);
        let (laser, head) = (state.join("laser"), state.join("ptu"));
        let ports = EmulatorPorts {
            laser: Some(&laser),
            head: Some(&head),
            laser_tcp: None,
            head_tcp: None,
        };
        let emulation = Emulation::new(
            EmulationOptions::seeded(seed),
            build_world(&first.before)?,
            first.before.map_from_base,
            clock.now(),
        );
        let emulator =
            Emulator::start(emulation, &ports, clock.clone()).map_err(Failure::failed)?;
        let socket = state.join("patrold.sock");
        let config = state.join("patrold.toml");
        let text = configuration(&emulator, state, &socket);
        files::write(&config, text.as_bytes())?;
        let (stop, stopped) = oneshot::channel();
        let service = spawn_service(&config, clock.clone(), stopped)?;
        let mut system = Self {
            clock,
            wanted_time_scale: time_scale,
            lowest_time_scale: time_scale,
            emulator,
            socket,
            stops: (0, ROUNDS * waypoints.len()),
            stop: Some(stop),
            service: Some(service),
        };
        system.wait_for_socket()?;
        Ok(system)
    }

    /// Sets the world and the pose of the robot. Slows time down if the devices have lagged, and speeds it up again if they
    /// have not.
    ///
    /// # Errors
    /// The service has ended.
    pub(super) fn set_scene(
        &mut self,
        world: Arc<World>,
        robot_pose: Pose2d,
    ) -> Result<(), Failure> {
        let mean_lag_s = self.emulator.take_lag().mean_s;
        let before = self.clock.scale();
        let scale = next_time_scale(before, self.wanted_time_scale, mean_lag_s);
        if scale < before {
            self.lower_time_scale(&too_slow(mean_lag_s, before), scale);
        } else if scale > before {
            output::progress_line(&format!(
                "this machine keeps up again; time scale raised to {scale:.1}"
            ));
            self.clock.set_scale(scale);
        }
        self.stops.0 += 1;
        self.emulator.set_world(world);
        self.emulator.drive_to(robot_pose);
        self.check_service()
    }

    /// Requests `/visit` or `/teach` and waits for the reply.
    pub(super) fn request<T: DeserializeOwned>(
        &mut self,
        path: &'static str,
        waypoint: &str,
        options: Value,
    ) -> Result<T, Failure> {
        let (now, all) = self.stops;
        let title = format!("{now} of {all}, {waypoint}");
        client::request_at_waypoint(&self.socket, path, waypoint, options, &title)
    }

    /// Lowers the time scale before another attempt, and reports on standard error why.
    pub(super) fn slow_down(&mut self, why: &str) {
        let scale = self.clock.scale() * SLOW_DOWN_FACTOR;
        self.lower_time_scale(&format!("{why}; {MAY_BE_TOO_SLOW}"), scale);
    }

    fn lower_time_scale(&mut self, why: &str, scale: f64) {
        output::progress_line(&format!("{why}: time scale lowered to {scale:.1}"));
        if self.lowest_time_scale == self.wanted_time_scale {
            output::progress_line(AGAINST_LAG);
        }
        self.clock.set_scale(scale);
        self.lowest_time_scale = self.lowest_time_scale.min(scale);
    }

    /// Why the rounds may have gone wrong, and what to do: where this machine did not keep the devices' time.
    pub(super) fn slow_machine_advice(&self) -> Option<String> {
        let (lowest, wanted) = (self.lowest_time_scale, self.wanted_time_scale);
        (lowest < wanted).then(|| slow_machine_advice(lowest))
    }

    pub(super) fn time_scale(&self) -> f64 {
        self.clock.scale()
    }

    /// Stops the service as SIGTERM would.
    ///
    /// # Errors
    /// The error that the service ended with.
    pub(super) fn stop(mut self) -> Result<(), Failure> {
        self.stop_service().map_err(Failure::Failed)
    }

    fn wait_for_socket(&mut self) -> Result<(), Failure> {
        let deadline = Instant::now() + LISTEN_TIMEOUT;
        while !self.socket.exists() {
            self.check_service()?;
            if Instant::now() > deadline {
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
            return Err(Failure::Failed("the service ended unexpectedly".to_owned()));
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

impl Drop for DemoSystem {
    fn drop(&mut self) {
        // Its error was returned by `stop`, or another failure is being returned.
        let _ = self.stop_service();
    }
}

fn too_slow(mean_lag_s: f64, scale: f64) -> String {
    format!(
        "this machine is too slow to keep the devices' time at time scale {scale:.1}: they lag by {:.0} ms of it, {:.0} are harmless",
        1e3 * mean_lag_s,
        1e3 * MAX_MEAN_LAG_S
    )
}

fn slow_machine_advice(lowest_scale: f64) -> String {
    format!(
        "this machine was too slow to keep the devices' time (time scale {lowest_scale:.1} at the lowest), so that sweeps had gaps: end what else runs here, or try patrold demo --time-scale {:.1}",
        (lowest_scale * SLOW_DOWN_FACTOR).max(MIN_TIME_SCALE)
    )
}

/// The time scale after a visit with this mean lag, in device time.
fn next_time_scale(now: f64, wanted: f64, mean_lag_s: f64) -> f64 {
    if mean_lag_s > MAX_MEAN_LAG_S {
        return now * SLOW_DOWN_FACTOR;
    }
    // The same delay is longer in device time on a faster clock: only where it would be far from too long.
    if mean_lag_s < SPEED_UP_SHARE * MAX_MEAN_LAG_S {
        return (now / SLOW_DOWN_FACTOR).min(wanted);
    }
    now
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

fn spawn_service(
    config: &Path,
    clock: Clock,
    stopped: oneshot::Receiver<()>,
) -> Result<JoinHandle<Result<(), String>>, Failure> {
    let loaded = load(Some(config), &[])?;
    let parts = ServiceParts {
        loaded,
        config_path: Some(config.to_owned()),
        connector: Box::new(StationConnector::new(clock.clone())),
        clock,
        disk: Arc::new(SystemDisk),
        log: None,
    };
    let run = move || {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .map_err(|error| error.to_string())?;
        let shutdown = async {
            // A dropped sender ends the service too.
            let _ = stopped.await;
        };
        runtime
            .block_on(run_until(parts, shutdown))
            .map_err(|error| error.to_string())
    };
    thread::Builder::new()
        .name("service".to_owned())
        .spawn(run)
        .map_err(Failure::failed)
}

#[cfg(test)]
mod tests {
    use super::{MAX_MEAN_LAG_S, SLOW_DOWN_FACTOR, next_time_scale, slow_machine_advice, too_slow};

    #[test]
    fn time_slows_down_with_the_lag_and_speeds_up_again_to_what_was_asked() {
        let mut scale = 10.0;
        for _ in 0..3 {
            scale = next_time_scale(scale, 10.0, 1.1 * MAX_MEAN_LAG_S);
        }
        assert!((scale - 10.0 * SLOW_DOWN_FACTOR.powi(3)).abs() < 1e-9);
        assert_eq!(next_time_scale(scale, 10.0, 0.9 * MAX_MEAN_LAG_S), scale);
        for _ in 0..4 {
            let next = next_time_scale(scale, 10.0, 0.3 * MAX_MEAN_LAG_S);
            assert!(next >= scale);
            scale = next;
        }
        assert_eq!(scale, 10.0);
    }

    #[test]
    fn a_slow_machine_is_named_with_what_to_do() {
        let text = too_slow(0.035, 10.0);
        assert!(
            text.contains("too slow to keep the devices' time at time scale 10.0: they lag by 35 ms of it, 20 are harmless"),
            "{text}"
        );
        let advice = slow_machine_advice(3.6);
        assert!(
            advice.contains("time scale 3.6") && advice.ends_with("--time-scale 2.2"),
            "{advice}"
        );
        assert!(slow_machine_advice(0.11).ends_with("--time-scale 0.1"));
    }

    #[test]
    fn speeding_up_never_brings_the_lag_that_slows_down() {
        // The delay is a property of the machine: in device time it grows with the scale.
        for lag_of_10 in [0.5, 0.9, 1.2, 3.0, 8.0] {
            let (mut scale, mut changes) = (10.0, Vec::new());
            for _ in 0..20 {
                let next = next_time_scale(scale, 10.0, lag_of_10 * MAX_MEAN_LAG_S * scale / 10.0);
                changes.push((next > scale, next < scale));
                scale = next;
            }
            let back = changes.iter().position(|(up, _)| *up);
            assert_eq!(back, None, "{lag_of_10}");
        }
    }
}
