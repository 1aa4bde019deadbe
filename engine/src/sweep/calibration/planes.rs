//! The planes of the room, found anew in every tolerance: flat cells of each pan segment, grouped into planes of all.

use super::constants::{
    CELL_M, MAX_CELL_DISTANCE_SIGMAS, MAX_PLANES, MIN_INCIDENCE_COS, MIN_PLANE_BEAMS,
    MIN_PLANE_CELLS, PLANE_TRIALS,
};
use crate::geometry::{SurfacePatch, Surfaces};
use crate::sweep::constants::URG_NOISE;
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

/// A plane of the room: `normal . x = offset_m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CalibrationPlane {
    /// Unit normal, towards the sensor.
    pub(super) normal: Vector3<f64>,
    pub(super) offset_m: f64,
}

impl CalibrationPlane {
    /// Signed distance of a point, metres.
    pub(super) fn height_m(&self, p: &Point3<f64>) -> f64 {
        self.normal.dot(&p.coords) - self.offset_m
    }

    /// Whether a cell lies on the plane within the tolerances of distance and angle.
    fn contains(&self, patch: &SurfacePatch, (distance_m, angle_rad): (f64, f64)) -> bool {
        self.height_m(&patch.mean).abs() < distance_m
            && self.normal.dot(&patch.normal) > angle_rad.cos()
    }

    /// The plane through these cells; `None` if they lie along a line.
    fn fit(patches: &[&SurfacePatch]) -> Option<Self> {
        let n = patches.len() as f64;
        let mean = patches.iter().map(|p| p.mean.coords).sum::<Vector3<f64>>() / n;
        let scatter: Matrix3<f64> = patches
            .iter()
            .map(|p| (p.mean.coords - mean) * (p.mean.coords - mean).transpose())
            .sum();
        let eigen = SymmetricEigen::new(scatter / n);
        let smallest = eigen.eigenvalues.imin();
        let mut normal: Vector3<f64> = eigen.eigenvectors.column(smallest).into_owned();
        let middle = eigen.eigenvalues.sum() - eigen.eigenvalues.min() - eigen.eigenvalues.max();
        let towards: f64 = patches.iter().map(|p| p.normal.dot(&normal)).sum();
        if towards < 0.0 {
            normal = -normal;
        }
        let determined = middle > CELL_M.powi(2) && normal.iter().all(|x| x.is_finite());
        determined.then_some(Self {
            normal,
            offset_m: normal.dot(&mean),
        })
    }
}

/// The points of a pan segment.
pub(super) struct PanSegmentPoints<'a> {
    /// In the base frame, metres.
    pub(super) points: &'a [Point3<f64>],
    /// Mean position of the laser.
    pub(super) origin: Point3<f64>,
    /// Angle between lines, radians.
    pub(super) pitch_rad: f64,
}

