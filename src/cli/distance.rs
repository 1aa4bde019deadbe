//! `patrold distance A.json B.json`: Earth Mover's Distance between two mixtures.

use super::failure::{CommandResult, DONE, Failure};
use super::{fit, output};
use clap::{Args, ValueEnum};
use patrold_engine::distance::{Emd, GroundDistance, cost_matrix, emd_of_costs};
use serde_json::json;
use std::path::PathBuf;
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

pub(super) fn run(args: &DistanceArgs) -> CommandResult {
    let a = fit::read_mixture(&args.first)?;
    let b = fit::read_mixture(&args.second)?;
    let mut cost_ms = Vec::new();
    let mut solve_ms = Vec::new();
    let mut solved = None;
    for _ in 0..args.repeat {
        let started = Instant::now();
        let costs = cost_matrix(&a, &b, args.ground.into());
        cost_ms.push(started.elapsed().as_secs_f64() * 1e3);
        let started = Instant::now();
        let emd = emd_of_costs(&a.weights, &b.weights, &costs).map_err(Failure::failed)?;
        solve_ms.push(started.elapsed().as_secs_f64() * 1e3);
        solved = Some(emd);
    }
    let Some(emd) = solved else {
        return Err(Failure::Usage("--repeat needs at least 1".to_owned()));
    };
    print_report(&emd, median(&mut cost_ms), median(&mut solve_ms), args.json)
}

fn print_report(emd: &Emd, cost_ms: f64, solve_ms: f64, as_json: bool) -> CommandResult {
    if as_json {
        let plan: Vec<(usize, usize, f64)> =
            emd.plan.iter().map(|f| (f.from, f.to, f.mass)).collect();
        output::json(&json!({
            "d": emd.d,
            "plan": plan,
            "duality_gap": emd.duality_gap,
            "cost_ms": cost_ms,
            "solve_ms": solve_ms,
        }))?;
    } else {
        output::line(format!(
            "d = {:.9}, {} flows, duality gap {:.1e}, costs {cost_ms:.3} ms, solved in {solve_ms:.3} ms",
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
