//! Whether the other view looked through a point, and how surely (`docs/novelty.md section 5`).
//!
//! A point is evidence of change only where the other view's rays pass on all sides of it and end well behind it, and where
//! no surface that the other view saw runs through it.

use super::noise::CrossViewNoise;
use super::{Evidence, EvidenceSettings, PreparedView, Visibility};
use crate::geometry::{DriftTransform, FieldOfViewBounds, Registration, SurfacePatch};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

/// Deviations up to this many sigmas are not evaluated further: less than segments grow to.
const NO_DEVIATION_SIGMAS: f64 = 2.4;

const MIN_POINTS_PER_TASK: usize = 1024;

/// Evaluates one view's points by another's rays.
pub(super) struct VisibilityTest<'a> {
    /// The view whose rays are used.
    pub other: &'a PreparedView,
    pub other_from_own: DriftTransform,
    /// The view whose points are evaluated.
    pub own: &'a PreparedView,
    /// Noise between the views, where known; it may exceed that of both.
    pub cross_view_noise: Option<CrossViewNoise>,
    pub registration: &'a Registration,
    /// To the frame in which the registration's covariance is given.
    pub reference_from_own: DriftTransform,
    /// Field of view of the other view, if it does not record directions without return.
    pub field_of_view: Option<FieldOfViewBounds>,
    pub settings: &'a EvidenceSettings,
}

