//! The field of view of a sensor, estimated from the directions of its rays. A recorded cloud does not contain the rays
//! without a return; directions inside these bounds were scanned all the same.

use super::constants::{FIELD_BINS, HOLE_BINS, MIN_OFF_TILT_AXIS, MIN_TILT_X};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Bounds of elevation and azimuth (a spinning sensor fills these), and of the tilt of a line about the y axis and the
/// angle along it (a tilted line scanner fills those). Both pairs hold for either sensor. Radians.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FieldOfViewBounds {
    elevation: [f64; 2],
    tilt: [f64; 2],
    /// Bins of a full turn that hold a ray.
    azimuths: [bool; FIELD_BINS],
    along_line: [bool; FIELD_BINS],
}

impl FieldOfViewBounds {
    /// The bounds of unit `directions`, in the sensor's own axes.
    pub(crate) fn from_directions(directions: &[Vector3<f64>]) -> Self {
        let mut field = Self {
            elevation: [f64::INFINITY, f64::NEG_INFINITY],
            tilt: [f64::INFINITY, f64::NEG_INFINITY],
            azimuths: [false; FIELD_BINS],
            along_line: [false; FIELD_BINS],
        };
        for d in directions {
            widen(&mut field.elevation, elevation(d));
            if d.x.abs() >= MIN_TILT_X {
                widen(&mut field.tilt, tilt(d));
            }
            field.azimuths[bin(azimuth(d))] = true;
            field.along_line[bin(along_line(d))] = true;
        }
        field
    }

    /// Bounds that contain both: the same sensor measures along the same directions on its next visit.
    pub(crate) fn union(&self, other: &Self) -> Self {
        let mut union = self.clone();
        for i in 0..2 {
            widen(&mut union.elevation, other.elevation[i]);
            widen(&mut union.tilt, other.tilt[i]);
        }
        for (own, others) in [
            (&mut union.azimuths, &other.azimuths),
            (&mut union.along_line, &other.along_line),
        ] {
            for (a, b) in own.iter_mut().zip(others) {
                *a |= b;
            }
        }
        union
    }

    /// Whether `d` lies between the bounds of elevation, and of tilt where that is well known. The blind cone above or
    /// below a spinning sensor has rays all around it and yet is out of bounds.
    pub(crate) fn within_bounds(&self, d: &Vector3<f64>) -> bool {
        let between = |bounds: &[f64; 2], at: f64| at >= bounds[0] && at <= bounds[1];
        between(&self.elevation, elevation(d))
            && (d.x.abs() < MIN_TILT_X || between(&self.tilt, tilt(d)))
    }

    /// Whether `d` lies inside all bounds, by at least `margin_rad`.
    pub(crate) fn contains(&self, d: &Vector3<f64>, margin_rad: f64) -> bool {
        let inside = |bounds: &[f64; 2], at: f64, margin: f64| {
            at >= bounds[0] + margin && at <= bounds[1] - margin
        };
        let margin_bins = (margin_rad * FIELD_BINS as f64 / (2.0 * PI)).ceil() as usize;
        // Nearer to the tilt axis, the same offset is a larger angle about it.
        let off_axis = (d.x * d.x + d.z * d.z).sqrt();
        off_axis >= MIN_OFF_TILT_AXIS
            && inside(&self.elevation, elevation(d), margin_rad)
            && inside(&self.tilt, tilt(d), margin_rad / off_axis)
            && known_on_both_sides(&self.azimuths, bin(azimuth(d)), margin_bins)
            && known_on_both_sides(&self.along_line, bin(along_line(d)), margin_bins)
    }
}

/// Whether bins on both sides of `at` hold rays: at least `margin` bins away, and near enough for the gap to be a hole.
fn known_on_both_sides(known: &[bool; FIELD_BINS], at: usize, margin: usize) -> bool {
    let on_side =
        |step: usize| (margin..=margin + HOLE_BINS).any(|k| known[(at + k * step) % FIELD_BINS]);
    on_side(1) && on_side(FIELD_BINS - 1)
}

fn widen(bounds: &mut [f64; 2], at: f64) {
    bounds[0] = bounds[0].min(at);
    bounds[1] = bounds[1].max(at);
}

fn elevation(d: &Vector3<f64>) -> f64 {
    d.z.clamp(-1.0, 1.0).asin()
}

/// Tilt, about y, of a line that passes through `d`. Behind, a line that is tilted down in front points up.
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

/// Angle along a tilted line from its middle.
fn along_line(d: &Vector3<f64>) -> f64 {
    d.y.atan2(d.x.signum() * (d.x * d.x + d.z * d.z).sqrt())
}

fn bin(angle: f64) -> usize {
    let turn = angle / (2.0 * PI) + 0.5;
    ((turn * FIELD_BINS as f64) as usize).min(FIELD_BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::FieldOfViewBounds;
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
    fn a_tilted_line_scans_between_its_extremes_only() {
        // A wall ahead shows the upper end of the tilt; nothing came back from there on the left.
        let mut rays: Vec<_> = line(-35.0, 120).collect();
        rays.extend(line(25.0, 20));
        let field = FieldOfViewBounds::from_directions(&rays);
        assert!(field.contains(&direction(60.0, 5.0), 0.01));
        assert!(
            !field.contains(&direction(60.0, 15.0), 0.01),
            "lines converge towards the side"
        );
        assert!(
            !field.contains(&direction(85.0, 0.0), 0.01),
            "and meet there"
        );
        assert!(!field.contains(&direction(0.0, 26.0), 0.01));
        assert!(
            !field.contains(&direction(140.0, 0.0), 0.01),
            "beyond the last step"
        );
    }

    #[test]
    fn rings_scan_a_full_turn() {
        let rings: Vec<_> = (-7..=7)
            .flat_map(|ring| {
                (0..180).map(move |s| direction(2.0 * f64::from(s), 2.0 * f64::from(ring)))
            })
            .collect();
        let field = FieldOfViewBounds::from_directions(&rings);
        for azimuth in [0.0, 50.0, 179.0, -131.0] {
            assert!(field.contains(&direction(azimuth, 11.0), 0.02));
            assert!(!field.contains(&direction(azimuth, 16.0), 0.02));
        }
        assert!(
            field.within_bounds(&direction(90.0, 13.0))
                && !field.within_bounds(&direction(90.0, 16.0))
        );
        assert!(!field.within_bounds(&-Vector3::z()), "the blind cone");
        let quarter = FieldOfViewBounds::from_directions(&rings[..45]);
        assert!(!quarter.contains(&direction(0.0, 0.0), 0.0));
        assert!(field.union(&quarter).contains(&direction(0.0, 0.0), 0.0));
    }
}
