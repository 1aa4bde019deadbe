//! The largest connected patch of a surface's inliers, found and mapped to the bitmap in one pass over the cloud.

use super::bitmap::{Bitmap, Chart};
use super::cloud::{ActivePoints, Cloud};
use super::score::{Accept, InlierTest, LANES, Tolerance, test_lanes};
use super::surface::UnboundedSurface;
use crate::mixture::instructions::{InstructionSet, SimdKernel};
use nalgebra::{Point3, Vector3};

/// Indices of the inliers of `surface` in the largest patch connected through neighbouring pixels `cell_m` wide, rising; of
/// equally large patches that of the first point.
pub(super) fn largest_patch(
    instructions: InstructionSet,
    surface: &UnboundedSurface,
    tolerance: Tolerance,
    cloud: &Cloud,
    cell_m: f64,
) -> Vec<u32> {
    let chart = Chart::new(surface);
    let bitmap = Bitmap::covering(&chart, cloud, cell_m as f32);
    let (mut indices, pixels) = instructions.run(PatchScan {
        test: InlierTest::new(surface, tolerance),
        chart,
        bitmap: &bitmap,
        cloud,
    });
    if let Some(labels) = bitmap.largest_component(&pixels) {
        let mut pixel = pixels.iter();
        indices.retain(|_| {
            let pixel = pixel.next().and_then(|&p| labels.get(p as usize));
            pixel.copied().unwrap_or(false)
        });
    }
    indices
}

/// Tests the points of a cloud, `LANES` at a time.
struct PatchScan<'a> {
    test: InlierTest,
    chart: Chart,
    bitmap: &'a Bitmap,
    cloud: &'a Cloud<'a>,
}

impl SimdKernel for PatchScan<'_> {
    /// Indices of the inliers, and their pixels.
    type Output = (Vec<u32>, Vec<u32>);

    #[inline(always)]
    fn run<const FUSED: bool, const WIDTH: usize>(self) -> Self::Output {
        // One loop per class, so that no lane branches on it.
        match (self.test, self.chart) {
            (InlierTest::Plane(test), Chart::Plane { .. }) => self.scan(test),
            (InlierTest::Radial(test), Chart::Cylinder { .. }) => self.scan(test),
            (InlierTest::Radial(test), Chart::Sphere { .. }) => self.scan(test),
            // Test and chart are always of one class.
            (InlierTest::Plane(_), _) | (InlierTest::Radial(_), Chart::Plane { .. }) => {
                Self::Output::default()
            }
        }
    }
}

impl PatchScan<'_> {
    #[inline(always)]
    fn scan(&self, test: impl Accept) -> (Vec<u32>, Vec<u32>) {
        let mut found = PatchPoints::with_capacity(self.cloud.len() + LANES);
        match self.cloud.active() {
            ActivePoints::All(points, normals) => {
                let (points, last_points) = points.as_chunks::<LANES>();
                let (normals, last_normals) = normals.as_chunks::<LANES>();
                let mut index = 0;
                for (points, normals) in points.iter().zip(normals) {
                    let indices = std::array::from_fn(|k| index + k as u32);
                    self.test_block(test, LANES, &indices, points, normals, &mut found);
                    index += LANES as u32;
                }
                let count = last_points.len().min(last_normals.len());
                let mut points = [Point3::origin(); LANES];
                let mut normals = [Vector3::zeros(); LANES];
                points[..count].copy_from_slice(&last_points[..count]);
                normals[..count].copy_from_slice(&last_normals[..count]);
                let indices = std::array::from_fn(|k| index + k as u32);
                self.test_block(test, count, &indices, &points, &normals, &mut found);
            }
            ActivePoints::Indices(active) => {
                for some in active.chunks(LANES) {
                    let mut indices = [0; LANES];
                    let mut points = [Point3::origin(); LANES];
                    let mut normals = [Vector3::zeros(); LANES];
                    for (k, &index) in some.iter().enumerate() {
                        indices[k] = index;
                        (points[k], normals[k]) = self.cloud.oriented_point(index);
                    }
                    self.test_block(test, some.len(), &indices, &points, &normals, &mut found);
                }
            }
        }
        (found.indices, found.pixels)
    }

    /// Tests the first `count` of these points.
    #[inline(always)]
    fn test_block(
        &self,
        test: impl Accept,
        count: usize,
        indices: &[u32; LANES],
        points: &[Point3<f64>; LANES],
        normals: &[Vector3<f64>; LANES],
        found: &mut PatchPoints,
    ) {
        let mut lanes = [[0.0; LANES]; 6];
        for k in 0..LANES {
            let position = points[k] - self.cloud.origin;
            (lanes[0][k], lanes[1][k], lanes[2][k]) =
                (position.x as f32, position.y as f32, position.z as f32);
            let n = &normals[k];
            (lanes[3][k], lanes[4][k], lanes[5][k]) = (n.x as f32, n.y as f32, n.z as f32);
        }
        let mut inliers = test_lanes(test, lanes.each_ref());
        inliers[count..].fill(false);
        if inliers == [false; LANES] {
            return;
        }
        let mut pixels = [0; LANES];
        for k in 0..LANES {
            let position = Vector3::new(lanes[0][k], lanes[1][k], lanes[2][k]);
            pixels[k] = self.bitmap.pixel_of(self.chart.parameters(&position));
        }
        found.push(indices, &pixels, &inliers);
    }
}

