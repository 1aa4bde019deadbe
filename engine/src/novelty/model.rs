//! Segments, novelties and verdicts.

use crate::geometry::DriftTransform;
use crate::mixture::{Gaussian, Mixture};
use nalgebra::Point3;

/// Whether an object appeared or disappeared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NoveltyKind {
    /// In the current view, where the reference saw free space.
    Appeared,
    /// In the reference, where the current view saw free space.
    Disappeared,
}

impl NoveltyKind {
    /// Name in JSON and in the database.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Appeared => "appeared",
            Self::Disappeared => "disappeared",
        }
    }
}

/// The three answers to "has this place changed?" (`docs/novelty.md section 9`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The place was seen, and d_GMM is below U_th.
    Quiet,
    /// d_GMM >= U_th (paper Eq. 7) and at least one novelty is listed.
    Changed,
    /// No honest answer is possible; a reason goes with it.
    NotObserved,
}

impl Verdict {
    /// Name in JSON and in the database.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Quiet => "quiet",
            Self::Changed => "changed",
            Self::NotObserved => "not_observed",
        }
    }
}

/// An object that appeared or disappeared: one connected part of Pi of Algorithm 1. Positions are in the current view's
/// frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Novelty {
    /// Whether it appeared or disappeared.
    pub kind: NoveltyKind,
    /// Index, in the same list, of the disappeared novelty that is the same object.
    pub moved_from: Option<usize>,
    /// Indices of its points: into the current view if appeared, into the reference if disappeared.
    pub point_indices: Vec<usize>,
    /// Its points, metres.
    pub points: Vec<Point3<f64>>,
    /// Points around it, which may belong to it although they prove no change.
    pub surroundings: Surroundings,
    /// Mean and covariance of its points.
    pub moments: Gaussian,
    /// Its Gaussians (Pi of Algorithm 1), for the retrieval of its shape (paper section IV).
    pub mixture: Mixture,
    /// Positions of its Gaussians in Theta if it appeared, in Gamma if it disappeared, as written by
    /// [`ComparedMixtures::mixture`](super::ComparedMixtures::mixture).
    pub components: Vec<usize>,
    /// Whether Algorithm 1 took one of its Gaussians before d_GMM fell below U_th.
    pub needed_for_alarm: bool,
    /// Size of the axis-aligned box around its points, metres.
    pub extent_m: [f64; 3],
    /// Its share of the mass that both views could see.
    pub mass: f64,
    /// Its part of d_GMM, in the unit of d_GMM.
    pub contribution: f64,
    /// See [`Segment::support`].
    pub support: f64,
}

/// Side (0 reference, 1 current) and index of a segment.
pub(super) type SegmentId = (usize, usize);

/// A connected set of deviating points of one view.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Indices of its points, ascending.
    pub point_indices: Vec<usize>,
    /// Sum of min(z, 20) over its points, z the deviation in sigmas, relative to the density of beams
    /// (`docs/novelty.md section 6`).
    pub support: f64,
    /// Angular widths as its own sensor saw it, the smaller first, radians.
    pub width_rad: [f64; 2],
    /// Density of the own beams there over their mean density, at least 1: lines of a tilted sensor converge.
    pub crowding: f64,
    /// Share of the own beams through its outline that end on it.
    pub fill: f64,
}

impl Segment {
    /// Number of rows of its own points across its shorter side.
    pub(super) fn own_rows(&self) -> f64 {
        let [small, large] = self.width_rad;
        (self.point_indices.len() as f64 * small / large.max(1e-9)).sqrt()
    }

    /// Its points per steradian of its outline.
    pub(super) fn own_density_per_sr(&self) -> f64 {
        let [small, large] = self.width_rad;
        // An ellipse: the width is sqrt(12) standard deviations, the half axis two.
        let outline_sr = std::f64::consts::PI * small * large / 3.0;
        self.point_indices.len() as f64 / outline_sr.max(1e-12)
    }
}

/// Points around a segment, metres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surroundings {
    /// Distance from the segment within which own points are included; twice that for those of the other view.
    pub reach_m: f64,
    /// Points of the view that shows the segment, which are in no segment.
    pub own: Vec<Point3<f64>>,
    /// Points of the other view.
    pub other: Vec<Point3<f64>>,
}

impl Surroundings {
    /// The same in another frame.
    pub(super) fn transformed(mut self, other_from_this: &DriftTransform) -> Self {
        for p in self.own.iter_mut().chain(&mut self.other) {
            *p = other_from_this.apply(p);
        }
        self
    }
}

/// Something that gave nothing back, as the visit saw it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AbsorbingThing {
    /// Its right and its left end, radians, anticlockwise from the visit's x axis; the second may exceed pi.
    pub bearings_rad: [f64; 2],
    /// Its lower and its upper end, radians.
    pub elevations_rad: [f64; 2],
    /// It is nearer than this, metres: the nearest surface that vanished behind it.
    pub far_m: f64,
    /// Beams of the reference that came back there.
    pub beams: usize,
}
