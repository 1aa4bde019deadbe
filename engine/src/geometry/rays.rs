//! The spherical index of a view: along which directions did it look, and how far did it see?

use super::directions::Directions;
use super::{Field, View, scatter, thin};
use nalgebra::{Point3, Vector3};

/// Directions around a query are sorted into this many equal sectors.
pub const SECTORS: usize = 8;
/// The neighbourhood of a query reaches this many row spacings before it counts as empty.
const REACH_SPACINGS: f64 = 1.6;
/// A hole is surrounded if rays stand around it within this many row spacings.
const HULL_SPACINGS: f64 = 40.0;
/// The hull of holes is kept on a coarser set of directions, this many row spacings apart.
const COARSE_SPACINGS: f64 = 4.0;
/// Cells of the index are this many row spacings wide: a look reads few cells, and few rays in vain.
const INDEX_SPACINGS: f64 = 0.8;
/// Neighbours that tell the noise of ranges lie within this many row spacings: lines above and below are among them.
const SCATTER_SPACINGS: f64 = 2.2;
/// Rays further apart than this are no neighbours, radians.
const WIDEST_GAP_RAD: f64 = 0.5;
/// Rays whose surroundings tell the spacing; more change nothing.
const SPACING_SAMPLES: usize = 160;

/// Rays of a view around its origin. Ray `i` is point `i`; rays beyond are its empty directions.
#[derive(Debug, Clone)]
pub struct Rays {
    origin: Point3<f64>,
    ranges_m: Vec<f64>,
    index: Directions,
    coarse: Directions,
    /// Bounds of where it looked.
    pub field: Field,
    /// Typical distance to the next ray in the sparse direction of the pattern (between scan
    /// lines), radians.
    pub spacing_rad: f64,
    /// Rays over the solid angle that they cover, per steradian.
    pub mean_density_per_sr: f64,
    /// Range in metres that the sensor reaches here: the 99th percentile of the ranges.
    pub reach_m: f64,
    /// Range up to which the sensor itself says that nothing stands where nothing came back, metres; 0 if it says nothing.
    pub free_range_m: f64,
}

/// What stands around one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// The nearest ray of each sector around the direction: its index and its angle off, radians.
    pub sectors: [Option<(usize, f64)>; SECTORS],
    /// The nearest ray of all.
    pub nearest: Option<(usize, f64)>,
    /// How many sectors have a ray.
    pub filled: usize,
}

/// The directions of a view before they are indexed, and how far apart they lie.
#[derive(Debug, Clone)]
pub struct Fan {
    origin: Point3<f64>,
    directions: Vec<Vector3<f64>>,
    ranges_m: Vec<f64>,
    /// See [`Rays::spacing_rad`].
    pub spacing_rad: f64,
    /// Median of the ranges that are any, metres.
    pub middle_range_m: f64,
    /// Standard deviation of ranges as a share of the range, roughly: neighbouring rays tell it.
    pub scatter: f64,
    reach_m: f64,
    free_range_m: f64,
}

impl Fan {
    /// Directions and ranges of `view`. Points at the origin itself have no direction and are never found.
    pub fn of(view: &View) -> Self {
        let mut directions = Vec::with_capacity(view.points.len() + view.no_return.len());
        let mut ranges_m = Vec::with_capacity(directions.capacity());
        for p in &view.points {
            let v = p - view.origin;
            let range_m = v.norm();
            ranges_m.push(range_m);
            directions.push(if range_m > 1e-9 {
                v / range_m
            } else {
                Vector3::zeros()
            });
        }
        let mut sorted = ranges_m.clone();
        for d in &view.no_return {
            directions.push(d.into_inner());
            ranges_m.push(f64::INFINITY);
        }
        // Without knowing better: as if the rays were spread over a third of the sphere.
        let even = (4.0 / (directions.len() as f64).max(1.0)).sqrt();
        let index = Directions::new(&directions, even);
        let spacing_rad = spacing(&index, &directions, even);
        Self {
            origin: view.origin,
            scatter: scatter::relative(
                &index,
                &directions,
                &ranges_m,
                SCATTER_SPACINGS * spacing_rad,
            ),
            spacing_rad,
            middle_range_m: quantile(&mut sorted, 0.5),
            reach_m: quantile(&mut sorted, 0.99),
            free_range_m: view.free_range_m,
            directions,
            ranges_m,
        }
    }
}

