//! The figures of the paper as SVG: Fig. 3 (removal of Gaussians), 4d (an ideal cylinder), 5 and 6 (scenes and shapes).

use super::projection::{LineStyle, PanelProjection, StyledLines};
use crate::cli::failure::Failure;
use crate::cli::files;
use nalgebra::Point3;
use patrold_engine::shape::{Primitive, Shape};
use patrold_lab::reproduce::{
    CylinderAttitude, GaussianRemoval, Polyline, ScenePicture, gaussian_outline, shape_outline,
};
use plotters::prelude::{
    BLACK, BLUE, ChartBuilder, Circle, Color, IntoDrawingArea, IntoFont, PathElement, RED,
    RGBColor, SVGBackend, Text, WHITE,
};
use std::collections::HashSet;
use std::path::Path;

/// Side of a panel and height of a figure, pixels.
const PANEL_PX: u32 = 420;
/// Most points of a cloud in a figure; a sweep has a hundred thousand.
const MAX_POINTS: usize = 2000;
/// Standard deviations at which ellipsoids are drawn.
const ELLIPSOID_SIGMAS: f64 = 2.0;
const GREY: RGBColor = RGBColor(150, 150, 150);

/// Writes a scene as `NAME.svg`: the cloud before, the cloud now with what appeared in red, its Gaussians, and the shapes
/// of both methods (blue Euclidean, red feature space).
///
/// # Errors
/// The file cannot be written.
pub(super) fn scene(folder: &Path, name: &str, picture: &ScenePicture) -> Result<(), Failure> {
    let points = |p: &[Point3<f64>], colour: RGBColor| StyledLines {
        lines: thinned(p).into_iter().map(|p| vec![p]).collect(),
        style: LineStyle { colour, width: 1 },
    };
    let lines = |lines: Vec<Polyline>, colour, width| StyledLines {
        lines,
        style: LineStyle { colour, width },
    };
    let outlines = |shapes: &[Shape]| shapes.iter().flat_map(shape_outline).collect::<Vec<_>>();
    let gaussians = picture.gaussians.iter();
    let ellipsoids: Vec<_> = gaussians
        .flat_map(|g| gaussian_outline(g, ELLIPSOID_SIGMAS))
        .collect();
    let panels = [
        ("before", vec![points(&picture.before, GREY)]),
        (
            "now",
            vec![
                points(&picture.unchanged, GREY),
                points(&picture.appeared, RED),
            ],
        ),
        (
            "Gaussians, 2 sigma",
            vec![points(&picture.appeared, GREY), lines(ellipsoids, BLACK, 1)],
        ),
        (
            "shapes: blue A, red B",
            vec![
                points(&picture.appeared, GREY),
                lines(outlines(&picture.euclidean), BLUE, 2),
                lines(outlines(&picture.feature), RED, 2),
            ],
        ),
    ];
    save(folder, name, &panels)
}

/// Writes Fig. 4d: an ideal cylinder (grey), and the shapes that both methods retrieve from its covariance.
///
/// # Errors
/// The file cannot be written.
pub(super) fn ideal_cylinder(folder: &Path, attitude: &CylinderAttitude) -> Result<(), Failure> {
    let truth = Primitive::Cylinder(attitude.cylinder);
    let ideal = Shape {
        class: truth.class(),
        rotation: truth.canonical_rotation(&Point3::origin()),
        size_m: truth.size_m(),
        centre: truth.centre(),
        ..match attitude.feature.clone().or(attitude.euclidean.clone()) {
            Some(shape) => shape,
            None => return Ok(()),
        }
    };
    let drawn = |shape: Option<&Shape>, colour, width| StyledLines {
        lines: shape.map(shape_outline).unwrap_or_default(),
        style: LineStyle { colour, width },
    };
    let ellipsoid = StyledLines {
        lines: gaussian_outline(&attitude.gaussian, 1.0),
        style: LineStyle {
            colour: BLACK,
            width: 1,
        },
    };
    let panels = [
        (
            "ideal cylinder, its Gaussian at 1 sigma",
            vec![drawn(Some(&ideal), GREY, 2), ellipsoid],
        ),
        (
            "shapes: blue A, red B",
            vec![
                drawn(Some(&ideal), GREY, 4),
                drawn(attitude.euclidean.as_ref(), BLUE, 2),
                drawn(attitude.feature.as_ref(), RED, 2),
            ],
        ),
    ];
    save(folder, "fig4d", &panels)
}

/// Writes Fig. 3 as a curve: d_GMM against the number of removed Gaussians; U_th in red, and in grey d_GMM of a view with
/// nothing new.
///
/// # Errors
/// The file cannot be written.
pub(super) fn gaussian_removal(folder: &Path, removal: &GaussianRemoval) -> Result<(), Failure> {
    let rest = removal.steps.iter().map(|s| s.d_gmm_m);
    let curve: Vec<(f64, f64)> = std::iter::once(removal.d_gmm_m)
        .chain(rest)
        .enumerate()
        .map(|(k, d)| (k as f64, d))
        .collect();
    let right = curve.len().max(2) as f64 - 0.5;
    let min_top_m = removal.u_th_m.max(removal.unchanged_m);
    let top = 1.15 * curve.iter().fold(min_top_m, |a, (_, d)| a.max(*d));
    let mut svg = String::new();
    {
        let root =
            SVGBackend::with_string(&mut svg, (PANEL_PX * 3 / 2, PANEL_PX)).into_drawing_area();
        root.fill(&WHITE).map_err(Failure::failed)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(56)
            .caption(
                "d_GMM while Gaussians are removed",
                ("sans-serif", 16).into_font(),
            )
            .build_cartesian_2d(-0.5..right, 0.0..top)
            .map_err(Failure::failed)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc("removed Gaussians")
            .y_desc("d_GMM, m")
            .draw()
            .map_err(Failure::failed)?;
        let unchanged_m = removal.unchanged_m;
        let unchanged = vec![(-0.5, unchanged_m), (right, unchanged_m)];
        let threshold = vec![(-0.5, removal.u_th_m), (right, removal.u_th_m)];
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
                label("U_th", removal.u_th_m + 0.04 * top),
                label("nothing new", unchanged_m + 0.04 * top),
            ])
            .map_err(Failure::failed)?;
        root.present().map_err(Failure::failed)?;
    }
    files::write(&folder.join("fig3.svg"), svg.as_bytes())
}

fn thinned(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let stride = points.len().div_ceil(MAX_POINTS).max(1);
    points.iter().step_by(stride).copied().collect()
}

/// Writes panels side by side, each fitted to its lines.
fn save(folder: &Path, name: &str, panels: &[(&str, Vec<StyledLines>)]) -> Result<(), Failure> {
    let mut svg = String::new();
    {
        let size = (PANEL_PX * panels.len() as u32, PANEL_PX);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(Failure::failed)?;
        let areas = root.split_evenly((1, panels.len()));
        for (area, (title, drawn)) in areas.iter().zip(panels) {
            let area = area
                .titled(title, ("sans-serif", 15).into_font())
                .map_err(Failure::failed)?
                .margin(8, 8, 8, 8);
            let Some(projection) = PanelProjection::fitting(drawn, area.dim_in_pixel()) else {
                continue;
            };
            for StyledLines { lines, style } in drawn {
                let mut filled_pixels = HashSet::new();
                for line in lines {
                    let line: Vec<(i32, i32)> = line.iter().map(|p| projection.pixel(p)).collect();
                    let width = style.width;
                    match line.as_slice() {
                        [at] if !filled_pixels.insert(*at) => Ok(()),
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