/// The planes, and for every point of every pan segment in order the plane that it lies on. `tolerance`: distance and angle
/// between a cell and its plane, metres and radians.
pub(super) fn find_planes(
    segments: &[PanSegmentPoints<'_>],
    tolerance: (f64, f64),
) -> (Vec<CalibrationPlane>, Vec<Option<usize>>) {
    let surfaces: Vec<Surfaces> = segments
        .iter()
        .map(|segment| {
            let spacing = segment.pitch_rad.max(CELL_M / 10.0);
            Surfaces::fit(
                segment.points,
                &segment.origin,
                spacing,
                URG_NOISE.per_m,
                CELL_M,
            )
        })
        .collect();
    let flat: Vec<&SurfacePatch> = surfaces
        .iter()
        .flat_map(|s| s.patches.iter().filter(|p| p.flat))
        .collect();
    let mut planes = group_cells(flat, tolerance);
    let mut plane_of_point = Vec::new();
    for (segment, surfaces) in segments.iter().zip(&surfaces) {
        let plane_of_patch: Vec<Option<usize>> = surfaces
            .patches
            .iter()
            .map(|patch| only_plane(&planes, patch, tolerance))
            .collect();
        for (point, patch) in segment.points.iter().zip(&surfaces.patch_of_point) {
            let own = plane_of_patch.get(*patch as usize).copied().flatten();
            let patch = surfaces.patches.get(*patch as usize);
            plane_of_point.push(own.filter(|plane| {
                patch.is_some_and(|patch| {
                    is_on_plane(point, patch, &planes[*plane], segment, tolerance.0)
                })
            }));
        }
    }
    drop_small_planes(&mut planes, &mut plane_of_point);
    (planes, plane_of_point)
}

/// Removes planes with few beams, because most of their cells belong to another plane as well.
fn drop_small_planes(planes: &mut Vec<CalibrationPlane>, plane_of_point: &mut [Option<usize>]) {
    let mut beams = vec![0_usize; planes.len()];
    plane_of_point.iter().flatten().for_each(|p| beams[*p] += 1);
    let mut next = 0;
    let kept: Vec<Option<usize>> = beams
        .iter()
        .map(|n| {
            (*n >= MIN_PLANE_BEAMS).then(|| {
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

/// Groups cells into planes, those with the most cells first.
fn group_cells(mut remaining: Vec<&SurfacePatch>, tolerance: (f64, f64)) -> Vec<CalibrationPlane> {
    let mut planes = Vec::new();
    while planes.len() < MAX_PLANES && remaining.len() >= MIN_PLANE_CELLS {
        let stride = remaining.len().div_ceil(PLANE_TRIALS);
        let best = remaining
            .iter()
            .step_by(stride)
            .map(|seed| CalibrationPlane {
                normal: seed.normal,
                offset_m: seed.offset_m,
            })
            .map(|plane| {
                (
                    remaining
                        .iter()
                        .filter(|p| plane.contains(p, tolerance))
                        .count(),
                    plane,
                )
            })
            .max_by_key(|(count, _)| *count);
        let Some((_, mut plane)) = best else { break };
        let mut members: Vec<&SurfacePatch> = Vec::new();
        let mut determined = true;
        for _ in 0..3 {
            members = remaining
                .iter()
                .filter(|p| plane.contains(p, tolerance))
                .copied()
                .collect();
            match CalibrationPlane::fit(&members).filter(|_| members.len() >= MIN_PLANE_CELLS) {
                Some(better) => plane = better,
                None => {
                    determined = false;
                    break;
                }
            }
        }
        let before = remaining.len();
        remaining.retain(|p| !plane.contains(p, tolerance));
        if determined {
            planes.push(plane);
        } else if members.len() < MIN_PLANE_CELLS || remaining.len() == before {
            break;
        }
    }
    planes
}

/// The plane of a cell; `None` for a cell on two planes.
fn only_plane(
    planes: &[CalibrationPlane],
    patch: &SurfacePatch,
    tolerance: (f64, f64),
) -> Option<usize> {
    if !patch.flat {
        return None;
    }
    let mut candidates = planes
        .iter()
        .enumerate()
        .filter(|(_, plane)| plane.contains(patch, tolerance))
        .map(|(i, _)| i);
    let first = candidates.next()?;
    candidates.next().is_none().then_some(first)
}

/// Whether a point lies on the plane of its cell and was not measured at a grazing angle.
fn is_on_plane(
    point: &Point3<f64>,
    patch: &SurfacePatch,
    plane: &CalibrationPlane,
    segment: &PanSegmentPoints<'_>,
    max_distance_m: f64,
) -> bool {
    let ray = point - segment.origin;
    let range_m = ray.norm();
    let cos = ray.dot(&plane.normal).abs() / range_m.max(1e-9);
    cos > MIN_INCIDENCE_COS
        && patch.height_m(point).abs() < MAX_CELL_DISTANCE_SIGMAS * URG_NOISE.sigma_m(range_m)
        && plane.height_m(point).abs() < 2.0 * max_distance_m
}