impl Rays {
    /// Indexes the directions of a view.
    pub fn of(fan: Fan) -> Self {
        let (directions, spacing_rad) = (fan.directions, fan.spacing_rad);
        let index = Directions::new(&directions, INDEX_SPACINGS * spacing_rad);
        let coarse_width = COARSE_SPACINGS * spacing_rad;
        let places: Vec<Point3<f64>> = directions.iter().map(|d| Point3::from(*d)).collect();
        let coarse: Vec<Vector3<f64>> = thin(&places, coarse_width)
            .points
            .iter()
            .filter_map(|p| p.coords.try_normalize(0.5))
            .collect();
        let mut rays = Self {
            origin: fan.origin,
            mean_density_per_sr: 0.0,
            field: Field::of(&coarse),
            coarse: Directions::new(&coarse, 3.0 * coarse_width),
            index,
            spacing_rad,
            reach_m: fan.reach_m,
            free_range_m: fan.free_range_m,
            ranges_m: fan.ranges_m,
        };
        rays.mean_density_per_sr = rays.mean_density(&directions);
        rays
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
    pub fn range_m(&self, index: usize) -> f64 {
        self.ranges_m[index]
    }

    /// The sensor's place.
    pub fn origin(&self) -> &Point3<f64> {
        &self.origin
    }

    /// What stands around the unit direction `d`, within 1.6 spacings; further out, up to twice
    /// that, only to fill sectors that are still empty.
    pub fn look(&self, d: &Vector3<f64>) -> Look {
        let near = self.look_within(d, REACH_SPACINGS * self.spacing_rad);
        if near.filled >= SECTORS - 1 || near.nearest.is_none() {
            return near;
        }
        let mut wide = self.look_within(d, 2.0 * REACH_SPACINGS * self.spacing_rad);
        for (slot, found) in wide.sectors.iter_mut().zip(near.sectors) {
            if found.is_some() {
                *slot = found;
            }
        }
        wide
    }

    /// Whether rays stand around the direction `d` on all sides, however far: then a place without rays
    /// is a hole inside the view, not its outside. A gap of a sixth of the way round is outside: where
    /// the lines of a tilted sensor converge, its field ends between two fans.
    pub fn surrounds(&self, d: &Vector3<f64>) -> bool {
        let (across, up) = basis(d);
        let mut sectors = [false; 2 * SECTORS];
        self.coarse
            .for_each_within(d, (HULL_SPACINGS * self.spacing_rad).min(1.0), |_, off| {
                let turn = off.dot(&up).atan2(off.dot(&across)) / std::f64::consts::TAU + 0.5;
                let at = (turn * sectors.len() as f64) as usize;
                sectors[at.min(2 * SECTORS - 1)] = true;
            });
        // No three neighbouring sectors empty.
        let n = sectors.len();
        (0..n).all(|i| (0..3).any(|k| sectors[(i + k) % n]))
    }

    /// Rays per steradian around the unit direction `d`, taken over 2.5 spacings.
    pub fn density_per_sr(&self, d: &Vector3<f64>) -> f64 {
        let radius = 2.5 * self.spacing_rad;
        let mut count = 0.0;
        self.index.for_each_within(d, radius, |_, _| count += 1.0);
        count / (std::f64::consts::PI * radius * radius)
    }

    fn look_within(&self, d: &Vector3<f64>, radius: f64) -> Look {
        let (across, up) = basis(d);
        let mut sectors = [None; SECTORS];
        self.index.for_each_within(d, radius, |i, off| {
            let slot = &mut sectors[sector(off.dot(&across), off.dot(&up))];
            keep_nearer(slot, i, off.norm_squared());
        });
        let mut nearest = None;
        for (i, d2) in sectors.iter().flatten() {
            keep_nearer(&mut nearest, *i, *d2);
        }
        let angle = |found: Option<(usize, f64)>| found.map(|(i, d2): (usize, f64)| (i, d2.sqrt()));
        Look {
            sectors: sectors.map(angle),
            nearest: angle(nearest),
            filled: sectors.iter().filter(|s| s.is_some()).count(),
        }
    }
}

fn keep_nearer(slot: &mut Option<(usize, f64)>, i: usize, d2: f64) {
    if slot.is_none_or(|(j, b)| d2 < b || (d2 == b && i < j)) {
        *slot = Some((i, d2));
    }
}

/// Two unit vectors that span the plane across `d`; the second points up unless `d` does.
fn basis(d: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let pole = if d.z.abs() < 0.95 {
        Vector3::z()
    } else {
        Vector3::x()
    };
    let across = pole.cross(d).normalize();
    (across, d.cross(&across))
}

/// Sector of the offset (x, y); sectors are centred on the axes and diagonals.
fn sector(x: f64, y: f64) -> usize {
    // Slopes instead of an arc tangent: tan(22.5 deg) splits axes from diagonals.
    const SLOPE: f64 = 0.414_213_562_373_095_03;
    let (ax, ay) = (x.abs(), y.abs());
    if ay <= SLOPE * ax {
        if x >= 0.0 { 0 } else { 4 }
    } else if ax <= SLOPE * ay {
        if y >= 0.0 { 2 } else { 6 }
    } else {
        match (x >= 0.0, y >= 0.0) {
            (true, true) => 1,
            (false, true) => 3,
            (false, false) => 5,
            (true, false) => 7,
        }
    }
}

/// The value below which the share `at` of `values` lies; 0 without any. Leaves them in another order.
fn quantile(values: &mut [f64], at: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let index = ((values.len() as f64 * at) as usize).min(values.len() - 1);
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

/// Median over a sample of rays of the second largest distance to the nearest ray of a sector.
fn spacing(index: &Directions, directions: &[Vector3<f64>], even: f64) -> f64 {
    let step = (directions.len() / SPACING_SAMPLES).max(1);
    let mut widths: Vec<f64> = directions
        .iter()
        .step_by(step)
        .filter(|d| d.norm_squared() > 0.25)
        .filter_map(|d| spacing_at(index, d, even))
        .collect();
    widths.sort_unstable_by(f64::total_cmp);
    // Without any surroundings: one ray per square of a hundredth of the sphere.
    widths
        .get(widths.len() / 2)
        .copied()
        .unwrap_or(0.35)
        .clamp(5e-4, 0.5)
}

/// The second largest distance to the nearest ray of a sector around the ray `d`; `None` at a view's edge.
fn spacing_at(index: &Directions, d: &Vector3<f64>, even: f64) -> Option<f64> {
    let (across, up) = basis(d);
    let mut radius = 3.0 * even;
    loop {
        let mut sectors = [f64::INFINITY; SECTORS];
        index.for_each_within(d, radius, |_, off| {
            let d2 = off.norm_squared();
            // The ray itself, and others along the same direction.
            if d2 > 1e-12 {
                let slot = &mut sectors[sector(off.dot(&across), off.dot(&up))];
                *slot = slot.min(d2);
            }
        });
        sectors.sort_unstable_by(f64::total_cmp);
        let second = sectors[SECTORS - 2].sqrt();
        if second.is_finite() {
            return Some(second);
        }
        if radius >= WIDEST_GAP_RAD {
            return None;
        }
        radius = (2.0 * radius).min(WIDEST_GAP_RAD);
    }
}

#[cfg(test)]
mod tests {
    use super::{Fan, Rays};
    use crate::geometry::View;
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
        View::bare(points, Point3::origin())
    }

    #[test]
    fn spacing_is_that_between_rings() {
        let rays = Rays::of(Fan::of(&rings()));
        assert!((1.9..2.4).contains(&rays.spacing_rad.to_degrees()));
        assert!((rays.reach_m - 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_direction_between_rings_is_looked_at_from_all_sides_and_one_above_is_not() {
        let rays = Rays::of(Fan::of(&rings()));
        let between = Vector3::new(1.0, 0.0, 1.0_f64.to_radians().tan()).normalize();
        let look = rays.look(&between);
        assert!(look.filled >= 6, "{look:?}");
        let above = Vector3::new(1.0, 0.0, 1.0).normalize();
        assert!(rays.look(&above).nearest.is_none());
        assert!(!rays.surrounds(&above));
    }
}
