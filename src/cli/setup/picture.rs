//! A sweep as two pictures (SVG): from above and from the side, so that a person sees whether signs and mount are right.

use nalgebra::Point3;
use patrold_engine::geometry::View;
use std::fmt::Write as _;

/// Side of a picture, and its margin, pixels.
const SIDE: f64 = 640.0;
const MARGIN: f64 = 40.0;
/// Points drawn; of more every so many.
const MAX_POINTS: usize = 12_000;
/// This share of the points is inside of the picture; the others are far away, through windows and doors.
const SHOWN_SHARE: f64 = 0.97;
/// Longest half side, metres.
const MAX_REACH_M: f64 = 15.0;
/// Colours from the lowest to the highest, or from right to left.
const COLOURS: [&str; 5] = ["#30509f", "#2c8f8f", "#3f9f3f", "#c8881f", "#c03030"];

/// The plane that a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// x, forward, upwards in the picture; y, left, to the left.
    Above,
    /// x to the right, z upwards.
    Right,
}

impl Side {
    /// Across and up in the picture, and what the colour shows.
    fn axes(self, p: &Point3<f64>) -> [f64; 3] {
        match self {
            Self::Above => [-p.y, p.x, p.z],
            Self::Right => [p.x, p.z, p.y],
        }
    }

    fn captions(self) -> [&'static str; 3] {
        match self {
            Self::Above => [
                "from above; x (forward) is up, y (left) is left; blue is low, red is high",
                "Each wall is one line and where it is. Seen in a mirror, or walls twice and crossed: ptu.pan_sign, or",
                "the laser's roll (mount.rpy_deg: 180 where it hangs upside down).",
            ],
            Self::Right => [
                "from the right; x (forward) is right, z is up; blue is right, red is left",
                "The floor is one level line below the sensor, walls stand upright. Upside down, or a floor that climbs:",
                "ptu.tilt_sign. A floor that slopes evenly: the laser's pitch, which calibrate finds.",
            ],
        }
    }
}

/// The points of `view`, in the frame of the pan-tilt's base.
pub(super) fn picture(view: &View, side: Side) -> String {
    let reach_m = reach_m(view);
    let scale = (SIDE / 2.0 - MARGIN) / reach_m;
    let at = |across: f64, up: f64| (SIDE / 2.0 + scale * across, SIDE / 2.0 - scale * up);
    let height = SIDE + 3.0 * 18.0;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {SIDE} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{SIDE}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for ring in 1..=(reach_m.ceil() as usize) {
        let (x, y) = at(0.0, 0.0);
        let radius = scale * ring as f64;
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"none\" stroke=\"#dddddd\"/>\
             <text x=\"{:.1}\" y=\"{y:.1}\" fill=\"#999999\" font-size=\"9\">{ring} m</text>",
            x + radius
        );
    }
    for (bin, path) in paths(view, side, reach_m, at).iter().enumerate() {
        let colour = COLOURS[bin];
        let _ = writeln!(
            text,
            "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"1.4\" stroke-linecap=\"round\" fill=\"none\"/>"
        );
    }
    let (x, y) = at(0.0, 0.0);
    let tip = match side {
        Side::Above => (x, y - 30.0),
        Side::Right => (x + 30.0, y),
    };
    let _ = writeln!(
        text,
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/><line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"black\" stroke-width=\"2\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\">x</text>",
        tip.0,
        tip.1,
        tip.0 + 4.0,
        tip.1 - 4.0
    );
    for (line, caption) in side.captions().iter().enumerate() {
        let y = SIDE + 4.0 + 16.0 * line as f64;
        let _ = writeln!(text, "<text x=\"10\" y=\"{y:.1}\">{caption}</text>");
    }
    text.push_str("</svg>\n");
    text
}

