//! `patrold compare REFERENCE CURRENT`: the engine on recorded clouds, one pair or all pairs of a manifest.

use super::failure::{
    CHANGED, CommandResult, DONE, FAILED, Failure, NOT_OBSERVED, verdict_exit_code,
};
use super::progress::Work;
use super::stopwatch::{CompareTiming, Stopwatch};
use super::{alarm_report, clouds, files, mixtures_out, output, table, value_parsers};
use crate::config::{self, Settings, load};
use crate::patrol::name::name_error;
use clap::Args;
use nalgebra::Point3;
use patrold_engine::formats::write_ply;
use patrold_engine::inspect::{Engine, Inspection, inspect, prepare};
use patrold_engine::novelty::Detection;
use patrold_engine::report::{CoverageRecord, InspectionReport};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct CompareArgs {
    /// The cloud as it should be (PLY, PCD or XYZ text)
    #[arg(required_unless_present = "manifest", requires = "current")]
    reference: Option<PathBuf>,
    /// The cloud as it is now
    current: Option<PathBuf>,
    /// Compare all pairs of this manifest, one JSON line each
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["reference", "labels_out", "novelty_out"])]
    manifest: Option<PathBuf>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Which engine
    #[arg(long, value_parser = value_parsers::engine())]
    engine: Option<Engine>,
    /// U_th in metres: the verdict is changed from this distance on
    #[arg(long, value_name = "METRES", value_parser = parse_metres)]
    u_th: Option<f64>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
    /// Write one line per point of CURRENT: 1 if on a listed novelty, else 0
    #[arg(long, value_name = "FILE")]
    labels_out: Option<PathBuf>,
    /// Write the points of all listed novelties
    #[arg(long, value_name = "FILE.ply")]
    novelty_out: Option<PathBuf>,
    /// Write both mixtures as compared to DIR/gamma.json and DIR/theta.json; of a manifest, to a folder for each pair
    #[arg(long, value_name = "DIR")]
    mixtures_out: Option<PathBuf>,
    /// Position of the sensor in the reference cloud, metres [default: what the file says, else 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = value_parsers::parse_point, allow_hyphen_values = true)]
    reference_origin: Option<Point3<f64>>,
    /// Position of the sensor in the current cloud, metres [default: what the file says, else 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = value_parsers::parse_point, allow_hyphen_values = true)]
    current_origin: Option<Point3<f64>>,
    /// Position of the sensor in both clouds, metres
    #[arg(long, value_name = "X,Y,Z", value_parser = value_parsers::parse_point, allow_hyphen_values = true)]
    sensor_origin: Option<Point3<f64>>,
}

/// One pair of clouds, from the command line or an entry of a manifest.
#[derive(Debug, Clone, Deserialize)]
struct CloudPair {
    name: String,
    reference: PathBuf,
    current: PathBuf,
    sensor_origin: Option<[f64; 3]>,
    reference_origin: Option<[f64; 3]>,
    current_origin: Option<[f64; 3]>,
    labels_out: Option<PathBuf>,
    #[serde(skip)]
    novelty_out: Option<PathBuf>,
    #[serde(skip)]
    mixtures_out: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
struct CompareManifest {
    pairs: Vec<Value>,
}

#[derive(Serialize)]
struct ComparedPairReport<'a> {
    name: &'a str,
    #[serde(flatten)]
    report: &'a InspectionReport,
    dropped: [usize; 2],
    no_return: [usize; 2],
    timing_ms: CompareTiming,
}

struct ComparedPair {
    inspection: Inspection,
    report: InspectionReport,
    /// Points of reference and current that were not measured.
    dropped: [usize; 2],
    /// Those among them that say that nothing came back.
    no_return: [usize; 2],
    timing: CompareTiming,
}

pub(super) fn run(args: &CompareArgs) -> CommandResult {
    let settings = load_settings(args)?;
    match &args.manifest {
        Some(manifest) => run_manifest(manifest, args, &settings),
        None => run_pair(args, &settings),
    }
}

