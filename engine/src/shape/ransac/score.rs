//! Which points lie on a surface: the inner loops of the search, in f32 and without branches.
//!
//! Distances are compared squared, so no loop takes a root: a point at distance q from a centre or
//! an axis lies within epsilon if (r - epsilon)^2 < q^2 < (r + epsilon)^2.

use super::sample::Sample;
use super::surface::Surface;
use crate::mixture::instructions::{Instructions, Loops};
use nalgebra::Vector3;
use std::ops::Range;

/// Numbers that are worked on together: one register of the widest instructions.
pub(super) const LANES: usize = 16;

/// Greatest distance and angle of a point that counts as lying on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tolerance {
    /// Metres.
    pub epsilon_m: f64,
    /// Cosine between the point's normal and the surface's, either way round.
    pub cos_angle: f64,
}

impl Tolerance {
    /// `factor` times the distance, the same angle.
    pub fn widened(self, factor: f64) -> Self {
        Self {
            epsilon_m: factor * self.epsilon_m,
            ..self
        }
    }

    /// Whether one point lies on `surface`; the loops below say the same in f32.
    pub fn accepts(&self, surface: &Surface, at: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
        surface.distance_m(at).abs() < self.epsilon_m
            && surface
                .normal_at(at)
                .is_some_and(|n| n.dot(normal).abs() > self.cos_angle)
    }
}

/// How many of the points in `range` lie on `surface`.
pub(super) fn count(
    instructions: Instructions,
    surface: &Surface,
    tolerance: Tolerance,
    sample: &Sample,
    range: Range<usize>,
) -> usize {
    let mut hits = [0u32; LANES];
    instructions.run(Scan {
        test: Test::new(surface, tolerance),
        columns: Columns::of(sample, range),
        each: |_, flags: &[bool; LANES]| {
            for (hits, flag) in hits.iter_mut().zip(flags) {
                *hits += u32::from(*flag);
            }
        },
    });
    hits.iter().sum::<u32>() as usize
}

/// Places of the points in `range` that lie on `surface`, rising.
pub(super) fn collect(
    instructions: Instructions,
    surface: &Surface,
    tolerance: Tolerance,
    sample: &Sample,
    range: Range<usize>,
) -> Vec<u32> {
    let columns = Columns::of(sample, range.clone());
    // Every place is written and the next one overwrites it unless it was a hit.
    let mut found = vec![0; columns.0[0].len() + LANES];
    let mut hits = 0;
    instructions.run(Scan {
        test: Test::new(surface, tolerance),
        columns,
        each: |from: usize, flags: &[bool; LANES]| {
            for (place, flag) in ((range.start + from) as u32..).zip(flags) {
                found[hits] = place;
                hits += usize::from(*flag);
            }
        },
    });
    found.truncate(hits);
    found
}

/// Borrowed columns of one range: coordinates, then normals.
struct Columns<'a>([&'a [f32]; 6]);

impl<'a> Columns<'a> {
    fn of(sample: &'a Sample, range: Range<usize>) -> Self {
        let end = range.end.min(sample.len());
        let range = range.start.min(end)..end;
        let [x, y, z] = &sample.at;
        let [u, v, w] = &sample.normal;
        Self([x, y, z, u, v, w].map(|column| column.get(range.clone()).unwrap_or_default()))
    }
}

/// A surface as the loops want it.
#[derive(Clone, Copy)]
pub(super) enum Test {
    Flat(Flat),
    Round(Round),
}

#[derive(Clone, Copy)]
pub(super) struct Flat {
    normal: [f32; 3],
    offset: f32,
    epsilon: f32,
    cos: f32,
}

/// Sphere and cylinder: the sphere is the cylinder whose axis is no direction (zero).
#[derive(Clone, Copy)]
pub(super) struct Round {
    middle: [f32; 3],
    axis: [f32; 3],
    least_squared: f32,
    most_squared: f32,
    cos_squared: f32,
}

impl Test {
    pub fn new(surface: &Surface, tolerance: Tolerance) -> Self {
        let narrow = |v: &Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let round = |middle: &Vector3<f64>, axis: &Vector3<f64>, radius_m: f64| {
            let square = |r: f64| (r.abs() * r) as f32;
            Self::Round(Round {
                middle: narrow(middle),
                axis: narrow(axis),
                least_squared: square(radius_m - tolerance.epsilon_m),
                most_squared: square(radius_m + tolerance.epsilon_m),
                cos_squared: square(tolerance.cos_angle),
            })
        };
        match surface {
            Surface::Plane { normal, offset_m } => Self::Flat(Flat {
                normal: narrow(normal),
                offset: *offset_m as f32,
                epsilon: tolerance.epsilon_m as f32,
                cos: tolerance.cos_angle as f32,
            }),
            Surface::Sphere { centre, radius_m } => round(centre, &Vector3::zeros(), *radius_m),
            Surface::Cylinder {
                point,
                axis,
                radius_m,
            } => round(point, axis, *radius_m),
        }
    }
}