/// Half of the picture's side, whole metres.
fn reach_m(view: &View) -> f64 {
    let mut far: Vec<f64> = view.points.iter().map(|p| p.coords.norm()).collect();
    far.sort_by(f64::total_cmp);
    let at = (far.len() as f64 * SHOWN_SHARE) as usize;
    let reach = far.get(at.min(far.len().saturating_sub(1))).copied();
    reach.unwrap_or(1.0).ceil().clamp(1.0, MAX_REACH_M)
}

/// A dot for each point, by colour.
fn paths(
    view: &View,
    side: Side,
    reach_m: f64,
    at: impl Fn(f64, f64) -> (f64, f64),
) -> [String; COLOURS.len()] {
    let mut paths = [const { String::new() }; COLOURS.len()];
    let shown: Vec<[f64; 3]> = view.points.iter().map(|p| side.axes(p)).collect();
    let mut depths: Vec<f64> = shown.iter().map(|p| p[2]).collect();
    depths.sort_by(f64::total_cmp);
    let of_depth = |share: f64| depths.get((share * depths.len() as f64) as usize).copied();
    let (low, high) = (of_depth(0.02).unwrap_or(0.0), of_depth(0.98).unwrap_or(1.0));
    for [across, up, depth] in shown.iter().step_by(shown.len() / MAX_POINTS + 1) {
        if across.abs() > reach_m || up.abs() > reach_m {
            continue;
        }
        let share = (depth - low) / (high - low).max(f64::MIN_POSITIVE);
        let bin = (share * COLOURS.len() as f64).clamp(0.0, COLOURS.len() as f64 - 1.0) as usize;
        let (x, y) = at(*across, *up);
        let _ = write!(paths[bin], "M{x:.1} {y:.1}h0");
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::{Side, picture};
    use nalgebra::Point3;
    use patrold_engine::geometry::View;

    /// Where the dots are, pixels.
    fn dots(svg: &str) -> Vec<(f64, f64)> {
        let paths = svg
            .split("<path d=\"")
            .skip(1)
            .filter_map(|p| p.split('"').next());
        let dots = paths.flat_map(|path| path.split('M').skip(1));
        dots.map(|dot| {
            let (x, y) = dot.trim_end_matches("h0").split_once(' ').expect("x y");
            (x.parse().expect("a number"), y.parse().expect("a number"))
        })
        .collect()
    }

    #[test]
    fn forward_is_up_and_left_is_left_from_above_and_high_is_up_from_the_side() {
        let one = |x, y, z| View::from_points(vec![Point3::new(x, y, z)], Point3::origin());
        let shown = |x, y, z, side| dots(&picture(&one(x, y, z), side))[0];
        let (x, y) = shown(2.0, 0.0, 0.0, Side::Above);
        assert!(x == 320.0 && y < 320.0, "{x} {y}");
        let (x, y) = shown(0.0, 2.0, 0.0, Side::Above);
        assert!(x < 320.0 && y == 320.0, "{x} {y}");
        let (x, y) = shown(2.0, 0.0, 0.0, Side::Right);
        assert!(x > 320.0 && y == 320.0, "{x} {y}");
        let (x, y) = shown(0.0, 0.0, 2.0, Side::Right);
        assert!(x == 320.0 && y < 320.0, "{x} {y}");
        // 2 m of a picture that reaches 2 m.
        assert_eq!(y, 40.0);
    }

    #[test]
    fn a_picture_is_well_formed_and_of_bounded_size() {
        let points = (0..200_000).map(|i| {
            let turn = f64::from(i) * 0.001;
            Point3::new(
                3.0 * turn.cos(),
                3.0 * turn.sin(),
                f64::from(i % 100) * 0.02,
            )
        });
        let view = View::from_points(points.collect(), Point3::origin());
        for side in [Side::Above, Side::Right] {
            let svg = picture(&view, side);
            assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
            assert!(svg.len() < 300_000, "{}", svg.len());
            assert_eq!(svg.matches('<').count(), svg.matches('>').count());
        }
        let empty = View::from_points(Vec::new(), Point3::origin());
        assert!(dots(&picture(&empty, Side::Above)).is_empty());
    }
}