fn load_settings(args: &CompareArgs) -> Result<Settings, Failure> {
    let mut flags = Vec::new();
    if let Some(engine) = args.engine {
        let name = engine.as_str().to_owned();
        flags.push(("novelty.engine", config::ConfigValue::Text(name)));
    }
    if let Some(u_th) = args.u_th {
        flags.push(("novelty.u_th_m", config::ConfigValue::Float(u_th)));
        flags.push(("novelty.u_th_fm", config::ConfigValue::Float(u_th)));
    }
    if let Some(seed) = args.seed {
        flags.push((
            "mixture.seed",
            config::ConfigValue::Integer(i64::from(seed)),
        ));
    }
    Ok(load(args.config.as_deref(), &flags)?.settings)
}

fn run_pair(args: &CompareArgs, settings: &Settings) -> CommandResult {
    let (Some(reference), Some(current)) = (&args.reference, &args.current) else {
        return Err(Failure::Usage(
            "compare needs REFERENCE and CURRENT, or --manifest".to_owned(),
        ));
    };
    let array = |p: Option<Point3<f64>>| p.map(|p| p.coords.into());
    let pair = CloudPair {
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
        mixtures_out: args.mixtures_out.clone(),
    };
    let compared = compare(&pair, settings)?;
    if args.json {
        output::json(&pair_report(&pair, &compared))?;
    } else {
        output::line(report_text(&compared))?;
    }
    Ok(verdict_exit_code(compared.inspection.detection.verdict))
}

