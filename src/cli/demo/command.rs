//! The command itself: its arguments, its folder, its exit code.

use super::{building, rounds, stage, tell};
use crate::cli::failure::{DONE, FAILED, Failure, Outcome};
use crate::cli::output;
use clap::Args;
use std::fs;
use std::path::{Path, PathBuf};

/// Arguments of `demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Keep database, configuration and references here [default: a new folder in the temporary directory]
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
    /// Seed of the sensors' noise and of where the robot stops
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Seconds of the robot's time in one second of yours; the demo slows itself down where the machine lags
    #[arg(long, value_name = "X", default_value_t = 10.0, value_parser = scale)]
    time_scale: f64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// Runs `demo`: teach, a quiet round, a changed round, the log, the truth.
pub fn run(args: &DemoArgs) -> Outcome {
    let state = state_folder(args.state.as_deref())?;
    let places = building::places()?;
    let mut stage = stage::Stage::open(&state, &places, args.time_scale, args.seed)?;
    let say = |text: &str| {
        if args.json {
            Ok(())
        } else {
            output::line(text)
        }
    };
    say(&format!(
        "state in {}; both devices on pseudo-terminals, time runs {} times as fast",
        state.display(),
        args.time_scale
    ))?;
    let rounds = rounds::all(&mut stage, &places, args.seed, &say)?;
    let slowed_to = stage.time_scale();
    stage.close()?;
    let judged = tell::judge(&places, rounds, &state)?;
    if args.json {
        output::json(&judged.report(args.seed, slowed_to))?;
    } else {
        output::line(judged.prose())?;
    }
    Ok(if judged.exactly_the_truth() {
        DONE
    } else {
        FAILED
    })
}

fn state_folder(wanted: Option<&Path>) -> Result<PathBuf, Failure> {
    let own_name = || {
        let started_ms = jiff::Timestamp::now().as_millisecond();
        format!("patrold-demo-{started_ms}-{}", std::process::id())
    };
    let folder = wanted.map_or_else(|| std::env::temp_dir().join(own_name()), Path::to_owned);
    let named =
        |error: &dyn std::fmt::Display| Failure::Failed(format!("{}: {error}", folder.display()));
    if folder.join("patrold.db").exists() {
        return Err(named(
            &"holds a patrol already; give --state an empty folder",
        ));
    }
    fs::create_dir_all(&folder).map_err(|error| named(&error))?;
    folder.canonicalize().map_err(|error| named(&error))
}

fn scale(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (0.1..=100.0).contains(&x) => Ok(x),
        _ => Err(format!("expected a number from 0.1 to 100, got {text:?}")),
    }
}