/// Indices and pixels of the inliers so far.
struct PatchPoints {
    indices: Vec<u32>,
    pixels: Vec<u32>,
}

impl PatchPoints {
    fn with_capacity(count: usize) -> Self {
        Self {
            indices: Vec::with_capacity(count),
            pixels: Vec::with_capacity(count),
        }
    }

    #[inline(always)]
    fn push(&mut self, indices: &[u32; LANES], pixels: &[u32; LANES], inliers: &[bool; LANES]) {
        let (mut to, mut pixel) = ([0; LANES], [0; LANES]);
        // Every value is written, and overwritten by the next one unless it is of an inlier.
        let mut count = 0;
        for k in 0..LANES {
            to[count] = indices[k];
            pixel[count] = pixels[k];
            count += usize::from(inliers[k]);
        }
        append_prefix(&mut self.indices, &to, count);
        append_prefix(&mut self.pixels, &pixel, count);
    }
}

/// Appends the first `count`. All are copied, since the compiler knows that size.
#[inline(always)]
fn append_prefix(all: &mut Vec<u32>, some: &[u32; LANES], count: usize) {
    let end = all.len() + count;
    all.extend_from_slice(some);
    all.truncate(end);
}

#[cfg(test)]
mod tests {
    use super::largest_patch;
    use crate::mixture::InstructionSet;
    use crate::shape::ransac::cloud::Cloud;
    use crate::shape::ransac::score::Tolerance;
    use crate::shape::ransac::surface::UnboundedSurface;
    use nalgebra::{Point3, Unit, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, UnitSphere};

    /// Accepts every point, so that only the connectivity counts.
    const ALL: Tolerance = Tolerance {
        epsilon_m: 1e4,
        cos_angle: -1.0,
    };

