//! Where an endless surface ends: the extent of its inliers.
//!
//! Strays lie on every endless surface, beyond its end too, where they are few. So a large patch
//! ends where its points become a third as dense; a small one with its outermost points.

use super::cloud::Cloud;
use super::constants::{
    END_DENSITY, EXTENT_GRID, EXTENT_POINTS, LEAST_EXTENT_POINTS, LEAST_WINDOW, RECTANGLE_POINTS,
    SPARSE_SHARE, WINDOW_SHARE,
};
use super::surface::Surface;
use crate::shape::primitive::{Cylinder, Plane, Primitive, Sphere};
use nalgebra::{Matrix3, Point3, Rotation3, Vector2};

/// The part of `surface` that the points of `cloud` at `places` cover, in the caller's frame.
pub(super) fn covered(surface: &Surface, cloud: &Cloud, places: &[u32]) -> Primitive {
    let offset = cloud.origin.coords;
    let stride = places.len().div_ceil(EXTENT_POINTS).max(1);
    let at = places.iter().step_by(stride).map(|&k| cloud.place(k));
    match *surface {
        Surface::Sphere { centre, radius_m } => Primitive::Sphere(Sphere {
            centre: Point3::from(centre + offset),
            radius_m,
        }),
        Surface::Cylinder {
            point,
            axis,
            radius_m,
        } => {
            let (low, high) = dense_span(at.map(|p| (p - point).dot(&axis)).collect());
            let centre = point + axis.as_ref() * f64::midpoint(low, high);
            Primitive::Cylinder(Cylinder {
                centre: Point3::from(centre + offset),
                axis,
                radius_m,
                length_m: high - low,
            })
        }
        Surface::Plane { normal, offset_m } => {
            let [x, y, z] = surface.frame();
            let plane = Plane {
                centre: Point3::from(normal.as_ref() * offset_m),
                rotation: Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, z])),
                sides_m: [0.0; 2],
            };
            let flat: Vec<_> = at.map(|p| Vector2::new(x.dot(&p), y.dot(&p))).collect();
            let plane = turned(&plane, &without_strays(&flat), dense_span);
            Primitive::Plane(Plane {
                centre: plane.centre + offset,
                ..plane
            })
        }
    }
}

/// The smallest of the rectangles around the points, over turns within the plane.
pub(in crate::shape) fn smallest_rectangle(plane: &Plane, points: &[Point3<f64>]) -> Plane {
    let m = plane.rotation.matrix();
    let (x, y) = (m.column(0).into_owned(), m.column(1).into_owned());
    let flat: Vec<Vector2<f64>> = points
        .iter()
        .map(|p| p - plane.centre)
        .map(|d| Vector2::new(d.dot(&x), d.dot(&y)))
        .collect();
    turned(plane, &flat, |values| span(values.iter().copied()))
}

/// The rectangle about `flat` (coordinates in the plane) whose turn makes it smallest; `ends`
/// tells its extents once that is known.
fn turned(plane: &Plane, flat: &[Vector2<f64>], ends: impl Fn(Vec<f64>) -> (f64, f64)) -> Plane {
    let m = plane.rotation.matrix();
    let (x, y) = (m.column(0).into_owned(), m.column(1).into_owned());
    // One in `stride` points decides the turn; all of them the extent.
    let stride = (flat.len() / RECTANGLE_POINTS).max(1);
    let some: Vec<Vector2<f64>> = flat.iter().step_by(stride).copied().collect();
    let area = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for v in &some {
            let at = [v.x * cos + v.y * sin, v.y * cos - v.x * sin];
            for k in 0..2 {
                low[k] = if at[k] < low[k] { at[k] } else { low[k] };
                high[k] = if at[k] > high[k] { at[k] } else { high[k] };
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

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// From where to where `values` lie densely: inwards from each end to the first whose neighbours
/// are a third as dense as the middle, and out again as far as no window is less than a third as
/// dense as the one before it. A surface that slants away thins out step by step; strays begin at
/// once.
fn dense_span(mut values: Vec<f64>) -> (f64, f64) {
    let n = values.len();
    if n < LEAST_EXTENT_POINTS {
        return span(values.into_iter());
    }
    values.sort_unstable_by(f64::total_cmp);
    let (tenth, window) = (n / 10, (n / WINDOW_SHARE).max(LEAST_WINDOW));
    let mean_gap = (values[n - 1 - tenth] - values[tenth]) / (n - 1 - 2 * tenth) as f64;
    let most = window as f64 * mean_gap / END_DENSITY;
    let gap = |k: &usize| values[k + window] - values[*k] <= most;
    let first = (0..n - window).find(gap).unwrap_or(0);
    let last = (0..n - window).rev().find(gap).unwrap_or(n - 1 - window);
    let from = first - thinning(values[..first + window + 1].iter().rev(), window);
    let to = last + window + thinning(values[last..].iter(), window);
    (values[from], values[to])
}

/// How many of `outwards` beyond its first window belong to a surface that thins out.
fn thinning<'a>(outwards: impl Iterator<Item = &'a f64>, window: usize) -> usize {
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

/// Those of many points in a plane that have company: neighbourhoods with a small share of what
/// the median point's holds are left out.
fn without_strays(flat: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    if flat.len() < LEAST_EXTENT_POINTS {
        return flat.to_vec();
    }
    let (left, right) = span(flat.iter().map(|v| v.x));
    let (low, high) = span(flat.iter().map(|v| v.y));
    let grid = EXTENT_GRID as f64;
    let digit = |v: f64, from: f64, to: f64| {
        let share = (v - from) / (to - from).max(f64::MIN_POSITIVE);
        ((share * grid) as usize).min(EXTENT_GRID - 1)
    };
    let cell = |v: &Vector2<f64>| digit(v.y, low, high) * EXTENT_GRID + digit(v.x, left, right);
    let mut held = vec![0u32; EXTENT_GRID * EXTENT_GRID];
    flat.iter().for_each(|v| held[cell(v)] += 1);
    let mut company: Vec<u32> = flat.iter().map(|v| held[cell(v)]).collect();
    let middle = company.len() / 2;
    let (_, median, _) = company.select_nth_unstable(middle);
    let least = f64::from(*median) * SPARSE_SHARE;
    let settled = |v: &&Vector2<f64>| f64::from(held[cell(v)]) >= least;
    flat.iter().filter(settled).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::{dense_span, smallest_rectangle, without_strays};
    use crate::shape::primitive::Plane;
    use nalgebra::{Point3, Rotation3, Vector2, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn strays_beyond_the_ends_do_not_stretch_a_span() {
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
    fn a_surface_that_thins_out_is_seen_to_its_end() {
        // A wall along the line of sight, a twelfth as dense at its far end: density falls as exp(-x).
        let far = 12f64.ln();
        for n in [300, 1100, 2048] {
            let place = |k: usize| -(1.0 - (k as f64 + 0.5) / n as f64 * (1.0 - (-far).exp())).ln();
            let (low, high) = dense_span((0..n).map(place).collect());
            assert!(
                low < 0.01 * far && high > 0.98 * far,
                "{n}: {low} {high} of {far}"
            );
        }
    }

    #[test]
    fn a_turned_rectangle_is_found_under_strays() {
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
        let kept = without_strays(&flat);
        assert!(kept.len() > 3800 && kept.len() < 4100, "{}", kept.len());
        let plane = Plane {
            centre: Point3::origin(),
            rotation: Rotation3::identity(),
            sides_m: [0.0; 2],
        };
        let found = super::turned(&plane, &kept, dense_span);
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
