//! `patrold compare REFERENCE CURRENT`: the engine on recorded clouds, one pair or a manifest of them.

use super::failure::{CHANGED, DONE, FAILED, Failure, NOT_OBSERVED, Outcome, verdict_code};
use super::stopwatch::{Stopwatch, Timing};
use super::{alarm_report, clouds, files, output, table};
use crate::config::{self, EngineMode, Settings, load};
use clap::{Args, ValueEnum};
use nalgebra::Point3;
use patrold_engine::formats::write_ply;
use patrold_engine::geometry::View;
use patrold_engine::inspect::{Inspection, inspect, prepare};
use patrold_engine::novelty::Detection;
use patrold_engine::report::Report;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The cloud as it should be (PLY, PCD or XYZ text)
    #[arg(required_unless_present = "manifest", requires = "current")]
    reference: Option<PathBuf>,
    /// The cloud as it is now
    current: Option<PathBuf>,
    /// Compare every pair of this manifest, one JSON line each
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["reference", "labels_out", "novelty_out"])]
    manifest: Option<PathBuf>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Which engine
    #[arg(long, value_enum)]
    engine: Option<EngineArg>,
    /// U_th in metres: changed from this distance on
    #[arg(long, value_name = "METRES", value_parser = positive)]
    u_th: Option<f64>,
    /// Seed of everything random
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
    /// Write one line per point of CURRENT: 1 on a listed novelty, else 0
    #[arg(long, value_name = "FILE")]
    labels_out: Option<PathBuf>,
    /// Write the points of all listed novelties
    #[arg(long, value_name = "FILE.ply")]
    novelty_out: Option<PathBuf>,
    /// Where the sensor stood in the reference's frame
    #[arg(long, value_name = "X,Y,Z", value_parser = clouds::parse_point, allow_hyphen_values = true)]
    reference_origin: Option<Point3<f64>>,
    /// Where the sensor stood in the current cloud's frame
    #[arg(long, value_name = "X,Y,Z", value_parser = clouds::parse_point, allow_hyphen_values = true)]
    current_origin: Option<Point3<f64>>,
    /// Where the sensor stood in both [default: 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = clouds::parse_point, allow_hyphen_values = true)]
    sensor_origin: Option<Point3<f64>>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum EngineArg {
    /// patrold's own
    Standard,
    /// The published recipe
    Paper,
}

/// One pair of clouds as files.
#[derive(Debug, Clone, Deserialize)]
struct Pair {
    name: String,
    reference: PathBuf,
    current: PathBuf,
    sensor_origin: Option<[f64; 3]>,
    reference_origin: Option<[f64; 3]>,
    current_origin: Option<[f64; 3]>,
    labels_out: Option<PathBuf>,
    #[serde(skip)]
    novelty_out: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
struct Manifest {
    pairs: Vec<Value>,
}

#[derive(Serialize)]
struct Line<'a> {
    name: &'a str,
    #[serde(flatten)]
    report: &'a Report,
    dropped: [usize; 2],
    timing_ms: Timing,
}

struct Compared {
    inspection: Inspection,
    report: Report,
    dropped: [usize; 2],
    timing: Timing,
}

/// Runs `compare`.
pub fn run(args: &CompareArgs) -> Outcome {
    let settings = settings(args)?;
    match &args.manifest {
        Some(manifest) => run_manifest(manifest, args, &settings),
        None => run_pair(args, &settings),
    }
}

fn settings(args: &CompareArgs) -> Result<Settings, Failure> {
    let mut flags = Vec::new();
    if let Some(engine) = args.engine {
        let mode = match engine {
            EngineArg::Standard => EngineMode::Standard,
            EngineArg::Paper => EngineMode::Paper,
        };
        flags.push((
            "novelty.engine",
            config::Value::Text(mode.word().to_owned()),
        ));
    }
    if let Some(u_th) = args.u_th {
        flags.push(("novelty.u_th_m", config::Value::Float(u_th)));
        flags.push(("novelty.u_th_fm", config::Value::Float(u_th)));
    }
    if let Some(seed) = args.seed {
        flags.push(("mixture.seed", config::Value::Integer(i64::from(seed))));
    }
    Ok(load(args.config.as_deref(), &flags)?.settings)
}

fn run_pair(args: &CompareArgs, settings: &Settings) -> Outcome {
    let (Some(reference), Some(current)) = (&args.reference, &args.current) else {
        return Err(Failure::Usage(
            "compare wants REFERENCE and CURRENT, or --manifest".to_owned(),
        ));
    };
    let array = |p: Option<Point3<f64>>| p.map(|p| p.coords.into());
    let pair = Pair {
        name: current
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        reference: reference.clone(),
        current: current.clone(),
        sensor_origin: array(args.sensor_origin),
        reference_origin: array(args.reference_origin),
        current_origin: array(args.current_origin),
        labels_out: args.labels_out.clone(),
        novelty_out: args.novelty_out.clone(),
    };
    let compared = compare(&pair, settings)?;
    if args.json {
        output::json(&line(&pair, &compared))?;
    } else {
        output::line(prose(&compared))?;
    }
    Ok(verdict_code(compared.inspection.detection.verdict))
}

