//! Did the other view look through this place, and how surely?
//!
//! A point is evidence of change only where the other view's rays pass on all sides of it and end
//! well behind it, and where no surface that the other view saw runs through it. Everything else
//! is either the same surface or out of the other's sight: no change.

use super::{EvidenceSettings, Prepared, noise::Between};
use crate::geometry::{Field, Passage, Patch, Registration};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

/// Deviations below this many sigmas are not looked into further: no setting grows from so little.
const SURELY_SAME: f64 = 2.4;

/// Fewest points that are worth a task of their own.
const FEWEST_PER_TASK: usize = 1024;

/// What the other view says about a point's place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sight {
    /// Outside its field, or in a hole that proves nothing.
    Unseen,
    /// It saw a surface in front of the place.
    Hidden,
    /// It saw a surface there.
    Same,
    /// Its rays passed through the place.
    Through,
    /// Further off than is to be looked at; it says nothing and weighs nothing.
    Beyond,
}

/// A point's deviation from the other view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// What the other view says.
    pub sight: Sight,
    /// Deviation in sigmas that all rays around agree upon; 0 if not looked through.
    pub z: f64,
    /// Deviation in sigmas judged by the nearest ray alone, for points next to a sure one.
    pub z_loose: f64,
    /// Whether the other view got nothing back from there.
    pub empty: bool,
}

impl Evidence {
    /// No deviation.
    pub(super) fn none(sight: Sight) -> Self {
        Self {
            sight,
            z: 0.0,
            z_loose: 0.0,
            empty: false,
        }
    }
}

/// How one view's points are judged by another's rays.
pub struct Judge<'a> {
    /// The view whose rays judge.
    pub other: &'a Prepared,
    /// Maps the judged points to its frame.
    pub other_from_own: Passage,
    /// The view whose points are judged.
    pub own: &'a Prepared,
    /// Noise of the difference between the views where it is known to exceed both.
    pub between: Option<Between>,
    /// How surely the views lie on one another; its covariance is in the reference's frame.
    pub registration: &'a Registration,
    /// Maps the judged points to the reference's frame, in which the registration's errors are told.
    pub reference_from_own: Passage,
    /// Bounds of where the other view looked, where it does not say itself what gave nothing back.
    pub field: Option<Field>,
    /// The constants.
    pub settings: &'a EvidenceSettings,
}

