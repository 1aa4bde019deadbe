//! The surfaces of a view: points cloud to cells, and a plane fitted around each cell.

use super::constants::{
    MAX_FLAT_RATIO, MAX_NOISE_THICKNESS_SIGMAS, MAX_PATCH_DISCS, MAX_PATCH_RADIUS_M,
    MAX_RAY_AREA_SPACINGS2, MIN_PATCH_CELLS, MIN_PLANE_CELLS, MIN_WIDTH_RATIO, NOISY_PATCH_SIGMAS,
    ONE_LINE_FACTOR, PATCH_SPACINGS,
};
use super::principal_axes::PrincipalAxes;
use super::{PointGrid, VoxelTable, voxel_downsample};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

/// Patches per parallel task.
const MIN_PATCHES_PER_TASK: usize = 256;

/// A thinning cell with the plane around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfacePatch {
    /// Mean of the cell's points, metres.
    pub(crate) mean: Point3<f64>,
    /// Number of cells that the plane was fitted to.
    pub(crate) neighbours: usize,
    /// Number of points in the cell.
    pub(crate) count: usize,
    /// Visible surface that the cell's points represent, square metres: their share of the disc around them. Independent of
    /// the density of beams and of how cells cut the surface.
    pub(crate) area_m2: f64,
    /// Unit normal of the plane, towards the sensor.
    pub(crate) normal: Vector3<f64>,
    /// Offset of the plane along the normal: a point `x` lies `normal . x - offset_m` metres above it.
    pub(crate) offset_m: f64,
    /// Root mean square height of the cells over the plane, metres.
    pub(crate) roughness_m: f64,
    /// Radius over which the plane was fitted, metres.
    pub(crate) radius_m: f64,
    /// Whether the cells fix a plane and lie on it.
    pub(crate) flat: bool,
}

impl SurfacePatch {
    /// Signed height of `p` over the plane, metres; positive on the sensor's side.
    pub(crate) fn height_m(&self, p: &Point3<f64>) -> f64 {
        self.normal.dot(&p.coords) - self.offset_m
    }
}

/// The patches of a view.
#[derive(Debug, Clone)]
pub struct Surfaces {
    /// One patch per occupied thinning cell, ordered by each cell's first point.
    pub(crate) patches: Vec<SurfacePatch>,
    /// The patch that holds each point of the view.
    pub(crate) patch_of_point: Vec<u32>,
    /// Finds patches by their mean.
    pub(crate) grid: PointGrid,
    /// Finds the patch whose cell holds a point.
    pub(crate) voxels: VoxelTable,
    /// Edge of the thinning cells, metres.
    pub cell_m: f64,
}

impl Surfaces {
    /// Thins `points` to cells of `cell_m` and fits a plane around each. The neighbourhood of a cell at range r from
    /// `origin` has the radius `max(3 cells, 1.6 spacing_rad r)`, so that it spans neighbouring scan lines. It is widened,
    /// to 1 m at most, where it is no thicker than noise and yet not wide against it. `relative_noise` is the standard
    /// deviation of ranges as a share of the range.
    pub(crate) fn fit(
        points: &[Point3<f64>],
        origin: &Point3<f64>,
        spacing_rad: f64,
        relative_noise: f64,
        cell_m: f64,
    ) -> Self {
        let cloud = voxel_downsample(points, cell_m);
        let grid = PointGrid::new(&cloud.points, 2.0 * cell_m);
        let cells = Cells {
            means: &cloud.points,
            counts: &cloud.counts,
            grid: &grid,
            cell_m,
        };
        let patches = (0..cloud.points.len())
            .into_par_iter()
            .with_min_len(MIN_PATCHES_PER_TASK)
            .map(|at| {
                let mean = &cloud.points[at];
                let range_m = (mean - origin).norm();
                let radius_m = (PATCH_SPACINGS * spacing_rad * range_m)
                    .max(MIN_PATCH_CELLS * cell_m)
                    .min(MAX_PATCH_RADIUS_M.max(MIN_PATCH_CELLS * cell_m));
                // A lone point represents its own gap between rays, met at a shallow angle.
                let max_ray_area_m2 =
                    (MAX_RAY_AREA_SPACINGS2 * (spacing_rad * range_m).powi(2)).max(cell_m.powi(2));
                patch(
                    &cells,
                    at,
                    origin,
                    [radius_m, relative_noise * range_m],
                    max_ray_area_m2,
                )
            })
            .collect();
        Self {
            patches,
            patch_of_point: cloud.voxel_of_point,
            grid,
            voxels: cloud.voxels,
            cell_m,
        }
    }
}

/// The patch of cell `at`, seen from `origin`, from the cells within `radius_m`; `sigma_m` is the standard deviation of
/// ranges, `max_ray_area_m2` the largest area of one point.
fn patch(
    cells: &Cells<'_>,
    at: usize,
    origin: &Point3<f64>,
    [radius_m, sigma_m]: [f64; 2],
    max_ray_area_m2: f64,
) -> SurfacePatch {
    let (mean, count) = (&cells.means[at], cells.counts[at] as usize);
    let near = Neighbourhood::of_surface(cells, mean, radius_m);
    let noisy_m = (NOISY_PATCH_SIGMAS * sigma_m).min(MAX_PATCH_RADIUS_M);
    let around = if near.is_one_line() && radius_m < MAX_PATCH_RADIUS_M {
        // Scan lines lie further apart on a surface met at a shallow angle.
        Neighbourhood::of_surface(
            cells,
            mean,
            (ONE_LINE_FACTOR * radius_m).min(MAX_PATCH_RADIUS_M),
        )
    } else if !near.is_flat()
        && noisy_m > radius_m
        && near.deviations[0] < MAX_NOISE_THICKNESS_SIGMAS * sigma_m
    {
        Neighbourhood::of_surface(cells, mean, noisy_m)
    } else {
        near
    };
    let mut normal = around.normal;
    if normal.dot(&(origin - mean)) < 0.0 {
        normal = -normal;
    }
    SurfacePatch {
        mean: *mean,
        neighbours: around.n as usize,
        count,
        area_m2: count as f64
            * (std::f64::consts::PI * around.radius_m.powi(2) / around.points.max(1.0))
                .min(max_ray_area_m2),
        normal,
        offset_m: normal.dot(&(mean + around.shift).coords),
        roughness_m: around.deviations[0],
        radius_m: around.radius_m,
        flat: around.is_flat(),
    }
}

