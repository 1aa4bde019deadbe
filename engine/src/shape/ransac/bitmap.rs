//! Connectivity of a surface's inliers by a bitmap over its parameters (Schnabel section 4.4).
//!
//! The parameters of a plane are its coordinates, of a cylinder the arc and the height, of a sphere the equal-area map of
//! the octahedron onto a square (Clarberg 2008, "Fast equal-area mapping of the (hemi)sphere using SIMD"). Where a chart is
//! cut open, its border pixels remain neighbours.

use super::cloud::Cloud;
use super::constants::MAX_PIXELS;
use super::surface::UnboundedSurface;
use nalgebra::Vector3;
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, PI, TAU};

/// Maps points of a surface to its two parameters.
#[derive(Clone, Copy)]
pub(super) enum Chart {
    Plane {
        axes: [Vector3<f32>; 2],
    },
    Cylinder {
        point: Vector3<f32>,
        axes: [Vector3<f32>; 3],
        radius_m: f32,
    },
    Sphere {
        centre: Vector3<f32>,
        radius_m: f32,
    },
}

impl Chart {
    pub(super) fn new(surface: &UnboundedSurface) -> Self {
        let [e1, e2, e3] = surface.frame().map(|v| narrow(&v));
        match surface {
            UnboundedSurface::Plane { .. } => Self::Plane { axes: [e1, e2] },
            UnboundedSurface::Cylinder {
                point, radius_m, ..
            } => Self::Cylinder {
                point: narrow(point),
                axes: [e1, e2, e3],
                radius_m: *radius_m as f32,
            },
            UnboundedSurface::Sphere { centre, radius_m } => Self::Sphere {
                centre: narrow(centre),
                radius_m: *radius_m as f32,
            },
        }
    }

    /// Metres on a plane; revolutions (0 to 1) and metres on a cylinder; 0 to 1 twice on a sphere.
    #[inline(always)]
    pub(super) fn parameters(&self, p: &Vector3<f32>) -> [f32; 2] {
        match self {
            Self::Plane { axes } => [axes[0].dot(p), axes[1].dot(p)],
            Self::Cylinder { point, axes, .. } => {
                let d = p - point;
                let angle = fast_atan2(axes[1].dot(&d), axes[0].dot(&d));
                [angle / TAU + 0.5, axes[2].dot(&d)]
            }
            Self::Sphere { centre, .. } => octahedral_map(&(p - centre)),
        }
    }
}

/// The pixels of a chart.
pub(super) struct Bitmap {
    columns: i32,
    rows: i32,
    topology: ChartTopology,
    /// Parameters of the first pixel's corner.
    from: [f32; 2],
    /// Pixels per unit.
    scale: [f32; 2],
}

/// Which borders of a chart meet.
#[derive(Clone, Copy)]
enum ChartTopology {
    Open,
    Cylindrical,
    Octahedral,
}

impl Bitmap {
    /// A bitmap for all points of `cloud`.
    pub(super) fn covering(chart: &Chart, cloud: &Cloud, cell_m: f32) -> Self {
        // Start and length of the cloud's box along an axis.
        let half = narrow(&cloud.sides_m) / 2.0;
        let middle = Vector3::from(cloud.low) + half;
        let extent = |axis: &Vector3<f32>, from: &Vector3<f32>| {
            let half_extent = axis.abs().dot(&half);
            (axis.dot(&(middle - from)) - half_extent, 2.0 * half_extent)
        };
        let origin = Vector3::zeros();
        let from_zero = |length_m: f32| (0.0, length_m);
        let (axes, topology) = match chart {
            Chart::Plane { axes } => (
                [extent(&axes[0], &origin), extent(&axes[1], &origin)],
                ChartTopology::Open,
            ),
            Chart::Cylinder {
                point,
                axes,
                radius_m,
            } => (
                [from_zero(TAU * radius_m), extent(&axes[2], point)],
                ChartTopology::Cylindrical,
            ),
            // A square of the sphere's area.
            Chart::Sphere { radius_m, .. } => (
                [from_zero((2.0 * TAU).sqrt() * radius_m); 2],
                ChartTopology::Octahedral,
            ),
        };
        let [(left, width_m), (top, height_m)] = axes;
        let least = (width_m * height_m / MAX_PIXELS as f32).sqrt();
        let longest = width_m.max(height_m) / MAX_PIXELS as f32;
        let cell_m = cell_m.max(2.0 * least.max(longest)).max(f32::MIN_POSITIVE);
        // Closed charts have a whole number of pixels, none narrower than `cell_m`.
        let whole_pixels = |length_m: f32| {
            let pixels = (length_m / cell_m).floor().max(1.0);
            (pixels, pixels as i32)
        };
        let open = |length_m: f32| (1.0 / cell_m, (length_m / cell_m) as i32 + 1);
        let [(across, columns), (down, rows)] = match topology {
            ChartTopology::Open => [open(width_m), open(height_m)],
            ChartTopology::Cylindrical => [whole_pixels(width_m), open(height_m)],
            ChartTopology::Octahedral => [whole_pixels(width_m), whole_pixels(height_m)],
        };
        Self {
            columns,
            rows,
            topology,
            from: [left, top],
            scale: [across, down],
        }
    }

