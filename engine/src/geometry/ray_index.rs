//! The rays of a view, indexed by direction: where it measured, how far, and how densely.

use super::constants::{
    COARSE_SPACINGS, DENSITY_SPACINGS, HULL_GAP_SECTORS, HULL_SPACINGS, INDEX_SPACINGS,
    NEIGHBOUR_SPACINGS, ON_EDGE_SPACINGS, SECTORS, SPACING_SAMPLES,
};
use super::direction_index::DirectionIndex;
use super::sectors::{sector_of, tangents};
use super::{FieldOfViewBounds, RaySet, voxel_downsample};
use nalgebra::{Point3, Vector3};
use std::cmp::Ordering;

/// The rays of a view around its origin. Ray `i` is point `i`; the rays after the points are the directions without a
/// return.
#[derive(Debug, Clone)]
pub struct RayIndex {
    origin: Point3<f64>,
    ranges_m: Vec<f64>,
    index: DirectionIndex,
    /// A thinned set of the directions.
    coarse: DirectionIndex,
    /// Bounds of the measured directions.
    pub(crate) field_of_view: FieldOfViewBounds,
    /// Row spacing, radians; see [`RaySet::spacing_rad`].
    pub spacing_rad: f64,
    /// Rays over the solid angle that they cover, per steradian.
    pub(crate) mean_density_per_sr: f64,
    /// Range in metres that the sensor reaches here: the 99th percentile of the ranges.
    pub(crate) reach_m: f64,
    /// Range up to which a ray without a return proves free space, metres; 0 if it proves nothing.
    pub(crate) free_range_m: f64,
}

/// The rays around a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayNeighbours {
    /// The nearest ray of each sector around the direction: its index and its angle off, radians.
    pub(crate) sectors: [Option<(usize, f64)>; SECTORS],
    /// Where those lie from the direction, radians across and up; of no meaning where there is none.
    offsets_rad: [[f64; 2]; SECTORS],
    /// The nearest of all, in the same form as those of the sectors.
    pub(crate) nearest: Option<(usize, f64)>,
}

impl RayNeighbours {
    /// Whether the direction lies among the rays or on their edge, not beyond it: no more than half a turn is empty, but for a
    /// small part of the row spacing.
    pub(crate) fn are_all_around(&self, spacing_rad: f64) -> bool {
        let filled = |sector: usize| self.sectors[sector % SECTORS].is_some();
        (0..SECTORS).filter(|s| filled(*s)).all(|sector| {
            let apart = (1..=SECTORS)
                .find(|n| filled(sector + n))
                .unwrap_or(SECTORS);
            match apart.cmp(&(SECTORS / 2)) {
                Ordering::Less => true,
                Ordering::Greater => false,
                Ordering::Equal => {
                    let [x, y] = self.offsets_rad[sector];
                    let [next_x, next_y] = self.offsets_rad[(sector + apart) % SECTORS];
                    // The distance beyond the line from the one to the other.
                    let beyond = y * next_x - x * next_y;
                    beyond <= ON_EDGE_SPACINGS * spacing_rad * (next_x - x).hypot(next_y - y)
                }
            }
        }) && self.nearest.is_some()
    }
}

impl RayIndex {
    /// Indexes `rays`.
    pub(crate) fn new(rays: RaySet) -> Self {
        let (directions, spacing_rad) = (rays.directions, rays.spacing_rad);
        let index = DirectionIndex::new(&directions, INDEX_SPACINGS * spacing_rad);
        let coarse_width = COARSE_SPACINGS * spacing_rad;
        let tips: Vec<Point3<f64>> = directions.iter().map(|d| Point3::from(*d)).collect();
        let coarse: Vec<Vector3<f64>> = voxel_downsample(&tips, coarse_width)
            .points
            .iter()
            .filter_map(|p| p.coords.try_normalize(0.5))
            .collect();
        let mut indexed = Self {
            origin: rays.origin,
            mean_density_per_sr: 0.0,
            field_of_view: FieldOfViewBounds::from_directions(&coarse),
            coarse: DirectionIndex::new(&coarse, 3.0 * coarse_width),
            index,
            spacing_rad,
            reach_m: rays.reach_m,
            free_range_m: rays.free_range_m,
            ranges_m: rays.ranges_m,
        };
        indexed.mean_density_per_sr = indexed.mean_density(&directions);
        indexed
    }

