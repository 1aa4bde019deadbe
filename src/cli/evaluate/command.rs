//! The command: which pairs, which engine and input, on how many threads.

use super::report::{EvaluateHead, EvaluateReport};
use crate::cli::experiment::{RunClock, by_name, create_folder, write_report};
use crate::cli::failure::{CommandResult, DONE, Failure};
use crate::cli::{files, output, progress, value_parsers};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use patrold_engine::inspect::{Engine, EngineSettings};
use patrold_lab::evaluate::{
    ChangeClass, EngineInput, KeptReference, ManifestEntry, PairCounts, PairPlan, PairScore,
    PairSet, PlaceKind, PoseErrorClass, SensorKind, SimulatedPair, dump, plan, quiet_threshold,
    quiet_visits, run_engine, score,
};
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    /// Quiet pairs; as many large changes and a third as many balls, in equal parts; a sixth of it all again for held-out
    /// places and for the held-out sensor
    #[arg(long, value_name = "N", default_value_t = 300)]
    pairs: usize,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Which engine
    #[arg(long, default_value = Engine::Standard.as_str(), value_parser = engine_choice())]
    engine: EngineChoice,
    /// Input of the engine: points alone, or all that a sweep of our own has
    #[arg(long, value_enum, default_value_t = EngineInputArg::Both)]
    view: EngineInputArg,
    /// The threshold of d_GMM
    #[arg(long, value_enum, default_value_t = ThresholdArg::Engine)]
    u_th: ThresholdArg,
    /// With `--u-th quiet`: quiet visits to the place of each pair
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=MAX_QUIET_VISITS))]
    quiet_visits: u32,
    /// What is kept of the reference
    #[arg(long, value_enum, default_value_t = ReferenceArg::View)]
    reference: ReferenceArg,
    /// Only pairs in such a place (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = place)]
    place: Vec<PlaceKind>,
    /// Only pairs with such a sensor (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = sensor)]
    sensor: Vec<SensorKind>,
    /// How far off the robot stops on each revisit [default: none, small and large in turn]
    #[arg(long, value_enum)]
    pose_error: Option<PoseErrorArg>,
    /// Only such pairs
    #[arg(long, value_enum)]
    only: Option<PairGroupArg>,
    /// Only pairs that nothing is tuned on
    #[arg(long)]
    held_out: bool,
    /// Exactly this pair, as --list-misses names it (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = pair, visible_alias = "only-index")]
    pair: Vec<PairPlan>,
    /// Pairs at a time [default: one for each core]; times are meaningful with 1 alone
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

#[derive(Debug, Clone)]
struct EngineChoice(Vec<Engine>);

