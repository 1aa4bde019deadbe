//! Algorithm 1 as a curve.

use super::panel::PANEL_PX;
use crate::cli::failure::Failure;
use crate::cli::files;
use patrold_lab::reproduce::GaussianRemoval;
use plotters::prelude::{
    BLUE, ChartBuilder, Circle, Color, IntoDrawingArea, IntoFont, PathElement, RED, RGBColor,
    SVGBackend, Text, WHITE,
};
use std::path::Path;

const GREY: RGBColor = RGBColor(150, 150, 150);

/// Writes `algorithm1.svg`: d_GMM against the number of removed Gaussians; U_th in red, and in grey d_GMM of a view with
/// nothing new.
///
/// # Errors
/// The file cannot be written.
pub(super) fn write(folder: &Path, removal: &GaussianRemoval) -> Result<(), Failure> {
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
            .x_label_formatter(&|x| format!("{x:.0}"))
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
        // Below its line, where the curve is not yet.
        let label = |text, at_m| Text::new(text, (-0.4, at_m), ("sans-serif", 13).into_font());
        chart
            .draw_series([
                label("U_th", removal.u_th_m + 0.04 * top),
                label("nothing new", unchanged_m - 0.01 * top),
            ])
            .map_err(Failure::failed)?;
        root.present().map_err(Failure::failed)?;
    }
    files::write(&folder.join("algorithm1.svg"), svg.as_bytes())
}
