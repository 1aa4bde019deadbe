//! The rays of a view: directions, ranges, row spacing and relative noise.

use super::constants::{
    DEFAULT_SPACING_RAD, MAX_NEIGHBOUR_GAP_RAD, NOISE_SPACINGS, REACH_SHARE, SECTORS,
    SPACING_BOUNDS_RAD, SPACING_SAMPLES,
};
use super::direction_index::DirectionIndex;
use super::sectors::{sector_of, tangents};
use super::{View, range_noise};
use nalgebra::{Point3, Vector3};

/// The rays of a view, not yet indexed. Ray `i` is point `i`; the rays after the points are the directions without a
/// return.
#[derive(Debug, Clone)]
pub(crate) struct RaySet {
    pub(super) origin: Point3<f64>,
    /// Unit vectors; zero for a point at the origin.
    pub(super) directions: Vec<Vector3<f64>>,
    /// Infinite where nothing came back.
    pub(super) ranges_m: Vec<f64>,
    /// Row spacing, radians: typical distance to the next ray in the sparse direction of the pattern (between scan lines).
    pub(crate) spacing_rad: f64,
    /// Median of the finite ranges, metres.
    pub(crate) median_range_m: f64,
    /// Rough standard deviation of ranges as a share of the range, estimated from neighbouring rays.
    pub(crate) relative_noise: f64,
    pub(super) reach_m: f64,
    pub(super) free_range_m: f64,
}

impl RaySet {
    /// Directions and ranges of `view`. Points at the origin itself have no direction and are never found.
    pub(crate) fn from_view(view: &View) -> Self {
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
        // First guess: the rays are spread evenly over a third of the sphere.
        let even_rad = (4.0 / (directions.len() as f64).max(1.0)).sqrt();
        let index = DirectionIndex::new(&directions, even_rad);
        let spacing_rad = row_spacing_rad(&index, &directions, even_rad);
        Self {
            origin: view.origin,
            relative_noise: range_noise::relative_noise(
                &index,
                &directions,
                &ranges_m,
                NOISE_SPACINGS * spacing_rad,
            ),
            spacing_rad,
            median_range_m: quantile(&mut sorted, 0.5),
            reach_m: quantile(&mut sorted, REACH_SHARE),
            free_range_m: view.free_range_m,
            directions,
            ranges_m,
        }
    }
}

/// The value below which the share `at` of `values` lies; 0 without any. Reorders `values`.
fn quantile(values: &mut [f64], at: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let index = ((values.len() as f64 * at) as usize).min(values.len() - 1);
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

/// Median over a sample of rays of the spacing around each. `even_rad` is a first guess.
fn row_spacing_rad(index: &DirectionIndex, directions: &[Vector3<f64>], even_rad: f64) -> f64 {
    let step = (directions.len() / SPACING_SAMPLES).max(1);
    let mut spacings_rad: Vec<f64> = directions
        .iter()
        .step_by(step)
        .filter(|d| d.norm_squared() > 0.25)
        .filter_map(|d| spacing_around_rad(index, d, even_rad))
        .collect();
    spacings_rad.sort_unstable_by(f64::total_cmp);
    spacings_rad
        .get(spacings_rad.len() / 2)
        .copied()
        .unwrap_or(DEFAULT_SPACING_RAD)
        .clamp(SPACING_BOUNDS_RAD.0, SPACING_BOUNDS_RAD.1)
}

/// The second largest distance to the nearest ray of a sector around the ray `d`; `None` at the edge of a view.
fn spacing_around_rad(index: &DirectionIndex, d: &Vector3<f64>, even_rad: f64) -> Option<f64> {
    let (across, up) = tangents(d);
    let mut radius = 3.0 * even_rad;
    loop {
        let mut sectors = [f64::INFINITY; SECTORS];
        index.for_each_within(d, radius, |_, off| {
            let d2 = off.norm_squared();
            // Not the ray itself, nor others along the same direction.
            if d2 > 1e-12 {
                let slot = &mut sectors[sector_of(off.dot(&across), off.dot(&up))];
                *slot = slot.min(d2);
            }
        });
        sectors.sort_unstable_by(f64::total_cmp);
        let second = sectors[SECTORS - 2].sqrt();
        if second.is_finite() {
            return Some(second);
        }
        if radius >= MAX_NEIGHBOUR_GAP_RAD {
            return None;
        }
        radius = (2.0 * radius).min(MAX_NEIGHBOUR_GAP_RAD);
    }
}
