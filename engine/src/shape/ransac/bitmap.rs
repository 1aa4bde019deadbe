//! Bitmaps over a surface's own parameters, on which its inliers hang together (Schnabel section
//! 4.4).
//!
//! A plane's are its coordinates, a cylinder's the arc and the height, a sphere's the equal-area
//! map of the octahedron onto a square (Clarberg 2008, "Fast equal-area mapping of the
//! (hemi)sphere using SIMD"). Where a chart is cut open its border pixels stay neighbours.

use super::cloud::Cloud;
use super::constants::MOST_PIXELS;
use super::surface::Surface;
use nalgebra::Vector3;
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, PI, TAU};

/// A surface's parameters and how its chart closes.
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
    pub fn new(surface: &Surface) -> Self {
        let [e1, e2, e3] = surface.frame().map(|v| narrow(&v));
        match surface {
            Surface::Plane { .. } => Self::Plane { axes: [e1, e2] },
            Surface::Cylinder {
                point, radius_m, ..
            } => Self::Cylinder {
                point: narrow(point),
                axes: [e1, e2, e3],
                radius_m: *radius_m as f32,
            },
            Surface::Sphere { centre, radius_m } => Self::Sphere {
                centre: narrow(centre),
                radius_m: *radius_m as f32,
            },
        }
    }

    /// Metres on a plane; turns (0 to 1) and metres on a cylinder; 0 to 1 twice on a sphere.
    #[inline(always)]
    pub fn parameters(&self, p: &Vector3<f32>) -> [f32; 2] {
        match self {
            Self::Plane { axes } => [axes[0].dot(p), axes[1].dot(p)],
            Self::Cylinder { point, axes, .. } => {
                let d = p - point;
                let angle = angle(axes[1].dot(&d), axes[0].dot(&d));
                [angle / TAU + 0.5, axes[2].dot(&d)]
            }
            Self::Sphere { centre, .. } => octahedral(&(p - centre)),
        }
    }
}

/// The pixels of a chart, and which are neighbours.
pub(super) struct Bitmap {
    columns: i32,
    rows: i32,
    closing: Closing,
    /// Parameters of the first pixel's corner, and pixels per unit.
    from: [f32; 2],
    scale: [f32; 2],
}

#[derive(Clone, Copy)]
enum Closing {
    Open,
    Around,
    Octahedron,
}

impl Bitmap {
    /// The bitmap on which all points of `cloud` find a place.
    pub fn holding(chart: &Chart, cloud: &Cloud, cell_m: f32) -> Self {
        // What the cloud's box reaches along an axis: its middle and half its shadow.
        let half = narrow(&cloud.sides_m) / 2.0;
        let middle = Vector3::from(cloud.low) + half;
        let reach = |axis: &Vector3<f32>, from: &Vector3<f32>| {
            let shadow = axis.abs().dot(&half);
            (axis.dot(&(middle - from)) - shadow, 2.0 * shadow)
        };
        let origin = Vector3::zeros();
        let round = |turn_m: f32| (0.0, turn_m);
        let (axes, closing) = match chart {
            Chart::Plane { axes } => (
                [reach(&axes[0], &origin), reach(&axes[1], &origin)],
                Closing::Open,
            ),
            Chart::Cylinder {
                point,
                axes,
                radius_m,
            } => (
                [round(TAU * radius_m), reach(&axes[2], point)],
                Closing::Around,
            ),
            // As a square of the sphere's area.
            Chart::Sphere { radius_m, .. } => (
                [round((2.0 * TAU).sqrt() * radius_m); 2],
                Closing::Octahedron,
            ),
        };
        let [(left, width_m), (top, height_m)] = axes;
        let least = (width_m * height_m / MOST_PIXELS as f32).sqrt();
        let longest = width_m.max(height_m) / MOST_PIXELS as f32;
        let cell_m = cell_m.max(2.0 * least.max(longest)).max(f32::MIN_POSITIVE);
        // Closed charts hold whole pixels, none narrower than asked for.
        let closed = |length_m: f32| {
            let pixels = (length_m / cell_m).floor().max(1.0);
            (pixels, pixels as i32)
        };
        let open = |length_m: f32| (1.0 / cell_m, (length_m / cell_m) as i32 + 1);
        let [(across, columns), (down, rows)] = match closing {
            Closing::Open => [open(width_m), open(height_m)],
            Closing::Around => [closed(width_m), open(height_m)],
            Closing::Octahedron => [closed(width_m), closed(height_m)],
        };
        Self {
            columns,
            rows,
            closing,
            from: [left, top],
            scale: [across, down],
        }
    }

    /// The pixel with these parameters.
    #[inline(always)]
    pub fn holds(&self, [u, v]: [f32; 2]) -> u32 {
        let column = digit((u - self.from[0]) * self.scale[0], self.columns);
        let row = digit((v - self.from[1]) * self.scale[1], self.rows);
        row * self.columns as u32 + column
    }

