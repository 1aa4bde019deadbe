//! Inliers of a surface: the inner loops of the search, in f32 and without branches.
//!
//! Squared distances are compared, so that no loop takes a root: a point at distance q from a centre or an axis is within
//! epsilon of the surface if (r - epsilon)^2 < q^2 < (r + epsilon)^2.

use super::sample::PointSample;
use super::surface::UnboundedSurface;
use crate::mixture::instructions::{InstructionSet, SimdKernel};
use nalgebra::Vector3;
use std::ops::Range;

/// Values processed together: one register of the widest instructions.
pub(super) const LANES: usize = 16;

/// Greatest distance and angle of an inlier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tolerance {
    pub epsilon_m: f64,
    /// Cosine between the point's normal and the surface's, of either sign.
    pub cos_angle: f64,
}

impl Tolerance {
    /// `factor` times the distance, the same angle.
    pub(super) fn widened(self, factor: f64) -> Self {
        Self {
            epsilon_m: factor * self.epsilon_m,
            ..self
        }
    }

    /// Whether a point is an inlier of `surface`, in f64; the loops below compute the same in f32.
    pub(super) fn accepts(
        &self,
        surface: &UnboundedSurface,
        position: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> bool {
        surface.distance_m(position).abs() < self.epsilon_m
            && surface
                .normal_at(position)
                .is_some_and(|n| n.dot(normal).abs() > self.cos_angle)
    }
}

/// Number of inliers among the points in `range`.
pub(super) fn count_inliers(
    instructions: InstructionSet,
    surface: &UnboundedSurface,
    tolerance: Tolerance,
    sample: &PointSample,
    range: Range<usize>,
) -> usize {
    let mut inliers = [0u32; LANES];
    instructions.run(InlierScan {
        test: InlierTest::new(surface, tolerance),
        columns: SampleColumns::new(sample, range),
        each: |_, flags: &[bool; LANES]| {
            for (inliers, flag) in inliers.iter_mut().zip(flags) {
                *inliers += u32::from(*flag);
            }
        },
    });
    inliers.iter().sum::<u32>() as usize
}

/// Indices of the inliers among the points in `range`, rising.
pub(super) fn collect_inliers(
    instructions: InstructionSet,
    surface: &UnboundedSurface,
    tolerance: Tolerance,
    sample: &PointSample,
    range: Range<usize>,
) -> Vec<u32> {
    let columns = SampleColumns::new(sample, range.clone());
    // Every index is written, and overwritten by the next one unless it is an inlier.
    let mut found = vec![0; columns.0[0].len() + LANES];
    let mut inliers = 0;
    instructions.run(InlierScan {
        test: InlierTest::new(surface, tolerance),
        columns,
        each: |from: usize, flags: &[bool; LANES]| {
            for (index, flag) in ((range.start + from) as u32..).zip(flags) {
                found[inliers] = index;
                inliers += usize::from(*flag);
            }
        },
    });
    found.truncate(inliers);
    found
}

/// Borrowed columns of one range: coordinates, then normals.
struct SampleColumns<'a>([&'a [f32]; 6]);

impl<'a> SampleColumns<'a> {
    fn new(sample: &'a PointSample, range: Range<usize>) -> Self {
        let end = range.end.min(sample.len());
        let range = range.start.min(end)..end;
        let [x, y, z] = &sample.positions;
        let [u, v, w] = &sample.normals;
        Self([x, y, z, u, v, w].map(|column| column.get(range.clone()).unwrap_or_default()))
    }
}

/// Inlier test of a surface, for the loops.
#[derive(Clone, Copy)]
pub(super) enum InlierTest {
    Plane(PlaneTest),
    Radial(RadialTest),
}

#[derive(Clone, Copy)]
pub(super) struct PlaneTest {
    normal: [f32; 3],
    offset: f32,
    epsilon: f32,
    cos: f32,
}

/// Of sphere and cylinder: a sphere has a zero axis.
#[derive(Clone, Copy)]
pub(super) struct RadialTest {
    centre: [f32; 3],
    axis: [f32; 3],
    min_squared: f32,
    max_squared: f32,
    cos_squared: f32,
}

impl InlierTest {
    pub(super) fn new(surface: &UnboundedSurface, tolerance: Tolerance) -> Self {
        let narrow = |v: &Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let radial = |centre: &Vector3<f64>, axis: &Vector3<f64>, radius_m: f64| {
            let square = |r: f64| (r.abs() * r) as f32;
            Self::Radial(RadialTest {
                centre: narrow(centre),
                axis: narrow(axis),
                min_squared: square(radius_m - tolerance.epsilon_m),
                max_squared: square(radius_m + tolerance.epsilon_m),
                cos_squared: square(tolerance.cos_angle),
            })
        };
        match surface {
            UnboundedSurface::Plane { normal, offset_m } => Self::Plane(PlaneTest {
                normal: narrow(normal),
                offset: *offset_m as f32,
                epsilon: tolerance.epsilon_m as f32,
                cos: tolerance.cos_angle as f32,
            }),
            UnboundedSurface::Sphere { centre, radius_m } => {
                radial(centre, &Vector3::zeros(), *radius_m)
            }
            UnboundedSurface::Cylinder {
                point,
                axis,
                radius_m,
            } => radial(point, axis, *radius_m),
        }
    }
}

