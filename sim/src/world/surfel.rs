//! A recorded cloud as surfels: every point becomes a small disc that stops rays.

use super::bvh::{Aabb, Bvh};
use super::constants::{
    SURFEL_CELL_M, SURFEL_LINE_RATIO, SURFEL_NEIGHBOURS, SURFEL_RADIUS_M, SURFEL_REACH_NEIGHBOUR,
};
use super::ray_box::RangeAndCosine;
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use rayon::prelude::*;
use std::collections::HashSet;

#[derive(Debug, Clone, PartialEq)]
struct Surfel {
    centre: Point3<f64>,
    /// Unit normal, of either sign.
    normal: Vector3<f64>,
    radius: f64,
}

/// The surfels of one cloud, indexed for ray casting.
#[derive(Debug, Clone, Default)]
pub(crate) struct Surfels {
    discs: Vec<Surfel>,
    tree: Bvh,
}

impl Surfels {
    /// Surfels of `points` (non-finite ones are left out) recorded from `origin`. The cloud is thinned first; normals
    /// come from the principal axes of the nearest neighbours, radii from their distance.
    pub(crate) fn from_points(points: &[Point3<f64>], origin: &Point3<f64>) -> Self {
        let mut occupied = HashSet::new();
        let cell = |c: f64| (c / SURFEL_CELL_M).floor() as i64;
        let thinned: Vec<Point3<f64>> = points
            .iter()
            .filter(|p| p.iter().all(|c| c.is_finite()))
            .filter(|p| occupied.insert([cell(p.x), cell(p.y), cell(p.z)]))
            .copied()
            .collect();
        let boxes: Vec<Aabb> = thinned.iter().map(|p| Aabb { low: *p, high: *p }).collect();
        let neighbours = Bvh::build(&boxes);
        let discs: Vec<Surfel> = thinned
            .par_iter()
            .map(|p| surfel(p, &thinned, &neighbours, origin))
            .collect();
        let boxes: Vec<Aabb> = discs.iter().map(Surfel::bounds).collect();
        Self {
            tree: Bvh::build(&boxes),
            discs,
        }
    }

    /// The nearest hit within `limit` metres.
    pub(crate) fn hit(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        limit: f64,
    ) -> Option<RangeAndCosine> {
        let (mut limit, mut best) = (limit, None);
        self.tree
            .visit_along_ray(origin, direction, &mut limit, |i, limit| {
                if let Some(hit) = self.discs.get(i).and_then(|s| s.hit(origin, direction))
                    && hit.0 < *limit
                {
                    *limit = hit.0;
                    best = Some(hit);
                }
            });
        best
    }
}

