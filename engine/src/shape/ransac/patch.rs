//! The points on a surface that hang together: found and put onto its bitmap in one pass over the
//! cloud.

use super::bitmap::{Bitmap, Chart};
use super::cloud::{Cloud, Part};
use super::score::{Accept, LANES, Test, Tolerance, flags};
use super::surface::Surface;
use crate::mixture::instructions::{Instructions, Loops};
use nalgebra::{Point3, Vector3};

/// Places of the points of `cloud` on `surface` in the largest patch connected through neighbouring
/// pixels `cell_m` wide, rising; of equal patches that of the first point.
pub(super) fn largest_patch(
    instructions: Instructions,
    surface: &Surface,
    tolerance: Tolerance,
    cloud: &Cloud,
    cell_m: f64,
) -> Vec<u32> {
    let chart = Chart::new(surface);
    let bitmap = Bitmap::holding(&chart, cloud, cell_m as f32);
    let (mut places, pixels) = instructions.run(Scan {
        test: Test::new(surface, tolerance),
        chart,
        bitmap: &bitmap,
        cloud,
    });
    if let Some(label) = bitmap.largest(&pixels) {
        let mut pixel = pixels.iter();
        places.retain(|_| {
            let pixel = pixel.next().and_then(|&p| label.get(p as usize));
            pixel.copied().unwrap_or(false)
        });
    }
    places
}

/// Hands the points of a cloud to a surface, a register of them at a time.
struct Scan<'a> {
    test: Test,
    chart: Chart,
    bitmap: &'a Bitmap,
    cloud: &'a Cloud<'a>,
}

impl Loops for Scan<'_> {
    /// Places of the points on the surface, and their pixels.
    type Output = (Vec<u32>, Vec<u32>);

    #[inline(always)]
    fn run<const FUSED: bool, const WIDTH: usize>(self) -> Self::Output {
        // One loop per class, so that no lane asks which it is.
        match (self.test, self.chart) {
            (Test::Flat(test), Chart::Plane { .. }) => self.each(test),
            (Test::Round(test), Chart::Cylinder { .. }) => self.each(test),
            (Test::Round(test), Chart::Sphere { .. }) => self.each(test),
            // A surface's test and its chart are of one class.
            (Test::Flat(_), _) | (Test::Round(_), Chart::Plane { .. }) => Self::Output::default(),
        }
    }
}

impl Scan<'_> {
    #[inline(always)]
    fn each(&self, test: impl Accept) -> (Vec<u32>, Vec<u32>) {
        let mut found = Found::with_room(self.cloud.len() + LANES);
        match self.cloud.part() {
            Part::All(points, normals) => {
                let (points, last_points) = points.as_chunks::<LANES>();
                let (normals, last_normals) = normals.as_chunks::<LANES>();
                let mut place = 0;
                for (points, normals) in points.iter().zip(normals) {
                    let places = std::array::from_fn(|k| place + k as u32);
                    self.take(test, LANES, &places, points, normals, &mut found);
                    place += LANES as u32;
                }
                let count = last_points.len().min(last_normals.len());
                let mut points = [Point3::origin(); LANES];
                let mut normals = [Vector3::zeros(); LANES];
                points[..count].copy_from_slice(&last_points[..count]);
                normals[..count].copy_from_slice(&last_normals[..count]);
                let places = std::array::from_fn(|k| place + k as u32);
                self.take(test, count, &places, &points, &normals, &mut found);
            }
            Part::At(left) => {
                for some in left.chunks(LANES) {
                    let mut places = [0; LANES];
                    let mut points = [Point3::origin(); LANES];
                    let mut normals = [Vector3::zeros(); LANES];
                    for (k, &place) in some.iter().enumerate() {
                        places[k] = place;
                        (points[k], normals[k]) = self.cloud.given(place);
                    }
                    self.take(test, some.len(), &places, &points, &normals, &mut found);
                }
            }
        }
        (found.places, found.pixels)
    }

    /// The first `count` of these points.
    #[inline(always)]
    fn take(
        &self,
        test: impl Accept,
        count: usize,
        places: &[u32; LANES],
        points: &[Point3<f64>; LANES],
        normals: &[Vector3<f64>; LANES],
        found: &mut Found,
    ) {
        let mut lanes = [[0.0; LANES]; 6];
        for k in 0..LANES {
            let at = points[k] - self.cloud.origin;
            (lanes[0][k], lanes[1][k], lanes[2][k]) = (at.x as f32, at.y as f32, at.z as f32);
            let n = &normals[k];
            (lanes[3][k], lanes[4][k], lanes[5][k]) = (n.x as f32, n.y as f32, n.z as f32);
        }
        let mut on_it = flags(test, lanes.each_ref());
        on_it[count..].fill(false);
        if on_it == [false; LANES] {
            return;
        }
        let mut pixels = [0; LANES];
        for k in 0..LANES {
            let at = Vector3::new(lanes[0][k], lanes[1][k], lanes[2][k]);
            pixels[k] = self.bitmap.holds(self.chart.parameters(&at));
        }
        found.push(places, &pixels, &on_it);
    }
}