    fn pixel(&self, column: i32, row: i32) -> Option<usize> {
        let (columns, rows) = (self.columns, self.rows);
        let inside = |v: i32, most: i32| (0..most).contains(&v);
        let (column, row) = match self.closing {
            Closing::Open => (column, row),
            Closing::Around => (column.rem_euclid(columns), row),
            Closing::Octahedron => {
                // The border of the square is folded: each side meets itself, turned about its
                // middle, and all four corners are one pole.
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

    /// Which pixels belong to the patch that holds most of the points; `None` if there is one
    /// patch only.
    pub fn largest(&self, pixels: &[u32]) -> Option<Vec<bool>> {
        let size = (self.columns * self.rows) as usize;
        let mut held = vec![0u32; size];
        for &pixel in pixels {
            held[pixel as usize] += 1;
        }
        let mut patch = vec![0u32; size];
        let (mut patches, mut best) = (0, (0, 0));
        let mut open = Vec::new();
        for &seed in pixels {
            if patch[seed as usize] != 0 {
                continue;
            }
            patches += 1;
            patch[seed as usize] = patches;
            open.push(seed as usize);
            let mut points = 0;
            while let Some(here) = open.pop() {
                points += held[here];
                let (column, row) = (here as i32 % self.columns, here as i32 / self.columns);
                for step in 0..9 {
                    let next = self.pixel(column + step % 3 - 1, row + step / 3 - 1);
                    if let Some(next) = next.filter(|&n| held[n] > 0 && patch[n] == 0) {
                        patch[next] = patches;
                        open.push(next);
                    }
                }
            }
            if points > best.0 {
                best = (points, patches);
            }
            if points as usize == pixels.len() {
                return None;
            }
        }
        Some(patch.into_iter().map(|p| p == best.1).collect())
    }
}

/// The whole part of `v`, within 0 to `count` - 1: rounding at the ends falls into the outermost
/// pixels. A cast would say the same but saturates, for which there is no vector instruction.
#[inline(always)]
fn digit(v: f32, count: i32) -> u32 {
    let v = if v > 0.0 { v } else { 0.0 };
    let last = (count - 1) as f32;
    let v = if v < last { v } else { last };
    // From here on neighbouring numbers differ by one, and MOST_PIXELS is less: the sum is rounded
    // to a whole number, which stands in its low bits.
    const UNIT_STEPS: f32 = (1 << 23) as f32;
    let rounded = v + UNIT_STEPS;
    let up = u32::from(rounded - UNIT_STEPS > v);
    rounded.to_bits() - UNIT_STEPS.to_bits() - up
}

fn narrow(v: &Vector3<f64>) -> Vector3<f32> {
    v.map(|c| c as f32)
}

/// Angle of (x, y) within -pi to pi, to 1e-5 (Abramowitz and Stegun 4.4.49).
#[inline(always)]
fn angle(y: f32, x: f32) -> f32 {
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

/// The direction of `d` on the square 0 to 1, areas in proportion; the middle is +z, the corners
/// are -z.
#[inline(always)]
fn octahedral(d: &Vector3<f32>) -> [f32; 2] {
    let z = d.z / d.norm().max(f32::MIN_POSITIVE);
    let radius = (1.0 - z.abs()).max(0.0).sqrt();
    let v = radius * angle(d.y.abs(), d.x.abs()) * FRAC_2_PI;
    let u = radius - v;
    let (u, v) = if z < 0.0 { (1.0 - v, 1.0 - u) } else { (u, v) };
    [u.copysign(d.x), v.copysign(d.y)].map(|w| w / 2.0 + 0.5)
}

#[cfg(test)]
mod tests {
    use super::{angle, digit, octahedral};
    use crate::shape::ransac::constants::MOST_PIXELS;
    use nalgebra::Vector3;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, UnitSphere};

    #[test]
    fn the_octahedral_map_keeps_areas() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let mut held = [0; 64];
        for _ in 0..64_000 {
            let d = <UnitSphere as Distribution<[f32; 3]>>::sample(&UnitSphere, &mut rng);
            let [u, v] = octahedral(&Vector3::from(d));
            held[((v * 8.0) as usize).min(7) * 8 + ((u * 8.0) as usize).min(7)] += 1;
        }
        assert!(held.iter().all(|n| (850..1150).contains(n)), "{held:?}");
    }

    #[test]
    fn digits_are_what_a_cast_says() {
        let most = MOST_PIXELS as f32;
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
        for count in [1, 2, 100, 65_536, MOST_PIXELS as i32] {
            for &v in &numbers {
                let cast = (v as i32).clamp(0, count - 1) as u32;
                assert_eq!(digit(v, count), cast, "{v} of {count}");
            }
        }
    }

    #[test]
    fn angles_are_those_of_the_library() {
        for i in -400..=400 {
            let wanted = i as f32 * 0.00785;
            let (y, x) = wanted.sin_cos();
            assert!((angle(y * 3.0, x * 3.0) - wanted).abs() < 3e-5, "{wanted}");
        }
        assert!(angle(0.0, 0.0).is_finite());
    }
}
