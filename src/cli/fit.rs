//! `patrold fit CLOUD`: the mixture of one cloud by EM.

use super::failure::{CommandResult, DONE, Failure};
use super::value_parsers::parse_positive;
use super::{clouds, files, output};
use clap::Args;
use patrold_engine::mixture::{
    Collapse, ComponentSelection, DEFAULT_MAX_COMPONENTS, DEFAULT_RESTARTS, EmFit, EmSettings,
    FitSettings, FitStart, Mixture, MixtureRecord, SplitSettings, StopReason, fit,
};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Debug, Args)]
pub(super) struct FitArgs {
    /// Recorded cloud (PLY, PCD or XYZ text)
    cloud: PathBuf,
    /// Number of components: K, `bic` or `mml` to choose it, `flat` to split until every component is flat
    #[arg(long, value_name = "K|bic|mml|flat", default_value = "flat", conflicts_with = "init", value_parser = ComponentsArg::parse)]
    components: ComponentsArg,
    /// Largest number of components that bic and mml try
    #[arg(long, value_name = "K", default_value_t = DEFAULT_MAX_COMPONENTS, value_parser = parse_positive)]
    max_components: usize,
    /// Number of random starts for K, bic and mml; the best fit is kept
    #[arg(long, value_name = "R", default_value_t = DEFAULT_RESTARTS, value_parser = parse_positive)]
    restarts: usize,
    /// Start from this mixture and run exactly --iterations (without --tolerance)
    #[arg(long, value_name = "FILE.json")]
    init: Option<PathBuf>,
    /// Maximum number of EM iterations
    #[arg(long, value_name = "N", default_value_t = EmSettings::default().iterations)]
    iterations: usize,
    /// Stop when the mean log-likelihood rises by less than this; 0 runs all iterations [default: 0.001, with --init 0]
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    /// Worker threads
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: u16,
    /// Seed of the random starts
    #[arg(long, value_name = "N", default_value_t = 7)]
    seed: u64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum ComponentsArg {
    Fixed(usize),
    Bic,
    Mml,
    Flat,
}

impl ComponentsArg {
    fn parse(text: &str) -> Result<Self, String> {
        match text {
            "bic" => Ok(Self::Bic),
            "mml" => Ok(Self::Mml),
            "flat" => Ok(Self::Flat),
            number => parse_positive(number)
                .map(Self::Fixed)
                .map_err(|_| "expected a number from 1, bic, mml or flat".to_owned()),
        }
    }

    fn as_str(self) -> &'static str {
        match self {
            Self::Fixed(_) => "fixed",
            Self::Bic => "bic",
            Self::Mml => "mml",
            Self::Flat => "flat",
        }
    }
}

#[derive(Serialize)]
struct FitReport {
    #[serde(flatten)]
    mixture: MixtureRecord,
    mean_log_likelihood: f64,
    iterations: usize,
    stopped: &'static str,
    points: usize,
    dropped: usize,
    no_return: usize,
    components_by: &'static str,
    start: FitStartReport,
    runs: usize,
    collapsed: Vec<CollapseReport>,
    instructions: &'static str,
    threads: usize,
    fit_ms: f64,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum FitStartReport {
    Init,
    KMeans { seed: u64, restart: u64 },
    Flat,
}

#[derive(Serialize)]
struct CollapseReport {
    component: usize,
    why: &'static str,
}

pub(super) fn run(args: &FitArgs) -> CommandResult {
    let tolerance = args.tolerance.unwrap_or(match args.init {
        Some(_) => 0.0,
        None => EmSettings::default().tolerance,
    });
    if !(tolerance.is_finite() && tolerance >= 0.0) {
        return Err(Failure::Usage(format!(
            "--tolerance needs a number from 0, got {tolerance}"
        )));
    }
    let cloud = clouds::load(&args.cloud, None)?;
    let start = args.init.as_deref().map(read_mixture).transpose()?;
    let settings = FitSettings {
        em: EmSettings {
            iterations: args.iterations,
            tolerance,
            threads: usize::from(args.threads),
            ..EmSettings::default()
        },
        components: match (start, args.components) {
            (Some(mixture), _) => ComponentSelection::Start(mixture),
            (None, ComponentsArg::Fixed(k)) => ComponentSelection::Fixed(k),
            (None, ComponentsArg::Bic) => ComponentSelection::Bic {
                max: args.max_components,
            },
            (None, ComponentsArg::Mml) => ComponentSelection::Mml {
                max: args.max_components,
            },
            (None, ComponentsArg::Flat) => ComponentSelection::Flat(SplitSettings::default()),
        },
        seed: args.seed,
        restarts: args.restarts,
    };
    let started = Instant::now();
    let fitted = fit(&cloud.measured.points, None, &settings)
        .map_err(|error| files::file_error(&args.cloud, error))?;
    let fit_ms = started.elapsed().as_secs_f64() * 1e3;
    print_report(&fitted, &cloud, fit_ms, args)
}

fn print_report(
    fitted: &EmFit,
    cloud: &clouds::LoadedCloud,
    fit_ms: f64,
    args: &FitArgs,
) -> CommandResult {
    let report = FitReport {
        mixture: MixtureRecord::from(&fitted.mixture),
        mean_log_likelihood: fitted.mean_log_likelihood,
        iterations: fitted.iterations,
        stopped: match fitted.stopped {
            StopReason::Converged => "converged",
            StopReason::IterationCap => "iteration_cap",
        },
        points: cloud.measured.points.len(),
        dropped: cloud.measured.dropped(),
        no_return: cloud.measured.no_return,
        components_by: match args.init {
            Some(_) => "init",
            None => args.components.as_str(),
        },
        start: match fitted.start {
            FitStart::Given => FitStartReport::Init,
            FitStart::KMeans { restart } => FitStartReport::KMeans {
                seed: args.seed,
                restart,
            },
            FitStart::Flat => FitStartReport::Flat,
        },
        runs: fitted.runs,
        collapsed: fitted.collapsed.iter().map(collapse_report).collect(),
        instructions: fitted.instructions.name(),
        threads: fitted.threads,
        fit_ms,
    };
    if args.json {
        output::json(&report)?;
        return Ok(DONE);
    }
    output::line(format!(
        "{} points ({} dropped), {} components ({} collapsed), {} iterations ({}), mean log-likelihood {:.6}, {fit_ms:.1} ms ({}, threads: {})",
        report.points,
        report.dropped,
        fitted.mixture.len(),
        report.collapsed.len(),
        report.iterations,
        report.stopped,
        report.mean_log_likelihood,
        report.instructions,
        report.threads
    ))?;
    Ok(DONE)
}

fn collapse_report(&(component, why): &(usize, Collapse)) -> CollapseReport {
    CollapseReport {
        component,
        why: match why {
            Collapse::NoMass => "no_mass",
            Collapse::NoVolume => "no_volume",
        },
    }
}

/// Reads a mixture file (`docs/contract.md`).
pub(super) fn read_mixture(path: &Path) -> Result<Mixture, Failure> {
    let text = files::read_text(path)?;
    MixtureRecord::parse(&text).map_err(|error| files::file_error(path, error))
}
