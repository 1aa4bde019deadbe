//! The surface that both views could see, cell by cell, and how the reference's components share it.

use super::compared_view::ComparedView;
use super::{NoveltyError, Visibility};
use crate::mixture::{EmSettings, Mixture, RefitSettings, Unexplained, refit};
use nalgebra::Point3;

/// Cells, each with the area of surface (or the number of beams) that it represents.
#[derive(Debug, Default)]
pub(super) struct WeightedCells {
    /// In the reference's frame.
    pub points: Vec<Point3<f64>>,
    pub areas_m2: Vec<f64>,
}

impl WeightedCells {
    pub(super) fn push(&mut self, point: Point3<f64>, area_m2: f64) {
        self.points.push(point);
        self.areas_m2.push(area_m2);
    }

    /// Adds all of `cells`, their areas times `factor`.
    pub(super) fn extend(&mut self, cells: &Self, factor: f64) {
        self.points.extend_from_slice(&cells.points);
        self.areas_m2
            .extend(cells.areas_m2.iter().map(|a| a * factor));
    }
}

/// The surface of one view that the other could see.
pub(super) struct VisibleSurface {
    /// Cells that both views saw.
    pub common: WeightedCells,
    /// Cells that the other view did not surely see.
    pub unsure: WeightedCells,
    /// Cells with points in free space of the other view that are in no segment.
    pub deviating: WeightedCells,
    /// Area of `common`.
    pub background_m2: f64,
    /// Area of each segment.
    pub segments_m2: Vec<f64>,
    /// Number of equal samples that the weights of `common` are worth.
    pub samples: f64,
    /// Share of the view's surface that the other could see.
    pub overlap: f64,
}

impl VisibleSurface {
    /// Adds up the cells of `view`.
    pub(super) fn new(view: &ComparedView<'_>) -> Self {
        let surfaces = &view.prepared.surfaces;
        // Points of each cell that are on a surface of the other view, in its free space, and in range.
        let mut on_surface = vec![0.0; surfaces.patches.len()];
        let mut free_space = vec![0.0; surfaces.patches.len()];
        let mut in_range = vec![0.0; surfaces.patches.len()];
        for (cell, visibility) in surfaces.patch_of_point.iter().zip(view.visibility) {
            // Points in free space that are in no segment are noise: they have no weight on either side.
            if *visibility == Visibility::OnSurface {
                on_surface[*cell as usize] += 1.0;
            }
            if *visibility == Visibility::FreeSpace {
                free_space[*cell as usize] += 1.0;
            }
            if *visibility != Visibility::OutOfRange {
                in_range[*cell as usize] += 1.0;
            }
        }
        let area_per_point_m2 = |cell: u32| {
            let patch = &surfaces.patches[cell as usize];
            patch.area_m2 / patch.count.max(1) as f64
        };
        let mut segments_m2 = Vec::with_capacity(view.segments.len());
        for point_indices in view.segments {
            let mut area_m2 = 0.0;
            for i in point_indices {
                let cell = surfaces.patch_of_point[*i];
                area_m2 += area_per_point_m2(cell);
                match view.visibility[*i] {
                    Visibility::OnSurface => on_surface[cell as usize] -= 1.0,
                    Visibility::FreeSpace => free_space[cell as usize] -= 1.0,
                    Visibility::OutOfView | Visibility::Occluded | Visibility::OutOfRange => {}
                }
            }
            segments_m2.push(area_m2);
        }
        let mut common = WeightedCells::default();
        let (mut unsure, mut deviating) = (WeightedCells::default(), WeightedCells::default());
        for (cell, n) in on_surface.iter().enumerate() {
            let patch = &surfaces.patches[cell];
            let point = view.reference_from_own.apply(&patch.mean);
            let area_m2 = area_per_point_m2(cell as u32);
            if *n > 0.0 {
                common.push(point, n * area_m2);
            }
            if free_space[cell] > 0.0 {
                deviating.push(point, free_space[cell] * area_m2);
            }
            if *n < in_range[cell] {
                unsure.push(point, (in_range[cell] - n.max(0.0)) * area_m2);
            }
        }
        let background_m2: f64 = common.areas_m2.iter().sum();
        let squares: f64 = common.areas_m2.iter().map(|w| w * w).sum();
        let visible_m2 = background_m2 + segments_m2.iter().sum::<f64>();
        let in_range_m2: f64 = in_range
            .iter()
            .enumerate()
            .map(|(cell, n)| n * area_per_point_m2(cell as u32))
            .sum();
        Self {
            samples: background_m2 * background_m2 / squares.max(f64::MIN_POSITIVE),
            common,
            unsure,
            deviating,
            background_m2,
            segments_m2,
            overlap: visible_m2 / in_range_m2.max(f64::MIN_POSITIVE),
        }
    }

    /// Area of background and segments.
    pub(super) fn total_m2(&self) -> f64 {
        self.background_m2 + self.segments_m2.iter().sum::<f64>()
    }
}

/// Area of `cells` that falls to each component of `mixture`, square metres: one M step from the mixture's weights, so that
/// each cell is shared out as the mixture would share it. More steps let overlapping components take weight from one another
/// for no reason of the scene.
pub(super) fn shared_areas(
    mixture: &Mixture,
    cells: &WeightedCells,
) -> Result<Vec<f64>, NoveltyError> {
    let total_m2: f64 = cells.areas_m2.iter().sum();
    if cells.points.is_empty() || total_m2 <= 0.0 {
        return Ok(vec![0.0; mixture.len()]);
    }
    let settings = RefitSettings {
        em: EmSettings {
            iterations: 1,
            tolerance: 0.0,
            ..RefitSettings::default().em
        },
        ..RefitSettings::default()
    };
    let refitted = refit(
        mixture,
        &cells.points,
        Some(&cells.areas_m2),
        Unexplained::Listed(&[]),
        &settings,
    )?;
    let weights = refitted.mixture.weights;
    Ok(weights.into_iter().map(|w| w * total_m2).collect())
}