pub(super) trait Accept: Copy {
    /// Whether a point with these three coordinates and three components of its normal is an inlier.
    fn accept(&self, p: [f32; 6]) -> bool;
}

impl Accept for PlaneTest {
    #[inline(always)]
    fn accept(&self, [x, y, z, u, v, w]: [f32; 6]) -> bool {
        let [a, b, c] = self.normal;
        let distance = a * x + b * y + c * z - self.offset;
        let cos = a * u + b * v + c * w;
        (distance.abs() < self.epsilon) & (cos.abs() > self.cos)
    }
}

impl Accept for RadialTest {
    #[inline(always)]
    fn accept(&self, [x, y, z, u, v, w]: [f32; 6]) -> bool {
        let [a, b, c] = self.axis;
        let (x, y, z) = (x - self.centre[0], y - self.centre[1], z - self.centre[2]);
        let height = a * x + b * y + c * z;
        let (x, y, z) = (x - height * a, y - height * b, z - height * c);
        let squared = x * x + y * y + z * z;
        let along = x * u + y * v + z * w;
        (squared > self.min_squared)
            & (squared < self.max_squared)
            & (along * along > self.cos_squared * squared)
    }
}

/// Passes the index of the first of `LANES` points and their test results to `each`.
struct InlierScan<'a, F> {
    test: InlierTest,
    columns: SampleColumns<'a>,
    each: F,
}

impl<F: FnMut(usize, &[bool; LANES])> SimdKernel for InlierScan<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool, const WIDTH: usize>(self) {
        match self.test {
            InlierTest::Plane(test) => scan_columns(test, self.columns, self.each),
            InlierTest::Radial(test) => scan_columns(test, self.columns, self.each),
        }
    }
}

#[inline(always)]
fn scan_columns(
    test: impl Accept,
    columns: SampleColumns<'_>,
    mut each: impl FnMut(usize, &[bool; LANES]),
) {
    let split = columns.0.map(|column| column.as_chunks::<LANES>());
    let [x, y, z, u, v, w] = split.map(|(whole, _)| whole);
    let whole = x.iter().zip(y).zip(z).zip(u).zip(v).zip(w);
    for (n, (((((x, y), z), u), v), w)) in whole.enumerate() {
        each(n * LANES, &test_lanes(test, [x, y, z, u, v, w]));
    }
    let rest = split.map(|(_, rest)| rest);
    let count = rest[0].len();
    if count > 0 {
        let padded = rest.map(|rest| {
            let mut lanes = [0.0; LANES];
            lanes[..count].copy_from_slice(rest);
            lanes
        });
        let mut flags = test_lanes(test, padded.each_ref());
        flags[count..].fill(false);
        each(columns.0[0].len() - count, &flags);
    }
}

/// The test results of all lanes.
#[inline(always)]
pub(super) fn test_lanes(
    test: impl Accept,
    [x, y, z, u, v, w]: [&[f32; LANES]; 6],
) -> [bool; LANES] {
    let mut flags = [false; LANES];
    for k in 0..LANES {
        flags[k] = test.accept([x[k], y[k], z[k], u[k], v[k], w[k]]);
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::{Tolerance, collect_inliers, count_inliers};
    use crate::mixture::InstructionSet;
    use crate::shape::ransac::cloud::Cloud;
    use crate::shape::ransac::surface::UnboundedSurface;
    use nalgebra::{Point3, Unit, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn loops_agree_with_distances_and_normals() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut any = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let points: Vec<_> = (0..1003).map(|_| Point3::from(any())).collect();
        let normals: Vec<_> = (0..1003).map(|_| any().normalize()).collect();
        let whole = Cloud::new(&points, &normals);
        let sample = whole.sample(1003, &mut ChaCha8Rng::seed_from_u64(5));
        let surfaces = [
            UnboundedSurface::Plane {
                normal: Unit::new_normalize(any()),
                offset_m: 0.2,
            },
            UnboundedSurface::Sphere {
                centre: any(),
                radius_m: 0.7,
            },
            // Smaller than epsilon: all of the inside is within it.
            UnboundedSurface::Sphere {
                centre: any() * 0.2,
                radius_m: 0.2,
            },
            UnboundedSurface::Cylinder {
                point: any() * 0.3,
                axis: Unit::new_normalize(any()),
                radius_m: 0.6,
            },
        ];
        let tolerance = Tolerance {
            epsilon_m: 0.3,
            cos_angle: 0.6,
        };
        for surface in surfaces {
            let one_by_one: Vec<u32> = (0..1003)
                .filter(|&k| tolerance.accepts(&surface, &sample.position(k), &sample.normal(k)))
                .collect();
            assert!(one_by_one.len() > 5, "{surface:?}");
            for set in InstructionSet::ALL {
                assert_eq!(
                    collect_inliers(set, &surface, tolerance, &sample, 0..1003),
                    one_by_one
                );
                for range in [0..0, 0..7, 5..100, 990..1003, 1000..2000] {
                    let within = one_by_one
                        .iter()
                        .filter(|k| range.contains(&(**k as usize)));
                    let got = count_inliers(set, &surface, tolerance, &sample, range.clone());
                    assert_eq!(got, within.count(), "{surface:?} {range:?}");
                }
            }
        }
    }
}
