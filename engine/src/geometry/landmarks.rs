//! What a registration holds the current view against: the reference's flat places, found at the speed of a
//! table while the gate is wide and exactly once it is narrow. Made once per reference.

use super::{Grid, Patch, Surfaces, Voxels, thin};
use nalgebra::Point3;

/// Edges of the tables' cubes, in thinning cells: a wide gate asks the coarse one.
const TABLE_CELLS: [f64; 2] = [2.0, 8.0];
/// Gates up to this many thinning cells ask the fine table.
const FINE_GATE_CELLS: f64 = 4.0;

/// The flat places of a reference, ready to be matched.
#[derive(Debug, Clone)]
pub struct Landmarks {
    flat: Vec<Patch>,
    grid: Grid,
    fine: Table,
    coarse: Table,
    cell_m: f64,
}

impl Landmarks {
    /// The flat patches of `surfaces`.
    pub fn of(surfaces: &Surfaces) -> Self {
        let flat: Vec<Patch> = surfaces
            .patches
            .iter()
            .filter(|p| p.flat)
            .copied()
            .collect();
        let means: Vec<Point3<f64>> = flat.iter().map(|p| p.mean).collect();
        let [fine, coarse] = TABLE_CELLS.map(|cells| Table::new(&means, cells * surfaces.cell_m));
        Self {
            grid: Grid::new(&means, 2.0 * surfaces.cell_m),
            fine,
            coarse,
            cell_m: surfaces.cell_m,
            flat,
        }
    }

    /// The plane near the place `p`, if `p` is at most `gate_m` above or below it: that of the nearest place to the
    /// middle of `p`'s cube. Off by up to a cube near corners.
    pub fn roughly(&self, p: &Point3<f64>, gate_m: f64) -> Option<&Patch> {
        let table = if gate_m > FINE_GATE_CELLS * self.cell_m {
            &self.coarse
        } else {
            &self.fine
        };
        let patch = &self.flat[table.find(p)?];
        (patch.height_m(p).abs() < gate_m).then_some(patch)
    }

    /// The plane of the flat place nearest to `p`, if `p` is at most `gate_m` above or below it.
    pub fn exactly(&self, p: &Point3<f64>, gate_m: f64) -> Option<&Patch> {
        let (found, _) = self.grid.nearest(p, gate_m + 2.0 * self.cell_m)?;
        let patch = &self.flat[found];
        (patch.height_m(p).abs() < gate_m).then_some(patch)
    }
}

/// For each cube that holds a flat place or touches one that does: the place nearest to its middle.
#[derive(Debug, Clone)]
struct Table {
    voxels: Voxels,
    place: Vec<u32>,
}

impl Table {
    fn new(means: &[Point3<f64>], edge_m: f64) -> Self {
        let thinned = thin(means, edge_m);
        // The first place of each cube stands for it.
        let mut first = vec![u32::MAX; thinned.points.len()];
        for (i, cube) in thinned.member_of.iter().enumerate() {
            let slot = &mut first[*cube as usize];
            *slot = (*slot).min(i as u32);
        }
        let mut voxels = Voxels::new(edge_m, 4 * first.len());
        let mut place: Vec<u32> = Vec::new();
        let mut nearest: Vec<f64> = Vec::new();
        for i in first {
            let mean = &means[i as usize];
            for (cell, middle) in voxels.around(mean) {
                let cube = voxels.enter(cell, place.len() as u32) as usize;
                let d2 = (middle - mean).norm_squared();
                if cube == place.len() {
                    place.push(i);
                    nearest.push(d2);
                } else if d2 < nearest[cube] {
                    place[cube] = i;
                    nearest[cube] = d2;
                }
            }
        }
        Self { voxels, place }
    }

    #[inline]
    fn find(&self, p: &Point3<f64>) -> Option<usize> {
        Some(self.place[self.voxels.find(p)?] as usize)
    }
}
