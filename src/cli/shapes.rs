//! `patrold shapes CLOUD`: the shapes in one segmented cloud.

use super::failure::{CommandResult, DONE, Failure};
use super::{clouds, files, output, table, value_parsers};
use clap::{Args, ValueEnum};
use nalgebra::Point3;
use patrold_engine::mixture::{FitSettings, fit};
use patrold_engine::novelty::Surroundings;
use patrold_engine::report::ShapeRecord;
use patrold_engine::shape::ransac::RansacSettings;
use patrold_engine::shape::{MethodChoice, Shape, ShapeSettings, detect_shapes, retrieve};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, Args)]
pub(super) struct ShapesArgs {
    /// Segmented cloud (PLY, PCD or XYZ text); its normals are used if it has them
    cloud: PathBuf,
    /// Method of shape retrieval
    #[arg(long, value_enum, default_value = "auto")]
    method: ShapeMethodArg,
    /// RANSAC on the points: all primitives, no point on two of them
    #[arg(long)]
    points: bool,
    /// Position of the sensor in the cloud, metres [default: what the file says, else 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = value_parsers::parse_point, allow_hyphen_values = true)]
    sensor_origin: Option<Point3<f64>>,
    /// Maximum distance of a point from its surface, metres [default: from the noise]
    #[arg(long, value_name = "M")]
    epsilon: Option<f64>,
    /// Seed of the sampling
    #[arg(long, value_name = "N", default_value_t = 7)]
    seed: u64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum ShapeMethodArg {
    /// RANSAC, on samples of the Gaussians' ellipsoids unless --points is given
    Ransac,
    /// Covariance matching
    Covariance,
    /// The better of the two
    Auto,
}

pub(super) fn run(args: &ShapesArgs) -> CommandResult {
    if args.epsilon.is_some_and(|e| !(e.is_finite() && e > 0.0)) {
        return Err(Failure::Usage("--epsilon needs metres above 0".to_owned()));
    }
    if args.points && args.method == ShapeMethodArg::Covariance {
        return Err(Failure::Usage(
            "--points uses RANSAC, --method covariance does not: give one of them".to_owned(),
        ));
    }
    let cloud = clouds::load(&args.cloud, args.sensor_origin)?;
    let started = Instant::now();
    let found = find_shapes(args, &cloud).map_err(|error| files::file_error(&args.cloud, error))?;
    let shape_ms = started.elapsed().as_secs_f64() * 1e3;
    let records: Vec<ShapeRecord> = found.iter().map(ShapeRecord::new).collect();
    // With --points no point is on two shapes; other methods fit shapes to all points.
    let points_on_shapes: usize = found.iter().map(|shape| shape.inliers).sum();
    let remainder = args
        .points
        .then(|| cloud.measured.points.len().saturating_sub(points_on_shapes));
    if args.json {
        let mut report = json!({
            "shapes": records,
            "points": cloud.measured.points.len(),
            "dropped": cloud.measured.dropped(),
            "no_return": cloud.measured.no_return,
            "shape_ms": shape_ms,
        });
        if let Some(remainder) = remainder {
            report["remainder"] = remainder.into();
        }
        output::json(&report)?;
        return Ok(DONE);
    }
    if records.is_empty() {
        output::line("no shape found")?;
        return Ok(DONE);
    }
    let mut rows = table::table(&[
        "class",
        "probability",
        "centre (m)",
        "size (m)",
        "points",
        "residual (m)",
    ]);
    for record in &records {
        rows.add_row([
            record.class.clone(),
            format!("{:.2}", record.probability),
            table::format_point(record.centre),
            table::format_point(record.size),
            record.inliers.to_string(),
            format!("{:.4}", record.residual_m),
        ]);
    }
    output::line(rows.to_string())?;
    if let Some(remainder) = remainder {
        output::line(format!("{remainder} points on no shape"))?;
    }
    Ok(DONE)
}

fn find_shapes(args: &ShapesArgs, cloud: &clouds::LoadedCloud) -> Result<Vec<Shape>, String> {
    let n = cloud.measured.points.len();
    let ransac = args
        .epsilon
        .map(|epsilon_m| RansacSettings::with_defaults(n, epsilon_m, usize::MAX));
    let settings = ShapeSettings {
        ransac,
        ..ShapeSettings::default()
    };
    if args.points {
        let normals = cloud.normals.as_deref();
        return Ok(detect_shapes(
            &cloud.measured.points,
            normals,
            &cloud.origin,
            &settings,
            args.seed,
        ));
    }
    let mixture = fit(&cloud.measured.points, None, &FitSettings::default())
        .map_err(|error| error.to_string())?
        .mixture;
    let settings = match args.method {
        ShapeMethodArg::Auto => settings,
        ShapeMethodArg::Covariance => ShapeSettings {
            choice: MethodChoice::Covariance,
            ..settings
        },
        ShapeMethodArg::Ransac => {
            let samples = ShapeSettings::paper().ransac_source;
            ShapeSettings {
                choice: MethodChoice::Ransac,
                ransac_source: samples,
                ..settings
            }
        }
    };
    let retrieval = retrieve(
        &cloud.measured.points,
        &Surroundings::default(),
        &mixture,
        &cloud.origin,
        &settings,
        args.seed,
    )
    .map_err(|error| error.to_string())?;
    let mut shapes = vec![retrieval.best];
    shapes.extend(retrieval.parts);
    Ok(shapes)
}