    /// The mean of 1/density over rays is the covered solid angle over their number.
    fn mean_density(&self, directions: &[Vector3<f64>]) -> f64 {
        let step = (directions.len() / SPACING_SAMPLES).max(1);
        let (mut n, mut inverse) = (0.0, 0.0);
        for d in directions.iter().step_by(step) {
            let density = self.density_per_sr(d);
            if density > 0.0 {
                n += 1.0;
                inverse += 1.0 / density;
            }
        }
        if inverse > 0.0 { n / inverse } else { 1.0 }
    }

    /// Range of ray `index`, metres; infinite where nothing came back.
    pub(crate) fn range_m(&self, index: usize) -> f64 {
        self.ranges_m[index]
    }

    /// The nearest ray to `d` within `radius_rad` that came back.
    pub(crate) fn nearest_return(&self, d: &Vector3<f64>, radius_rad: f64) -> Option<usize> {
        let mut nearest: Option<(usize, f64)> = None;
        self.index.for_each_within(d, radius_rad, |ray, off| {
            if self.ranges_m[ray].is_finite() {
                keep_nearer(&mut nearest, ray, off.norm_squared());
            }
        });
        nearest.map(|(ray, _)| ray)
    }

    /// Position of the sensor.
    pub(crate) fn origin(&self) -> &Point3<f64> {
        &self.origin
    }

    /// The rays around the unit direction `d`, within 1.6 row spacings; further out, up to twice
    /// that, only to fill sectors that are still empty.
    pub(crate) fn neighbours(&self, d: &Vector3<f64>) -> RayNeighbours {
        let near = self.neighbours_within(d, NEIGHBOUR_SPACINGS * self.spacing_rad);
        let filled = near.sectors.iter().flatten().count();
        if filled >= SECTORS - 1 || near.nearest.is_none() {
            return near;
        }
        let mut wide = self.neighbours_within(d, 2.0 * NEIGHBOUR_SPACINGS * self.spacing_rad);
        for (sector, found) in near.sectors.into_iter().enumerate() {
            if found.is_some() {
                wide.sectors[sector] = found;
                wide.offsets_rad[sector] = near.offsets_rad[sector];
            }
        }
        wide
    }

    /// Whether there are rays on all sides of the direction `d`, however far: then a direction without rays is a hole inside
    /// the view, not its outside. A gap of a sixth of a turn is outside: where the lines of a tilted sensor converge, its
    /// field of view ends between two fans.
    pub(crate) fn surrounds(&self, d: &Vector3<f64>) -> bool {
        let (across, up) = tangents(d);
        let mut sectors = [false; 2 * SECTORS];
        self.coarse
            .for_each_within(d, (HULL_SPACINGS * self.spacing_rad).min(1.0), |_, off| {
                let turn = off.dot(&up).atan2(off.dot(&across)) / std::f64::consts::TAU + 0.5;
                let at = (turn * sectors.len() as f64) as usize;
                sectors[at.min(2 * SECTORS - 1)] = true;
            });
        let n = sectors.len();
        (0..n).all(|i| (0..HULL_GAP_SECTORS).any(|k| sectors[(i + k) % n]))
    }

    /// Rays per steradian around the unit direction `d`, taken over 2.5 row spacings.
    pub(crate) fn density_per_sr(&self, d: &Vector3<f64>) -> f64 {
        let radius = DENSITY_SPACINGS * self.spacing_rad;
        let mut count = 0.0;
        self.index.for_each_within(d, radius, |_, _| count += 1.0);
        count / (std::f64::consts::PI * radius * radius)
    }

