//! The paper's figures as SVG: Fig. 3 (d_GMM while Gaussians go), 4d (an ideal cylinder), 5 and 6 (scenes and shapes).

use super::projection::{Drawn, Frame, Style};
use crate::cli::failure::Failure;
use crate::cli::files;
use nalgebra::Point3;
use patrold_engine::shape::{Primitive, Shape};
use patrold_lab::reproduce::outline::{of_gaussian, of_shape};
use patrold_lab::reproduce::{Attitude, Picture, Removals};
use plotters::prelude::{
    BLACK, BLUE, ChartBuilder, Circle, Color, IntoDrawingArea, IntoFont, PathElement, RED,
    RGBColor, SVGBackend, Text, WHITE,
};
use std::path::Path;

/// A panel's side and the height of a figure, pixels.
const PANEL: u32 = 420;
/// Most points of a cloud that a picture shows; a sweep has a hundred thousand.
const MOST_POINTS: usize = 4000;
/// Ellipsoids are drawn at as many standard deviations.
const ELLIPSOID_SIGMAS: f64 = 2.0;
const GREY: RGBColor = RGBColor(150, 150, 150);

/// Writes a scene as `NAME.svg`: the cloud before, the cloud now with what came in red, its Gaussians, and the shapes
/// of both methods (blue Euclidean, red feature space).
///
/// # Errors
/// The file cannot be written.
pub fn scene(folder: &Path, name: &str, picture: &Picture) -> Result<(), Failure> {
    let points = |p: &[Point3<f64>], colour: RGBColor| Drawn {
        lines: thinned(p).into_iter().map(|p| vec![p]).collect(),
        style: Style { colour, width: 1 },
    };
    let lines = |lines: Vec<Vec<Point3<f64>>>, colour, width| Drawn {
        lines,
        style: Style { colour, width },
    };
    let outlines = |shapes: &[Shape]| shapes.iter().flat_map(of_shape).collect::<Vec<_>>();
    let gaussians = picture.gaussians.iter();
    let ellipsoids: Vec<_> = gaussians
        .flat_map(|g| of_gaussian(g, ELLIPSOID_SIGMAS))
        .collect();
    let panels = [
        ("before", vec![points(&picture.before, GREY)]),
        (
            "now",
            vec![points(&picture.same, GREY), points(&picture.came, RED)],
        ),
        (
            "Gaussians, 2 sigma",
            vec![points(&picture.came, GREY), lines(ellipsoids, BLACK, 1)],
        ),
        (
            "shapes: blue A, red B",
            vec![
                points(&picture.came, GREY),
                lines(outlines(&picture.euclidean), BLUE, 2),
                lines(outlines(&picture.feature), RED, 2),
            ],
        ),
    ];
    save(folder, name, &panels)
}

/// Writes Fig. 4d: an ideal cylinder (grey), and what each method makes of its covariance.
///
/// # Errors
/// The file cannot be written.
pub fn ideal_cylinder(folder: &Path, attitude: &Attitude) -> Result<(), Failure> {
    let truth = Primitive::Cylinder(attitude.cylinder);
    let own = Shape {
        class: truth.class(),
        rotation: truth.rotation(&Point3::origin()),
        size_m: truth.size_m(),
        centre: truth.centre(),
        ..match attitude.feature.clone().or(attitude.euclidean.clone()) {
            Some(shape) => shape,
            None => return Ok(()),
        }
    };
    let drawn = |shape: Option<&Shape>, colour, width| Drawn {
        lines: shape.map(of_shape).unwrap_or_default(),
        style: Style { colour, width },
    };
    let ellipsoid = Drawn {
        lines: of_gaussian(&attitude.gaussian, 1.0),
        style: Style {
            colour: BLACK,
            width: 1,
        },
    };
    let panels = [
        (
            "ideal cylinder, its Gaussian at 1 sigma",
            vec![drawn(Some(&own), GREY, 2), ellipsoid],
        ),
        (
            "shapes: blue A, red B",
            vec![
                drawn(Some(&own), GREY, 4),
                drawn(attitude.euclidean.as_ref(), BLUE, 2),
                drawn(attitude.feature.as_ref(), RED, 2),
            ],
        ),
    ];
    save(folder, "fig4d", &panels)
}

