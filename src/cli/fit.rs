//! `patrold fit CLOUD`: the mixture of one cloud by EM.

use super::failure::{DONE, Failure, Outcome};
use super::{clouds, files, output};
use crate::mixture::{
    Components, EmSettings, Fit, FitSettings, Mixture, MixtureRecord, SplitSettings, Stopped, fit,
};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `fit`.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Recorded cloud (PLY, PCD or XYZ text)
    cloud: PathBuf,
    /// Number of components [default: split until every component is flat]
    #[arg(long, value_name = "K", conflicts_with = "init", value_parser = clap::value_parser!(u32).range(1..))]
    components: Option<u32>,
    /// Start from this mixture and run exactly --iterations
    #[arg(long, value_name = "FILE.json")]
    init: Option<PathBuf>,
    /// EM steps at most
    #[arg(long, value_name = "N", default_value_t = EmSettings::default().iterations)]
    iterations: usize,
    /// Stop when the mean log-likelihood rises by less than this; 0 runs every step
    #[arg(long, value_name = "T", conflicts_with = "init")]
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

#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    mixture: MixtureRecord,
    mean_log_likelihood: f64,
    iterations: usize,
    stopped: &'static str,
    points: usize,
    dropped: usize,
    fit_ms: f64,
}

/// Runs `fit`.
pub fn run(args: &FitArgs) -> Outcome {
    let tolerance = args.tolerance.unwrap_or(EmSettings::default().tolerance);
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
            tolerance: if start.is_some() { 0.0 } else { tolerance },
            threads: usize::from(args.threads),
            ..EmSettings::default()
        },
        components: match (start, args.components) {
            (Some(mixture), _) => Components::Start(mixture),
            (None, Some(k)) => Components::Fixed(k as usize),
            (None, None) => Components::Flat(SplitSettings::default()),
        },
        seed: args.seed,
        ..FitSettings::default()
    };
    let began = Instant::now();
    let fitted =
        fit(&cloud.points, None, &settings).map_err(|error| files::named(&args.cloud, error))?;
    let fit_ms = began.elapsed().as_secs_f64() * 1e3;
    tell(&fitted, &cloud, fit_ms, args.json)
}

fn tell(fitted: &Fit, cloud: &clouds::LoadedCloud, fit_ms: f64, as_json: bool) -> Outcome {
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
        fit_ms,
    };
    if as_json {
        output::json(&report)?;
        return Ok(DONE);
    }
    output::line(format!(
        "{} points ({} dropped), {} components, {} iterations ({}), mean log-likelihood {:.6}, {fit_ms:.1} ms",
        report.points,
        report.dropped,
        fitted.mixture.len(),
        report.iterations,
        report.stopped,
        report.mean_log_likelihood
    ))?;
    Ok(DONE)
}

/// Reads a mixture file of the contract's form.
///
/// # Errors
/// The file is missing or is no mixture.
pub fn read_mixture(path: &Path) -> Result<Mixture, Failure> {
    let text = files::read_text(path)?;
    MixtureRecord::parse(&text).map_err(|error| files::named(path, error))
}
