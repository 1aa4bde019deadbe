//! The surfaces a view shows: points thinned to cells, and the plane that each cell lies on.

use super::principal::Principal;
use super::{Grid, Voxels, thin};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

/// Fewest cells that can say whether a place is flat.
const FEWEST_NEIGHBOURS: usize = 6;
/// Largest ratio of thickness to the smaller width (standard deviations) of a flat place.
const FLAT_RATIO: f64 = 0.25;
/// Smallest ratio of the two widths: below, neighbours lie along one scan line and fix no plane.
const NARROW_RATIO: f64 = 0.2;
/// Most surface of one ray, in squares of its distance to the next.
const SHALLOW: f64 = 4.0;
/// A neighbourhood spans this many row spacings to either side.
const LINES_SPANNED: f64 = 1.6;
/// A neighbourhood that noise makes thick reaches this many standard deviations of a range: a disc of radius r has r / 2
/// along its axes, which a flat place exceeds by [`FLAT_RATIO`], with a quarter to spare.
const WIDE_SIGMAS: f64 = 10.0;
/// What is thicker than this many standard deviations of a range is so by its shape.
const THICK_SIGMAS: f64 = 2.0;
/// Fewest patches that are worth a task of their own.
const FEWEST_PER_TASK: usize = 256;
/// How much further to look where neighbours lie along one scan line.
const WIDER: f64 = 2.5;

/// One thinning cell with the surface around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Mean of the cell's points, metres.
    pub mean: Point3<f64>,
    /// Number of cells that the plane was taken from.
    pub neighbours: usize,
    /// Number of points in the cell.
    pub count: usize,
    /// Visible surface that the cell's points stand for, square metres: their share of the disc around
    /// them. Free of how beams crowd and of how cells cut the surface.
    pub area_m2: f64,
    /// Unit normal of the surrounding surface, turned towards the sensor.
    pub normal: Vector3<f64>,
    /// Offset of the surrounding surface's mean along the normal: a place `x` lies
    /// `normal . x - offset_m` metres above the plane.
    pub offset_m: f64,
    /// Root mean square height of the neighbours over the plane, metres.
    pub roughness_m: f64,
    /// Radius over which the surface was taken, metres.
    pub radius_m: f64,
    /// Whether the neighbours fix a plane and lie on it.
    pub flat: bool,
}

impl Patch {
    /// Signed height of `place` over the plane, metres; positive on the sensor's side.
    pub fn height_m(&self, place: &Point3<f64>) -> f64 {
        self.normal.dot(&place.coords) - self.offset_m
    }
}

/// All patches of a view.
#[derive(Debug, Clone)]
pub struct Surfaces {
    /// One patch per occupied thinning cell, ordered by each cell's first point.
    pub patches: Vec<Patch>,
    /// The patch that holds each point of the view.
    pub patch_of_point: Vec<u32>,
    /// Finds patches by their mean.
    pub grid: Grid,
    /// Finds the patch whose cell holds a place.
    pub voxels: Voxels,
    /// Edge of the thinning cells, metres.
    pub cell_m: f64,
}

impl Surfaces {
    /// Thins `points` to cells of `cell_m` and fits a plane around each. The neighbourhood of a
    /// place at range r from `origin` reaches `max(3 cells, 1.6 spacing_rad r)`, so that it spans neighbouring scan lines,
    /// and further where it is no thicker than noise and yet not wide against it, but never further than 1 m. `scatter` is
    /// the standard deviation of ranges as a share of the range.
    pub fn of(
        points: &[Point3<f64>],
        origin: &Point3<f64>,
        spacing_rad: f64,
        scatter: f64,
        cell_m: f64,
    ) -> Self {
        let thinned = thin(points, cell_m);
        let grid = Grid::new(&thinned.points, 2.0 * cell_m);
        let cells = Cells {
            means: &thinned.points,
            counts: &thinned.counts,
            grid: &grid,
        };
        let patches = (0..thinned.points.len())
            .into_par_iter()
            .with_min_len(FEWEST_PER_TASK)
            .map(|at| {
                let mean = &thinned.points[at];
                let range_m = (mean - origin).norm();
                let radius_m = (LINES_SPANNED * spacing_rad * range_m)
                    .max(3.0 * cell_m)
                    .min(1.0_f64.max(3.0 * cell_m));
                // A lone point stands for its own gap between rays, met at a shallow angle.
                let most_m2 = (SHALLOW * (spacing_rad * range_m).powi(2)).max(cell_m.powi(2));
                patch(&cells, at, origin, [radius_m, scatter * range_m], most_m2)
            })
            .collect();
        Self {
            patches,
            patch_of_point: thinned.member_of,
            grid,
            voxels: thinned.voxels,
            cell_m,
        }
    }
}

