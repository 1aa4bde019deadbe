//! The extent of a surface's inliers.
//!
//! Foreign points are on the unbounded surface beyond its end too, where they are sparse. So a large patch ends where its
//! points become a third as dense, a small one with its outermost points.

use super::cloud::Cloud;
use super::constants::{
    END_DENSITY, EXTENT_GRID, EXTENT_POINTS, MIN_EXTENT_POINTS, MIN_WINDOW, RECTANGLE_POINTS,
    SPARSE_SHARE, WINDOW_SHARE,
};
use super::surface::UnboundedSurface;
use crate::shape::primitive::{Cylinder, Plane, Primitive, Sphere};
use nalgebra::{Matrix3, Point3, Rotation3, Vector2};

/// The part of `surface` that is covered by the points of `cloud` at `indices`, in the caller's frame.
pub(super) fn bounded_primitive(
    surface: &UnboundedSurface,
    cloud: &Cloud,
    indices: &[u32],
) -> Primitive {
    let offset = cloud.origin.coords;
    let stride = indices.len().div_ceil(EXTENT_POINTS).max(1);
    let positions = indices.iter().step_by(stride).map(|&k| cloud.position(k));
    match *surface {
        UnboundedSurface::Sphere { centre, radius_m } => Primitive::Sphere(Sphere {
            centre: Point3::from(centre + offset),
            radius_m,
        }),
        UnboundedSurface::Cylinder {
            point,
            axis,
            radius_m,
        } => {
            let (low, high) = dense_span(positions.map(|p| (p - point).dot(&axis)).collect());
            let centre = point + axis.as_ref() * f64::midpoint(low, high);
            Primitive::Cylinder(Cylinder {
                centre: Point3::from(centre + offset),
                axis,
                radius_m,
                length_m: high - low,
            })
        }
        UnboundedSurface::Plane { normal, offset_m } => {
            let [x, y, z] = surface.frame();
            let plane = Plane {
                centre: Point3::from(normal.as_ref() * offset_m),
                rotation: Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, z])),
                sides_m: [0.0; 2],
            };
            let flat: Vec<_> = positions
                .map(|p| Vector2::new(x.dot(&p), y.dot(&p)))
                .collect();
            let plane = min_area_rectangle(&plane, &without_sparse_points(&flat), dense_span);
            Primitive::Plane(Plane {
                centre: plane.centre + offset,
                ..plane
            })
        }
    }
}

/// The smallest of the rectangles around the points, over rotations within the plane.
pub(in crate::shape) fn smallest_rectangle(plane: &Plane, points: &[Point3<f64>]) -> Plane {
    let m = plane.rotation.matrix();
    let (x, y) = (m.column(0).into_owned(), m.column(1).into_owned());
    let flat: Vec<Vector2<f64>> = points
        .iter()
        .map(|p| p - plane.centre)
        .map(|d| Vector2::new(d.dot(&x), d.dot(&y)))
        .collect();
    min_area_rectangle(plane, &flat, |values| full_span(values.iter().copied()))
}

