//! `patrold distance A.json B.json`: Earth Mover's Distance between two mixtures.

use super::failure::{CommandResult, DONE, Failure};
use super::{files, fit, output};
use clap::{Args, ValueEnum};
use patrold_engine::distance::{
    Emd, Flow, GroundDistance, PartialEmd, cost_matrix, emd_of_costs, partial_emd_of_costs,
};
use patrold_engine::mixture::{Mixture, MixtureRecord};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Debug, Args)]
pub(super) struct DistanceArgs {
    /// First mixture
    first: PathBuf,
    /// Second mixture
    second: PathBuf,
    /// Ground distance between Gaussians
    #[arg(long, value_enum, default_value = "w2")]
    ground: GroundArg,
    /// Take the weights as they stand, whatever their sums W and U: move the smaller side and divide by min{W, U}
    #[arg(long)]
    partial: bool,
    /// Repeat R times and report median times
    #[arg(long, value_name = "R", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum GroundArg {
    /// Wasserstein-2, metres
    W2,
    /// Euclidean distance of the means, metres
    Euclid,
    /// Foerstner-Moonen plus the distance of the means in metres, no unit
    Fm,
}

impl From<GroundArg> for GroundDistance {
    fn from(arg: GroundArg) -> Self {
        match arg {
            GroundArg::W2 => Self::W2,
            GroundArg::Euclid => Self::Euclid,
            GroundArg::Fm => Self::Fm,
        }
    }
}

/// What is printed of either distance.
struct Solved {
    d: f64,
    plan: Vec<Flow>,
    duality_gap: f64,
    /// W and U, with `--partial`.
    totals: Option<[f64; 2]>,
}

impl From<Emd> for Solved {
    fn from(emd: Emd) -> Self {
        Self {
            d: emd.d,
            plan: emd.plan,
            duality_gap: emd.duality_gap,
            totals: None,
        }
    }
}

impl From<PartialEmd> for Solved {
    fn from(emd: PartialEmd) -> Self {
        Self {
            d: emd.d,
            plan: emd.plan,
            duality_gap: emd.duality_gap,
            totals: Some(emd.totals),
        }
    }
}

pub(super) fn run(args: &DistanceArgs) -> CommandResult {
    let (left, a) = read(&args.first, args.partial)?;
    let (right, b) = read(&args.second, args.partial)?;
    let mut cost_ms = Vec::new();
    let mut solve_ms = Vec::new();
    let mut solved = None;
    for _ in 0..args.repeat {
        let started = Instant::now();
        let costs = cost_matrix(&a, &b, args.ground.into());
        cost_ms.push(started.elapsed().as_secs_f64() * 1e3);
        let started = Instant::now();
        let emd = if args.partial {
            partial_emd_of_costs(&left, &right, &costs).map(Solved::from)
        } else {
            emd_of_costs(&left, &right, &costs).map(Solved::from)
        };
        let emd = emd.map_err(Failure::failed)?;
        solve_ms.push(started.elapsed().as_secs_f64() * 1e3);
        solved = Some(emd);
    }
    let Some(emd) = solved else {
        return Err(Failure::Usage("--repeat needs at least 1".to_owned()));
    };
    print_report(&emd, median(&mut cost_ms), median(&mut solve_ms), args.json)
}

/// The masses of a mixture file and the mixture: its weights, which have to sum to one unless `partial`.
fn read(path: &Path, partial: bool) -> Result<(Vec<f64>, Mixture), Failure> {
    if !partial {
        let mixture = fit::read_mixture(path)?;
        return Ok((mixture.weights.clone(), mixture));
    }
    let text = files::read_text(path)?;
    MixtureRecord::parse_masses(&text).map_err(|error| files::file_error(path, error))
}

fn print_report(emd: &Solved, cost_ms: f64, solve_ms: f64, as_json: bool) -> CommandResult {
    if as_json {
        let plan: Vec<(usize, usize, f64)> =
            emd.plan.iter().map(|f| (f.from, f.to, f.mass)).collect();
        let mut report = json!({
            "d": emd.d,
            "plan": plan,
            "duality_gap": emd.duality_gap,
            "cost_ms": cost_ms,
            "solve_ms": solve_ms,
        });
        if let Some(totals) = emd.totals {
            report["totals"] = json!(totals);
        }
        output::json(&report)?;
    } else {
        let of_part = emd.totals.map_or_else(String::new, |[w, u]| {
            format!(", {:.6} of {w:.6} and {u:.6} moved", w.min(u))
        });
        output::line(format!(
            "d = {:.9}{of_part}, {} flows, duality gap {:.1e}, costs {cost_ms:.3} ms, solved in {solve_ms:.3} ms",
            emd.d,
            emd.plan.len(),
            emd.duality_gap
        ))?;
    }
    Ok(DONE)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
