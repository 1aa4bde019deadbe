//! Connectivity (Schnabel section 4.4): the largest connected patch of a surface's inliers, on a
//! bitmap over the surface's own parameters.
//!
//! A plane's are its coordinates, a cylinder's the arc and the height, a sphere's the equal-area
//! map of the octahedron onto a square (Clarberg 2008, "Fast equal-area mapping of the
//! (hemi)sphere using SIMD"). Where a chart is cut open its border pixels stay neighbours.

use super::cloud::Cloud;
use super::constants::MOST_PIXELS;
use super::score::LANES;
use super::surface::Surface;
use crate::mixture::instructions::{Instructions, Loops};
use nalgebra::Vector3;
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, PI, TAU};

/// Those of `places` (in `cloud`, near `surface`) in the largest patch connected through
/// neighbouring pixels `cell_m` wide, in their order; of equal patches that of the first point.
pub(super) fn largest_patch(
    instructions: Instructions,
    surface: &Surface,
    cloud: &Cloud,
    places: &[u32],
    cell_m: f64,
) -> Vec<u32> {
    if places.is_empty() {
        return Vec::new();
    }
    let chart = Chart::new(surface);
    let bitmap = Bitmap::holding(&chart, cloud, cell_m as f32);
    let pixels = instructions.run(Charted {
        chart: &chart,
        bitmap: &bitmap,
        cloud,
        places,
    });
    let Some(label) = bitmap.largest(&pixels) else {
        return places.to_vec();
    };
    let own = |pixel: &u32| label.get(*pixel as usize).copied().unwrap_or(false);
    let kept = places.iter().zip(&pixels).filter(|(_, pixel)| own(pixel));
    kept.map(|(&k, _)| k).collect()
}

/// A surface's parameters and how its chart closes.
enum Chart {
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
    fn new(surface: &Surface) -> Self {
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
    fn parameters(&self, p: &Vector3<f32>) -> [f32; 2] {
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

/// Points on their way to their pixels, a register of them at a time.
struct Charted<'a> {
    chart: &'a Chart,
    bitmap: &'a Bitmap,
    cloud: &'a Cloud,
    places: &'a [u32],
}

impl Loops for Charted<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<const FUSED: bool, const WIDTH: usize>(self) -> Self::Output {
        // One loop per class, so that no lane asks which it is.
        match self.chart {
            Chart::Plane { .. } => self.each(),
            Chart::Cylinder { .. } => self.each(),
            Chart::Sphere { .. } => self.each(),
        }
    }
}

impl Charted<'_> {
    #[inline(always)]
    fn each(&self) -> Vec<u32> {
        let mut pixels = Vec::with_capacity(self.places.len() + LANES);
        for places in self.places.chunks(LANES) {
            let mut at = [[0.0; LANES]; 3];
            for (k, &place) in places.iter().enumerate() {
                let p = self.cloud.narrow_place(place);
                (at[0][k], at[1][k], at[2][k]) = (p.x, p.y, p.z);
            }
            let mut some = [0; LANES];
            for k in 0..LANES {
                let p = Vector3::new(at[0][k], at[1][k], at[2][k]);
                some[k] = self.bitmap.holds(self.chart.parameters(&p));
            }
            pixels.extend_from_slice(&some);
        }
        pixels.truncate(self.places.len());
        pixels
    }
}

