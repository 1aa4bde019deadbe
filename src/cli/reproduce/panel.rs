//! Panels side by side, each with points, lines and labels in one projection.

use super::projection::{LineStyle, PanelProjection, StyledLines};
use crate::cli::failure::Failure;
use crate::cli::files;
use nalgebra::Point3;
use patrold_lab::reproduce::Polyline;
use plotters::coord::Shift;
use plotters::prelude::{
    Circle, Color, DrawingArea, IntoDrawingArea, IntoFont, PathElement, RGBColor, SVGBackend, Text,
    WHITE,
};
use std::collections::HashSet;
use std::path::Path;

/// Side of a panel and height of a figure, pixels.
pub(super) const PANEL_PX: u32 = 420;
/// Most points of a cloud in a figure; a sweep has a hundred thousand.
const MAX_POINTS: usize = 2000;

/// Fewer points than these are drawn larger.
const FEW_POINTS: usize = 1000;
/// Where the upper left corner of a label is from its point, pixels.
const LABEL_OFFSET_PX: [i32; 2] = [4, -34];
/// Size of a label, pixels.
const LABEL_PX: i32 = 34;

/// What one panel shows.
#[derive(Debug, Clone, Default)]
pub(super) struct Panel {
    title: String,
    lines: Vec<StyledLines>,
    labels: Vec<(Point3<f64>, String, RGBColor)>,
}

impl Panel {
    /// An empty panel.
    pub(super) fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            ..Self::default()
        }
    }

    /// With these points, thinned where they are too many.
    pub(super) fn points(self, points: &[Point3<f64>], colour: RGBColor) -> Self {
        let stride = points.len().div_ceil(MAX_POINTS).max(1);
        let dots = points.iter().step_by(stride).map(|p| vec![*p]);
        let radius = if points.len() < FEW_POINTS { 2 } else { 1 };
        self.lines(dots.collect(), colour, radius)
    }

    /// With these lines, `width` pixels wide.
    pub(super) fn lines(mut self, lines: Vec<Polyline>, colour: RGBColor, width: u32) -> Self {
        let style = LineStyle { colour, width };
        self.lines.push(StyledLines { lines, style });
        self
    }

    /// With a text above this point.
    pub(super) fn label(mut self, at: Point3<f64>, text: String, colour: RGBColor) -> Self {
        self.labels.push((at, text, colour));
        self
    }

    fn draw(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Failure> {
        let area = area
            .titled(&self.title, ("sans-serif", 15).into_font())
            .map_err(Failure::failed)?
            .margin(8, 8, 8, 8);
        let Some(projection) = PanelProjection::fitting(&self.lines, area.dim_in_pixel()) else {
            return Ok(());
        };
        for StyledLines { lines, style } in &self.lines {
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
        for (at, text, colour) in &self.labels {
            let font = ("sans-serif", LABEL_PX).into_font().color(colour);
            let (x, y) = projection.pixel(at);
            let [right, down] = LABEL_OFFSET_PX;
            area.draw(&Text::new(text.clone(), (x + right, y + down), font))
                .map_err(Failure::failed)?;
        }
        Ok(())
    }
}

/// Writes panels side by side as `NAME.svg`, each fitted to its lines.
///
/// # Errors
/// The file cannot be written.
pub(super) fn save(folder: &Path, name: &str, panels: &[Panel]) -> Result<(), Failure> {
    let mut svg = String::new();
    {
        let size = (PANEL_PX * panels.len() as u32, PANEL_PX);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(Failure::failed)?;
        let areas = root.split_evenly((1, panels.len()));
        for (area, panel) in areas.iter().zip(panels) {
            panel.draw(area)?;
        }
        root.present().map_err(Failure::failed)?;
    }
    files::write(&folder.join(format!("{name}.svg")), svg.as_bytes())
}