    fn neighbours_within(&self, d: &Vector3<f64>, radius: f64) -> RayNeighbours {
        let (across, up) = tangents(d);
        let mut sectors = [None; SECTORS];
        let mut offsets_rad = [[0.0; 2]; SECTORS];
        self.index.for_each_within(d, radius, |i, off| {
            let [x, y] = [off.dot(&across), off.dot(&up)];
            let sector = sector_of(x, y);
            keep_nearer(&mut sectors[sector], i, off.norm_squared());
            if sectors[sector].is_some_and(|(kept, _)| kept == i) {
                offsets_rad[sector] = [x, y];
            }
        });
        let mut nearest = None;
        for (i, d2) in sectors.iter().flatten() {
            keep_nearer(&mut nearest, *i, *d2);
        }
        let angle = |found: Option<(usize, f64)>| found.map(|(i, d2): (usize, f64)| (i, d2.sqrt()));
        RayNeighbours {
            sectors: sectors.map(angle),
            offsets_rad,
            nearest: angle(nearest),
        }
    }
}

/// Keeps the nearer ray; of equals, the one with the lower index.
fn keep_nearer(slot: &mut Option<(usize, f64)>, i: usize, d2: f64) {
    if slot.is_none_or(|(j, b)| d2 < b || (d2 == b && i < j)) {
        *slot = Some((i, d2));
    }
}

#[cfg(test)]
mod tests {
    use super::RayIndex;
    use crate::geometry::{RaySet, View};
    use nalgebra::{Point3, Vector3};

    /// 16 rings 2 deg apart, 0.4 deg along the ring, all at 3 m.
    fn rings() -> View {
        let mut points = Vec::new();
        for ring in -8..8 {
            for step in 0..900 {
                let (el, az) = (
                    (f64::from(ring) * 2.0).to_radians(),
                    (f64::from(step) * 0.4).to_radians(),
                );
                points.push(Point3::new(
                    3.0 * el.cos() * az.cos(),
                    3.0 * el.cos() * az.sin(),
                    3.0 * el.sin(),
                ));
            }
        }
        View::from_points(points, Point3::origin())
    }

    #[test]
    fn spacing_is_that_between_rings() {
        let rays = RayIndex::new(RaySet::from_view(&rings()));
        assert!((1.9..2.4).contains(&rays.spacing_rad.to_degrees()));
        assert!((rays.reach_m - 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_direction_between_rings_has_rays_on_all_sides_and_one_above_does_not() {
        let rays = RayIndex::new(RaySet::from_view(&rings()));
        let between = Vector3::new(1.0, 0.0, 1.0_f64.to_radians().tan()).normalize();
        let found = rays.neighbours(&between);
        assert!(found.are_all_around(rays.spacing_rad), "{found:?}");
        let above = Vector3::new(1.0, 0.0, 1.0).normalize();
        assert!(rays.neighbours(&above).nearest.is_none());
        assert!(!rays.surrounds(&above));
    }

    #[test]
    fn a_direction_beyond_an_edge_of_the_rays_is_not_among_them_however_the_edge_is_turned() {
        const SPACING_RAD: f64 = 0.01;
        for edge in 0..48 {
            let turn = f64::from(edge) / 48.0 * std::f64::consts::TAU;
            let (sin, cos) = turn.sin_cos();
            // A square grid that is turned, up to an edge that is turned by the same.
            let mut points = Vec::new();
            for (column, row) in (-30..=0).flat_map(|c| (-30..=30).map(move |r| (c, r))) {
                let [a, b] = [column, row].map(|n| f64::from(n) * SPACING_RAD);
                let (y, z) = (a * cos - b * sin, a * sin + b * cos);
                points.push(Point3::from(3.0 * Vector3::new(1.0, y, z).normalize()));
            }
            let view = View::from_points(points, Point3::origin());
            let rays = RayIndex::new(RaySet::from_view(&view));
            for (spacings, along) in [0.2, 0.3, 0.5, 0.8, 1.0, -0.02, -0.4, -1.0, -1.5, -2.3]
                .into_iter()
                .flat_map(|s| [0.0, 0.13, 0.5, 0.77].map(|along| (s, along)))
            {
                let [a, b] = [spacings, along].map(|n| n * SPACING_RAD);
                let (y, z) = (a * cos - b * sin, a * sin + b * cos);
                let around = rays.neighbours(&Vector3::new(1.0, y, z).normalize());
                let at = format!("{spacings} beyond, {along} along, turned by {turn:.2}");
                assert!(around.nearest.is_some(), "{at}");
                assert_eq!(
                    around.are_all_around(rays.spacing_rad),
                    spacings < 0.0,
                    "{at}: {around:?}"
                );
            }
        }
    }
}