/// Whether a point lies on a surface.
pub(super) trait Accept: Copy {
    /// Of one with these coordinates and this normal, both in three numbers.
    fn accept(&self, p: [f32; 6]) -> bool;
}

impl Accept for Flat {
    #[inline(always)]
    fn accept(&self, [x, y, z, u, v, w]: [f32; 6]) -> bool {
        let [a, b, c] = self.normal;
        let distance = a * x + b * y + c * z - self.offset;
        let cos = a * u + b * v + c * w;
        (distance.abs() < self.epsilon) & (cos.abs() > self.cos)
    }
}

impl Accept for Round {
    #[inline(always)]
    fn accept(&self, [x, y, z, u, v, w]: [f32; 6]) -> bool {
        let [a, b, c] = self.axis;
        let (x, y, z) = (x - self.middle[0], y - self.middle[1], z - self.middle[2]);
        let height = a * x + b * y + c * z;
        let (x, y, z) = (x - height * a, y - height * b, z - height * c);
        let squared = x * x + y * y + z * z;
        let along = x * u + y * v + z * w;
        (squared > self.least_squared)
            & (squared < self.most_squared)
            & (along * along > self.cos_squared * squared)
    }
}

/// Hands out the flags of `LANES` points after the other.
struct Scan<'a, F> {
    test: Test,
    columns: Columns<'a>,
    each: F,
}

impl<F: FnMut(usize, &[bool; LANES])> Loops for Scan<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool, const WIDTH: usize>(self) {
        match self.test {
            Test::Flat(test) => scan(test, self.columns, self.each),
            Test::Round(test) => scan(test, self.columns, self.each),
        }
    }
}

#[inline(always)]
fn scan(test: impl Accept, columns: Columns<'_>, mut each: impl FnMut(usize, &[bool; LANES])) {
    let split = columns.0.map(|column| column.as_chunks::<LANES>());
    let [x, y, z, u, v, w] = split.map(|(whole, _)| whole);
    let whole = x.iter().zip(y).zip(z).zip(u).zip(v).zip(w);
    for (n, (((((x, y), z), u), v), w)) in whole.enumerate() {
        each(n * LANES, &flags(test, [x, y, z, u, v, w]));
    }
    let rest = split.map(|(_, rest)| rest);
    let count = rest[0].len();
    if count > 0 {
        let padded = rest.map(|rest| {
            let mut lanes = [0.0; LANES];
            lanes[..count].copy_from_slice(rest);
            lanes
        });
        let mut flags = flags(test, padded.each_ref());
        flags[count..].fill(false);
        each(columns.0[0].len() - count, &flags);
    }
}

/// Of every lane, whether it lies on the surface.
#[inline(always)]
pub(super) fn flags(test: impl Accept, [x, y, z, u, v, w]: [&[f32; LANES]; 6]) -> [bool; LANES] {
    let mut flags = [false; LANES];
    for k in 0..LANES {
        flags[k] = test.accept([x[k], y[k], z[k], u[k], v[k], w[k]]);
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::{Tolerance, collect, count};
    use crate::mixture::Instructions;
    use crate::shape::ransac::cloud::Cloud;
    use crate::shape::ransac::surface::Surface;
    use nalgebra::{Point3, Unit, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn loops_say_what_distances_and_normals_say() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut any = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let points: Vec<_> = (0..1003).map(|_| Point3::from(any())).collect();
        let normals: Vec<_> = (0..1003).map(|_| any().normalize()).collect();
        let whole = Cloud::of(&points, &normals);
        let sample = whole.sample(1003, &mut ChaCha8Rng::seed_from_u64(5));
        let surfaces = [
            Surface::Plane {
                normal: Unit::new_normalize(any()),
                offset_m: 0.2,
            },
            Surface::Sphere {
                centre: any(),
                radius_m: 0.7,
            },
            // Smaller than epsilon: the inside belongs to it.
            Surface::Sphere {
                centre: any() * 0.2,
                radius_m: 0.2,
            },
            Surface::Cylinder {
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
                .filter(|&k| tolerance.accepts(&surface, &sample.place(k), &sample.normal(k)))
                .collect();
            assert!(one_by_one.len() > 5, "{surface:?}");
            for set in Instructions::ALL {
                assert_eq!(
                    collect(set, &surface, tolerance, &sample, 0..1003),
                    one_by_one
                );
                for range in [0..0, 0..7, 5..100, 990..1003, 1000..2000] {
                    let within = one_by_one
                        .iter()
                        .filter(|k| range.contains(&(**k as usize)));
                    let got = count(set, &surface, tolerance, &sample, range.clone());
                    assert_eq!(got, within.count(), "{surface:?} {range:?}");
                }
            }
        }
    }
}
