//! The field of a sensor, from outside: bounds that hold for every direction along which it is known to have looked.
//! A bare cloud does not say where nothing came back; what lies inside these bounds was looked at all the same.

use nalgebra::Vector3;
use std::f64::consts::PI;

/// Angles around are kept in so many bins of a full turn.
const BINS: usize = 180;
/// Gaps of this many bins or fewer are holes in a field, not its end.
const HOLE_BINS: usize = 15;
/// A tilt is well known of directions with at least this share along x: within 60 deg of the axis.
const AHEAD: f64 = 0.5;
/// Where less than this share of a direction points away from y, tilted lines converge: nothing is said there.
const ASIDE: f64 = 0.2;

/// Bounds of elevation and azimuth, and of the tilt of a line that turns about the y axis and the angle along it. A
/// spinning sensor fills the former, a tilted line scanner the latter; each bounds the other's field too, but loosely.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    elevation: [f64; 2],
    tilt: [f64; 2],
    azimuths: [bool; BINS],
    along: [bool; BINS],
}

impl Field {
    /// The bounds of unit `directions`, in the sensor's own axes.
    pub fn of(directions: &[Vector3<f64>]) -> Self {
        let mut field = Self {
            elevation: [f64::INFINITY, f64::NEG_INFINITY],
            tilt: [f64::INFINITY, f64::NEG_INFINITY],
            azimuths: [false; BINS],
            along: [false; BINS],
        };
        for d in directions {
            widen(&mut field.elevation, elevation(d));
            if d.x.abs() >= AHEAD {
                widen(&mut field.tilt, tilt(d));
            }
            field.azimuths[bin(azimuth(d))] = true;
            field.along[bin(along(d))] = true;
        }
        field
    }

    /// Bounds of both: the same sensor, on its next visit, looks along the same directions.
    pub fn joined(&self, other: &Self) -> Self {
        let mut joined = self.clone();
        for i in 0..2 {
            widen(&mut joined.elevation, other.elevation[i]);
            widen(&mut joined.tilt, other.tilt[i]);
        }
        for (mine, theirs) in [
            (&mut joined.azimuths, &other.azimuths),
            (&mut joined.along, &other.along),
        ] {
            for (a, b) in mine.iter_mut().zip(theirs) {
                *a |= b;
            }
        }
        joined
    }

    /// Whether `d` lies between the bounds of elevation, and of tilt where that is well known: the blind cone above or
    /// below a spinning sensor has rays all around it and yet does not.
    pub fn spans(&self, d: &Vector3<f64>) -> bool {
        let between = |bounds: &[f64; 2], at: f64| at >= bounds[0] && at <= bounds[1];
        between(&self.elevation, elevation(d))
            && (d.x.abs() < AHEAD || between(&self.tilt, tilt(d)))
    }

    /// Whether `d` surely lies inside, by `margin_rad` at least.
    pub fn holds(&self, d: &Vector3<f64>, margin_rad: f64) -> bool {
        let inside = |bounds: &[f64; 2], at: f64, margin: f64| {
            at >= bounds[0] + margin && at <= bounds[1] - margin
        };
        let margin_bins = (margin_rad * BINS as f64 / (2.0 * PI)).ceil() as usize;
        // Nearer to the axis of tilting, the same offset is a larger angle about it.
        let off_axis = (d.x * d.x + d.z * d.z).sqrt();
        off_axis >= ASIDE
            && inside(&self.elevation, elevation(d), margin_rad)
            && inside(&self.tilt, tilt(d), margin_rad / off_axis)
            && surrounded(&self.azimuths, bin(azimuth(d)), margin_bins)
            && surrounded(&self.along, bin(along(d)), margin_bins)
    }
}

/// Whether bins are known on both sides, `margin` away at least but near enough for what lies between to be a hole.
fn surrounded(known: &[bool; BINS], at: usize, margin: usize) -> bool {
    let on_side =
        |step: usize| (margin..=margin + HOLE_BINS).any(|k| known[(at + k * step) % BINS]);
    on_side(1) && on_side(BINS - 1)
}

fn widen(bounds: &mut [f64; 2], at: f64) {
    bounds[0] = bounds[0].min(at);
    bounds[1] = bounds[1].max(at);
}

fn elevation(d: &Vector3<f64>) -> f64 {
    d.z.clamp(-1.0, 1.0).asin()
}

/// By how much a line along y is tilted to pass through `d`; behind, a line tilted down in front looks up.
fn tilt(d: &Vector3<f64>) -> f64 {
    if d.x < 0.0 {
        (-d.z).atan2(-d.x)
    } else {
        d.z.atan2(d.x)
    }
}

fn azimuth(d: &Vector3<f64>) -> f64 {
    d.y.atan2(d.x)
}

/// The angle from the middle of a tilted line.
fn along(d: &Vector3<f64>) -> f64 {
    d.y.atan2(d.x.signum() * (d.x * d.x + d.z * d.z).sqrt())
}

fn bin(angle: f64) -> usize {
    let turn = angle / (2.0 * PI) + 0.5;
    ((turn * BINS as f64) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::Field;
    use nalgebra::Vector3;

    fn direction(azimuth_deg: f64, elevation_deg: f64) -> Vector3<f64> {
        let (az, el) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
        Vector3::new(el.cos() * az.cos(), el.cos() * az.sin(), el.sin())
    }

    /// A line over `half_deg` to either side, tilted.
    fn line(tilt_deg: f64, half_deg: i32) -> impl Iterator<Item = Vector3<f64>> {
        let (sin, cos) = tilt_deg.to_radians().sin_cos();
        (-half_deg..=half_deg).map(move |s| {
            let (y, x) = f64::from(s).to_radians().sin_cos();
            Vector3::new(x * cos, y, x * sin)
        })
    }

    #[test]
    fn a_tilted_line_looks_between_its_extremes_and_nowhere_else() {
        // One wall ahead told the upper end of the tilt; nothing came back from there on the left.
        let mut seen: Vec<_> = line(-35.0, 120).collect();
        seen.extend(line(25.0, 20));
        let field = Field::of(&seen);
        assert!(field.holds(&direction(60.0, 5.0), 0.01));
        assert!(
            !field.holds(&direction(60.0, 15.0), 0.01),
            "lines converge towards the side"
        );
        assert!(!field.holds(&direction(85.0, 0.0), 0.01), "and meet there");
        assert!(!field.holds(&direction(0.0, 26.0), 0.01));
        assert!(
            !field.holds(&direction(140.0, 0.0), 0.01),
            "beyond the last step"
        );
    }

    #[test]
    fn rings_look_all_round() {
        let rings: Vec<_> = (-7..=7)
            .flat_map(|ring| {
                (0..180).map(move |s| direction(2.0 * f64::from(s), 2.0 * f64::from(ring)))
            })
            .collect();
        let field = Field::of(&rings);
        for azimuth in [0.0, 50.0, 179.0, -131.0] {
            assert!(field.holds(&direction(azimuth, 11.0), 0.02));
            assert!(!field.holds(&direction(azimuth, 16.0), 0.02));
        }
        assert!(field.spans(&direction(90.0, 13.0)) && !field.spans(&direction(90.0, 16.0)));
        assert!(!field.spans(&-Vector3::z()), "the blind cone");
        let quarter = Field::of(&rings[..45]);
        assert!(!quarter.holds(&direction(0.0, 0.0), 0.0));
        assert!(field.joined(&quarter).holds(&direction(0.0, 0.0), 0.0));
    }
}