impl VisibilityTest<'_> {
    /// Evidence of each own point, in their order.
    pub(super) fn evaluate(&self) -> Vec<Evidence> {
        let points = &self.own.view.points;
        points
            .par_iter()
            .enumerate()
            .with_min_len(MIN_POINTS_PER_TASK)
            .map(|(i, p)| {
                let evidence = self.evaluate_point(p, &self.own.view.origin);
                if evidence.no_return && self.is_grazing(i) {
                    return Evidence::none(Visibility::OutOfView);
                }
                evidence
            })
            .collect()
    }

    /// Whether the other view would have met the surface of own point `i` at such a flat angle that there may be no return.
    fn is_grazing(&self, i: usize) -> bool {
        let other_origin = self.other_from_own.pose.inverse() * self.other.rays.origin();
        self.own
            .is_grazed(i, &other_origin, self.settings.grazing_cos)
    }

    /// Evidence of a point in the frame of the own view, which need not be one of its points.
    pub(super) fn evaluate_point(&self, own: &Point3<f64>, own_origin: &Point3<f64>) -> Evidence {
        let p = self.other_from_own.apply(own);
        let rays = &self.other.rays;
        let offset = p - rays.origin();
        let range_m = offset.norm();
        if range_m < 1e-6 {
            return Evidence::none(Visibility::OutOfView);
        }
        let d = offset / range_m;
        let own_range_m = (own - own_origin).norm();
        let noise_m = self.noise_m(own_range_m, range_m);
        if self.on_surface(&p, &d, range_m, noise_m) {
            return Evidence::none(Visibility::OnSurface);
        }
        let around = rays.neighbours(&d);
        let hole_rad = self.settings.hole_spacings * rays.spacing_rad;
        let Some((nearest, _)) = around.nearest.filter(|n| n.1 <= hole_rad) else {
            return self.evaluate_without_ray(&p, &d, range_m, noise_m, own);
        };
        if !around.are_all_around(rays.spacing_rad) && !self.is_inside_field(&d, range_m) {
            return Evidence::none(Visibility::OutOfView);
        }
        let uncertainty = self.uncertainty(own, noise_m);
        let mut shortest_m = f64::INFINITY;
        let mut longest_m = 0.0_f64;
        for (ray, _) in around.sectors.iter().flatten() {
            let r = self.end_m(*ray);
            shortest_m = shortest_m.min(r);
            longest_m = longest_m.max(r);
        }
        let mut z = f64::INFINITY;
        let mut occluded = false;
        for (ray, _) in around.sectors.iter().flatten() {
            let (gap, sigma) = self.gap(*ray, &d, range_m, (shortest_m, longest_m), &uncertainty);
            z = z.min(gap / sigma);
            occluded |= gap < -5.0 * sigma;
        }
        let (gap, sigma) = self.gap(nearest, &d, range_m, (shortest_m, longest_m), &uncertainty);
        let z_nearest = gap / sigma;
        if z_nearest <= NO_DEVIATION_SIGMAS && z <= NO_DEVIATION_SIGMAS {
            return Evidence::none(if occluded {
                Visibility::Occluded
            } else {
                Visibility::OnSurface
            });
        }
        let z_surface = self.off_surface(&p, &d, &uncertainty);
        let max_sigmas = self.settings.max_sigmas;
        Evidence {
            z_loose: z_nearest.min(z_surface).clamp(0.0, max_sigmas),
            no_return: self.other.is_without_return(nearest),
            ..Evidence::from_deviation(z.min(z_surface).clamp(0.0, max_sigmas))
        }
    }

    /// Whether the point is clearly on a surface that the other view saw in the same cell or a neighbouring one. Most points
    /// are, and need no further evaluation.
    fn on_surface(&self, p: &Point3<f64>, d: &Vector3<f64>, range_m: f64, noise_m: f64) -> bool {
        let surfaces = &self.other.surfaces;
        let lateral_m = surfaces.cell_m + self.other.rays.spacing_rad * range_m;
        let on = |cell_point: &Point3<f64>| {
            let patch = surfaces
                .voxels
                .find(cell_point)
                .and_then(|cell| surfaces.patches.get(cell));
            patch.is_some_and(|patch| {
                let off2 = (patch.mean - p).norm_squared();
                if !patch.flat {
                    let within_m = 0.5 * surfaces.cell_m + NO_DEVIATION_SIGMAS * noise_m;
                    return off2 < within_m * within_m;
                }
                let across_m = patch.normal.dot(d) * noise_m;
                // The uncertainty of the registration would only widen this.
                let sigma_m = self.height_sigma_m(across_m, 0.0, patch);
                patch.height_m(p).abs() < NO_DEVIATION_SIGMAS * sigma_m
                    && off2 < lateral_m * lateral_m
            })
        };
        on(p)
            || [0, 1, 2].into_iter().any(|axis| {
                [-surfaces.cell_m, surfaces.cell_m].into_iter().any(|step| {
                    let mut cell_point = *p;
                    cell_point[axis] += step;
                    on(&cell_point)
                })
            })
    }

    /// A direction without any ray: free space only if there are rays all around it.
    fn evaluate_without_ray(
        &self,
        p: &Point3<f64>,
        d: &Vector3<f64>,
        range_m: f64,
        noise_m: f64,
        own: &Point3<f64>,
    ) -> Evidence {
        let rays = &self.other.rays;
        let observed = (range_m <= self.other.free_m(self.settings)
            && rays.field_of_view.within_bounds(d)
            && rays.surrounds(d))
            || self.is_inside_field(d, range_m);
        if !observed {
            return Evidence::none(Visibility::OutOfView);
        }
        let z = self
            .off_surface(p, d, &self.uncertainty(own, noise_m))
            .min(self.settings.max_sigmas);
        Evidence {
            no_return: true,
            ..Evidence::from_deviation(z)
        }
    }

    /// Whether the other view, which does not record directions without return, must have looked along `d` this far.
    fn is_inside_field(&self, d: &Vector3<f64>, range_m: f64) -> bool {
        let rays = &self.other.rays;
        let margin_rad = self.settings.field_margin_spacings * rays.spacing_rad
            + self.settings.origin_error_m / range_m;
        range_m <= self.other.free_m(self.settings)
            && self
                .field_of_view
                .as_ref()
                .is_some_and(|f| f.contains(d, margin_rad))
    }

    /// Range at which a ray ends: that of its return, else [`Self::free_m`].
    fn end_m(&self, ray: usize) -> f64 {
        let range_m = self.other.rays.range_m(ray);
        if range_m.is_finite() {
            range_m
        } else {
            self.other.free_m(self.settings)
        }
    }

    /// Distance of the point in front of the surface that `ray` meets, across that surface, and its standard deviation,
    /// metres.
    fn gap(
        &self,
        ray: usize,
        d: &Vector3<f64>,
        range_m: f64,
        span_m: (f64, f64),
        uncertainty: &PositionUncertainty,
    ) -> (f64, f64) {
        let other = self.other;
        let plain = |end: f64| (end - range_m, uncertainty.sigma_m(d));
        if other.rays.range_m(ray).is_infinite() {
            return plain(self.end_m(ray));
        }
        let patch = other
            .surfaces
            .patch_of_point
            .get(ray)
            .and_then(|i| other.surfaces.patches.get(*i as usize));
        let end = other.rays.range_m(ray);
        let Some(patch) = patch.filter(|p| p.flat) else {
            return plain(end);
        };
        let incidence = -patch.normal.dot(d);
        if incidence < self.settings.min_incidence_cos {
            return plain(end);
        }
        // Height of the sensor over the plane, over the descent of the ray per metre.
        let meets_m = (patch.height_m(other.rays.origin()) / incidence).clamp(span_m.0, span_m.1);
        let sigma = self.height_sigma_m(
            incidence * uncertainty.noise_m,
            uncertainty.pose_m(&patch.normal),
            patch,
        );
        ((meets_m - range_m) * incidence, sigma)
    }

    /// Distance to the nearest surface that the other view saw, in sigmas of that direction. The pose may be uncertain along
    /// one direction alone, and range noise acts along the ray: across a surface met at a shallow angle, heights are far
    /// better known.
    fn off_surface(
        &self,
        p: &Point3<f64>,
        d: &Vector3<f64>,
        uncertainty: &PositionUncertainty,
    ) -> f64 {
        let surfaces = &self.other.surfaces;
        let max_sigmas = self.settings.max_sigmas;
        let widest_m = uncertainty.widest_m();
        let spacing_m = self.other.rays.spacing_rad * (p - self.other.rays.origin()).norm();
        let reach_m = (max_sigmas * widest_m).max(spacing_m).clamp(
            2.0 * surfaces.cell_m,
            (6.0 * surfaces.cell_m).max(8.0 * widest_m),
        );
        let mut least = reach_m / widest_m;
        surfaces.grid.for_each_within(p, reach_m, |i, d2| {
            let patch = &surfaces.patches[i];
            let off = p - patch.mean;
            let z = if patch.flat {
                // Height over the plane, and distance along it beyond the cell and the row spacing.
                let height = patch.height_m(p).abs();
                let lateral_m = (d2 - height * height).max(0.0).sqrt();
                let beyond_m = (lateral_m - surfaces.cell_m - spacing_m).max(0.0);
                let direction = off - patch.normal * patch.normal.dot(&off);
                let across = patch.normal.dot(d) * uncertainty.noise_m;
                let sigma_height =
                    self.height_sigma_m(across, uncertainty.pose_m(&patch.normal), patch);
                norm3(
                    height / sigma_height,
                    beyond_m / uncertainty.sigma_m(&direction),
                    0.0,
                )
            } else {
                (d2.sqrt() - 0.5 * surfaces.cell_m).max(0.0) / uncertainty.sigma_m(&off)
            };
            least = least.min(z);
        });
        least
    }

    /// Standard deviation of a height over `patch`.
    fn height_sigma_m(&self, across_m: f64, registration_m: f64, patch: &SurfacePatch) -> f64 {
        norm3(across_m, patch.roughness_m, registration_m)
            .max(self.cross_view_noise.map_or(0.0, |b| b.height_m))
    }

    fn noise_m(&self, own_range_m: f64, other_range_m: f64) -> f64 {
        let both = norm3(
            self.own.noise.sigma_m(own_range_m),
            self.other.noise.sigma_m(other_range_m),
            0.0,
        );
        self.cross_view_noise
            .map_or(both, |law| both.max(law.ranges.sigma_m(other_range_m)))
    }

    /// Uncertainty of the position of an own point, in the other view's frame.
    fn uncertainty(&self, own: &Point3<f64>, noise_m: f64) -> PositionUncertainty {
        let reference_from_other =
            self.reference_from_own.pose.rotation * self.other_from_own.pose.rotation.inverse();
        let rotation = reference_from_other.to_rotation_matrix().into_inner();
        let point = self.reference_from_own.apply(own);
        PositionUncertainty {
            noise_m,
            pose_m2: rotation.transpose() * self.registration.covariance_at(&point) * rotation,
        }
    }
}

struct PositionUncertainty {
    /// Standard deviation of the ranges of both views.
    noise_m: f64,
    /// Covariance of the registration at the point.
    pose_m2: Matrix3<f64>,
}

impl PositionUncertainty {
    /// Standard deviation of the registration along `direction`, which need not be a unit vector.
    fn pose_m(&self, direction: &Vector3<f64>) -> f64 {
        let variance =
            direction.dot(&(self.pose_m2 * direction)) / direction.norm_squared().max(1e-18);
        variance.max(0.0).sqrt()
    }

    /// The same with the noise of the ranges, taken as equal in all directions.
    fn sigma_m(&self, direction: &Vector3<f64>) -> f64 {
        norm3(self.noise_m, self.pose_m(direction), 0.0)
    }

    /// Upper bound over all directions.
    fn widest_m(&self) -> f64 {
        norm3(self.noise_m, self.pose_m2.trace().max(0.0).sqrt(), 0.0)
    }
}

/// Square root of the sum of squares; no care for overflow.
#[inline]
fn norm3(a: f64, b: f64, c: f64) -> f64 {
    (a * a + b * b + c * c).sqrt()
}
