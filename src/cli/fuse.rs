//! `patrold fuse A.json B.json`: two mixtures of one place as one.

use super::failure::{CommandResult, DONE, Failure};
use super::table::{format_point, table};
use super::value_parsers::parse_positive;
use super::{files, output};
use clap::Args;
use patrold_engine::mixture::{
    CountedMixture, CountedMixtureRecord, DEFAULT_MAX_FUSED_COMPONENTS, Fusion, fuse,
};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct FuseArgs {
    /// First mixture
    first: PathBuf,
    /// Second mixture, in the same frame
    second: PathBuf,
    /// Largest number of components; pairs are merged at the least loss until it is reached
    #[arg(long, value_name = "K", default_value_t = DEFAULT_MAX_FUSED_COMPONENTS, value_parser = parse_positive)]
    max_components: usize,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct FuseReport {
    #[serde(flatten)]
    fused: CountedMixtureRecord,
    components_of: [usize; 2],
    merges: usize,
    lost_nats: f64,
}

pub(super) fn run(args: &FuseArgs) -> CommandResult {
    let a = read(&args.first)?;
    let b = read(&args.second)?;
    let fusion = fuse(&a, &b, args.max_components).map_err(Failure::failed)?;
    if args.json {
        output::json(&FuseReport {
            fused: CountedMixtureRecord::from(&fusion.fused),
            components_of: [a.mixture().len(), b.mixture().len()],
            merges: fusion.merges,
            lost_nats: fusion.lost_nats,
        })?;
    } else {
        print_table(&a, &b, &fusion)?;
    }
    Ok(DONE)
}

fn print_table(a: &CountedMixture, b: &CountedMixture, fusion: &Fusion) -> Result<(), Failure> {
    let mut rows = table(&["mixture", "components", "beams", "surface m2", "mean m"]);
    for (name, counted) in [("A", a), ("B", b), ("fused", &fusion.fused)] {
        let mean = counted.mixture().total_moments();
        rows.add_row([
            name.to_owned(),
            counted.mixture().len().to_string(),
            format!("{:.0}", counted.beams().iter().sum::<f64>()),
            format!("{:.2}", counted.surface_m2()),
            mean.map_or_else(String::new, |g| format_point(g.mean.into())),
        ]);
    }
    output::line(rows.to_string())?;
    output::line(format!(
        "{} pairs merged, {:.2e} nats per beam lost",
        fusion.merges, fusion.lost_nats
    ))
}

fn read(path: &Path) -> Result<CountedMixture, Failure> {
    let text = files::read_text(path)?;
    CountedMixtureRecord::parse(&text).map_err(|error| files::file_error(path, error))
}