fn run_manifest(path: &Path, args: &CompareArgs, settings: &Settings) -> Outcome {
    let text = files::read_text(path)?;
    let manifest: Manifest =
        serde_json::from_str(&text).map_err(|error| files::named(path, error))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let progress = super::progress::bar(manifest.pairs.len(), "pairs");
    let mut codes = Vec::new();
    for (index, entry) in manifest.pairs.into_iter().enumerate() {
        let name = match entry.get("name") {
            Some(Value::String(name)) => name.clone(),
            _ => index.to_string(),
        };
        let compared = pair_of(entry, folder, args).and_then(|pair| {
            let compared = compare(&pair, settings)?;
            output::json(&line(&pair, &compared))?;
            Ok(verdict_code(compared.inspection.detection.verdict))
        });
        match compared {
            Ok(code) => codes.push(code),
            Err(failure) => {
                output::json(&json!({"name": name, "error": failure.to_string()}))?;
                codes.push(FAILED);
            }
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    let first_of = |code: &u8| codes.contains(code);
    Ok([FAILED, CHANGED, NOT_OBSERVED]
        .into_iter()
        .find(first_of)
        .unwrap_or(DONE))
}

/// One entry of a manifest: its paths start at the manifest's folder, and where it does not say where the sensor
/// stood, the command line does.
fn pair_of(entry: Value, folder: &Path, args: &CompareArgs) -> Result<Pair, Failure> {
    let mut pair: Pair = serde_json::from_value(entry)
        .map_err(|error| Failure::Failed(format!("in the manifest: {error}; mend this pair")))?;
    for file in [&mut pair.reference, &mut pair.current] {
        *file = folder.join(&*file);
    }
    pair.labels_out = pair.labels_out.map(|file| folder.join(file));
    let array = |p: Option<Point3<f64>>| p.map(|p| p.coords.into());
    if pair.sensor_origin.is_none() {
        let of_flags = |own: Option<Point3<f64>>| array(own.or(args.sensor_origin));
        pair.reference_origin = pair.reference_origin.or(of_flags(args.reference_origin));
        pair.current_origin = pair.current_origin.or(of_flags(args.current_origin));
    }
    Ok(pair)
}

fn compare(pair: &Pair, settings: &Settings) -> Result<Compared, Failure> {
    let mut watch = Stopwatch::start();
    let reference = clouds::load(&pair.reference)?;
    let current = clouds::load(&pair.current)?;
    let origin =
        |own: Option<[f64; 3]>| Point3::from(own.or(pair.sensor_origin).unwrap_or_default());
    let then = View::bare(reference.points.clone(), origin(pair.reference_origin));
    let now = View::bare(current.points.clone(), origin(pair.current_origin));

    let engine = settings.engine(None);
    let seed = settings.mixture.seed;
    let named = |error| Failure::Failed(format!("{}: {error}", pair.name));
    watch.reference();
    let prepared = prepare(&then, &engine, seed).map_err(named)?;
    let inspection = inspect(&prepared, &now, &engine, seed, &mut |stage| {
        watch.stage(stage)
    })
    .map_err(named)?;
    let timing = watch.stop();

    write_outputs(pair, &inspection.detection, &current)?;
    let points = [then.points.len(), now.points.len()];
    Ok(Compared {
        report: Report::new(&inspection, points, settings.novelty.engine.word(), seed),
        inspection,
        dropped: [reference.dropped(), current.dropped()],
        timing,
    })
}

fn write_outputs(
    pair: &Pair,
    detection: &Detection,
    current: &clouds::LoadedCloud,
) -> Result<(), Failure> {
    if let Some(path) = &pair.labels_out {
        let mut labels = vec!["0"; current.in_file];
        for (index, listed) in current.file_index.iter().zip(&detection.labels) {
            if *listed {
                labels[*index] = "1";
            }
        }
        files::write(path, (labels.join("\n") + "\n").as_bytes())?;
    }
    if let Some(path) = &pair.novelty_out {
        let places: Vec<Point3<f64>> = detection
            .novelties
            .iter()
            .flat_map(|n| n.places.iter().copied())
            .collect();
        files::write(path, &write_ply(&places))?;
    }
    Ok(())
}

fn line<'a>(pair: &'a Pair, compared: &'a Compared) -> Line<'a> {
    Line {
        name: &pair.name,
        report: &compared.report,
        dropped: compared.dropped,
        timing_ms: compared.timing,
    }
}

fn prose(compared: &Compared) -> String {
    let report = &compared.report;
    let mut lines = vec![
        format!("{}: {}", report.verdict, report.reason),
        format!(
            "d_GMM {:.6}, U_th {:.6}; {} and {} points; {:.0} ms",
            report.d_gmm,
            report.u_th,
            report.reference.points,
            report.current.points,
            compared.timing.total
        ),
    ];
    let [dropped_then, dropped_now] = compared.dropped;
    if dropped_then + dropped_now > 0 {
        lines.push(format!(
            "dropped {dropped_then} and {dropped_now} points that are not finite"
        ));
    }
    let [x, y, z] = report.pose_correction.translation;
    lines.push(format!(
        "pose correction {}, yaw {:.2} deg",
        table::place([x, y, z]),
        report.pose_correction.rotation_deg[2]
    ));
    lines.extend(
        report
            .novelties
            .iter()
            .map(|n| format!("{}, {} points", alarm_report::describe(n), n.points)),
    );
    lines.join("\n")
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err(format!("expected metres above 0, got {text:?}")),
    }
}