    /// The pixel with these parameters.
    #[inline(always)]
    pub(super) fn pixel_of(&self, [u, v]: [f32; 2]) -> u32 {
        let column = floor_index((u - self.from[0]) * self.scale[0], self.columns);
        let row = floor_index((v - self.from[1]) * self.scale[1], self.rows);
        row * self.columns as u32 + column
    }

    /// Index of the pixel at this column and row, which may be one beyond the border.
    fn neighbour(&self, column: i32, row: i32) -> Option<usize> {
        let (columns, rows) = (self.columns, self.rows);
        let inside = |v: i32, most: i32| (0..most).contains(&v);
        let (column, row) = match self.topology {
            ChartTopology::Open => (column, row),
            ChartTopology::Cylindrical => (column.rem_euclid(columns), row),
            ChartTopology::Octahedral => {
                // Each side of the square meets itself, mirrored about its middle, and all four corners are one pole.
                let (column, row) = if inside(column, columns) {
                    (column, row)
                } else {
                    (column.clamp(0, columns - 1), rows - 1 - row)
                };
                if inside(row, rows) {
                    (column, row)
                } else {
                    (columns - 1 - column, row.clamp(0, rows - 1))
                }
            }
        };
        let within = inside(column, columns) && inside(row, rows);
        within.then_some((row * columns + column) as usize)
    }

    /// Which pixels belong to the connected component with the most points; `None` if there is only one.
    pub(super) fn largest_component(&self, pixels: &[u32]) -> Option<Vec<bool>> {
        let size = (self.columns * self.rows) as usize;
        let mut counts = vec![0u32; size];
        for &pixel in pixels {
            counts[pixel as usize] += 1;
        }
        let mut labels = vec![0u32; size];
        let (mut components, mut best) = (0, (0, 0));
        let mut stack = Vec::new();
        for &seed in pixels {
            if labels[seed as usize] != 0 {
                continue;
            }
            components += 1;
            labels[seed as usize] = components;
            stack.push(seed as usize);
            let mut points = 0;
            while let Some(here) = stack.pop() {
                points += counts[here];
                let (column, row) = (here as i32 % self.columns, here as i32 / self.columns);
                for step in 0..9 {
                    let next = self.neighbour(column + step % 3 - 1, row + step / 3 - 1);
                    if let Some(next) = next.filter(|&n| counts[n] > 0 && labels[n] == 0) {
                        labels[next] = components;
                        stack.push(next);
                    }
                }
            }
            if points > best.0 {
                best = (points, components);
            }
            if points as usize == pixels.len() {
                return None;
            }
        }
        Some(labels.into_iter().map(|p| p == best.1).collect())
    }
}

