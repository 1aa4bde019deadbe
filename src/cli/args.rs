//! The command line: every command with its arguments, and the exit code of a run.

use super::failure::CommandResult;
use super::{
    alarms, backup, calibrate, compare, config, demo, devices, diagnose, distance, emulate,
    evaluate, events, fit, fuse, output, rejudge, reload, reproduce, run as run_command, setup,
    shapes, status, store, sweep, teach, tune, visit, visits, waypoints,
};
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Guards a building from a patrol robot: sweeps each waypoint in 3D, finds what changed and its shape, raises alarms
#[derive(Debug, Parser)]
#[command(name = "patrold", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: CliCommand,
}

#[derive(Debug, Subcommand)]
enum CliCommand {
    /// Run a patrol without hardware: emulated devices, three rounds, alarms checked against the truth
    Demo(demo::DemoArgs),
    /// Run the service: sweep and inspect on request, until stopped
    Run(run_command::RunArgs),
    /// Show the service, its devices, the last visits, incidents, configuration and disk
    ///
    /// Also where the service is down: from the store alone.
    Status(status::StatusArgs),
    /// Make the service read its configuration again
    ///
    /// The exit code is 0 where it was taken and 2 where it has mistakes; the old one stays in force then.
    Reload(reload::ReloadArgs),
    /// Inspect waypoint NAME
    ///
    /// The robot must be at the waypoint and the service must run. The exit code is 0 for quiet, 10 for changed, 11 for not
    /// observed.
    Visit(visit::VisitArgs),
    /// Take the reference of waypoint NAME
    ///
    /// The robot must be at the waypoint and the service must run.
    Teach(teach::TeachArgs),
    /// Compare two recorded clouds, or all pairs of a manifest
    Compare(compare::CompareArgs),
    /// Emulate both devices on pseudo-terminals
    ///
    /// Runs until interrupted. JSON lines on standard input command it: {"at": [x, y, yaw]} (metres, radians) moves the robot,
    /// {"scene": FILE} changes the world, {"fault": SPEC} injects a fault.
    Emulate(emulate::EmulateArgs),
    /// Find both devices, name them in the configuration, and draw what they see
    ///
    /// The service must not run. Writes 10-devices.toml into the folder of the configuration, takes the sweeps of a calibration,
    /// draws the first from above and from the side, and proposes lines for the mount.
    Setup(setup::SetupArgs),
    /// Show the connected devices: model, serial number, firmware, limits, health
    Devices(devices::DevicesArgs),
    /// Take one sweep and write it as a cloud
    Sweep(sweep::SweepArgs),
    /// Estimate the mount, time offset and backlash from sweeps
    Calibrate(calibrate::CalibrateArgs),
    /// Fit a Gaussian mixture to a recorded cloud
    Fit(fit::FitArgs),
    /// Compute the Earth Mover's Distance between two mixtures
    Distance(distance::DistanceArgs),
    /// Merge two mixtures of one place into one
    ///
    /// Surface that both describe counts once, beams add. A mixture file may have the beams of its components (`beams`) and the
    /// area of which its weights are shares (`surface_m2`); without them beams are the weights times `points`, and the area is
    /// derived from the components.
    Fuse(fuse::FuseArgs),
    /// Find the shapes in a segmented cloud
    Shapes(shapes::ShapesArgs),
    /// Check or show the configuration
    Config(config::ConfigArgs),
    /// List, show or forget waypoints and their references; make a mixture anew
    Waypoints(waypoints::WaypointsArgs),
    /// List, show, acknowledge or export alarms
    Alarms(alarms::AlarmsArgs),
    /// Check the store, or make its database anew from the journal
    Store(store::StoreArgs),
    /// Copy the store to folder DIR; the service may run
    ///
    /// Run again it copies what is missing there. At the end the copy is checked.
    Backup(backup::BackupArgs),
    /// Make the store what the backup in folder DIR is; the service must not run
    ///
    /// The old database is kept under another name, and no evidence file is deleted.
    Restore(backup::BackupArgs),
    /// Show what other thresholds U_th would have done to the past, and put one into force
    Tune(tune::TuneArgs),
    /// List or show visits
    Visits(visits::VisitsArgs),
    /// Write one file for support: log, unit, devices, configuration without secrets
    Diagnose(diagnose::DiagnoseArgs),
    /// List events: devices lost and found, configuration, starts and stops
    Events(events::EventsArgs),
    /// Measure how often the engine is right, on simulated pairs of sweeps
    Evaluate(evaluate::EvaluateArgs),
    /// Repeat the experiments of the paper and print its tables beside ours
    Reproduce(reproduce::ReproduceArgs),
    /// Judge stored sweeps again with the current settings; nothing is written
    Rejudge(rejudge::RejudgeArgs),
}

/// Runs the command. A failure is one line on standard error, or one per configuration error.
pub fn run(cli: Cli) -> ExitCode {
    let result: CommandResult = match &cli.command {
        CliCommand::Demo(args) => demo::run(args),
        CliCommand::Run(args) => run_command::run(args),
        CliCommand::Status(args) => status::run(args),
        CliCommand::Reload(args) => reload::run(args),
        CliCommand::Visit(args) => visit::run(args),
        CliCommand::Teach(args) => teach::run(args),
        CliCommand::Compare(args) => compare::run(args),
        CliCommand::Emulate(args) => emulate::run(args),
        CliCommand::Setup(args) => setup::run(args),
        CliCommand::Diagnose(args) => diagnose::run(args),
        CliCommand::Devices(args) => devices::run(args),
        CliCommand::Sweep(args) => sweep::run(args),
        CliCommand::Calibrate(args) => calibrate::run(args),
        CliCommand::Fit(args) => fit::run(args),
        CliCommand::Distance(args) => distance::run(args),
        CliCommand::Fuse(args) => fuse::run(args),
        CliCommand::Shapes(args) => shapes::run(args),
        CliCommand::Config(args) => config::run(args),
        CliCommand::Waypoints(args) => waypoints::run(args),
        CliCommand::Alarms(args) => alarms::run(args),
        CliCommand::Store(args) => store::run(args),
        CliCommand::Backup(args) => backup::back_up(args),
        CliCommand::Restore(args) => backup::restore(args),
        CliCommand::Tune(args) => tune::run(args),
        CliCommand::Visits(args) => visits::run(args),
        CliCommand::Events(args) => events::run(args),
        CliCommand::Evaluate(args) => evaluate::run(args),
        CliCommand::Reproduce(args) => reproduce::run(args),
        CliCommand::Rejudge(args) => rejudge::run(args),
    };
    match result {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            for line in failure.to_string().lines() {
                eprintln!("patrold: {}", output::printable(line));
            }
            failure.exit_code()
        }
    }
}