fn run_manifest(path: &Path, args: &CompareArgs, settings: &Settings) -> CommandResult {
    let text = files::read_text(path)?;
    let manifest: CompareManifest =
        serde_json::from_str(&text).map_err(|error| files::file_error(path, error))?;
    if manifest.pairs.is_empty() {
        eprintln!(
            "patrold: {}: `pairs` is empty, nothing was compared",
            path.display()
        );
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    // An output of one pair may not be an input of a later one.
    for pair in &manifest.pairs {
        let inputs = [&pair["reference"], &pair["current"]];
        for file in inputs.into_iter().filter_map(Value::as_str) {
            files::note_input(&folder.join(file));
        }
    }
    let work = Work::of_steps(manifest.pairs.len(), "pairs");
    let mut codes = Vec::new();
    let mut folders = BTreeSet::new();
    for (index, entry) in manifest.pairs.into_iter().enumerate() {
        let name = match entry.get("name") {
            Some(Value::String(name)) => name.clone(),
            _ => index.to_string(),
        };
        let compared = parse_pair(entry, folder, args).and_then(|pair| {
            if pair.mixtures_out.is_some() && !folders.insert(pair.name.clone()) {
                let text = "--mixtures-out: another pair has this name; rename one of them";
                return Err(Failure::Failed(text.to_owned()));
            }
            let compared = compare(&pair, settings)?;
            output::json(&pair_report(&pair, &compared))?;
            Ok(verdict_exit_code(compared.inspection.detection.verdict))
        });
        match compared {
            Ok(code) => codes.push(code),
            Err(failure) => {
                output::json(&json!({"name": name, "error": failure.to_string()}))?;
                codes.push(FAILED);
            }
        }
        work.advance(1);
    }
    drop(work);
    Ok([FAILED, CHANGED, NOT_OBSERVED]
        .into_iter()
        .find(|code| codes.contains(code))
        .unwrap_or(DONE))
}

/// An entry of a manifest: its paths are relative to `folder`; origins that it does not have come from the command line.
fn parse_pair(entry: Value, folder: &Path, args: &CompareArgs) -> Result<CloudPair, Failure> {
    let mut pair: CloudPair = serde_json::from_value(entry)
        .map_err(|error| Failure::Failed(format!("manifest: {error}; correct this pair")))?;
    if let Some(why) = name_error(&pair.name) {
        return Err(Failure::Failed(format!("manifest: {why}")));
    }
    for file in [&mut pair.reference, &mut pair.current] {
        *file = folder.join(&*file);
    }
    pair.labels_out = pair.labels_out.map(|file| folder.join(file));
    if let Some(dir) = &args.mixtures_out {
        pair.mixtures_out = Some(mixtures_out::pair_folder(dir, &pair.name)?);
    }
    let array = |p: Option<Point3<f64>>| p.map(|p| p.coords.into());
    if pair.sensor_origin.is_none() {
        let from_args = |own: Option<Point3<f64>>| array(own.or(args.sensor_origin));
        pair.reference_origin = pair.reference_origin.or(from_args(args.reference_origin));
        pair.current_origin = pair.current_origin.or(from_args(args.current_origin));
    }
    Ok(pair)
}

fn compare(pair: &CloudPair, settings: &Settings) -> Result<ComparedPair, Failure> {
    let mut watch = Stopwatch::start();
    let origin = |own: Option<[f64; 3]>| own.or(pair.sensor_origin).map(Point3::from);
    let reference = clouds::load(&pair.reference, origin(pair.reference_origin))?;
    let current = clouds::load(&pair.current, origin(pair.current_origin))?;
    let (reference_view, current_view) = (reference.view(), current.view());

    let engine = settings.engine_settings(None);
    let seed = settings.mixture.seed;
    let failed = |error| Failure::Failed(format!("{}: {error}", pair.name));
    watch.enter_reference();
    let prepared = prepare(&reference_view, &engine, seed).map_err(failed)?;
    let inspection = inspect(&prepared, &current_view, &engine, seed, &mut |stage| {
        watch.enter(stage)
    })
    .map_err(failed)?;
    let timing = watch.stop();

    write_outputs(pair, &inspection.detection, &current)?;
    let points = [reference_view.points.len(), current_view.points.len()];
    Ok(ComparedPair {
        report: InspectionReport::new(&inspection, points, settings.novelty.engine.as_str(), seed),
        inspection,
        dropped: [&reference, &current].map(|cloud| cloud.measured.dropped()),
        no_return: [&reference, &current].map(|cloud| cloud.measured.no_return),
        timing,
    })
}

fn write_outputs(
    pair: &CloudPair,
    detection: &Detection,
    current: &clouds::LoadedCloud,
) -> Result<(), Failure> {
    if let Some(path) = &pair.labels_out {
        let mut labels = vec!["0"; current.in_file];
        for (index, listed) in current.measured.file_index.iter().zip(&detection.labels) {
            if *listed {
                labels[*index] = "1";
            }
        }
        files::write(path, (labels.join("\n") + "\n").as_bytes())?;
    }
    if let Some(path) = &pair.novelty_out {
        let points: Vec<Point3<f64>> = detection
            .novelties
            .iter()
            .flat_map(|n| n.points.iter().copied())
            .collect();
        files::write(path, &write_ply(&points))?;
    }
    if let Some(dir) = &pair.mixtures_out {
        mixtures_out::write(dir, &detection.compared)?;
    }
    Ok(())
}

fn pair_report<'a>(pair: &'a CloudPair, compared: &'a ComparedPair) -> ComparedPairReport<'a> {
    ComparedPairReport {
        name: &pair.name,
        report: &compared.report,
        dropped: compared.dropped,
        no_return: compared.no_return,
        timing_ms: compared.timing,
    }
}

fn report_text(compared: &ComparedPair) -> String {
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
    lines.extend(report.coverage.iter().map(CoverageRecord::to_string));
    let [dropped_reference, dropped_current] = compared.dropped;
    if dropped_reference + dropped_current > 0 {
        lines.push(format!(
            "dropped {dropped_reference} and {dropped_current} points that are not finite or stand for no return"
        ));
    }
    let [x, y, z] = report.pose_correction.translation;
    lines.push(format!(
        "pose correction {}, yaw {:.2} deg",
        table::format_point([x, y, z]),
        report.pose_correction.rotation_deg[2]
    ));
    lines.extend(
        report
            .novelties
            .iter()
            .map(|n| format!("{}, {} points", alarm_report::novelty_text(n), n.points)),
    );
    lines.join("\n")
}

fn parse_metres(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err(format!("expected metres above 0, got {text:?}")),
    }
}