/// The rectangle around `flat` (coordinates in the plane) with the rotation that makes it smallest; `ends` gives its extents
/// along an axis.
fn min_area_rectangle(
    plane: &Plane,
    flat: &[Vector2<f64>],
    ends: impl Fn(Vec<f64>) -> (f64, f64),
) -> Plane {
    let m = plane.rotation.matrix();
    let (x, y) = (m.column(0).into_owned(), m.column(1).into_owned());
    // A subsample decides the rotation, all points the extents.
    let stride = (flat.len() / RECTANGLE_POINTS).max(1);
    let subsample: Vec<Vector2<f64>> = flat.iter().step_by(stride).copied().collect();
    let area = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for v in &subsample {
            let rotated = [v.x * cos + v.y * sin, v.y * cos - v.x * sin];
            for k in 0..2 {
                low[k] = if rotated[k] < low[k] {
                    rotated[k]
                } else {
                    low[k]
                };
                high[k] = if rotated[k] > high[k] {
                    rotated[k]
                } else {
                    high[k]
                };
            }
        }
        (high[0] - low[0]) * (high[1] - low[1])
    };
    let angle = (0..90)
        .map(|k| f64::from(k).to_radians())
        .min_by(|a, b| area(*a).total_cmp(&area(*b)))
        .unwrap_or(0.0);
    let (sin, cos) = angle.sin_cos();
    let (a, b) = ends(flat.iter().map(|v| v.x * cos + v.y * sin).collect());
    let (c, d) = ends(flat.iter().map(|v| v.y * cos - v.x * sin).collect());
    let (u, v) = (x * cos + y * sin, y * cos - x * sin);
    let axes = Matrix3::from_columns(&[u, v, plane.normal()]);
    Plane {
        centre: plane.centre + u * f64::midpoint(a, b) + v * f64::midpoint(c, d),
        rotation: Rotation3::from_matrix_unchecked(axes),
        sides_m: [b - a, d - c],
    }
    .longer_first()
}

fn full_span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// The range in which `values` are dense: inwards from each end to the first that is a third as dense as the middle, and
/// outwards again while each window is at least a third as dense as the one before it. An oblique surface thins out
/// gradually; foreign points are sparse at once.
fn dense_span(mut values: Vec<f64>) -> (f64, f64) {
    let n = values.len();
    if n < MIN_EXTENT_POINTS {
        return full_span(values.into_iter());
    }
    values.sort_unstable_by(f64::total_cmp);
    let (tenth, window) = (n / 10, (n / WINDOW_SHARE).max(MIN_WINDOW));
    let mean_gap = (values[n - 1 - tenth] - values[tenth]) / (n - 1 - 2 * tenth) as f64;
    let max_gap = window as f64 * mean_gap / END_DENSITY;
    let is_dense = |k: &usize| values[k + window] - values[*k] <= max_gap;
    let first = (0..n - window).find(is_dense).unwrap_or(0);
    let last = (0..n - window)
        .rev()
        .find(is_dense)
        .unwrap_or(n - 1 - window);
    let from = first - thinned_extent(values[..first + window + 1].iter().rev(), window);
    let to = last + window + thinned_extent(values[last..].iter(), window);
    (values[from], values[to])
}

/// How many of `outwards` beyond the first window belong to a surface that thins out gradually.
fn thinned_extent<'a>(outwards: impl Iterator<Item = &'a f64>, window: usize) -> usize {
    let values: Vec<f64> = outwards.copied().collect();
    let mut end = window;
    loop {
        let next = (end + window).min(values.len() - 1);
        let steps = (next - end) as f64 / window as f64;
        let inner = (values[end] - values[end - window]).abs();
        let outer = (values[next] - values[end]).abs();
        if next == end || outer > inner * steps / END_DENSITY {
            return end - window;
        }
        end = next;
    }
}