/// The floor of `v`, clamped to 0 to `count` - 1. A cast would give the same, but its saturation has no vector instruction.
#[inline(always)]
fn floor_index(v: f32, count: i32) -> u32 {
    let v = if v > 0.0 { v } else { 0.0 };
    let last = (count - 1) as f32;
    let v = if v < last { v } else { last };
    // From 2^23 on neighbouring f32 differ by one, and MAX_PIXELS is less: the sum is rounded to a whole number, which is in
    // its low bits.
    const UNIT_STEPS: f32 = (1 << 23) as f32;
    let rounded = v + UNIT_STEPS;
    let up = u32::from(rounded - UNIT_STEPS > v);
    rounded.to_bits() - UNIT_STEPS.to_bits() - up
}

fn narrow(v: &Vector3<f64>) -> Vector3<f32> {
    v.map(|c| c as f32)
}

/// atan2 to 1e-5 (Abramowitz and Stegun 4.4.49).
#[inline(always)]
fn fast_atan2(y: f32, x: f32) -> f32 {
    let (small, large) = (x.abs().min(y.abs()), x.abs().max(y.abs()));
    let t = small / large.max(f32::MIN_POSITIVE);
    let s = t * t;
    let odd = 0.999_866 + s * (-0.330_299_5 + s * (0.180_141 + s * (-0.085_133 + s * 0.020_835_1)));
    let octant = t * odd;
    let quadrant = if y.abs() > x.abs() {
        FRAC_PI_2 - octant
    } else {
        octant
    };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    half.copysign(y)
}

/// Equal-area map of the direction of `d` onto the unit square: its middle is +z, its corners are -z.
#[inline(always)]
fn octahedral_map(d: &Vector3<f32>) -> [f32; 2] {
    let z = d.z / d.norm().max(f32::MIN_POSITIVE);
    let radius = (1.0 - z.abs()).max(0.0).sqrt();
    let v = radius * fast_atan2(d.y.abs(), d.x.abs()) * FRAC_2_PI;
    let u = radius - v;
    let (u, v) = if z < 0.0 { (1.0 - v, 1.0 - u) } else { (u, v) };
    [u.copysign(d.x), v.copysign(d.y)].map(|w| w / 2.0 + 0.5)
}

#[cfg(test)]
mod tests {
    use super::{fast_atan2, floor_index, octahedral_map};
    use crate::shape::ransac::constants::MAX_PIXELS;
    use nalgebra::Vector3;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, UnitSphere};

    #[test]
    fn the_octahedral_map_keeps_areas() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let mut counts = [0; 64];
        for _ in 0..64_000 {
            let d = <UnitSphere as Distribution<[f32; 3]>>::sample(&UnitSphere, &mut rng);
            let [u, v] = octahedral_map(&Vector3::from(d));
            counts[((v * 8.0) as usize).min(7) * 8 + ((u * 8.0) as usize).min(7)] += 1;
        }
        assert!(counts.iter().all(|n| (850..1150).contains(n)), "{counts:?}");
    }

    #[test]
    fn floor_indices_agree_with_a_cast() {
        let most = MAX_PIXELS as f32;
        let mut numbers = vec![0.0, -0.0, -1.0, 0.5, 1.5, 2.5, most, 1e20, -1e20, f32::NAN];
        numbers.extend([f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE]);
        for whole in [
            1.0f32,
            2.0,
            3.0,
            100.0,
            65_536.0,
            most - 2.0,
            most - 1.0,
            most,
        ] {
            numbers.extend([whole.next_down(), whole, whole.next_up(), whole - 0.5]);
        }
        for count in [1, 2, 100, 65_536, MAX_PIXELS as i32] {
            for &v in &numbers {
                let cast = (v as i32).clamp(0, count - 1) as u32;
                assert_eq!(floor_index(v, count), cast, "{v} of {count}");
            }
        }
    }

    #[test]
    fn angles_agree_with_the_standard_library() {
        for i in -400..=400 {
            let wanted = i as f32 * 0.00785;
            let (y, x) = wanted.sin_cos();
            assert!(
                (fast_atan2(y * 3.0, x * 3.0) - wanted).abs() < 3e-5,
                "{wanted}"
            );
        }
        assert!(fast_atan2(0.0, 0.0).is_finite());
    }
}
