//! The command: arguments, folder, exit code.

use super::building::demo_waypoints;
use super::report::DemoReport;
use super::rounds::run_rounds;
use super::system::{DemoSystem, MIN_TIME_SCALE};
use crate::cli::failure::{CommandResult, DONE, FAILED, Failure};
use crate::cli::signals::TerminationSignals;
use crate::cli::{files, output};
use clap::Args;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Folder of the database and configuration, which stay; must hold no patrol yet [default: a temporary folder, which does not]
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
    /// Seed of the sensor noise and of the robot's stop errors
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Device seconds per second of wall time; lowered where this machine lags
    #[arg(long, value_name = "X", default_value_t = 10.0, value_parser = parse_demo_time_scale)]
    time_scale: f64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &DemoArgs) -> CommandResult {
    let state = StateFolder::new(args.state.as_deref())?;
    state.remove_on_signal()?;
    let waypoints = demo_waypoints()?;
    let mut system = DemoSystem::start(&state.path, &waypoints, args.time_scale, args.seed)?;
    let print = |text: &str| {
        if args.json {
            Ok(())
        } else {
            output::line(text)
        }
    };
    let scale = args.time_scale;
    print(&format!(
        "both devices emulated on pseudo-terminals, time scale {scale}"
    ))?;
    let rounds = run_rounds(&mut system, &waypoints, args.seed, &print);
    let slow_machine = system.slow_machine_advice();
    let warn_of_slow_machine = || {
        slow_machine
            .iter()
            .for_each(|advice| output::warning(advice))
    };
    let quiet_visits = rounds.inspect_err(|_| warn_of_slow_machine())?;
    let final_time_scale = system.time_scale();
    system.stop()?;
    let report = DemoReport::new(&waypoints, quiet_visits, &state.path)?;
    if args.json {
        output::json(&report.json(args.seed, final_time_scale))?;
    } else {
        output::line(report.text())?;
        output::line(next_steps(args.state.as_deref()))?;
    }
    if !report.is_correct() {
        warn_of_slow_machine();
    }
    Ok(if report.is_correct() { DONE } else { FAILED })
}

/// How often a folder that is written to is removed.
const REMOVE_TRIES: usize = 1000;

/// The folder of the patrol; a temporary one is removed at the end.
struct StateFolder {
    path: PathBuf,
    is_temporary: bool,
}

impl StateFolder {
    fn new(given: Option<&Path>) -> Result<Self, Failure> {
        let new_name = || {
            let started_ms = jiff::Timestamp::now().as_millisecond();
            format!("patrold-demo-{started_ms}-{}", std::process::id())
        };
        let folder = given.map_or_else(|| std::env::temp_dir().join(new_name()), Path::to_owned);
        let failure = |error: &dyn std::fmt::Display| files::file_error(&folder, error);
        if folder.join("patrold.db").exists() {
            return Err(failure(
                &"already holds a patrol; give --state an empty folder",
            ));
        }
        fs::create_dir_all(&folder).map_err(|error| failure(&error))?;
        Ok(Self {
            path: folder.canonicalize().map_err(|error| failure(&error))?,
            is_temporary: given.is_none(),
        })
    }

    /// An interrupted demo leaves nothing behind either.
    fn remove_on_signal(&self) -> Result<(), Failure> {
        if !self.is_temporary {
            return Ok(());
        }
        let (path, signals) = (self.path.clone(), TerminationSignals::new()?);
        thread::spawn(move || {
            signals.wait();
            // The service may write to it until the process ends, which is now: a folder that is not empty is tried again.
            let tries = 0..REMOVE_TRIES;
            let removed = tries.into_iter().any(|_| fs::remove_dir_all(&path).is_ok());
            if !removed {
                output::warning(&format!("{}: not removed", path.display()));
            }
            std::process::exit(i32::from(FAILED));
        });
        Ok(())
    }
}

impl Drop for StateFolder {
    fn drop(&mut self) {
        if self.is_temporary {
            // What cannot be removed is in the folder of temporary files.
            let _ = fs::remove_dir_all(&self.path);
        }
    }
}

/// What to try next, for the folder that was asked for.
fn next_steps(state: Option<&Path>) -> String {
    let folder = state.unwrap_or(Path::new("patrol")).display();
    let mut lines = vec!["\nto try next".to_owned()];
    if state.is_none() {
        lines.push("  patrold demo --state patrol        # keeps the log; then".to_owned());
    }
    let config = format!("--config {folder}/patrold.toml");
    lines.extend(
        ["alarms show 1", "visits", "rejudge --since 1h", "tune"]
            .map(|command| format!("  patrold {command} {config}")),
    );
    lines.push("  patrold compare BEFORE.ply NOW.ply # two clouds of your own".to_owned());
    lines.push("  patrold setup                      # with a laser and a pan-tilt".to_owned());
    lines.join("\n")
}

fn parse_demo_time_scale(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (MIN_TIME_SCALE..=100.0).contains(&x) => Ok(x),
        _ => Err(format!("expected a number from 0.1 to 100, got {text:?}")),
    }
}
