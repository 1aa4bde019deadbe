//! A view prepared for comparison: rays, surfaces and noise (`docs/novelty.md section 2`).

use super::plausible_view::check_plausible;
use super::{EvidenceSettings, NoveltyError, noise};
use crate::geometry::{NoiseLaw, RayIndex, RaySet, SurfacePatch, Surfaces, View};
use crate::mixture::SplitSettings;
use nalgebra::Point3;

const MIN_POINTS: usize = 20;

/// A view with its rays, surfaces and noise.
#[derive(Debug, Clone)]
pub struct PreparedView {
    /// The view itself.
    pub view: View,
    /// Its rays, indexed by direction.
    pub rays: RayIndex,
    /// The surfaces it saw.
    pub surfaces: Surfaces,
    /// Noise of its ranges: stated by the sensor, or estimated from flat cells.
    pub noise: NoiseLaw,
    /// Median of its ranges, metres.
    pub median_range_m: f64,
    /// Rays from this index on came back, but from what the reference's mixture does not have: they surely looked along
    /// their direction. Other rays without a return may have met a surface that gives none.
    pub(super) first_denied_ray: usize,
}

impl PreparedView {
    /// Prepares `view`; `name` is for errors.
    ///
    /// # Errors
    /// Fewer than 20 points, a coordinate that is not finite, or points and origin that can be no view in metres.
    pub fn new(
        view: &View,
        name: &'static str,
        settings: &EvidenceSettings,
    ) -> Result<Self, NoveltyError> {
        let got = view.points.len();
        if got < MIN_POINTS {
            return Err(NoveltyError::TooFewPoints {
                name,
                got,
                expected: MIN_POINTS,
            });
        }
        let finite = |v: &[f64]| v.iter().all(|c| c.is_finite());
        if let Some(index) = view
            .points
            .iter()
            .position(|p| !finite(p.coords.as_slice()))
        {
            return Err(NoveltyError::NotFinite { name, index });
        }
        check_plausible(view, name)?;
        let ray_set = RaySet::from_view(view);
        let (spacing_rad, relative_noise) = (ray_set.spacing_rad, ray_set.relative_noise);
        let median_range_m = ray_set.median_range_m;
        // Not finer than the rows, and not thinner than the noise of a wall.
        let cell_m = (0.5 * spacing_rad * median_range_m)
            .max(settings.cell_sigmas * relative_noise * median_range_m)
            .clamp(settings.min_cell_m, settings.max_cell_m);
        let (rays, surfaces) = rayon::join(
            || RayIndex::new(ray_set),
            || {
                Surfaces::fit(
                    &view.points,
                    &view.origin,
                    spacing_rad,
                    relative_noise,
                    cell_m,
                )
            },
        );
        let floor = settings.noise_floor;
        let found = view
            .noise
            .or_else(|| noise::estimate(&view.points, &view.origin, &surfaces))
            .unwrap_or(floor);
        let noise = NoiseLaw {
            at_zero_m: found.at_zero_m.max(floor.at_zero_m),
            per_m: found.per_m.max(floor.per_m),
        };
        Ok(Self {
            view: view.clone(),
            rays,
            surfaces,
            noise,
            median_range_m,
            first_denied_ray: usize::MAX,
        })
    }

    /// Whether nothing came back along `ray`, and not because the reference's mixture denies what did.
    pub(super) fn is_without_return(&self, ray: usize) -> bool {
        self.rays.range_m(ray).is_infinite() && ray < self.first_denied_ray
    }

    /// Whether a beam from `sensor`, in its own frame, meets the flat surface of point `i` at grazing incidence.
    pub(super) fn is_grazed(&self, i: usize, sensor: &Point3<f64>, grazing_cos: f64) -> bool {
        let surfaces = &self.surfaces;
        let cell = surfaces.patch_of_point.get(i);
        let patch = cell.and_then(|cell| surfaces.patches.get(*cell as usize));
        patch.filter(|patch| patch.flat).is_some_and(|patch| {
            let towards = sensor - self.view.points[i];
            patch.normal.dot(&towards).abs() < grazing_cos * towards.norm()
        })
    }

    /// Range up to which a direction without return proves free space, metres.
    pub(super) fn free_m(&self, settings: &EvidenceSettings) -> f64 {
        let rays = &self.rays;
        rays.free_range_m
            .max(settings.no_return_reach_share * rays.reach_m)
    }

    /// Its visible surface up to this range, square metres.
    pub(super) fn area_within_m2(&self, max_range_m: f64) -> f64 {
        let cells = self.cells_within(max_range_m);
        cells.map(|(_, patch)| patch.area_m2).sum()
    }

    /// Its cells up to this range, with their indices. Beyond the range limit a mixture has nothing.
    pub(super) fn cells_within(
        &self,
        max_range_m: f64,
    ) -> impl Iterator<Item = (usize, &SurfacePatch)> {
        let patches = self.surfaces.patches.iter().enumerate();
        patches.filter(move |(_, patch)| (patch.mean - self.view.origin).norm() <= max_range_m)
    }

    /// How finely its surfaces are split into components.
    pub(super) fn split_settings(&self) -> SplitSettings {
        let range_m = self.median_range_m;
        SplitSettings::for_data(
            self.noise.sigma_m(range_m),
            (self.rays.spacing_rad * range_m).max(self.surfaces.cell_m),
        )
    }
}