impl Judge<'_> {
    /// Judges the own view's points, in their order.
    pub fn judge(&self) -> Vec<Evidence> {
        let points = &self.own.view.points;
        points
            .par_iter()
            .enumerate()
            .with_min_len(FEWEST_PER_TASK)
            .map(|(i, p)| {
                let evidence = self.judge_one(p, &self.own.view.origin);
                if evidence.empty && self.slants(i) {
                    return Evidence::none(Sight::Unseen);
                }
                evidence
            })
            .collect()
    }

    /// Whether the other view would have met the surface of the own point `i` at so flat an angle that nothing need
    /// have come back.
    fn slants(&self, i: usize) -> bool {
        let surfaces = &self.own.surfaces;
        let patch = surfaces
            .patch_of_point
            .get(i)
            .and_then(|cell| surfaces.patches.get(*cell as usize))
            .filter(|patch| patch.flat);
        patch.is_some_and(|patch| {
            let eye = self.other_from_own.pose.inverse() * self.other.rays.origin();
            let towards = eye - self.own.view.points[i];
            patch.normal.dot(&towards).abs() < self.settings.grazing * towards.norm()
        })
    }

    fn judge_one(&self, own: &Point3<f64>, own_origin: &Point3<f64>) -> Evidence {
        let p = self.other_from_own.carry(own);
        let rays = &self.other.rays;
        let view = p - rays.origin();
        let range_m = view.norm();
        if range_m < 1e-6 {
            return Evidence::none(Sight::Unseen);
        }
        let d = view / range_m;
        let own_range_m = (own - own_origin).norm();
        let noise_m = self.noise_m(own_range_m, range_m);
        if self.on_surface(&p, &d, range_m, noise_m) {
            return Evidence::none(Sight::Same);
        }
        let look = rays.look(&d);
        let hole_rad = self.settings.hole_spacings * rays.spacing_rad;
        let Some((nearest, _)) = look.nearest.filter(|n| n.1 <= hole_rad) else {
            return self.judge_hole(&p, &d, range_m, noise_m, own);
        };
        if look.filled < 5 && !self.looked_into(&d, range_m) {
            return Evidence::none(Sight::Unseen);
        }
        let doubt = self.doubt(own, noise_m);
        let mut shortest_m = f64::INFINITY;
        let mut longest_m = 0.0_f64;
        for (ray, _) in look.sectors.iter().flatten() {
            let r = self.end_m(*ray);
            shortest_m = shortest_m.min(r);
            longest_m = longest_m.max(r);
        }
        let mut z = f64::INFINITY;
        let mut hidden = false;
        for (ray, _) in look.sectors.iter().flatten() {
            let (gap, sigma) = self.gap(*ray, &d, range_m, (shortest_m, longest_m), &doubt);
            z = z.min(gap / sigma);
            hidden |= gap < -5.0 * sigma;
        }
        let (gap, sigma) = self.gap(nearest, &d, range_m, (shortest_m, longest_m), &doubt);
        let z_nearest = gap / sigma;
        if z_nearest <= SURELY_SAME && z <= SURELY_SAME {
            return Evidence::none(if hidden { Sight::Hidden } else { Sight::Same });
        }
        let z_surface = self.off_surface(&p, &d, &doubt);
        let most = self.settings.most_sigmas;
        Evidence {
            sight: if z.min(z_surface) > 5.0 {
                Sight::Through
            } else {
                Sight::Same
            },
            z: z.min(z_surface).clamp(0.0, most),
            z_loose: z_nearest.min(z_surface).clamp(0.0, most),
            empty: self.other.rays.range_m(nearest).is_infinite(),
        }
    }

    /// Whether the place surely lies on a surface that the other view saw in the same cell or one beside it. Most
    /// places do, and need no further look.
    fn on_surface(&self, p: &Point3<f64>, d: &Vector3<f64>, range_m: f64, noise_m: f64) -> bool {
        let surfaces = &self.other.surfaces;
        let beside_m = surfaces.cell_m + self.other.rays.spacing_rad * range_m;
        let on = |place: &Point3<f64>| {
            let patch = surfaces
                .voxels
                .find(place)
                .and_then(|cell| surfaces.patches.get(cell));
            patch.is_some_and(|patch| {
                let off2 = (patch.mean - p).norm_squared();
                if !patch.flat {
                    let within_m = 0.5 * surfaces.cell_m + SURELY_SAME * noise_m;
                    return off2 < within_m * within_m;
                }
                let across_m = patch.normal.dot(d) * noise_m;
                // The registration's own error could only make it more so.
                let sigma_m = self.height_sigma_m(across_m, 0.0, patch);
                patch.height_m(p).abs() < SURELY_SAME * sigma_m && off2 < beside_m * beside_m
            })
        };
        on(p)
            || [0, 1, 2].into_iter().any(|axis| {
                [-surfaces.cell_m, surfaces.cell_m].into_iter().any(|step| {
                    let mut place = *p;
                    place[axis] += step;
                    on(&place)
                })
            })
    }

    /// A direction without any ray: free only if rays stand all around it.
    fn judge_hole(
        &self,
        p: &Point3<f64>,
        d: &Vector3<f64>,
        range_m: f64,
        noise_m: f64,
        own: &Point3<f64>,
    ) -> Evidence {
        let rays = &self.other.rays;
        let looked = (range_m <= self.free_m() && rays.field.spans(d) && rays.surrounds(d))
            || self.looked_into(d, range_m);
        if !looked {
            return Evidence::none(Sight::Unseen);
        }
        let z = self
            .off_surface(p, d, &self.doubt(own, noise_m))
            .min(self.settings.most_sigmas);
        Evidence {
            sight: if z > 5.0 { Sight::Through } else { Sight::Same },
            z,
            z_loose: z,
            empty: true,
        }
    }

    /// Whether the other view, which does not say where nothing came back, must have looked along `d` at least this far.
    fn looked_into(&self, d: &Vector3<f64>, range_m: f64) -> bool {
        let rays = &self.other.rays;
        let margin_rad = self.settings.field_margin_spacings * rays.spacing_rad
            + self.settings.eye_wanders_m / range_m;
        range_m <= self.free_m() && self.field.as_ref().is_some_and(|f| f.holds(d, margin_rad))
    }

    /// Where a ray ends: at its return, or, without one, as far as the sensor surely sees.
    fn end_m(&self, ray: usize) -> f64 {
        let range_m = self.other.rays.range_m(ray);
        if range_m.is_finite() {
            range_m
        } else {
            self.free_m()
        }
    }

    /// How far a direction without return proves free space: what gives something back now would have done so then, up to
    /// where ranges fade.
    fn free_m(&self) -> f64 {
        let rays = &self.other.rays;
        rays.free_range_m
            .max(self.settings.hole_reach * rays.reach_m)
    }

    /// How far behind the place the surface met by `ray` lies, across that surface, and the
    /// standard deviation of that; metres.
    fn gap(
        &self,
        ray: usize,
        d: &Vector3<f64>,
        range_m: f64,
        span_m: (f64, f64),
        doubt: &Doubt,
    ) -> (f64, f64) {
        let other = self.other;
        let plain = |end: f64| (end - range_m, doubt.sigma_m(d));
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
        if incidence < self.settings.least_incidence {
            return plain(end);
        }
        // Height of the sensor over the plane, over the fall of the ray per metre.
        let meets_m = (patch.height_m(other.rays.origin()) / incidence).clamp(span_m.0, span_m.1);
        let sigma = self.height_sigma_m(
            incidence * doubt.noise_m,
            doubt.pose_m(&patch.normal),
            patch,
        );
        ((meets_m - range_m) * incidence, sigma)
    }

    /// Distance to the nearest surface that the other view saw, in sigmas of that very direction: the pose may leave one
    /// open and fix the others. Ranges err along the ray: across a surface seen at a shallow angle, heights are far
    /// better known.
    fn off_surface(&self, p: &Point3<f64>, d: &Vector3<f64>, doubt: &Doubt) -> f64 {
        let surfaces = &self.other.surfaces;
        let most = self.settings.most_sigmas;
        let widest_m = doubt.widest_m();
        let spacing_m = self.other.rays.spacing_rad * (p - self.other.rays.origin()).norm();
        let reach_m = (most * widest_m).max(spacing_m).clamp(
            2.0 * surfaces.cell_m,
            (6.0 * surfaces.cell_m).max(8.0 * widest_m),
        );
        let mut least = reach_m / widest_m;
        surfaces.grid.for_each_within(p, reach_m, |i, d2| {
            let patch = &surfaces.patches[i];
            let off = p - patch.mean;
            let z = if patch.flat {
                // On the plane, and beside the cell by no more than the lines lie apart.
                let height = patch.height_m(p).abs();
                let beside = (d2 - height * height).max(0.0).sqrt();
                let beyond = (beside - surfaces.cell_m - spacing_m).max(0.0);
                let lateral = off - patch.normal * patch.normal.dot(&off);
                let across = patch.normal.dot(d) * doubt.noise_m;
                let sigma_height = self.height_sigma_m(across, doubt.pose_m(&patch.normal), patch);
                norm3(height / sigma_height, beyond / doubt.sigma_m(&lateral), 0.0)
            } else {
                (d2.sqrt() - 0.5 * surfaces.cell_m).max(0.0) / doubt.sigma_m(&off)
            };
            least = least.min(z);
        });
        least
    }

    /// Standard deviation of a height over `patch`.
    fn height_sigma_m(&self, across_m: f64, registration_m: f64, patch: &Patch) -> f64 {
        norm3(across_m, patch.roughness_m, registration_m)
            .max(self.between.map_or(0.0, |b| b.height_m))
    }

    fn noise_m(&self, own_range_m: f64, other_range_m: f64) -> f64 {
        let both = norm3(
            self.own.noise.sigma_m(own_range_m),
            self.other.noise.sigma_m(other_range_m),
            0.0,
        );
        self.between
            .map_or(both, |law| both.max(law.ranges.sigma_m(other_range_m)))
    }

    /// How unsure the place of the own point is, in the other view's frame.
    fn doubt(&self, own: &Point3<f64>, noise_m: f64) -> Doubt {
        let turn =
            self.reference_from_own.pose.rotation * self.other_from_own.pose.rotation.inverse();
        let turn = turn.to_rotation_matrix().into_inner();
        let at = self.reference_from_own.carry(own);
        Doubt {
            noise_m,
            pose_m2: turn.transpose() * self.registration.covariance_at(&at) * turn,
        }
    }
}

/// How unsure a place is.
struct Doubt {
    /// Standard deviation of the ranges of both views, metres.
    noise_m: f64,
    /// Covariance that the registration leaves, square metres.
    pose_m2: Matrix3<f64>,
}

impl Doubt {
    /// What the registration leaves along `way`, of any length but zero, metres.
    fn pose_m(&self, way: &Vector3<f64>) -> f64 {
        let square = way.dot(&(self.pose_m2 * way)) / way.norm_squared().max(1e-18);
        square.max(0.0).sqrt()
    }

    /// With the noise of the ranges, as if it were alike in all directions.
    fn sigma_m(&self, way: &Vector3<f64>) -> f64 {
        norm3(self.noise_m, self.pose_m(way), 0.0)
    }

    /// No direction is less sure.
    fn widest_m(&self) -> f64 {
        norm3(self.noise_m, self.pose_m2.trace().max(0.0).sqrt(), 0.0)
    }
}

/// Lengths that add as squares; none is near the ends of the number range.
#[inline]
fn norm3(a: f64, b: f64, c: f64) -> f64 {
    (a * a + b * b + c * c).sqrt()
}
