//! From points to pixels: a parallel projection from behind, above and to the right of the sensor.

use nalgebra::{Point3, Vector3};
use patrold_lab::reproduce::Polyline;
use plotters::prelude::RGBColor;

/// Direction of view, degrees: to the left of ahead, and down.
const VIEW_DEG: [f64; 2] = [25.0, 25.0];

/// Style of lines, or of points.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineStyle {
    pub colour: RGBColor,
    /// Width of a line, radius of a point, pixels.
    pub width: u32,
}

/// Lines of one style, metres; a line of one point is a dot.
#[derive(Debug, Clone)]
pub(super) struct StyledLines {
    pub lines: Vec<Polyline>,
    pub style: LineStyle,
}

/// The projection of one panel.
#[derive(Debug, Clone, Copy)]
pub(super) struct PanelProjection {
    right: Vector3<f64>,
    up: Vector3<f64>,
    middle: [f64; 2],
    pixels_per_m: f64,
    size: [f64; 2],
}

impl PanelProjection {
    /// The largest in which all lines fit into a panel of `size` pixels; `None` without lines.
    pub(super) fn fitting(drawn: &[StyledLines], size: (u32, u32)) -> Option<Self> {
        let [left, down] = VIEW_DEG.map(f64::to_radians);
        let ahead = Vector3::new(
            down.cos() * left.cos(),
            down.cos() * left.sin(),
            -down.sin(),
        );
        let right = ahead.cross(&Vector3::z()).normalize();
        let up = right.cross(&ahead);
        let mut bounds: Option<[[f64; 2]; 2]> = None;
        for p in drawn.iter().flat_map(|d| d.lines.iter().flatten()) {
            let at = [p.coords.dot(&right), p.coords.dot(&up)];
            let [low, high] = bounds.unwrap_or([at, at]);
            bounds = Some([
                [low[0].min(at[0]), low[1].min(at[1])],
                [high[0].max(at[0]), high[1].max(at[1])],
            ]);
        }
        let [low, high] = bounds?;
        let size = [f64::from(size.0), f64::from(size.1)];
        let scale = |k: usize| size[k] / (high[k] - low[k]).max(1e-6);
        Some(Self {
            right,
            up,
            middle: [0, 1].map(|k| f64::midpoint(low[k], high[k])),
            pixels_per_m: scale(0).min(scale(1)),
            size,
        })
    }

    /// Pixels from the left and from the top.
    pub(super) fn pixel(&self, p: &Point3<f64>) -> (i32, i32) {
        let at = [p.coords.dot(&self.right), p.coords.dot(&self.up)];
        let from_middle = [0, 1].map(|k| (at[k] - self.middle[k]) * self.pixels_per_m);
        (
            (self.size[0] / 2.0 + from_middle[0]).round() as i32,
            (self.size[1] / 2.0 - from_middle[1]).round() as i32,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{LineStyle, PanelProjection, StyledLines};
    use nalgebra::Point3;
    use plotters::prelude::BLACK;

    #[test]
    fn all_lines_lie_in_the_panel_and_up_is_up() {
        let points = [[0.0, 0.0, 0.0], [4.0, -1.0, 2.0], [2.0, 1.5, -0.5]].map(Point3::from);
        let drawn = [StyledLines {
            lines: vec![points.to_vec()],
            style: LineStyle {
                colour: BLACK,
                width: 1,
            },
        }];
        let projection = PanelProjection::fitting(&drawn, (300, 200)).expect("lines");
        for p in &points {
            let (x, y) = projection.pixel(p);
            assert!((0..=300).contains(&x) && (0..=200).contains(&y), "{x} {y}");
        }
        let [foot, head] = [0.0, 1.0].map(|z| projection.pixel(&Point3::new(1.0, 0.0, z)));
        assert!(foot.0 == head.0 && head.1 < foot.1);
        assert!(PanelProjection::fitting(&[], (10, 10)).is_none());
    }
}
