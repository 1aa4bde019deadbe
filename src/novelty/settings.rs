//! Every constant that decides about novelties, with its unit and where it comes from.

use crate::geometry::{NoiseLaw, RegistrationSettings};

/// What the engine is asked to do. The defaults are the standard engine's.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Distance in metres from which a place counts as changed (U_th of Eq. 7).
    pub u_th_m: f64,
    /// Points further from the sensor than this are not looked at, metres.
    pub max_range_m: Option<f64>,
    /// How the views are brought together.
    pub registration: RegistrationSettings,
    /// What counts as the same place, and what as noise.
    pub evidence: EvidenceSettings,
    /// How deviating points become things.
    pub segment: SegmentSettings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            u_th_m: 5e-4,
            max_range_m: None,
            registration: RegistrationSettings::default(),
            evidence: EvidenceSettings::default(),
            segment: SegmentSettings::default(),
        }
    }
}

/// When a point deviates from what the other view saw.
#[derive(Debug, Clone, PartialEq)]
pub struct EvidenceSettings {
    /// Smallest edge of the thinning cells, metres (design section 5: 5-8 cm for modelling).
    pub least_cell_m: f64,
    /// Largest edge of the thinning cells, metres: still smaller than the things looked for.
    pub most_cell_m: f64,
    /// Smallest noise believed, whatever the data say: quantisation and bent surfaces remain.
    pub least_noise: NoiseLaw,
    /// Deviations beyond this many sigmas weigh no more (design section 5).
    pub most_sigmas: f64,
    /// Cosine of incidence below which a plane says nothing about the range along a ray.
    pub least_incidence: f64,
    /// Share of the reach up to which a direction without return proves free space in a bare cloud.
    pub hole_reach: f64,
    /// A hole is a direction without any ray nearer than this many row spacings.
    pub hole_spacings: f64,
}

impl Default for EvidenceSettings {
    fn default() -> Self {
        Self {
            least_cell_m: 0.05,
            most_cell_m: 0.2,
            least_noise: NoiseLaw {
                at_zero_m: 0.003,
                per_m: 0.0005,
            },
            most_sigmas: 20.0,
            least_incidence: 0.05,
            hole_reach: 0.7,
            hole_spacings: 1.2,
        }
    }
}

/// How deviating points become things.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentSettings {
    /// A point this many sigmas off starts a thing (design section 5).
    pub seed_sigmas: f64,
    /// A point this many sigmas off joins a thing nearby (design section 5).
    pub grow_sigmas: f64,
    /// How near is nearby, metres (design section 5).
    pub grow_within_m: f64,
    /// Parts of one thing lie no further apart, metres (design section 5).
    pub link_m: f64,
    /// Both distances reach at least this many row spacings at the point's range.
    pub link_spacings: f64,
    /// Least support of a listed novelty: the sum over its points of min(z, 20), relative to
    /// [`Self::support_density_per_sr`] (design section 5: 0 of 150 quiet sweeps reached it).
    pub least_support: f64,
    /// Beam density that supports are told for: 683 x 120 beams over 240 x 78 deg (design section 5).
    pub support_density_per_sr: f64,
    /// Fewest points of a thing: fewer fix neither extent nor covariance.
    pub least_points: usize,
    /// Angular width of a thing across its longer side, in row spacings, from which it is judged by
    /// [`Self::least_support`]: three rows.
    pub least_width_spacings: f64,
    /// Least width of all: two rows, of which chance and mixed pixels along an edge are capable.
    pub thin_width_spacings: f64,
    /// Least support of a thing that thin: four times that of a wide one.
    pub thin_support: f64,
    /// Least share of the beams through a thing's outline that hit it.
    pub least_fill: f64,
}

impl Default for SegmentSettings {
    fn default() -> Self {
        Self {
            seed_sigmas: 5.0,
            grow_sigmas: 2.5,
            grow_within_m: 0.15,
            link_m: 0.16,
            link_spacings: 2.2,
            least_support: 300.0,
            support_density_per_sr: 15_550.0,
            least_points: 8,
            least_width_spacings: 1.7,
            thin_width_spacings: 0.7,
            thin_support: 1200.0,
            least_fill: 0.3,
        }
    }
}