impl Surfel {
    fn hit(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<RangeAndCosine> {
        let cosine = self.normal.dot(direction);
        let range = self.normal.dot(&(self.centre - origin)) / cosine;
        let inside =
            (origin + direction * range - self.centre).norm_squared() <= self.radius.powi(2);
        (range.is_finite() && range > 0.0 && inside).then_some((range, cosine.abs()))
    }

    fn bounds(&self) -> Aabb {
        let reach = self
            .normal
            .map(|n| self.radius * (1.0 - n * n).max(0.0).sqrt());
        Aabb {
            low: self.centre - reach,
            high: self.centre + reach,
        }
    }
}

/// The up to `SURFEL_NEIGHBOURS` points nearest to `point` (itself included) with squared distances, nearest first.
fn neighbours(point: &Point3<f64>, points: &[Point3<f64>], tree: &Bvh) -> Vec<(f64, usize)> {
    let mut found: Vec<(f64, usize)> = Vec::with_capacity(SURFEL_NEIGHBOURS + 1);
    let mut limit = f64::INFINITY;
    tree.visit_near_point(point, &mut limit, |i, limit| {
        let Some(other) = points.get(i) else { return };
        let entry = ((other - point).norm_squared(), i);
        if entry.0 > *limit {
            return;
        }
        let index = found.partition_point(|e| (e.0, e.1) < entry);
        found.insert(index, entry);
        found.truncate(SURFEL_NEIGHBOURS);
        if let (SURFEL_NEIGHBOURS, Some(last)) = (found.len(), found.last()) {
            *limit = last.0;
        }
    });
    found
}

fn surfel(point: &Point3<f64>, points: &[Point3<f64>], tree: &Bvh, origin: &Point3<f64>) -> Surfel {
    let found = neighbours(point, points, tree);
    let near = || found.iter().filter_map(|(_, i)| points.get(*i));
    let mean = near().map(|p| p.coords).sum::<Vector3<f64>>() / found.len().max(1) as f64;
    let scatter: Matrix3<f64> = near()
        .map(|p| (p.coords - mean) * (p.coords - mean).transpose())
        .sum();
    let eigen = SymmetricEigen::new(scatter);
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let [smallest, middle, largest] = axes;
    let to_sensor = (origin - point)
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::z);
    let along: Vector3<f64> = eigen.eigenvectors.column(largest).into();
    let flat = eigen.eigenvalues[middle] > SURFEL_LINE_RATIO * eigen.eigenvalues[largest];
    let normal = if flat {
        eigen.eigenvectors.column(smallest).into()
    } else {
        // All neighbours lie on one scan line: face the sensor as far as the line allows.
        (to_sensor - along * along.dot(&to_sensor))
            .try_normalize(1e-6)
            .unwrap_or(to_sensor)
    };
    let reach = found.get(SURFEL_REACH_NEIGHBOUR).or(found.last());
    Surfel {
        centre: *point,
        normal,
        radius: reach
            .map_or(0.0, |(d2, _)| d2.sqrt())
            .clamp(SURFEL_RADIUS_M.0, SURFEL_RADIUS_M.1),
    }
}

#[cfg(test)]
mod tests {
    use super::Surfels;
    use nalgebra::{Point3, Vector3};
    use std::f64::consts::{PI, TAU};

    #[test]
    fn a_sampled_wall_and_sphere_stop_rays_where_they_are() {
        // A wall at x = 3 and in front of it a sphere of radius 0.4 about (2, 0, 0), sampled every 3 cm.
        let mut points = Vec::new();
        for i in -60..=60 {
            for j in -60..=60 {
                points.push(Point3::new(3.0, f64::from(i) * 0.03, f64::from(j) * 0.03));
            }
        }
        for i in 0..40 {
            for j in 0..80 {
                let (t, p) = (PI * f64::from(i) / 40.0, TAU * f64::from(j) / 80.0);
                points.push(Point3::new(
                    2.0 + 0.4 * t.sin() * p.cos(),
                    0.4 * t.sin() * p.sin(),
                    0.4 * t.cos(),
                ));
            }
        }
        points.push(Point3::new(f64::NAN, 0.0, 0.0));
        let surfels = Surfels::from_points(&points, &Point3::origin());
        for i in -40..=40 {
            for j in -40..=40 {
                let direction =
                    Vector3::new(1.0, f64::from(i) * 0.01, f64::from(j) * 0.01).normalize();
                let (range, _) = surfels
                    .hit(&Point3::origin(), &direction, 10.0)
                    .expect("a closed wall");
                let b = 2.0 * direction.x;
                let ball = b * b - (4.0 - 0.16);
                let wall = 3.0 / direction.x;
                let miss = (4.0 - b * b).sqrt();
                if ball > 0.02 {
                    assert!(
                        (range - (b - ball.sqrt())).abs() < 0.02,
                        "ball {i} {j}: {range}"
                    );
                } else if miss > 0.45 {
                    assert!((range - wall).abs() < 1e-6, "wall {i} {j}: {range}");
                }
            }
        }
        assert_eq!(surfels.hit(&Point3::origin(), &Vector3::x(), 1.0), None);
        assert_eq!(surfels.hit(&Point3::origin(), &-Vector3::x(), 10.0), None);
    }

    #[test]
    fn no_points_give_no_surfels() {
        let none = Surfels::from_points(&[], &Point3::origin());
        assert_eq!(none.hit(&Point3::origin(), &Vector3::x(), 10.0), None);
    }
}
