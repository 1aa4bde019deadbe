//! The flat surfaces of the place, found anew in every round: cells of each leg by itself, gathered to surfaces of all.

use super::constants::{
    CELL_M, LEAST_BEAMS, LEAST_CELLS, LEAST_COS, MOST_PLANES, OWN_CELL_SIGMAS, TRIALS,
};
use crate::geometry::{Patch, Surfaces};
use crate::sweep::constants::URG_NOISE;
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

/// `normal . x = offset_m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit normal, towards the sensor.
    pub normal: Vector3<f64>,
    /// Metres.
    pub offset_m: f64,
}

impl Plane {
    /// Signed distance of a place, metres.
    pub fn height_m(&self, place: &Point3<f64>) -> f64 {
        self.normal.dot(&place.coords) - self.offset_m
    }

    fn holds(&self, patch: &Patch, (off_m, turned_rad): (f64, f64)) -> bool {
        self.height_m(&patch.mean).abs() < off_m
            && self.normal.dot(&patch.normal) > turned_rad.cos()
    }

    /// Through these cells; `None` where they lie along a line.
    fn through(patches: &[&Patch]) -> Option<Self> {
        let n = patches.len() as f64;
        let mean = patches.iter().map(|p| p.mean.coords).sum::<Vector3<f64>>() / n;
        let scatter: Matrix3<f64> = patches
            .iter()
            .map(|p| (p.mean.coords - mean) * (p.mean.coords - mean).transpose())
            .sum();
        let eigen = SymmetricEigen::new(scatter / n);
        let least = eigen.eigenvalues.imin();
        let mut normal: Vector3<f64> = eigen.eigenvectors.column(least).into_owned();
        let middle = eigen.eigenvalues.sum() - eigen.eigenvalues.min() - eigen.eigenvalues.max();
        let towards: f64 = patches.iter().map(|p| p.normal.dot(&normal)).sum();
        if towards < 0.0 {
            normal = -normal;
        }
        let whole = middle > CELL_M.powi(2) && normal.iter().all(|x| x.is_finite());
        whole.then_some(Self {
            normal,
            offset_m: normal.dot(&mean),
        })
    }
}

/// A leg's points and the lines between them.
pub struct LegPoints<'a> {
    /// Base's frame, metres.
    pub points: &'a [Point3<f64>],
    /// Where the laser was.
    pub origin: Point3<f64>,
    /// Between two lines, radians.
    pub pitch_rad: f64,
}

/// The surfaces, and for every point of every leg in order the surface that it lies on.
pub fn find(legs: &[LegPoints<'_>], round: (f64, f64)) -> (Vec<Plane>, Vec<Option<usize>>) {
    let surfaces: Vec<Surfaces> = legs
        .iter()
        .map(|leg| {
            let spacing = leg.pitch_rad.max(CELL_M / 10.0);
            Surfaces::of(leg.points, &leg.origin, spacing, URG_NOISE.per_m, CELL_M)
        })
        .collect();
    let flat: Vec<&Patch> = surfaces
        .iter()
        .flat_map(|s| s.patches.iter().filter(|p| p.flat))
        .collect();
    let mut planes = gather(flat, round);
    let mut plane_of_point = Vec::new();
    for (leg, surfaces) in legs.iter().zip(&surfaces) {
        let plane_of_patch: Vec<Option<usize>> = surfaces
            .patches
            .iter()
            .map(|patch| only_plane(&planes, patch, round))
            .collect();
        for (point, patch) in leg.points.iter().zip(&surfaces.patch_of_point) {
            let own = plane_of_patch.get(*patch as usize).copied().flatten();
            let patch = surfaces.patches.get(*patch as usize);
            plane_of_point.push(own.filter(|plane| {
                patch.is_some_and(|patch| belongs(point, patch, &planes[*plane], leg, round.0))
            }));
        }
    }
    drop_poor(&mut planes, &mut plane_of_point);
    (planes, plane_of_point)
}

/// Surfaces that hardly a beam is left on, most of their cells being claimed by another, are none.
fn drop_poor(planes: &mut Vec<Plane>, plane_of_point: &mut [Option<usize>]) {
    let mut beams = vec![0_usize; planes.len()];
    plane_of_point.iter().flatten().for_each(|p| beams[*p] += 1);
    let mut next = 0;
    let kept: Vec<Option<usize>> = beams
        .iter()
        .map(|n| {
            (*n >= LEAST_BEAMS).then(|| {
                next += 1;
                next - 1
            })
        })
        .collect();
    let mut at = 0;
    planes.retain(|_| {
        at += 1;
        kept[at - 1].is_some()
    });
    for plane in plane_of_point {
        *plane = plane.and_then(|p| kept[p]);
    }
}

/// Surfaces with the most cells first.
fn gather(mut left: Vec<&Patch>, round: (f64, f64)) -> Vec<Plane> {
    let mut planes = Vec::new();
    while planes.len() < MOST_PLANES && left.len() >= LEAST_CELLS {
        let stride = left.len().div_ceil(TRIALS);
        let best = left
            .iter()
            .step_by(stride)
            .map(|seed| Plane {
                normal: seed.normal,
                offset_m: seed.offset_m,
            })
            .map(|plane| (left.iter().filter(|p| plane.holds(p, round)).count(), plane))
            .max_by_key(|(count, _)| *count);
        let Some((_, mut plane)) = best else { break };
        let mut on: Vec<&Patch> = Vec::new();
        let mut whole = true;
        for _ in 0..3 {
            on = left
                .iter()
                .filter(|p| plane.holds(p, round))
                .copied()
                .collect();
            match Plane::through(&on).filter(|_| on.len() >= LEAST_CELLS) {
                Some(better) => plane = better,
                None => {
                    whole = false;
                    break;
                }
            }
        }
        let before = left.len();
        left.retain(|p| !plane.holds(p, round));
        if whole {
            planes.push(plane);
        } else if on.len() < LEAST_CELLS || left.len() == before {
            break;
        }
    }
    planes
}

/// The plane of a cell; none for a cell that two could claim.
fn only_plane(planes: &[Plane], patch: &Patch, round: (f64, f64)) -> Option<usize> {
    if !patch.flat {
        return None;
    }
    let mut claims = planes
        .iter()
        .enumerate()
        .filter(|(_, plane)| plane.holds(patch, round))
        .map(|(i, _)| i);
    let first = claims.next()?;
    claims.next().is_none().then_some(first)
}

/// Whether a point is of its cell's surface, and was not met at a grazing angle.
fn belongs(
    point: &Point3<f64>,
    patch: &Patch,
    plane: &Plane,
    leg: &LegPoints<'_>,
    off_m: f64,
) -> bool {
    let ray = point - leg.origin;
    let range_m = ray.norm();
    let cos = ray.dot(&plane.normal).abs() / range_m.max(1e-9);
    cos > LEAST_COS
        && patch.height_m(point).abs() < OWN_CELL_SIGMAS * URG_NOISE.sigma_m(range_m)
        && plane.height_m(point).abs() < 2.0 * off_m
}
