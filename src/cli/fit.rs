//! `patrold fit CLOUD`: the mixture of one cloud by EM.

use super::failure::{DONE, Failure, Outcome};
use super::{clouds, files, output};
use clap::Args;
use patrold_engine::mixture::constants::{MOST_COMPONENTS, RESTARTS};
use patrold_engine::mixture::{
    Collapse, Components, EmSettings, Fit, FitSettings, Mixture, MixtureRecord, SplitSettings,
    Start, Stopped, fit,
};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `fit`.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Recorded cloud (PLY, PCD or XYZ text)
    cloud: PathBuf,
    /// How many: a number K, `bic` or `mml` to find one, `flat` to split until every component is flat
    #[arg(long, value_name = "K|bic|mml|flat", default_value = "flat", conflicts_with = "init", value_parser = Count::parse)]
    components: Count,
    /// Most components that bic and mml try
    #[arg(long, value_name = "K", default_value_t = MOST_COMPONENTS, value_parser = most)]
    max_components: usize,
    /// Starts drawn anew for K, bic and mml; the best fit wins
    #[arg(long, value_name = "R", default_value_t = RESTARTS, value_parser = most)]
    restarts: usize,
    /// Start from this mixture and run exactly --iterations (without --tolerance)
    #[arg(long, value_name = "FILE.json")]
    init: Option<PathBuf>,
    /// EM steps at most
    #[arg(long, value_name = "N", default_value_t = EmSettings::default().iterations)]
    iterations: usize,
    /// Stop when the mean log-likelihood rises by less than this; 0 runs every step [default: 0.001, with --init 0]
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

/// How many components, by name.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Count {
    Fixed(usize),
    Bic,
    Mml,
    Flat,
}

impl Count {
    fn parse(text: &str) -> Result<Self, String> {
        match text {
            "bic" => Ok(Self::Bic),
            "mml" => Ok(Self::Mml),
            "flat" => Ok(Self::Flat),
            number => most(number)
                .map(Self::Fixed)
                .map_err(|_| "expected a number from 1, bic, mml or flat".to_owned()),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Fixed(_) => "fixed",
            Self::Bic => "bic",
            Self::Mml => "mml",
            Self::Flat => "flat",
        }
    }
}

fn most(text: &str) -> Result<usize, String> {
    match text.parse::<u32>() {
        Ok(n) if n > 0 => Ok(n as usize),
        _ => Err("expected a number from 1".to_owned()),
    }
}

#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    mixture: MixtureRecord,
    mean_log_likelihood: f64,
    iterations: usize,
    stopped: &'static str,
    points: usize,
    dropped: usize,
    components_by: &'static str,
    start: StartReport,
    runs: usize,
    collapsed: Vec<CollapseReport>,
    instructions: &'static str,
    threads: usize,
    fit_ms: f64,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum StartReport {
    Init,
    KMeans { seed: u64, restart: u64 },
    Flat,
}

#[derive(Serialize)]
struct CollapseReport {
    component: usize,
    why: &'static str,
}

/// Runs `fit`.
pub fn run(args: &FitArgs) -> Outcome {
    let tolerance = args.tolerance.unwrap_or(match args.init {
        Some(_) => 0.0,
        None => EmSettings::default().tolerance,
    });
    if !(tolerance.is_finite() && tolerance >= 0.0) {
        return Err(Failure::Usage(format!(
            "--tolerance wants a number of 0 or more, got {tolerance}"
        )));
    }
    let cloud = clouds::load(&args.cloud)?;
    let start = args.init.as_deref().map(read_mixture).transpose()?;
    let settings = FitSettings {
        em: EmSettings {
            iterations: args.iterations,
            tolerance,
            threads: usize::from(args.threads),
            ..EmSettings::default()
        },
        components: match (start, args.components) {
            (Some(mixture), _) => Components::Start(mixture),
            (None, Count::Fixed(k)) => Components::Fixed(k),
            (None, Count::Bic) => Components::Bic {
                max: args.max_components,
            },
            (None, Count::Mml) => Components::Mml {
                max: args.max_components,
            },
            (None, Count::Flat) => Components::Flat(SplitSettings::default()),
        },
        seed: args.seed,
        restarts: args.restarts,
    };
    let began = Instant::now();
    let fitted =
        fit(&cloud.points, None, &settings).map_err(|error| files::named(&args.cloud, error))?;
    let fit_ms = began.elapsed().as_secs_f64() * 1e3;
    tell(&fitted, &cloud, fit_ms, args)
}

fn tell(fitted: &Fit, cloud: &clouds::LoadedCloud, fit_ms: f64, args: &FitArgs) -> Outcome {
    let report = Report {
        mixture: MixtureRecord::from(&fitted.mixture),
        mean_log_likelihood: fitted.mean_log_likelihood,
        iterations: fitted.iterations,
        stopped: match fitted.stopped {
            Stopped::Converged => "converged",
            Stopped::IterationCap => "iteration_cap",
        },
        points: cloud.points.len(),
        dropped: cloud.dropped(),
        components_by: match args.init {
            Some(_) => "init",
            None => args.components.name(),
        },
        start: match fitted.start {
            Start::Given => StartReport::Init,
            Start::KMeans { restart } => StartReport::KMeans {
                seed: args.seed,
                restart,
            },
            Start::Flat => StartReport::Flat,
        },
        runs: fitted.runs,
        collapsed: fitted.collapsed.iter().map(collapse).collect(),
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

fn collapse(&(component, why): &(usize, Collapse)) -> CollapseReport {
    CollapseReport {
        component,
        why: match why {
            Collapse::NoMass => "no_mass",
            Collapse::NoVolume => "no_volume",
        },
    }
}

/// Reads a mixture file of the contract's form.
///
/// # Errors
/// The file is missing or is no mixture.
pub fn read_mixture(path: &Path) -> Result<Mixture, Failure> {
    let text = files::read_text(path)?;
    MixtureRecord::parse(&text).map_err(|error| files::named(path, error))
}
