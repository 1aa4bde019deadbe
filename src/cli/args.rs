//! The command line as a whole, and the way from a command to its exit code.

use super::failure::Outcome;
use super::{
    alarms, calibrate, compare, config, demo, devices, distance, emulate, evaluate, fit, rejudge,
    reproduce, run as service, shapes, sweep, teach, visit, waypoints,
};
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Guards a building from a patrol robot: sweeps each waypoint in 3D, finds what changed, says its shape, raises alarms.
#[derive(Debug, Parser)]
#[command(name = "patrold", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The whole job with no hardware: emulated devices, three rounds, the log against the truth
    Demo(demo::DemoArgs),
    /// The service: sweeps and judges on request, until stopped
    Run(service::RunArgs),
    /// Ask the running service: the robot stands at NAME, inspect it
    Visit(visit::VisitArgs),
    /// Ask the running service: the robot stands at NAME, take its reference
    Teach(teach::TeachArgs),
    /// Compare recorded clouds with the engine of the service
    Compare(compare::CompareArgs),
    /// Both devices, byte for byte, on pseudo-terminals, until interrupted
    Emulate(emulate::EmulateArgs),
    /// Who answers on the ports: model, serial number, firmware, limits, health
    Devices(devices::DevicesArgs),
    /// One sweep of the place around the robot, as a cloud
    Sweep(sweep::SweepArgs),
    /// Mount, clock offset and backlash from sweeps of the room around the robot
    Calibrate(calibrate::CalibrateArgs),
    /// The mixture of one recorded cloud
    Fit(fit::FitArgs),
    /// Earth Mover's Distance between two mixtures
    Distance(distance::DistanceArgs),
    /// The shapes in one segmented cloud
    Shapes(shapes::ShapesArgs),
    /// Check or show the configuration
    Config(config::ConfigArgs),
    /// Waypoints and their reference versions
    Waypoints(waypoints::WaypointsArgs),
    /// The alarm log: list, show, ack, export
    Alarms(alarms::AlarmsArgs),
    /// The engine on hundreds of simulated pairs, and how often it is right
    Evaluate(evaluate::EvaluateArgs),
    /// The paper's tables beside ours
    Reproduce(reproduce::ReproduceArgs),
    /// Judge a stored sweep again, under the settings in force now; nothing is written
    Rejudge(rejudge::RejudgeArgs),
}

/// Runs the command; a failure is one line (or one per mistake) on standard error.
pub fn run(cli: Cli) -> ExitCode {
    let outcome: Outcome = match &cli.command {
        Command::Demo(args) => demo::run(args),
        Command::Run(args) => service::run(args),
        Command::Visit(args) => visit::run(args),
        Command::Teach(args) => teach::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Emulate(args) => emulate::run(args),
        Command::Devices(args) => devices::run(args),
        Command::Sweep(args) => sweep::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Fit(args) => fit::run(args),
        Command::Distance(args) => distance::run(args),
        Command::Shapes(args) => shapes::run(args),
        Command::Config(args) => config::run(args),
        Command::Waypoints(args) => waypoints::run(args),
        Command::Alarms(args) => alarms::run(args),
        Command::Evaluate(args) => evaluate::run(args),
        Command::Reproduce(args) => reproduce::run(args),
        Command::Rejudge(args) => rejudge::run(args),
    };
    match outcome {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            for line in failure.to_string().lines() {
                eprintln!("patrold: {line}");
            }
            failure.code()
        }
    }
}