/// The patch of cell `at`, seen from `origin`, from its surroundings within `radius_m`, ranges erring by `sigma_m`; one of
/// its points stands for `most_m2` at most.
fn patch(
    cells: &Cells<'_>,
    at: usize,
    origin: &Point3<f64>,
    [radius_m, sigma_m]: [f64; 2],
    most_m2: f64,
) -> Patch {
    let (mean, count) = (&cells.means[at], cells.counts[at] as usize);
    let near = Neighbourhood::of(cells, mean, radius_m);
    let noisy_m = (WIDE_SIGMAS * sigma_m).min(1.0);
    let around = if near.one_line() && radius_m < 1.0 {
        // Scan lines lie further apart on a surface met at a shallow angle.
        Neighbourhood::of(cells, mean, (WIDER * radius_m).min(1.0))
    } else if !near.flat() && noisy_m > radius_m && near.deviations[0] < THICK_SIGMAS * sigma_m {
        Neighbourhood::of(cells, mean, noisy_m)
    } else {
        near
    };
    let mut normal = around.normal;
    if normal.dot(&(origin - mean)) < 0.0 {
        normal = -normal;
    }
    Patch {
        mean: *mean,
        neighbours: around.n as usize,
        count,
        area_m2: count as f64
            * (std::f64::consts::PI * around.radius_m.powi(2) / around.points.max(1.0))
                .min(most_m2),
        normal,
        offset_m: normal.dot(&(mean + around.shift).coords),
        roughness_m: around.deviations[0],
        radius_m: around.radius_m,
        flat: around.flat(),
    }
}

/// All thinning cells of a view.
struct Cells<'a> {
    means: &'a [Point3<f64>],
    counts: &'a [u32],
    grid: &'a Grid,
}

/// The cells around a place and their principal axes.
struct Neighbourhood {
    n: f64,
    points: f64,
    radius_m: f64,
    shift: Vector3<f64>,
    normal: Vector3<f64>,
    /// Standard deviations along the principal axes, ascending, metres.
    deviations: [f64; 3],
}

impl Neighbourhood {
    fn of(cells: &Cells<'_>, mean: &Point3<f64>, radius_m: f64) -> Self {
        let mut n = 0.0;
        let mut points = 0;
        let mut sum = [0.0; 3];
        let mut square = [0.0; 6];
        cells.grid.for_each_within(mean, radius_m, |i, _| {
            let d = cells.means[i] - mean;
            n += 1.0;
            points += cells.counts[i];
            sum[0] += d.x;
            sum[1] += d.y;
            sum[2] += d.z;
            square[0] += d.x * d.x;
            square[1] += d.x * d.y;
            square[2] += d.x * d.z;
            square[3] += d.y * d.y;
            square[4] += d.y * d.z;
            square[5] += d.z * d.z;
        });
        let shift = Vector3::from(sum) / n;
        let [xx, xy, xz, yy, yz, zz] = square;
        let covariance =
            Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) / n - shift * shift.transpose();
        let principal = Principal::of(&covariance);
        Self {
            n,
            points: f64::from(points),
            radius_m,
            shift,
            normal: principal.least_axis,
            deviations: principal.variances.map(f64::sqrt),
        }
    }

    /// Whether the cells fix a plane and lie on it.
    fn flat(&self) -> bool {
        self.n >= FEWEST_NEIGHBOURS as f64
            && self.deviations[0] < FLAT_RATIO * self.deviations[1]
            && self.deviations[1] > NARROW_RATIO * self.deviations[2]
    }

    /// Whether the cells lie along one line, and so fix no plane.
    fn one_line(&self) -> bool {
        self.n < FEWEST_NEIGHBOURS as f64 || self.deviations[1] <= NARROW_RATIO * self.deviations[2]
    }
}

#[cfg(test)]
mod tests {
    use super::Surfaces;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn a_wall_is_flat_and_faces_the_sensor() {
        let wall: Vec<Point3<f64>> = (0..1600)
            .map(|i| {
                Point3::new(
                    2.0,
                    f64::from(i % 40) * 0.025 - 0.5,
                    f64::from(i / 40) * 0.025 - 0.5,
                )
            })
            .collect();
        let surfaces = Surfaces::of(&wall, &Point3::origin(), 0.01, 0.0, 0.05);
        assert!(surfaces.patches.iter().all(|p| p.flat));
        for p in &surfaces.patches {
            assert!((p.normal + Vector3::x()).norm() < 1e-9);
            assert!((p.height_m(&Point3::new(1.5, 0.0, 0.0)) - 0.5).abs() < 1e-9);
        }
        let counted: usize = surfaces.patches.iter().map(|p| p.count).sum();
        assert_eq!(counted, wall.len());
    }
}