/// All thinning cells of a view.
struct Cells<'a> {
    means: &'a [Point3<f64>],
    counts: &'a [u32],
    grid: &'a PointGrid,
    cell_m: f64,
}

/// The cells around a point and their principal axes.
struct Neighbourhood {
    /// Number of cells.
    n: f64,
    /// Number of points in them.
    points: f64,
    radius_m: f64,
    /// From the point to the mean of the cells.
    shift: Vector3<f64>,
    normal: Vector3<f64>,
    /// Standard deviations along the principal axes, ascending, metres.
    deviations: [f64; 3],
}

impl Neighbourhood {
    /// The cells within `radius_m`; where they are more than surfaces can have, and so fill a volume, those of the smallest
    /// neighbourhood. Its cost is that of a surface for any points.
    fn of_surface(cells: &Cells<'_>, mean: &Point3<f64>, radius_m: f64) -> Self {
        let least_m = (MIN_PATCH_CELLS * cells.cell_m).min(radius_m);
        let max_cells = MAX_PATCH_DISCS * std::f64::consts::PI * (radius_m / cells.cell_m).powi(2);
        let near = Self::new(cells, mean, radius_m, max_cells);
        if near.n > max_cells {
            return Self::new(cells, mean, least_m, f64::INFINITY);
        }
        near
    }

    /// The cells within `radius_m`, or the first of them if they are more than `max_cells`.
    fn new(cells: &Cells<'_>, mean: &Point3<f64>, radius_m: f64, max_cells: f64) -> Self {
        let mut n = 0.0;
        let mut points = 0;
        let mut sum = [0.0; 3];
        let mut square = [0.0; 6];
        cells.grid.for_each_within_while(mean, radius_m, |i, _| {
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
            n <= max_cells
        });
        let shift = Vector3::from(sum) / n;
        let [xx, xy, xz, yy, yz, zz] = square;
        let covariance =
            Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) / n - shift * shift.transpose();
        let axes = PrincipalAxes::from_covariance(&covariance);
        Self {
            n,
            points: f64::from(points),
            radius_m,
            shift,
            normal: axes.smallest_axis,
            deviations: axes.variances.map(f64::sqrt),
        }
    }

    /// Whether the cells fix a plane and lie on it.
    fn is_flat(&self) -> bool {
        self.n >= MIN_PLANE_CELLS as f64
            && self.deviations[0] < MAX_FLAT_RATIO * self.deviations[1]
            && self.deviations[1] > MIN_WIDTH_RATIO * self.deviations[2]
    }

    /// Whether the cells lie along one line, and so fix no plane.
    fn is_one_line(&self) -> bool {
        self.n < MIN_PLANE_CELLS as f64
            || self.deviations[1] <= MIN_WIDTH_RATIO * self.deviations[2]
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_PATCH_RADIUS_M, Surfaces};
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
        let surfaces = Surfaces::fit(&wall, &Point3::origin(), 0.01, 0.0, 0.05);
        assert!(surfaces.patches.iter().all(|p| p.flat));
        for p in &surfaces.patches {
            assert!((p.normal + Vector3::x()).norm() < 1e-9);
            assert!((p.height_m(&Point3::new(1.5, 0.0, 0.0)) - 0.5).abs() < 1e-9);
        }
        let counted: usize = surfaces.patches.iter().map(|p| p.count).sum();
        assert_eq!(counted, wall.len());
    }

    #[test]
    fn a_volume_of_points_is_judged_by_few_of_them() {
        // A ball of 0.7 m full of cells, its rows so far apart that neighbourhoods would reach through all of it.
        let side = -14..=14;
        let points: Vec<Point3<f64>> = side
            .clone()
            .flat_map(|x| side.clone().map(move |y| (x, y)))
            .flat_map(|(x, y)| side.clone().map(move |z| [x, y, z]))
            .map(|p| Point3::from(p.map(|k| 0.05 * (f64::from(k) + 0.5))))
            .collect();
        let cell_m = 0.05;
        let origin = Point3::new(-5.0, 0.0, 0.0);
        let surfaces = Surfaces::fit(&points, &origin, 0.5, 0.0, cell_m);
        let middle = surfaces
            .patches
            .iter()
            .find(|p| p.mean.coords.norm() < 0.05);
        let middle = middle.expect("a cell");
        // The 123 grid places within three cells, not the 24,389 within a metre.
        assert!(
            (100..=150).contains(&middle.neighbours),
            "{}",
            middle.neighbours
        );
        assert!(!middle.flat && middle.radius_m < 0.2);
        // A wall of the same cells is taken to the full radius.
        let wall: Vec<Point3<f64>> = points
            .iter()
            .copied()
            .filter(|p| p.x.abs() < 0.03)
            .collect();
        let surfaces = Surfaces::fit(&wall, &origin, 0.5, 0.0, cell_m);
        assert!(
            surfaces
                .patches
                .iter()
                .all(|p| p.flat && p.radius_m == MAX_PATCH_RADIUS_M)
        );
    }
}
