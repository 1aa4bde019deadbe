//! The command itself: which scenes, in which ways, on how many threads.

use super::figures;
use super::numbers::Figures;
use super::tell::Report;
use crate::cli::failure::{DONE, Failure, Outcome};
use crate::cli::{files, output, progress};
use clap::{Args, ValueEnum};
use patrold_engine::report::class_word;
use patrold_lab::reproduce::{
    Beams, Corridor, Density, Furnished, Look, LookError, Mark, Noise, Site, Thing, Way, judge,
    picture, score,
};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub struct ReproduceArgs {
    /// Which table
    #[arg(value_enum)]
    table: TableArg,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// table1: scenes of each class, and as many empty ones [default: 100]; table2: repeats at each site [default: 10]; rooms: as table1
    #[arg(long, value_name = "N")]
    scenes: Option<usize>,
    /// table1: only this reading of the noise and this number of points
    #[arg(long, value_enum)]
    set: Option<SetArg>,
    /// table1: how the beams lie that meet the thing
    #[arg(long, value_enum, default_value_t = BeamsArg::Rows)]
    beams: BeamsArg,
    /// Only this column (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = way)]
    way: Vec<Way>,
    /// Exactly this scene, as the list of misses names it, such as sphere-17
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Scenes at a time; times mean something with 1 alone
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
    /// Report as JSON
    #[arg(long)]
    json: bool,
    /// Write the paper's figures here as SVG; the folder is made
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TableArg {
    /// Simulated data: one thing in a corridor of 400 points
    Table1,
    /// Three test sites: a door opened, a person in a corridor, a door closed
    Table2,
    /// One thing of any class in a furnished room: what the paper left for later
    Rooms,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BeamsArg {
    /// In even rows, as a laser range finder's
    Rows,
    /// At random
    Scattered,
}

/// The sets of table1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SetArg {
    /// Noise of variance 0.001 m^2, 60-120 points on the thing
    Printed,
    /// The same, 15-30 points
    PrintedFew,
    /// Noise of 1 mm, 60-120 points
    Fine,
    /// The same, 15-30 points
    FineFew,
}

impl SetArg {
    fn word(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::PrintedFew => "printed-few",
            Self::Fine => "fine",
            Self::FineFew => "fine-few",
        }
    }

    fn of(self) -> (Noise, Density) {
        match self {
            Self::Printed => (Noise::Printed, Density::Many),
            Self::PrintedFew => (Noise::Printed, Density::Few),
            Self::Fine => (Noise::Fine, Density::Many),
            Self::FineFew => (Noise::Fine, Density::Few),
        }
    }
}

fn way(text: &str) -> Result<Way, String> {
    let words = || Way::ALL.map(Way::word).join(", ");
    let found = Way::ALL.into_iter().find(|w| w.word() == text);
    found.ok_or_else(|| format!("expected one of: {}", words()))
}

/// One scene to be judged.
#[derive(Debug, Clone, Copy)]
enum Planned {
    Corridor(SetArg, Corridor),
    Site(Site, usize),
    Furnished(Furnished),
}

impl Planned {
    fn set(&self) -> &'static str {
        match self {
            Self::Corridor(set, _) => set.word(),
            Self::Site(..) => "sites",
            Self::Furnished(_) => "rooms",
        }
    }

    /// What it is a scene of.
    fn of(&self) -> &'static str {
        match self {
            Self::Corridor(_, corridor) => corridor.thing.word(),
            Self::Site(site, _) => site.word(),
            Self::Furnished(room) => room.class.map_or(Thing::Nothing.word(), class_word),
        }
    }

    fn name(&self) -> String {
        match self {
            Self::Corridor(_, corridor) => corridor.name(),
            Self::Site(site, repeat) => format!("{}-{repeat}", site.word()),
            Self::Furnished(room) => format!("{}-{}", self.of(), room.number),
        }
    }

    fn look(&self, seed: u64) -> Result<Look, LookError> {
        match self {
            Self::Corridor(_, corridor) => corridor.look(seed),
            Self::Site(site, repeat) => site.look(*repeat, seed),
            Self::Furnished(room) => room.look(self.name(), seed),
        }
    }
}

/// What one scene gave in one way.
#[derive(Debug, Clone)]
pub struct Done {
    /// The set that it belongs to.
    pub set: &'static str,
    /// What it is a scene of.
    pub of: &'static str,
    /// The column.
    pub way: Way,
    /// What came of it.
    pub mark: Mark,
}

