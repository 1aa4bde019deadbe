//! The flat patches of a reference, indexed for registration: found approximately by table lookup while the gate is wide,
//! exactly once it is narrow. Built once per reference.

use super::constants::{FINE_GATE_CELLS, TABLE_CELLS};
use super::{PointGrid, SurfacePatch, Surfaces, VoxelTable, voxel_downsample};
use nalgebra::Point3;

/// The flat patches of a reference, each the plane around one thinning cell.
#[derive(Debug, Clone)]
pub(crate) struct PlaneIndex {
    flat: Vec<SurfacePatch>,
    grid: PointGrid,
    fine: CubeTable,
    coarse: CubeTable,
    cell_m: f64,
}

impl PlaneIndex {
    /// Indexes the flat patches of `surfaces`.
    pub(crate) fn new(surfaces: &Surfaces) -> Self {
        let flat: Vec<SurfacePatch> = surfaces
            .patches
            .iter()
            .filter(|p| p.flat)
            .copied()
            .collect();
        let means: Vec<Point3<f64>> = flat.iter().map(|p| p.mean).collect();
        let [fine, coarse] =
            TABLE_CELLS.map(|cells| CubeTable::new(&means, cells * surfaces.cell_m));
        Self {
            grid: PointGrid::new(&means, 2.0 * surfaces.cell_m),
            fine,
            coarse,
            cell_m: surfaces.cell_m,
            flat,
        }
    }

    /// A plane near `p`, if `p` lies less than `gate_m` above or below it: that of the patch nearest to the centre of `p`'s
    /// cube. Off by up to a cube near corners.
    pub(crate) fn find_approximate(&self, p: &Point3<f64>, gate_m: f64) -> Option<&SurfacePatch> {
        let table = if gate_m > FINE_GATE_CELLS * self.cell_m {
            &self.coarse
        } else {
            &self.fine
        };
        let patch = &self.flat[table.find(p)?];
        (patch.height_m(p).abs() < gate_m).then_some(patch)
    }

    /// The plane of the flat patch nearest to `p`, if `p` lies less than `gate_m` above or below it.
    pub(crate) fn find_exact(&self, p: &Point3<f64>, gate_m: f64) -> Option<&SurfacePatch> {
        let (found, _) = self.grid.nearest(p, gate_m + 2.0 * self.cell_m)?;
        let patch = &self.flat[found];
        (patch.height_m(p).abs() < gate_m).then_some(patch)
    }
}

/// For each cube that holds a flat patch or touches one that does: the patch nearest to its centre.
#[derive(Debug, Clone)]
struct CubeTable {
    voxels: VoxelTable,
    patches: Vec<u32>,
}

impl CubeTable {
    fn new(means: &[Point3<f64>], edge_m: f64) -> Self {
        let cubes = voxel_downsample(means, edge_m);
        // The first patch of each cube represents it.
        let mut first = vec![u32::MAX; cubes.points.len()];
        for (i, cube) in cubes.voxel_of_point.iter().enumerate() {
            let slot = &mut first[*cube as usize];
            *slot = (*slot).min(i as u32);
        }
        let mut voxels = VoxelTable::new(edge_m, 4 * first.len());
        let mut patches: Vec<u32> = Vec::new();
        let mut nearest: Vec<f64> = Vec::new();
        for i in first {
            let mean = &means[i as usize];
            for (cell, centre) in voxels.neighbourhood(mean) {
                let cube = voxels.insert(cell, patches.len() as u32) as usize;
                let d2 = (centre - mean).norm_squared();
                if cube == patches.len() {
                    patches.push(i);
                    nearest.push(d2);
                } else if d2 < nearest[cube] {
                    patches[cube] = i;
                    nearest[cube] = d2;
                }
            }
        }
        Self { voxels, patches }
    }

    #[inline]
    fn find(&self, p: &Point3<f64>) -> Option<usize> {
        Some(self.patches[self.voxels.find(p)?] as usize)
    }
}