    #[test]
    fn the_pass_agrees_with_distances_and_normals() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut any = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let away = Vector3::new(300.0, -20.0, 5.0);
        let points: Vec<_> = (0..1003).map(|_| Point3::from(any() + away)).collect();
        let normals: Vec<_> = (0..1003).map(|_| any().normalize()).collect();
        let middle = away - points[0].coords;
        let normal = Unit::new_normalize(any());
        let surfaces = [
            UnboundedSurface::Plane {
                normal,
                offset_m: normal.dot(&middle) + 0.2,
            },
            UnboundedSurface::Sphere {
                centre: any() + middle,
                radius_m: 0.7,
            },
            UnboundedSurface::Cylinder {
                point: any() * 0.3 + middle,
                axis: Unit::new_normalize(any()),
                radius_m: 0.6,
            },
        ];
        let tolerance = Tolerance {
            epsilon_m: 0.3,
            cos_angle: 0.6,
        };
        // Cells as wide as the cloud: all of it is connected.
        for surface in surfaces {
            let mut cloud = Cloud::new(&points, &normals);
            for gone in [&[][..], &[0, 5, 77, 78, 1002]] {
                cloud.remove(gone);
                let whole = Cloud::new(&points, &normals);
                let is_inlier = |k: &u32| {
                    tolerance.accepts(&surface, &whole.position(*k), &normals[*k as usize])
                        && !gone.contains(k)
                };
                let one_by_one: Vec<u32> = (0..1003).filter(is_inlier).collect();
                assert!(one_by_one.len() > 5, "{surface:?}");
                for set in InstructionSet::ALL {
                    let got = largest_patch(set, &surface, tolerance, &cloud, 10.0);
                    assert_eq!(got, one_by_one, "{surface:?}");
                    if gone.is_empty() {
                        let got = largest_patch(set, &surface, tolerance, &whole, 10.0);
                        assert_eq!(got, one_by_one, "{surface:?}");
                    }
                }
            }
        }
        let none = Cloud::new(&[], &[]);
        assert!(
            largest_patch(InstructionSet::best(), &surfaces[0], tolerance, &none, 1.0).is_empty()
        );
    }

    /// The largest patch for a surface in the frame of `points`, which is moved to the cloud's.
    fn patch(surface: &UnboundedSurface, points: &[Vector3<f64>], cell_m: f64) -> Vec<u32> {
        let points: Vec<_> = points.iter().map(|p| Point3::from(*p)).collect();
        let normals = vec![Vector3::z(); points.len()];
        let cloud = Cloud::new(&points, &normals);
        let shift = cloud.origin.coords;
        let moved = match *surface {
            UnboundedSurface::Plane { normal, offset_m } => UnboundedSurface::Plane {
                normal,
                offset_m: offset_m - normal.dot(&shift),
            },
            UnboundedSurface::Sphere { centre, radius_m } => UnboundedSurface::Sphere {
                centre: centre - shift,
                radius_m,
            },
            UnboundedSurface::Cylinder {
                point,
                axis,
                radius_m,
            } => UnboundedSurface::Cylinder {
                point: point - shift,
                axis,
                radius_m,
            },
        };
        largest_patch(InstructionSet::best(), &moved, ALL, &cloud, cell_m)
    }

    fn flat() -> UnboundedSurface {
        UnboundedSurface::Plane {
            normal: Vector3::z_axis(),
            offset_m: -1.0,
        }
    }

    #[test]
    fn a_gap_separates_patches_of_a_plane() {
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
    fn cells_too_small_for_memory_grow() {
        let points = [0.0, 1e-5, 500.0].map(|x| Vector3::new(x, 2.0 * x, -1.0));
        assert_eq!(patch(&flat(), &points, 1e-6), [0, 1]);
    }

    #[test]
    fn the_seam_of_a_cylinder_is_no_gap() {
        let axis = Unit::new_normalize(Vector3::new(0.3, -0.2, 1.0));
        let e1 = crate::shape::primitive::perpendicular(&axis).into_inner();
        let e2 = axis.cross(&e1);
        let surface = UnboundedSurface::Cylinder {
            point: Vector3::new(1.0, 2.0, 3.0),
            axis,
            radius_m: 0.5,
        };
        let on = |angle: f64, height: f64| {
            Vector3::new(1.0, 2.0, 3.0)
                + (e1 * angle.cos() + e2 * angle.sin()) * 0.5
                + axis.as_ref() * height
        };
        // Arcs of 2 rad about every direction, and an outlier opposite.
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
        // Rings apart along the axis are not connected.
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
    fn a_cap_of_a_sphere_is_connected_in_any_direction_and_the_opposite_cap_is_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mut any = || {
            Vector3::from(<UnitSphere as Distribution<[f64; 3]>>::sample(
                &UnitSphere,
                &mut rng,
            ))
        };
        let centre = Vector3::new(0.3, 0.1, -2.0);
        let surface = UnboundedSurface::Sphere {
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
}