/// Writes Fig. 3 as a curve: d_GMM against the number of Gaussians taken away; U_th in red, and in grey d_GMM of a look at
/// which nothing was new.
///
/// # Errors
/// The file cannot be written.
pub fn removals(folder: &Path, removals: &Removals) -> Result<(), Failure> {
    let rest = removals.steps.iter().map(|s| s.d_gmm_m);
    let curve: Vec<(f64, f64)> = std::iter::once(removals.d_gmm_m)
        .chain(rest)
        .enumerate()
        .map(|(k, d)| (k as f64, d))
        .collect();
    let right = curve.len().max(2) as f64 - 0.5;
    let least_top_m = removals.u_th_m.max(removals.unchanged_m);
    let top = 1.15 * curve.iter().fold(least_top_m, |a, (_, d)| a.max(*d));
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (PANEL * 3 / 2, PANEL)).into_drawing_area();
        root.fill(&WHITE).map_err(Failure::failed)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(56)
            .caption(
                "d_GMM while Gaussians are taken away",
                ("sans-serif", 16).into_font(),
            )
            .build_cartesian_2d(-0.5..right, 0.0..top)
            .map_err(Failure::failed)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc("Gaussians taken away")
            .y_desc("d_GMM, m")
            .draw()
            .map_err(Failure::failed)?;
        let floor_m = removals.unchanged_m;
        let unchanged = vec![(-0.5, floor_m), (right, floor_m)];
        let threshold = vec![(-0.5, removals.u_th_m), (right, removals.u_th_m)];
        chart
            .draw_series([
                PathElement::new(curve.clone(), BLUE.stroke_width(2)),
                PathElement::new(threshold, RED.stroke_width(1)),
                PathElement::new(unchanged, GREY.stroke_width(1)),
            ])
            .map_err(Failure::failed)?;
        chart
            .draw_series(curve.iter().map(|at| Circle::new(*at, 3, BLUE.filled())))
            .map_err(Failure::failed)?;
        let label =
            |text, at_m| Text::new(text, (right - 1.5, at_m), ("sans-serif", 13).into_font());
        chart
            .draw_series([
                label("U_th", removals.u_th_m + 0.04 * top),
                label("nothing new", floor_m + 0.04 * top),
            ])
            .map_err(Failure::failed)?;
        root.present().map_err(Failure::failed)?;
    }
    files::write(&folder.join("fig3.svg"), svg.as_bytes())
}

fn thinned(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let stride = points.len().div_ceil(MOST_POINTS).max(1);
    points.iter().step_by(stride).copied().collect()
}

/// Panels side by side, each framed by what it shows.
fn save(folder: &Path, name: &str, panels: &[(&str, Vec<Drawn>)]) -> Result<(), Failure> {
    let mut svg = String::new();
    {
        let size = (PANEL * panels.len() as u32, PANEL);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(Failure::failed)?;
        let areas = root.split_evenly((1, panels.len()));
        for (area, (title, drawn)) in areas.iter().zip(panels) {
            let area = area
                .titled(title, ("sans-serif", 15).into_font())
                .map_err(Failure::failed)?
                .margin(8, 8, 8, 8);
            let Some(frame) = Frame::around(drawn, area.dim_in_pixel()) else {
                continue;
            };
            for Drawn { lines, style } in drawn {
                for line in lines {
                    let line: Vec<(i32, i32)> = line.iter().map(|p| frame.pixel(p)).collect();
                    let width = style.width;
                    match line.as_slice() {
                        [at] => area.draw(&Circle::new(*at, width, style.colour.filled())),
                        _ => area.draw(&PathElement::new(line, style.colour.stroke_width(width))),
                    }
                    .map_err(Failure::failed)?;
                }
            }
        }
        root.present().map_err(Failure::failed)?;
    }
    files::write(&folder.join(format!("{name}.svg")), svg.as_bytes())
}
