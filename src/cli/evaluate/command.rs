//! The command itself: which pairs, judged how, on how many threads.

use super::tell;
use crate::cli::failure::{DONE, Failure, Outcome as Ended};
use crate::cli::{files, output, progress};
use clap::{Args, ValueEnum};
use patrold_lab::evaluate::{
    Amounts, Change, Engine, Entry, Given, Kind, Outcome, Pair, Planned, Sensor, Set, dump, judge,
    plan, score,
};
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `evaluate`.
#[derive(Debug, Args)]
pub struct EvaluateArgs {
    /// Quiet pairs; as many large changes and a third as many balls, in equal parts; a sixth of it all again for held-out
    /// places and for the held-out sensor
    #[arg(long, value_name = "N", default_value_t = 300)]
    pairs: usize,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Which engine
    #[arg(long, value_enum, default_value_t = EngineArg::Standard)]
    engine: EngineArg,
    /// What the engine is given: points alone, or all that a sweep of our own knows
    #[arg(long, value_enum, default_value_t = ViewArg::Both)]
    view: ViewArg,
    /// Only pairs in such a place (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = place)]
    place: Vec<Kind>,
    /// Only pairs with such a sensor (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = sensor)]
    sensor: Vec<Sensor>,
    /// Only such pairs
    #[arg(long, value_enum)]
    only: Option<OnlyArg>,
    /// Only pairs that nothing is tuned on
    #[arg(long)]
    held_out: bool,
    /// Exactly this pair, as --list-misses names it (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = pair, visible_alias = "only-index")]
    pair: Vec<Planned>,
    /// Pairs at a time [default: one for each core]; times mean something with 1 alone
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Write every pair here as clouds and labels, with a manifest that `compare --manifest` reads
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
    /// One line for each pair judged wrongly, with everything to run it again
    #[arg(long)]
    list_misses: bool,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineArg {
    /// patrold's own
    Standard,
    /// The published recipe
    Paper,
    /// One after the other
    Both,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ViewArg {
    /// Points alone, as `compare` has them
    Bare,
    /// Also where nothing came back, and how noisy ranges are
    Sweep,
    /// One after the other
    Both,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OnlyArg {
    /// Nothing changed
    Quiet,
    /// Something changed, balls aside
    Changed,
    /// Balls
    Balls,
}

fn one_of<T: Copy>(all: &[T], word: impl Fn(T) -> &'static str, text: &str) -> Result<T, String> {
    let words = || all.iter().map(|t| word(*t)).collect::<Vec<_>>().join(", ");
    let found = all.iter().copied().find(|t| word(*t) == text);
    found.ok_or_else(|| format!("expected one of: {}", words()))
}

fn place(text: &str) -> Result<Kind, String> {
    one_of(&Kind::all().collect::<Vec<_>>(), Kind::word, text)
}

fn sensor(text: &str) -> Result<Sensor, String> {
    one_of(&Sensor::all().collect::<Vec<_>>(), Sensor::word, text)
}

fn pair(text: &str) -> Result<Planned, String> {
    Planned::named(text).ok_or_else(|| "expected a class and a number, such as quiet-17".to_owned())
}

impl EvaluateArgs {
    fn pairs(&self) -> Vec<Planned> {
        if !self.pair.is_empty() {
            return self.pair.clone();
        }
        let amounts = |n: usize| Amounts {
            quiet: n,
            large: n.div_ceil(Change::LARGE.len()),
            balls: n.div_ceil(3 * Change::BALLS.len()),
        };
        let held_out = amounts(self.pairs / 6);
        let wanted = |p: &Planned| {
            let of_class = match self.only {
                None => true,
                Some(OnlyArg::Quiet) => p.change == Change::Quiet,
                Some(OnlyArg::Changed) => Change::LARGE.contains(&p.change),
                Some(OnlyArg::Balls) => p.change.ball().is_some(),
            };
            of_class
                && (self.place.is_empty() || self.place.contains(&p.place))
                && (self.sensor.is_empty() || self.sensor.contains(&p.sensor))
                && (!self.held_out || p.set != Set::Tuned)
        };
        plan([amounts(self.pairs), held_out, held_out])
            .into_iter()
            .filter(wanted)
            .collect()
    }

    fn ways(&self) -> Vec<(Engine, Given)> {
        let engines = match self.engine {
            EngineArg::Standard => vec![Engine::Standard],
            EngineArg::Paper => vec![Engine::Paper],
            EngineArg::Both => vec![Engine::Standard, Engine::Paper],
        };
        let views = match self.view {
            ViewArg::Bare => vec![Given::Bare],
            ViewArg::Sweep => vec![Given::Sweep],
            ViewArg::Both => vec![Given::Bare, Given::Sweep],
        };
        let with = |e: &Engine| views.iter().map(|v| (*e, *v)).collect::<Vec<_>>();
        engines.iter().flat_map(with).collect()
    }
}

/// Runs `evaluate`.
pub fn run(args: &EvaluateArgs) -> Ended {
    let pairs = args.pairs();
    if pairs.is_empty() {
        return Err(Failure::Usage(
            "no pair is left by --place, --sensor, --only and --held-out; ask for more --pairs"
                .to_owned(),
        ));
    }
    let run = Run {
        seed: args.seed,
        ways: args.ways(),
        folder: args.dump.as_deref(),
    };
    if let Some(folder) = run.folder {
        fs::create_dir_all(folder).map_err(|error| files::named(folder, error))?;
    }
    let began = Instant::now();
    let clock = || began.elapsed().as_secs_f64() * 1e3;
    let done = progress::over(&pairs, "pairs", args.threads, |planned| {
        run.one(planned, &clock)
    })?;
    let (mut outcomes, mut entries) = (Vec::new(), Vec::new());
    for (judged, entry) in done {
        outcomes.extend(judged);
        entries.extend(entry);
    }
    if let Some(folder) = run.folder {
        let manifest = serde_json::to_vec_pretty(&json!({"seed": args.seed, "pairs": entries}));
        files::write(
            &folder.join("manifest.json"),
            &manifest.map_err(Failure::failed)?,
        )?;
    }
    let report = tell::Report::new(&outcomes, args.seed, pairs.len(), clock() / 1e3);
    if args.json {
        output::json(&report)?;
    } else {
        output::line(report.prose(args.threads == 1))?;
        if args.list_misses {
            output::line(report.misses())?;
        }
    }
    Ok(DONE)
}

/// What came of a pair: what it was judged in each way, and its entry where it was kept.
type Done = (Vec<Outcome>, Option<Entry>);

/// What is done with every pair.
struct Run<'a> {
    seed: u64,
    ways: Vec<(Engine, Given)>,
    folder: Option<&'a Path>,
}

impl Run<'_> {
    fn one(&self, planned: &Planned, clock: &(dyn Fn() -> f64 + Sync)) -> Result<Done, Failure> {
        let pair = Pair::take(planned, self.seed).map_err(Failure::failed)?;
        let entry = self.folder.map(|folder| keep(&pair, folder)).transpose()?;
        let judged = self.ways.iter().map(|(engine, given)| {
            let named = |error| Failure::Failed(format!("pair {}: {error}", planned.name()));
            let judged = judge(&pair, *given, &engine.settings(), clock).map_err(named)?;
            Ok(score(&pair, *engine, *given, &judged))
        });
        Ok((judged.collect::<Result<_, Failure>>()?, entry))
    }
}

fn keep(pair: &Pair, folder: &Path) -> Result<Entry, Failure> {
    let (entry, written) = dump(pair);
    for (name, bytes) in written {
        files::write(&folder.join(name), &bytes)?;
    }
    Ok(entry)
}
