//! Beams that a thing drew. A sensor's pattern is the same at every visit: where many more own beams end on a thing than
//! the pattern has, and the other view has no such crowd there, they are there for the thing's sake (a closer look, a
//! cloud put together), and the other view would have had them if the thing had been there then.

use super::outline::Outline;
use super::{Prepared, SegmentSettings, Thing};
use crate::geometry::Passage;
use nalgebra::Vector3;

/// The view that judged a thing.
#[derive(Debug, Clone, Copy)]
pub struct Onlooker<'a> {
    /// The view.
    pub view: &'a Prepared,
    /// Maps the thing's points to its frame.
    pub from_own: Passage,
}

impl Onlooker<'_> {
    /// Whether `thing` drew the own beams that end on it: several rows of them, more than the own pattern has around and
    /// more than this view has within the same outline.
    pub fn lacks(&self, own: &Prepared, thing: &Thing, settings: &SegmentSettings) -> bool {
        thing.own_rows() >= settings.least_width_spacings
            && thing.own_density_per_sr()
                >= settings.drawn_fill * thing.crowding * own.rays.mean_density_per_sr
            && self.surplus(own, thing) >= settings.drawn_surplus
    }

    /// How many times as many beams of `own` end on `thing` as this view has within the same outline, in shares of what
    /// both have per solid angle elsewhere.
    fn surplus(&self, own: &Prepared, thing: &Thing) -> f64 {
        let rays = &self.view.rays;
        let seen: Vec<Vector3<f64>> = thing
            .points
            .iter()
            .map(|i| self.from_own.carry(&own.view.points[*i]) - rays.origin())
            .filter_map(|v| v.try_normalize(1e-9))
            .collect();
        let outline = Outline::of(&seen);
        let mut inside: Vec<usize> = seen
            .iter()
            .filter_map(|d| rays.look(d).nearest)
            .map(|(ray, _)| ray)
            .filter(|ray| self.direction(*ray).is_some_and(|d| outline.holds(&d)))
            .collect();
        inside.sort_unstable();
        inside.dedup();
        let usual = own.rays.mean_density_per_sr / rays.mean_density_per_sr;
        // One more than there are: the next may just have missed it.
        seen.len() as f64 / (usual * (inside.len() + 1) as f64)
    }

    fn direction(&self, ray: usize) -> Option<Vector3<f64>> {
        let view = &self.view.view;
        match view.points.get(ray) {
            Some(p) => (p - view.origin).try_normalize(1e-9),
            None => Some(view.no_return.get(ray - view.points.len())?.into_inner()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Onlooker;
    use crate::geometry::{Passage, View};
    use crate::novelty::{Evidence, Prepared, Settings, Sight, measure};
    use nalgebra::{Point3, Vector3};

    fn at(azimuth_deg: f64, elevation_deg: f64) -> Vector3<f64> {
        let (az, el) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
        Vector3::new(el.cos() * az.cos(), el.cos() * az.sin(), el.sin())
    }

    /// A sphere of 4 m about the sensor by rows ten degrees apart.
    fn shell() -> Vec<Point3<f64>> {
        let lines = (-6..6).flat_map(|az| (-4..4).map(move |el| (az, el)));
        lines
            .map(|(az, el)| at(10.0 * f64::from(az) + 5.0, 10.0 * f64::from(el) + 5.0))
            .map(|d| Point3::from(d * 4.0))
            .collect()
    }

    /// `columns` by `rows` beams over `across_deg` by `up_deg` about straight ahead, which end at `range_m`.
    fn beams(columns: usize, rows: usize, size_deg: [f64; 2], range_m: f64) -> Vec<Point3<f64>> {
        let place =
            |k: usize, of: usize, size_deg: f64| ((k as f64 + 0.5) / of as f64 - 0.5) * size_deg;
        let all = (0..columns).flat_map(|c| (0..rows).map(move |r| (c, r)));
        all.map(|(c, r)| at(place(c, columns, size_deg[0]), place(r, rows, size_deg[1])))
            .map(|d| Point3::from(d * range_m))
            .collect()
    }

    /// Whether a thing that these beams end on drew them, before a view with these beams further on.
    fn drew(thing: &[Point3<f64>], other: Vec<Point3<f64>>) -> bool {
        let settings = Settings::default();
        let prepare = |points: Vec<Point3<f64>>| {
            let view = View::bare(points, Point3::origin());
            Prepared::of(&view, "view", &settings.evidence).expect("a view")
        };
        let mut now = shell();
        let indices: Vec<usize> = (now.len()..now.len() + thing.len()).collect();
        now.extend(thing);
        let evidence = vec![
            Evidence {
                z: 20.0,
                ..Evidence::none(Sight::Through)
            };
            now.len()
        ];
        let (now, then) = (prepare(now), prepare(other));
        let thing = measure(&now, &evidence, indices, &settings.segment);
        let onlooker = Onlooker {
            view: &then,
            from_own: Passage::identity(),
        };
        onlooker.lacks(&now, &thing, &settings.segment)
    }

    #[test]
    fn a_crowd_that_the_other_view_has_not_is_drawn() {
        assert!(drew(&beams(4, 5, [6.0, 7.0], 2.0), shell()));
        assert!(drew(&beams(3, 8, [5.0, 20.0], 2.0), shell()));
        // The other view looked as closely and saw what lies behind.
        let mut closely = shell();
        closely.extend(beams(4, 5, [6.0, 7.0], 4.0));
        assert!(!drew(&beams(4, 5, [6.0, 7.0], 2.0), closely));
    }

    #[test]
    fn beams_of_the_pattern_and_strings_of_beams_are_not_drawn() {
        assert!(!drew(&beams(4, 4, [40.0, 40.0], 2.0), shell()));
        assert!(!drew(&beams(2, 4, [20.0, 40.0], 2.0), shell()));
        assert!(!drew(&beams(1, 20, [0.1, 20.0], 2.0), shell()));
    }
}