/// The pixels of a chart, and which are neighbours.
struct Bitmap {
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
    fn holding(chart: &Chart, cloud: &Cloud, cell_m: f32) -> Self {
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
    fn holds(&self, [u, v]: [f32; 2]) -> u32 {
        // Rounding at the ends falls into the outermost pixels.
        let digit = |v: f32, most: i32| (v as i32).clamp(0, most - 1);
        let column = digit((u - self.from[0]) * self.scale[0], self.columns);
        let row = digit((v - self.from[1]) * self.scale[1], self.rows);
        (row * self.columns + column) as u32
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
    fn largest(&self, pixels: &[u32]) -> Option<Vec<bool>> {
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
    use super::{angle, largest_patch, octahedral};
    use crate::mixture::Instructions;
    use crate::shape::ransac::cloud::Cloud;
    use crate::shape::ransac::surface::Surface;
    use nalgebra::{Point3, Unit, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, UnitSphere};

    /// The cloud keeps its own middle: surfaces below are given in the world and moved there.
    fn patch(surface: &Surface, points: &[Vector3<f64>], cell_m: f64) -> Vec<u32> {
        let points: Vec<_> = points.iter().map(|p| Point3::from(*p)).collect();
        let cloud = Cloud::of(&points, &vec![Vector3::z(); points.len()]);
        let shift = cloud.origin.coords;
        let moved = match *surface {
            Surface::Plane { normal, offset_m } => Surface::Plane {
                normal,
                offset_m: offset_m - normal.dot(&shift),
            },
            Surface::Sphere { centre, radius_m } => Surface::Sphere {
                centre: centre - shift,
                radius_m,
            },
            Surface::Cylinder {
                point,
                axis,
                radius_m,
            } => Surface::Cylinder {
                point: point - shift,
                axis,
                radius_m,
            },
        };
        let all: Vec<u32> = (0..points.len() as u32).collect();
        largest_patch(Instructions::best(), &moved, &cloud, &all, cell_m)
    }

    fn flat() -> Surface {
        Surface::Plane {
            normal: Vector3::z_axis(),
            offset_m: -1.0,
        }
    }

    #[test]
    fn a_gap_parts_patches_of_a_plane() {
        let points: Vec<_> = (0..30)
            .map(|i| f64::from(i) * 0.1 + if i < 10 { 0.0 } else { 5.0 })
            .map(|x| Vector3::new(x, 0.0, -1.0))
            .collect();
        assert_eq!(
            patch(&flat(), &points, 0.15),
            (10..30).collect::<Vec<u32>>()
        );
        assert!(patch(&flat(), &[], 0.15).is_empty());
        assert_eq!(patch(&flat(), &points[..1], 0.15), [0]);
        assert_eq!(patch(&flat(), &points[..10], 0.15).len(), 10);
    }

    #[test]
    fn cells_too_fine_for_memory_grow() {
        let points = [0.0, 1e-5, 500.0].map(|x| Vector3::new(x, 2.0 * x, -1.0));
        assert_eq!(patch(&flat(), &points, 1e-6), [0, 1]);
    }

    #[test]
    fn a_cylinders_seam_is_no_gap() {
        let axis = Unit::new_normalize(Vector3::new(0.3, -0.2, 1.0));
        let e1 = crate::shape::primitive::perpendicular(&axis).into_inner();
        let e2 = axis.cross(&e1);
        let surface = Surface::Cylinder {
            point: Vector3::new(1.0, 2.0, 3.0),
            axis,
            radius_m: 0.5,
        };
        let on = |angle: f64, height: f64| {
            Vector3::new(1.0, 2.0, 3.0)
                + (e1 * angle.cos() + e2 * angle.sin()) * 0.5
                + axis.as_ref() * height
        };
        // Arcs of 2 rad about every direction, and a stray point opposite.
        for turn in 0..16 {
            let middle = f64::from(turn) * std::f64::consts::TAU / 16.0;
            let mut points: Vec<_> = (0..41)
                .map(|i| on(middle + f64::from(i - 20) * 0.05, f64::from(i % 3) * 0.02))
                .collect();
            points.push(on(middle + std::f64::consts::PI, 0.0));
            assert_eq!(
                patch(&surface, &points, 0.04),
                (0..41).collect::<Vec<u32>>()
            );
        }
        // Rings that stand apart along the axis do not join.
        let ring = |h: f64, n: i32| {
            (0..n).map(move |i| (f64::from(i) * std::f64::consts::TAU / f64::from(n), h))
        };
        let points: Vec<_> = ring(0.0, 100)
            .chain(ring(0.5, 120))
            .map(|(a, h)| on(a, h))
            .collect();
        assert_eq!(
            patch(&surface, &points, 0.1),
            (100..220).collect::<Vec<u32>>()
        );
    }

    #[test]
    fn caps_of_a_sphere_hang_together_anywhere_and_apart_caps_do_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mut any = || {
            Vector3::from(<UnitSphere as Distribution<[f64; 3]>>::sample(
                &UnitSphere,
                &mut rng,
            ))
        };
        let centre = Vector3::new(0.3, 0.1, -2.0);
        let surface = Surface::Sphere {
            centre,
            radius_m: 0.5,
        };
        let mut towards = vec![Vector3::z(), -Vector3::z(), Vector3::x(), -Vector3::y()];
        towards.push(Vector3::new(1.0, 0.0, -1.0).normalize());
        towards.push(Vector3::new(-1.0, 1.0, 0.0).normalize());
        towards.extend((0..20).map(|_| any()));
        let all: Vec<_> = (0..8000).map(|_| any()).collect();
        for pole in towards {
            // Cap of 50 deg, and a smaller one opposite.
            let cap = |cos: f64, side: f64| {
                let on = all.iter().filter(move |d| side * d.dot(&pole) > cos);
                on.map(|d| centre + d * 0.5).collect::<Vec<_>>()
            };
            let mut points = cap(0.643, 1.0);
            let wanted = points.len();
            points.extend(cap(0.8, -1.0));
            let kept = patch(&surface, &points, 0.1);
            assert_eq!(kept, (0..wanted as u32).collect::<Vec<u32>>(), "{pole}");
        }
    }

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
    fn angles_are_those_of_the_library() {
        for i in -400..=400 {
            let wanted = i as f32 * 0.00785;
            let (y, x) = wanted.sin_cos();
            assert!((angle(y * 3.0, x * 3.0) - wanted).abs() < 3e-5, "{wanted}");
        }
        assert!(angle(0.0, 0.0).is_finite());
    }
}
