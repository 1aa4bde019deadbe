//! The command: which scenes, in which columns, on how many threads.

use super::figure_numbers::FigureNumbers;
use super::plan::{CorridorSetArg, ScenePlan, corridor_scenes, room_scenes, site_scenes};
use super::report::{ReportHead, ReproduceReport};
use super::{figure_scenes, figure_svg, removal_curve};
use crate::cli::experiment::{RunClock, by_name, create_folder, write_report};
use crate::cli::failure::{CommandResult, DONE, Failure};
use crate::cli::progress;
use clap::{Args, ValueEnum};
use patrold_engine::shape::ELLIPSOID_SIGMAS;
use patrold_lab::reproduce::{
    BeamLayout, SceneResult, TableColumn, run_engine, scene_picture, score,
};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct ReproduceArgs {
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
    set: Option<CorridorSetArg>,
    /// table1: layout of the beams that hit the object
    #[arg(long, value_enum, default_value_t = BeamLayoutArg::Rows)]
    beams: BeamLayoutArg,
    /// Semi-axes of the ellipsoids that method A samples, in standard deviations; 1 and the square root of 3 are readings of
    /// the paper, which prints no factor
    #[arg(long, value_name = "X", default_value_t = ELLIPSOID_SIGMAS, value_parser = parse_sigmas)]
    ellipsoid_sigmas: f64,
    /// Only this column (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = column)]
    way: Vec<TableColumn>,
    /// Exactly this scene, as the list of misses names it, such as sphere-17
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Scenes at a time; times are meaningful with 1 alone
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
    /// Report as JSON
    #[arg(long)]
    json: bool,
    /// Write the figures of the paper here as SVG; the folder is created
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TableArg {
    /// Simulated data: one object in a corridor of 400 points
    Table1,
    /// Three test sites: a door opened in an office, a person in a corridor, a door closed in a laboratory
    Table2,
    /// One object of any class in a furnished room: what the paper left for later
    Rooms,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BeamLayoutArg {
    /// In even rows, as a laser range finder's
    Rows,
    /// At random
    Scattered,
}

impl BeamLayoutArg {
    fn as_str(self) -> &'static str {
        match self {
            Self::Rows => "rows",
            Self::Scattered => "scattered",
        }
    }

    fn layout(self) -> BeamLayout {
        match self {
            Self::Rows => BeamLayout::Rows,
            Self::Scattered => BeamLayout::Scattered,
        }
    }
}

fn column(text: &str) -> Result<TableColumn, String> {
    by_name(&TableColumn::ALL, TableColumn::as_str, text)
}

fn parse_sigmas(text: &str) -> Result<f64, String> {
    let sigmas = text.parse::<f64>().ok();
    sigmas
        .filter(|x| (0.1..=10.0).contains(x))
        .ok_or_else(|| "expected a number from 0.1 to 10".to_owned())
}

impl ReproduceArgs {
    fn plan(&self) -> Vec<ScenePlan> {
        let mut plan = match self.table {
            TableArg::Table1 => corridor_scenes(self.scenes, self.set, self.beams.layout()),
            TableArg::Table2 => site_scenes(self.scenes),
            TableArg::Rooms => room_scenes(self.scenes),
        };
        if let Some(name) = &self.scene {
            plan.retain(|scene| *name == scene.name());
        }
        plan
    }

    fn columns(&self) -> Vec<TableColumn> {
        match self.way.as_slice() {
            [] => TableColumn::ALL.to_vec(),
            some => some.to_vec(),
        }
    }
}

pub(crate) fn run(args: &ReproduceArgs) -> CommandResult {
    let plan = args.plan();
    if plan.is_empty() {
        return Err(Failure::Usage(
            "no scene is left by --scene, --set and --scenes".to_owned(),
        ));
    }
    let columns = args.columns();
    let clock = RunClock::start();
    let judge = |plan: &ScenePlan| judge(plan, args, &columns, clock);
    let results = progress::map_parallel(&plan, "scenes", args.threads, judge)?.concat();
    let figures = match args.table {
        TableArg::Table1 if args.scene.is_none() => Some(FigureNumbers::new(args.seed)?),
        _ => None,
    };
    if let Some(folder) = &args.figures {
        create_folder(folder)?;
        draw(folder, args, &plan, figures.as_ref())?;
    }
    let (table, beams) = match args.table {
        TableArg::Table1 => (1, Some(args.beams.as_str())),
        TableArg::Table2 => (2, None),
        TableArg::Rooms => (3, None),
    };
    let head = ReportHead {
        table,
        seed: args.seed,
        beams,
        ellipsoid_sigmas: args.ellipsoid_sigmas,
        seconds: clock.seconds(),
    };
    let report = ReproduceReport::new(head, &results, figures);
    write_report(&report, || report.tables(args.threads == 1), args.json)?;
    Ok(DONE)
}

/// The results of one scene in all columns.
fn judge(
    plan: &ScenePlan,
    args: &ReproduceArgs,
    columns: &[TableColumn],
    clock: RunClock,
) -> Result<Vec<SceneResult>, Failure> {
    let scene = plan.simulate(args.seed).map_err(Failure::failed)?;
    let results = columns.iter().map(|column| {
        let answer = run_engine(&scene, *column, args.ellipsoid_sigmas, &|| clock.millis())
            .map_err(Failure::failed)?;
        Ok(SceneResult {
            set: plan.set(),
            kind: plan.kind(),
            column: *column,
            score: score(&scene, &answer),
        })
    });
    results.collect()
}

/// Fig. 3 and 4 and the curve of Algorithm 1, and as Fig. 5 or 6 the first scene of every kind.
fn draw(
    folder: &Path,
    args: &ReproduceArgs,
    plan: &[ScenePlan],
    figures: Option<&FigureNumbers>,
) -> Result<(), Failure> {
    if let Some(figures) = figures {
        removal_curve::write(folder, figures.removal())?;
        figure_svg::corridor(folder, &figure_scenes::fig3(args.seed)?)?;
        let novelty = figure_scenes::fig4(args.seed)?;
        if let (Some(novelty), Some(first)) = (novelty, figures.attitudes().first()) {
            figure_svg::retrieval(folder, &novelty, first)?;
        }
    }
    let figure = match args.table {
        TableArg::Table1 => Some("fig5"),
        TableArg::Table2 => Some("fig6"),
        TableArg::Rooms => None,
    };
    let mut drawn = Vec::new();
    for scene in plan.iter().filter(|scene| !scene.is_empty()) {
        let kind = (scene.set(), scene.kind());
        if drawn.contains(&kind) {
            continue;
        }
        drawn.push(kind);
        let pair = scene.simulate(args.seed).map_err(Failure::failed)?;
        let picture = scene_picture(&pair).map_err(Failure::failed)?;
        let (name, letters) = match figure {
            Some(figure) => (
                format!("{figure}-{}-{}", scene.set(), scene.name()),
                figure_scenes::letters(scene.kind()),
            ),
            // No figure of the paper.
            None => (format!("{}-{}", scene.set(), scene.name()), [None; 4]),
        };
        figure_svg::scene(folder, &name, &picture, letters)?;
    }
    Ok(())
}