/// What was found so far.
struct Found {
    places: Vec<u32>,
    pixels: Vec<u32>,
}

impl Found {
    fn with_room(count: usize) -> Self {
        Self {
            places: Vec::with_capacity(count),
            pixels: Vec::with_capacity(count),
        }
    }

    #[inline(always)]
    fn push(&mut self, places: &[u32; LANES], pixels: &[u32; LANES], on_it: &[bool; LANES]) {
        let (mut to, mut pixel) = ([0; LANES], [0; LANES]);
        // Every one is written and the next one overwrites it unless it was a hit.
        let mut hits = 0;
        for k in 0..LANES {
            to[hits] = places[k];
            pixel[hits] = pixels[k];
            hits += usize::from(on_it[k]);
        }
        append(&mut self.places, &to, hits);
        append(&mut self.pixels, &pixel, hits);
    }
}

/// The first `count`; copied as a whole, whose size the compiler knows.
#[inline(always)]
fn append(all: &mut Vec<u32>, some: &[u32; LANES], count: usize) {
    let end = all.len() + count;
    all.extend_from_slice(some);
    all.truncate(end);
}

#[cfg(test)]
mod tests {
    use super::largest_patch;
    use crate::mixture::Instructions;
    use crate::shape::ransac::cloud::Cloud;
    use crate::shape::ransac::score::Tolerance;
    use crate::shape::ransac::surface::Surface;
    use nalgebra::{Point3, Unit, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, UnitSphere};

    /// Everything lies on everything: what is left is how it hangs together.
    const ALL: Tolerance = Tolerance {
        epsilon_m: 1e4,
        cos_angle: -1.0,
    };

    #[test]
    fn one_pass_finds_what_distances_and_normals_say() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut any = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let away = Vector3::new(300.0, -20.0, 5.0);
        let points: Vec<_> = (0..1003).map(|_| Point3::from(any() + away)).collect();
        let normals: Vec<_> = (0..1003).map(|_| any().normalize()).collect();
        let middle = away - points[0].coords;
        let normal = Unit::new_normalize(any());
        let surfaces = [
            Surface::Plane {
                normal,
                offset_m: normal.dot(&middle) + 0.2,
            },
            Surface::Sphere {
                centre: any() + middle,
                radius_m: 0.7,
            },
            Surface::Cylinder {
                point: any() * 0.3 + middle,
                axis: Unit::new_normalize(any()),
                radius_m: 0.6,
            },
        ];
        let tolerance = Tolerance {
            epsilon_m: 0.3,
            cos_angle: 0.6,
        };
        // Cells as wide as the cloud: all of it hangs together.
        for surface in surfaces {
            let mut cloud = Cloud::of(&points, &normals);
            for gone in [&[][..], &[0, 5, 77, 78, 1002]] {
                cloud.remove(gone);
                let whole = Cloud::of(&points, &normals);
                let on_it = |k: &u32| {
                    tolerance.accepts(&surface, &whole.place(*k), &normals[*k as usize])
                        && !gone.contains(k)
                };
                let one_by_one: Vec<u32> = (0..1003).filter(on_it).collect();
                assert!(one_by_one.len() > 5, "{surface:?}");
                for set in Instructions::ALL {
                    let got = largest_patch(set, &surface, tolerance, &cloud, 10.0);
                    assert_eq!(got, one_by_one, "{surface:?}");
                    if gone.is_empty() {
                        let got = largest_patch(set, &surface, tolerance, &whole, 10.0);
                        assert_eq!(got, one_by_one, "{surface:?}");
                    }
                }
            }
        }
        let none = Cloud::of(&[], &[]);
        assert!(
            largest_patch(Instructions::best(), &surfaces[0], tolerance, &none, 1.0).is_empty()
        );
    }

    /// The cloud keeps its own middle: surfaces below are given in the world and moved there.
    fn patch(surface: &Surface, points: &[Vector3<f64>], cell_m: f64) -> Vec<u32> {
        let points: Vec<_> = points.iter().map(|p| Point3::from(*p)).collect();
        let normals = vec![Vector3::z(); points.len()];
        let cloud = Cloud::of(&points, &normals);
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
        largest_patch(Instructions::best(), &moved, ALL, &cloud, cell_m)
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
}