/// Without the points of sparse cells: those with less than `SPARSE_SHARE` of the points in the median point's cell. All
/// points if they are few.
fn without_sparse_points(flat: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    if flat.len() < MIN_EXTENT_POINTS {
        return flat.to_vec();
    }
    let (left, right) = full_span(flat.iter().map(|v| v.x));
    let (low, high) = full_span(flat.iter().map(|v| v.y));
    let grid = EXTENT_GRID as f64;
    let cell_index = |v: f64, from: f64, to: f64| {
        let share = (v - from) / (to - from).max(f64::MIN_POSITIVE);
        ((share * grid) as usize).min(EXTENT_GRID - 1)
    };
    let cell =
        |v: &Vector2<f64>| cell_index(v.y, low, high) * EXTENT_GRID + cell_index(v.x, left, right);
    let mut counts = vec![0u32; EXTENT_GRID * EXTENT_GRID];
    flat.iter().for_each(|v| counts[cell(v)] += 1);
    let mut neighbours: Vec<u32> = flat.iter().map(|v| counts[cell(v)]).collect();
    let middle = neighbours.len() / 2;
    let (_, median, _) = neighbours.select_nth_unstable(middle);
    let least = f64::from(*median) * SPARSE_SHARE;
    let is_dense = |v: &&Vector2<f64>| f64::from(counts[cell(v)]) >= least;
    flat.iter().filter(is_dense).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::{dense_span, smallest_rectangle, without_sparse_points};
    use crate::shape::primitive::Plane;
    use nalgebra::{Point3, Rotation3, Vector2, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn sparse_points_beyond_the_ends_do_not_stretch_a_span() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for n in [300, 4000] {
            let mut values: Vec<f64> = (0..n).map(|_| rng.random_range(-1.0..1.0)).collect();
            values.extend((0..n / 20).map(|_| rng.random_range(-2.0..2.0)));
            let (low, high) = dense_span(values);
            let tolerance = if n < 1000 { 0.15 } else { 0.05 };
            assert!(
                (low + 1.0).abs() < tolerance && (high - 1.0).abs() < tolerance,
                "{low} {high}"
            );
        }
        assert_eq!(dense_span(vec![3.0, -1.0, 7.0]), (-1.0, 7.0));
        assert_eq!(dense_span(vec![]), (0.0, 0.0));
        assert_eq!(dense_span(vec![2.0; 500]), (2.0, 2.0));
    }

    #[test]
    fn a_surface_that_thins_out_is_measured_to_its_end() {
        // A wall along the line of sight, a twelfth as dense at its far end: density falls as exp(-x).
        let far = 12f64.ln();
        for n in [300, 1100, 2048] {
            let position =
                |k: usize| -(1.0 - (k as f64 + 0.5) / n as f64 * (1.0 - (-far).exp())).ln();
            let (low, high) = dense_span((0..n).map(position).collect());
            assert!(
                low < 0.01 * far && high > 0.98 * far,
                "{n}: {low} {high} of {far}"
            );
        }
    }

    #[test]
    fn a_rotated_rectangle_is_found_among_sparse_points() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut any = |half: f64| rng.random_range(-half..half);
        let turn = 0.4f64;
        let mut flat: Vec<_> = (0..4000)
            .map(|_| Vector2::new(any(1.0), any(0.5)))
            .map(|v| {
                Vector2::new(
                    v.x * turn.cos() - v.y * turn.sin(),
                    v.x * turn.sin() + v.y * turn.cos(),
                )
            })
            .collect();
        flat.extend((0..200).map(|_| Vector2::new(any(2.0), any(2.0))));
        let kept = without_sparse_points(&flat);
        assert!(kept.len() > 3800 && kept.len() < 4100, "{}", kept.len());
        let plane = Plane {
            centre: Point3::origin(),
            rotation: Rotation3::identity(),
            sides_m: [0.0; 2],
        };
        let found = super::min_area_rectangle(&plane, &kept, dense_span);
        assert!((found.sides_m[0] - 2.0).abs() < 0.06, "{found:?}");
        assert!((found.sides_m[1] - 1.0).abs() < 0.06, "{found:?}");
    }

    #[test]
    fn few_points_give_the_rectangle_around_them_all() {
        let plane = Plane {
            centre: Point3::new(1.0, 1.0, 2.0),
            rotation: Rotation3::identity(),
            sides_m: [0.0; 2],
        };
        let corners = [(0.0, 0.0), (3.0, 0.0), (0.0, 1.0), (3.0, 1.0)];
        let points = corners.map(|(x, y)| Point3::new(x, y, 2.0));
        let found = smallest_rectangle(&plane, &points);
        assert!((found.centre - Point3::new(1.5, 0.5, 2.0)).norm() < 1e-12);
        assert!((Vector2::from(found.sides_m) - Vector2::new(3.0, 1.0)).norm() < 1e-12);
        assert!((found.normal() - Vector3::z()).norm() < 1e-12);
    }
}