impl ReproduceArgs {
    fn plan(&self) -> Vec<Planned> {
        let planned: Vec<Planned> = match self.table {
            TableArg::Table1 => {
                let sets = SetArg::value_variants().iter().copied();
                let sets = sets.filter(|set| self.set.is_none_or(|only| only == *set));
                let number = self.scenes.unwrap_or(Corridor::SCENES);
                let beams = match self.beams {
                    BeamsArg::Rows => Beams::Rows,
                    BeamsArg::Scattered => Beams::Scattered,
                };
                let scenes = |set: SetArg| {
                    let (noise, density) = set.of();
                    Thing::ALL.into_iter().flat_map(move |thing| {
                        (0..number).map(move |number| {
                            let corridor = Corridor {
                                thing,
                                noise,
                                density,
                                beams,
                                number,
                            };
                            Planned::Corridor(set, corridor)
                        })
                    })
                };
                sets.flat_map(scenes).collect()
            }
            TableArg::Table2 => {
                let number = self.scenes.unwrap_or(Site::REPEATS);
                let repeats = |site| (0..number).map(move |k| Planned::Site(site, k));
                Site::ALL.into_iter().flat_map(repeats).collect()
            }
            TableArg::Rooms => {
                let scenes = self.scenes.unwrap_or(Corridor::SCENES);
                let of = |class| (0..scenes).map(move |number| Furnished { class, number });
                let all = Furnished::CLASSES.into_iter().flat_map(of);
                all.map(Planned::Furnished).collect()
            }
        };
        let wanted = |p: &Planned| self.scene.as_ref().is_none_or(|name| *name == p.name());
        planned.into_iter().filter(wanted).collect()
    }
}

/// Runs `reproduce`.
pub fn run(args: &ReproduceArgs) -> Outcome {
    let planned = args.plan();
    if planned.is_empty() {
        return Err(Failure::Usage(
            "no scene is left by --scene, --set and --scenes".to_owned(),
        ));
    }
    let ways = match args.way.as_slice() {
        [] => Way::ALL.to_vec(),
        some => some.to_vec(),
    };
    let began = Instant::now();
    let clock = || began.elapsed().as_secs_f64() * 1e3;
    let one = |planned: &Planned| -> Result<Vec<Done>, Failure> {
        let look = planned.look(args.seed).map_err(Failure::failed)?;
        let done = ways.iter().map(|way| {
            let judged = judge(&look, *way, &clock).map_err(Failure::failed)?;
            Ok(Done {
                set: planned.set(),
                of: planned.of(),
                way: *way,
                mark: score(&look, &judged),
            })
        });
        done.collect()
    };
    let done = progress::over(&planned, "scenes", args.threads, one)?.concat();
    let table = match args.table {
        TableArg::Table1 => 1,
        TableArg::Table2 => 2,
        TableArg::Rooms => 3,
    };
    let figures = match args.table {
        TableArg::Table1 if args.scene.is_none() => Some(Figures::new(args.seed)?),
        _ => None,
    };
    if let Some(folder) = &args.figures {
        fs::create_dir_all(folder).map_err(|error| files::named(folder, error))?;
        draw(folder, args, &planned, figures.as_ref())?;
    }
    let beams = match (args.table, args.beams) {
        (TableArg::Table2 | TableArg::Rooms, _) => None,
        (TableArg::Table1, BeamsArg::Rows) => Some("rows"),
        (TableArg::Table1, BeamsArg::Scattered) => Some("scattered"),
    };
    let report = Report::new(table, args.seed, beams, clock() / 1e3, &done, figures);
    if args.json {
        output::json(&report)?;
    } else {
        output::line(report.prose(args.threads == 1))?;
    }
    Ok(DONE)
}

/// Fig. 3 and 4d, and as Fig. 5 or 6 the first scene of every kind.
fn draw(
    folder: &Path,
    args: &ReproduceArgs,
    planned: &[Planned],
    told: Option<&Figures>,
) -> Result<(), Failure> {
    if let Some(told) = told {
        figures::removals(folder, told.removals())?;
        if let Some(first) = told.attitudes().first() {
            figures::ideal_cylinder(folder, first)?;
        }
    }
    let mut drawn = Vec::new();
    for scene in planned {
        let kind = (scene.set(), scene.of());
        if drawn.contains(&kind) || scene.of() == Thing::Nothing.word() {
            continue;
        }
        drawn.push(kind);
        let look = scene.look(args.seed).map_err(Failure::failed)?;
        let picture = picture(&look).map_err(Failure::failed)?;
        let figure = match args.table {
            TableArg::Table1 => "fig5",
            TableArg::Table2 | TableArg::Rooms => "fig6",
        };
        let name = format!("{figure}-{}-{}", scene.set(), scene.name());
        figures::scene(folder, &name, &picture)?;
    }
    Ok(())
}
