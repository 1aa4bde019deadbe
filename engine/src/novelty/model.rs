//! The words in which a change is told.

use super::Rim;
use crate::mixture::{Gaussian, Mixture};
use nalgebra::Point3;

/// Whether a thing came or went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Seen now, and the reference looked through its place.
    Appeared,
    /// Seen in the reference, and the revisit looked through its place.
    Disappeared,
}

/// The three answers to "has this place changed?".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Looked, and nothing changed.
    Quiet,
    /// d_GMM >= U_th (Eq. 7) and at least one novelty is listed.
    Changed,
    /// No honest answer is possible; a reason goes with it.
    NotObserved,
}

impl Verdict {
    /// The word that stands in JSON and in the database.
    pub fn word(self) -> &'static str {
        match self {
            Self::Quiet => "quiet",
            Self::Changed => "changed",
            Self::NotObserved => "not_observed",
        }
    }
}

/// One thing that came or went (Pi of Algorithm 1, one connected part of it).
/// Positions are in the current view's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Novelty {
    /// Came or went.
    pub kind: Kind,
    /// Index, in the same list, of the disappeared novelty that this one is the same thing as.
    pub moved_from: Option<usize>,
    /// Indices of its points: into the current view if appeared, into the reference if disappeared.
    pub points: Vec<usize>,
    /// Those points, metres.
    pub places: Vec<Point3<f64>>,
    /// What lies about it: points that may be its own although they prove no change.
    pub rim: Rim,
    /// Mean and covariance of its points.
    pub moments: Gaussian,
    /// Its Gaussians, for retrieval of its shape (section IV); weights sum to one within it.
    pub mixture: Mixture,
    /// Size of the axis-aligned box around its points, metres.
    pub extent_m: [f64; 3],
    /// Share of the commonly visible mass that it is.
    pub mass: f64,
    /// Its part of d_GMM; contributions of all novelties and of the unexplained rest sum to d_GMM.
    pub contribution: f64,
    /// Sum over its points of min(z, 20), z the deviation in sigmas, relative to the beam density.
    pub support: f64,
}
