//! `patrold shapes CLOUD`: the shapes in one segmented cloud.

use super::failure::{DONE, Failure, Outcome};
use super::{clouds, files, output, table};
use clap::{Args, ValueEnum};
use nalgebra::Point3;
use patrold_engine::mixture::{FitSettings, fit};
use patrold_engine::novelty::Rim;
use patrold_engine::report::ShapeRecord;
use patrold_engine::shape::ransac::RansacSettings;
use patrold_engine::shape::{Choice, Shape, ShapeSettings, primitives, retrieve};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `shapes`.
#[derive(Debug, Args)]
pub struct ShapesArgs {
    /// Segmented cloud (PLY, PCD or XYZ text); its normals are used if it has them
    cloud: PathBuf,
    /// How shapes are retrieved
    #[arg(long, value_enum, default_value = "auto")]
    method: MethodArg,
    /// RANSAC on the points themselves: every primitive in them, with disjoint points
    #[arg(long)]
    points: bool,
    /// Where the sensor stood
    #[arg(long, value_name = "X,Y,Z", value_parser = clouds::parse_point, allow_hyphen_values = true, default_value = "0,0,0")]
    sensor_origin: Point3<f64>,
    /// Greatest distance of a point from the surface it belongs to, metres [default: from the noise]
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
enum MethodArg {
    /// Random sampling consensus (on samples of the Gaussians' ellipsoids unless --points)
    Ransac,
    /// Covariance matching
    Covariance,
    /// The better of the two
    Auto,
}

/// Runs `shapes`.
pub fn run(args: &ShapesArgs) -> Outcome {
    if args.epsilon.is_some_and(|e| !(e.is_finite() && e > 0.0)) {
        return Err(Failure::Usage("--epsilon wants metres above 0".to_owned()));
    }
    if args.points && args.method == MethodArg::Covariance {
        return Err(Failure::Usage(
            "--points takes the points by RANSAC, --method covariance does not: leave one of them away".to_owned(),
        ));
    }
    let cloud = clouds::load(&args.cloud)?;
    let began = Instant::now();
    let found = shapes(args, &cloud).map_err(|error| files::named(&args.cloud, error))?;
    let shape_ms = began.elapsed().as_secs_f64() * 1e3;
    let records: Vec<ShapeRecord> = found.iter().map(ShapeRecord::new).collect();
    // Primitives on the points share none; what the other methods tell is of all of them.
    let on_one: usize = found.iter().map(|shape| shape.inliers).sum();
    let remainder = args
        .points
        .then(|| cloud.points.len().saturating_sub(on_one));
    if args.json {
        let mut report = json!({
            "shapes": records,
            "points": cloud.points.len(),
            "dropped": cloud.dropped(),
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
            table::place(record.centre),
            table::place(record.size),
            record.inliers.to_string(),
            format!("{:.4}", record.residual_m),
        ]);
    }
    output::line(rows.to_string())?;
    if let Some(remainder) = remainder {
        output::line(format!("{remainder} points on none of them"))?;
    }
    Ok(DONE)
}

fn shapes(args: &ShapesArgs, cloud: &clouds::LoadedCloud) -> Result<Vec<Shape>, String> {
    let n = cloud.points.len();
    let ransac = args
        .epsilon
        .map(|epsilon_m| RansacSettings::derived(n, epsilon_m, usize::MAX));
    let settings = ShapeSettings {
        ransac,
        ..ShapeSettings::default()
    };
    if args.points {
        let normals = cloud.normals.as_deref();
        return Ok(primitives(
            &cloud.points,
            normals,
            &args.sensor_origin,
            &settings,
            args.seed,
        ));
    }
    let mixture = fit(&cloud.points, None, &FitSettings::default())
        .map_err(|error| error.to_string())?
        .mixture;
    let settings = match args.method {
        MethodArg::Auto => settings,
        MethodArg::Covariance => ShapeSettings {
            choice: Choice::Covariance,
            ..settings
        },
        MethodArg::Ransac => {
            let samples = ShapeSettings::ideal().ransac_source;
            ShapeSettings {
                choice: Choice::Ransac,
                ransac_source: samples,
                ..settings
            }
        }
    };
    let retrieval = retrieve(
        &cloud.points,
        &Rim::default(),
        &mixture,
        &args.sensor_origin,
        &settings,
        args.seed,
    )
    .map_err(|error| error.to_string())?;
    let mut all = vec![retrieval.best];
    all.extend(retrieval.parts);
    Ok(all)
}
