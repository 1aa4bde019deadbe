//! What lies about a thing. Where a thing touches what stood there before, its own points are no evidence of change: a box
//! lacks its foot, a door the strip beside its hinge. They belong to its shape all the same.

use super::segment::reaches_m;
use super::{Onlooker, Prepared, SegmentSettings, Thing};
use crate::geometry::{Grid, Passage};
use nalgebra::Point3;

/// Points about a thing, metres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rim {
    /// Distance within which points count as beside the thing.
    pub reach_m: f64,
    /// Points of the view that shows the thing which lie beside it and are of no thing.
    pub beside: Vec<Point3<f64>>,
    /// Points of the other view about them.
    pub before: Vec<Point3<f64>>,
}

impl Rim {
    /// The same in another frame.
    pub(super) fn carried(mut self, passage: &Passage) -> Self {
        for p in self.beside.iter_mut().chain(&mut self.before) {
            *p = passage.carry(p);
        }
        self
    }
}

/// The rim of `thing` in the frame of `own`, which shows it; `of_things` marks the own points of all things.
pub(super) fn rim(
    thing: &Thing,
    own: &Prepared,
    of_things: &[bool],
    onlooker: &Onlooker<'_>,
    settings: &SegmentSettings,
) -> Rim {
    let points = &own.view.points;
    let places: Vec<Point3<f64>> = thing.points.iter().map(|i| points[*i]).collect();
    let grid = Grid::new(&places, settings.link_m);
    let mut reaches_m = reaches_m(own, &places, &grid, settings);
    let middle = reaches_m.len() / 2;
    let (_, reach_m, _) = reaches_m.select_nth_unstable_by(middle, f64::total_cmp);
    let reach_m = *reach_m;
    let frame = Frame::around(&places);
    let near = |p: &Point3<f64>, within_m: f64| {
        frame.holds(p, within_m) && grid.nearest(p, within_m).is_some()
    };
    let beside = points.iter().zip(of_things).filter(|(_, taken)| !**taken);
    let beside: Vec<Point3<f64>> = beside
        .map(|(p, _)| *p)
        .filter(|p| near(p, reach_m))
        .collect();
    let own_from_other = onlooker.from_own.inverse();
    let before = onlooker.view.view.points.iter();
    let before = match beside.len() {
        0 => Vec::new(),
        _ => before
            .map(|p| own_from_other.carry(p))
            .filter(|p| near(p, 2.0 * reach_m))
            .collect(),
    };
    Rim {
        reach_m,
        beside,
        before,
    }
}

/// A box around places.
struct Frame {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Frame {
    fn around(places: &[Point3<f64>]) -> Self {
        let far = f64::INFINITY;
        let start = Self {
            low: Point3::new(far, far, far),
            high: Point3::new(-far, -far, -far),
        };
        places.iter().fold(start, |frame, p| Self {
            low: frame.low.inf(p),
            high: frame.high.sup(p),
        })
    }

    fn holds(&self, p: &Point3<f64>, margin_m: f64) -> bool {
        (0..3).all(|k| p[k] >= self.low[k] - margin_m && p[k] <= self.high[k] + margin_m)
    }
}

#[cfg(test)]
mod tests {
    use super::rim;
    use crate::geometry::{Passage, Pose, RangeDrift, View};
    use crate::novelty::{Evidence, Onlooker, Prepared, Settings, Sight, measure};
    use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

    #[test]
    fn a_rim_is_what_lies_beside_and_is_of_no_thing() {
        let settings = Settings::default();
        let wall: Vec<Point3<f64>> = (-25..=25)
            .flat_map(|y| (-25..=25).map(move |z| (y, z)))
            .map(|(y, z)| Point3::new(2.0, f64::from(y) * 0.04, f64::from(z) * 0.04))
            .collect();
        let moved = Pose::from_parts(
            Translation3::new(0.1, -0.2, 0.05),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.1),
        );
        let prepare = |points: &[Point3<f64>]| {
            let view = View::bare(points.to_vec(), Point3::origin());
            Prepared::of(&view, "view", &settings.evidence).expect("a view")
        };
        let own = prepare(&wall);
        let other: Vec<Point3<f64>> = wall.iter().map(|p| moved * p).collect();
        let other = prepare(&other);
        let inside = |p: &Point3<f64>| p.y.abs() < 0.3 && p.z.abs() < 0.3;
        let of_another = |p: &Point3<f64>| p.y > 0.35;
        let of = |of: &dyn Fn(&Point3<f64>) -> bool| -> Vec<usize> {
            (0..wall.len()).filter(|i| of(&wall[*i])).collect()
        };
        let evidence = vec![Evidence::none(Sight::Through); wall.len()];
        let thing = measure(&own, &evidence, of(&inside), &settings.segment);
        let taken: Vec<bool> = wall.iter().map(|p| inside(p) || of_another(p)).collect();
        let onlooker = Onlooker {
            view: &other,
            from_own: Passage::to_reference(moved, RangeDrift::default(), Point3::origin()),
        };
        let found = rim(&thing, &own, &taken, &onlooker, &settings.segment);
        let off_m = |p: &Point3<f64>| {
            let distances = thing.points.iter().map(|i| (wall[*i] - p).norm());
            distances.fold(f64::INFINITY, f64::min)
        };
        let reach_m = found.reach_m;
        assert!(reach_m >= settings.segment.link_m);
        let free = wall.iter().filter(|p| !inside(p) && !of_another(p));
        let beside: Vec<_> = free.filter(|p| off_m(p) <= reach_m).copied().collect();
        assert!(!beside.is_empty());
        assert_eq!(found.beside, beside);
        // The other view has the same wall, which comes back to the same places.
        let about = wall.iter().filter(|p| off_m(p) < 2.0 * reach_m - 1e-9);
        assert!(found.before.len() >= about.count());
        let lowest = |p: &Point3<f64>| wall.iter().any(|q| (q - p).norm() < 1e-9);
        assert!(found.before.iter().all(lowest));
        let back = found.carried(&onlooker.from_own);
        assert!((back.beside[0] - moved * beside[0]).norm() < 1e-12);
    }
}
