//! The command: arguments, folder, exit code.

use super::building::demo_waypoints;
use super::report::DemoReport;
use super::rounds::run_rounds;
use super::system::DemoSystem;
use crate::cli::failure::{CommandResult, DONE, FAILED, Failure};
use crate::cli::{files, output};
use clap::Args;
use std::fs;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Folder of the database and configuration; must hold no patrol yet [default: a new temporary folder]
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
    let state = state_folder(args.state.as_deref())?;
    let waypoints = demo_waypoints()?;
    let mut system = DemoSystem::start(&state, &waypoints, args.time_scale, args.seed)?;
    let print = |text: &str| {
        if args.json {
            Ok(())
        } else {
            output::line(text)
        }
    };
    print(&format!(
        "state in {}; both devices emulated on pseudo-terminals, time scale {}",
        state.display(),
        args.time_scale
    ))?;
    let quiet_visits = run_rounds(&mut system, &waypoints, args.seed, &print)?;
    let final_time_scale = system.time_scale();
    system.stop()?;
    let report = DemoReport::new(&waypoints, quiet_visits, &state)?;
    if args.json {
        output::json(&report.json(args.seed, final_time_scale))?;
    } else {
        output::line(report.text())?;
    }
    Ok(if report.is_correct() { DONE } else { FAILED })
}

fn state_folder(given: Option<&Path>) -> Result<PathBuf, Failure> {
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
    folder.canonicalize().map_err(|error| failure(&error))
}

fn parse_demo_time_scale(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (0.1..=100.0).contains(&x) => Ok(x),
        _ => Err(format!("expected a number from 0.1 to 100, got {text:?}")),
    }
}