/// Reads the name of an engine, or `both`.
fn engine_choice() -> impl TypedValueParser<Value = EngineChoice> {
    let both = PossibleValue::new("both").help("One after the other");
    let names = value_parsers::engine_values().into_iter().chain([both]);
    PossibleValuesParser::new(names).map(|name| match name.parse() {
        Ok(engine) => EngineChoice(vec![engine]),
        Err(_) => EngineChoice(Engine::ALL.to_vec()),
    })
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineInputArg {
    /// Points alone, as in `compare`
    Bare,
    /// Also empty directions and the noise of ranges
    Sweep,
    /// One after the other
    Both,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ReferenceArg {
    /// Its mixture and its view, as in the store
    View,
    /// Its mixture alone
    Mixture,
}

/// More would only take time: the quantile is that of the last in twenty.
const MAX_QUIET_VISITS: i64 = 1000;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ThresholdArg {
    /// The engine's own
    Engine,
    /// Of each pair's place, from quiet visits to that place: the .95 quantile of their d_GMM
    Quiet,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PoseErrorArg {
    /// Not at all
    None,
    /// Up to 5 cm and 2 deg
    Small,
    /// 5-10 cm and 2-5 deg
    Large,
    /// 10-20 cm and 5-8 deg
    Wide,
    /// 20-30 cm and 8-15 deg
    Widest,
}

impl PoseErrorArg {
    fn class(self) -> PoseErrorClass {
        match self {
            Self::None => PoseErrorClass::None,
            Self::Small => PoseErrorClass::Small,
            Self::Large => PoseErrorClass::Large,
            Self::Wide => PoseErrorClass::Wide,
            Self::Widest => PoseErrorClass::Widest,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PairGroupArg {
    /// Nothing changed
    Quiet,
    /// Something changed, balls aside
    Changed,
    /// Balls
    Balls,
}

fn place(text: &str) -> Result<PlaceKind, String> {
    by_name(
        &PlaceKind::all().collect::<Vec<_>>(),
        PlaceKind::as_str,
        text,
    )
}

fn sensor(text: &str) -> Result<SensorKind, String> {
    by_name(
        &SensorKind::all().collect::<Vec<_>>(),
        SensorKind::as_str,
        text,
    )
}

fn pair(text: &str) -> Result<PairPlan, String> {
    PairPlan::from_name(text)
        .ok_or_else(|| "expected a class and a number, such as quiet-17".to_owned())
}

impl EvaluateArgs {
    fn plan(&self) -> Vec<PairPlan> {
        let mut plan = self.planned();
        if let Some(pose_error) = self.pose_error {
            for pair in &mut plan {
                pair.pose_error = pose_error.class();
            }
        }
        plan
    }

    /// The pairs as their names say.
    fn planned(&self) -> Vec<PairPlan> {
        if !self.pair.is_empty() {
            return self.pair.clone();
        }
        let counts = |n: usize| PairCounts {
            quiet: n,
            large: n.div_ceil(ChangeClass::LARGE.len()),
            balls: n.div_ceil(3 * ChangeClass::BALLS.len()),
        };
        let held_out = counts(self.pairs / 6);
        let selected = |p: &PairPlan| {
            let of_group = match self.only {
                None => true,
                Some(PairGroupArg::Quiet) => p.change == ChangeClass::Quiet,
                Some(PairGroupArg::Changed) => ChangeClass::LARGE.contains(&p.change),
                Some(PairGroupArg::Balls) => p.change.ball().is_some(),
            };
            of_group
                && (self.place.is_empty() || self.place.contains(&p.place))
                && (self.sensor.is_empty() || self.sensor.contains(&p.sensor))
                && (!self.held_out || p.set != PairSet::Tuned)
        };
        plan([counts(self.pairs), held_out, held_out])
            .into_iter()
            .filter(selected)
            .collect()
    }

    fn kept(&self) -> KeptReference {
        match self.reference {
            ReferenceArg::View => KeptReference::View,
            ReferenceArg::Mixture => KeptReference::Mixture,
        }
    }

    /// Quiet visits to each place that U_th comes from; `None`: it is the engine's own.
    fn quiet_visits(&self) -> Option<u32> {
        (self.u_th == ThresholdArg::Quiet).then_some(self.quiet_visits)
    }

    /// Engines and inputs with which every pair is judged.
    fn runs(&self) -> Vec<(Engine, EngineInput)> {
        let inputs = match self.view {
            EngineInputArg::Bare => vec![EngineInput::Bare],
            EngineInputArg::Sweep => vec![EngineInput::Sweep],
            EngineInputArg::Both => vec![EngineInput::Bare, EngineInput::Sweep],
        };
        let with = |e: &Engine| inputs.iter().map(|i| (*e, *i)).collect::<Vec<_>>();
        self.engine.0.iter().flat_map(with).collect()
    }
}

pub(crate) fn run(args: &EvaluateArgs) -> CommandResult {
    let plan = args.plan();
    if plan.is_empty() {
        return Err(Failure::Usage(
            "no pair is left by --place, --sensor, --only and --held-out; ask for more --pairs"
                .to_owned(),
        ));
    }
    let evaluation = Evaluation {
        seed: args.seed,
        runs: args.runs(),
        kept: args.kept(),
        quiet_visits: args.quiet_visits(),
        folder: args.dump.as_deref(),
        clock: RunClock::start(),
    };
    if let Some(folder) = evaluation.folder {
        create_folder(folder)?;
    }
    let done = progress::map_parallel(&plan, "pairs", args.threads, |pair| evaluation.judge(pair))?;
    let (mut scores, mut entries) = (Vec::new(), Vec::new());
    for (own, entry) in done {
        scores.extend(own);
        entries.extend(entry);
    }
    if let Some(folder) = evaluation.folder {
        let manifest = serde_json::to_vec_pretty(&json!({"seed": args.seed, "pairs": entries}));
        files::write(
            &folder.join("manifest.json"),
            &manifest.map_err(Failure::failed)?,
        )?;
    }
    let seconds = evaluation.clock.seconds();
    let head = EvaluateHead {
        seed: args.seed,
        pairs: plan.len(),
        reference: args.kept().as_str(),
        quiet_visits: args.quiet_visits(),
        pose_error: args.pose_error.and_then(|p| {
            let value = p.to_possible_value()?;
            Some(value.get_name().to_owned())
        }),
        seconds,
    };
    let report = EvaluateReport::new(head, &scores);
    write_report(&report, || report.tables(args.threads == 1), args.json)?;
    if args.list_misses && !args.json {
        output::line(report.misses())?;
    }
    Ok(DONE)
}

/// The scores of a pair in all runs, and its manifest entry if it was dumped.
type PairResult = (Vec<PairScore>, Option<ManifestEntry>);

/// What is the same for all pairs.
struct Evaluation<'a> {
    seed: u64,
    runs: Vec<(Engine, EngineInput)>,
    kept: KeptReference,
    /// Quiet visits to each place that U_th comes from.
    quiet_visits: Option<u32>,
    folder: Option<&'a Path>,
    clock: RunClock,
}

impl Evaluation<'_> {
    fn judge(&self, plan: &PairPlan) -> Result<PairResult, Failure> {
        let pair = SimulatedPair::simulate(plan, self.seed).map_err(Failure::failed)?;
        let entry = self
            .folder
            .map(|folder| write_pair(&pair, folder))
            .transpose()?;
        let visits = self.quiet_visits.map(|n| quiet_visits(&pair, n));
        let visits = visits.transpose().map_err(Failure::failed)?;
        let clock = || self.clock.millis();
        let scores = self.runs.iter().map(|(engine, input)| {
            let named = |error| Failure::Failed(format!("pair {}: {error}", plan.name()));
            let settings = EngineSettings::for_engine(*engine).novelty;
            let threshold = visits
                .as_ref()
                .map(|visits| quiet_threshold(&pair, visits, *input, &settings))
                .transpose()
                .map_err(named)?;
            let settings = match &threshold {
                Some(threshold) => threshold.apply(settings),
                None => settings,
            };
            let answer = run_engine(&pair, *input, self.kept, &settings, &clock).map_err(named)?;
            Ok(score(&pair, *engine, *input, threshold.as_ref(), &answer))
        });
        Ok((scores.collect::<Result<_, Failure>>()?, entry))
    }
}

fn write_pair(pair: &SimulatedPair, folder: &Path) -> Result<ManifestEntry, Failure> {
    let (entry, pair_files) = dump(pair);
    for (name, bytes) in pair_files {
        files::write(&folder.join(name), &bytes)?;
    }
    Ok(entry)
}
