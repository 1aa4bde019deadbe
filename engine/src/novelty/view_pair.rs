//! A reference and a current view, registered, and the evidence that each gives about the other.

use super::compared_view::ComparedView;
use super::noise::{CrossViewNoise, cross_view_noise};
use super::visibility::VisibilityTest;
use super::{
    Evidence, EvidenceSettings, NoveltySettings, ObserverView, PreparedView, Reference, Visibility,
};
use crate::geometry::{DriftTransform, FieldOfViewBounds, Pose, Registration, register};
use nalgebra::Point3;

/// A reference and a current view, registered.
pub(super) struct ViewPair<'a> {
    /// The reference and the current view.
    pub views: [&'a PreparedView; 2],
    pub registration: Registration,
    /// Noise between the views; `None` if too few surfaces were seen by both.
    pub cross_view_noise: Option<CrossViewNoise>,
}

impl<'a> ViewPair<'a> {
    pub(super) fn register(
        reference: &'a Reference,
        current: &'a PreparedView,
        settings: &NoveltySettings,
    ) -> Self {
        let reference_view = &reference.prepared;
        let sigma_m = reference_view
            .noise
            .sigma_m(reference_view.median_range_m)
            .hypot(current.noise.sigma_m(current.median_range_m));
        let gate_m = (settings.evidence.gate_sigmas * sigma_m).max(settings.evidence.min_gate_m);
        let registration = register(
            &reference.planes,
            &current.surfaces,
            [&reference_view.view.origin, &current.view.origin],
            &Pose::identity(),
            gate_m,
            &settings.registration,
        );
        let cross_view_noise = cross_view_noise(
            &reference_view.surfaces,
            &reference_view.view.origin,
            &current.view.points,
            &registration,
            2.0 * gate_m,
        );
        Self {
            views: [reference_view, current],
            registration,
            cross_view_noise,
        }
    }

    /// From the frame of view `side` (0 reference, 1 current) to that of the reference.
    pub(super) fn reference_from(&self, side: usize) -> DriftTransform {
        if side == 0 {
            DriftTransform::identity()
        } else {
            self.registration.reference_from_current()
        }
    }

    /// From the frame of view `side` to that of the other view.
    fn other_from(&self, side: usize) -> DriftTransform {
        let reference_from_current = self.registration.reference_from_current();
        match side {
            0 => reference_from_current.inverse(),
            _ => reference_from_current,
        }
    }

    /// The view that observes the points of view `side`.
    pub(super) fn observer_of(&self, side: usize) -> ObserverView<'a> {
        ObserverView {
            view: self.views[1 - side],
            observer_from_own: self.other_from(side),
        }
    }

    /// Evidence of each view's points from the other's rays. Points beyond the range limit give no evidence themselves, but
    /// still end rays.
    pub(super) fn evaluate_evidence(&self, settings: &NoveltySettings) -> [Vec<Evidence>; 2] {
        [0, 1].map(|side| {
            let (own, other) = (self.views[side], self.views[1 - side]);
            let other_from_own = self.other_from(side);
            let mut evidence = self.visibility_test(side, settings).evaluate();
            if let Some(max_m) = settings.max_range_m {
                // From both sensors, or a surface at the limit would have mass on one side only.
                let other_origin = other_from_own.pose.inverse() * other.view.origin;
                let out_of_range = |p: &Point3<f64>| {
                    (p - own.view.origin).norm() > max_m || (p - other_origin).norm() > max_m
                };
                for (e, p) in evidence.iter_mut().zip(&own.view.points) {
                    if out_of_range(p) {
                        *e = Evidence::none(Visibility::OutOfRange);
                    }
                }
            }
            evidence
        })
    }

    /// Evidence of views that do not match: neither saw any point of the other.
    pub(super) fn no_evidence(&self) -> [Vec<Evidence>; 2] {
        self.views
            .map(|view| vec![Evidence::none(Visibility::OutOfView); view.view.points.len()])
    }

    /// How the current view sees positions in the reference's frame.
    pub(super) fn visibility_of(
        &self,
        positions: &[Point3<f64>],
        settings: &NoveltySettings,
    ) -> Vec<Visibility> {
        let test = self.visibility_test(0, settings);
        let origin = &self.views[0].view.origin;
        let evidence = positions.iter().map(|p| test.evaluate_point(p, origin));
        evidence.map(|e| e.visibility).collect()
    }

    /// Asks the other view about the points of view `side`.
    fn visibility_test<'b>(
        &'b self,
        side: usize,
        settings: &'b NoveltySettings,
    ) -> VisibilityTest<'b> {
        VisibilityTest {
            other: self.views[1 - side],
            other_from_own: self.other_from(side),
            own: self.views[side],
            cross_view_noise: self.cross_view_noise,
            registration: &self.registration,
            reference_from_own: self.reference_from(side),
            field_of_view: self.observer_field_of_view(side, &settings.evidence),
            settings: &settings.evidence,
        }
    }

    /// Field of view of the observer of view `side`, if it is a bare cloud; joined with that of the other visit where both
    /// sensors have about the same origin in their frames.
    fn observer_field_of_view(
        &self,
        side: usize,
        settings: &EvidenceSettings,
    ) -> Option<FieldOfViewBounds> {
        let (own, other) = (self.views[side], self.views[1 - side]);
        if !other.view.no_return.is_empty() {
            return None;
        }
        let same_origin =
            (own.view.origin - other.view.origin).norm() < settings.same_origin_within_m;
        Some(if same_origin {
            other.rays.field_of_view.union(&own.rays.field_of_view)
        } else {
            other.rays.field_of_view.clone()
        })
    }

    pub(super) fn compared_view(
        &self,
        side: usize,
        visibility: &'a [Visibility],
        segments: &'a [Vec<usize>],
    ) -> ComparedView<'a> {
        ComparedView {
            prepared: self.views[side],
            reference_from_own: self.reference_from(side),
            visibility,
            segments,
        }
    }

    /// Noise between the views over the noise of both, at the reference's median range.
    pub(super) fn disagreement(&self) -> f64 {
        let [reference, current] = self.views;
        let range_m = reference.median_range_m;
        let both_m = reference
            .noise
            .sigma_m(range_m)
            .hypot(current.noise.sigma_m(range_m));
        self.cross_view_noise
            .map_or(0.0, |noise| noise.ranges.sigma_m(range_m) / both_m)
    }
}
