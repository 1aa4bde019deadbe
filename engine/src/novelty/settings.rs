//! Settings and constants of the detection: unit and origin of each.

use super::RemovalExtent;
use super::constants::REFERENCE_MODEL_VERSION;
use crate::distance::GroundDistance;
use crate::geometry::{NoiseLaw, RegistrationSettings};

/// Settings of a detection. The defaults are those of the engine `standard`.
#[derive(Debug, Clone, PartialEq)]
pub struct NoveltySettings {
    /// d_GMM from which a place has changed, metres (U_th of paper Eq. 7). Quiet pairs are at zero (66 of 66 simulated ones,
    /// `cargo test --test gates`); an object at the gate of a segment three rows wide ([`SegmentSettings`]),
    /// 1e-3 sr in a view of 5 sr, moves 2e-4 of the mass by metres (`docs/novelty.md section 8`).
    pub u_th_m: f64,
    /// The same for [`GroundDistance::Fm`], which has no unit.
    pub u_th_fm: f64,
    /// What says which beams are new.
    pub evidence_source: EvidenceSource,
    /// How mixtures are fitted.
    pub model: RevisitModel,
    /// Points further than this from either sensor are neither novelty nor mass, metres. Their rays still prove free space.
    pub max_range_m: Option<f64>,
    /// How far Algorithm 1 goes.
    pub removal_extent: RemovalExtent,
    /// Registration of the views.
    pub registration: RegistrationSettings,
    /// Visibility and noise.
    pub evidence: EvidenceSettings,
    /// Segmentation of deviating points.
    pub segment: SegmentSettings,
    /// Computation of d_GMM.
    pub quantify: QuantifySettings,
    /// Conditions of the verdict.
    pub verdict: VerdictSettings,
}

/// What says which beams Gamma does not explain, and which of its components are gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EvidenceSource {
    /// The rays of the other view: where it looked through.
    Rays,
    /// The mixtures alone, within the field of view of the other view.
    Mixture,
}

/// How the revisit's mixture Theta is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RevisitModel {
    /// From Gamma, whose components are frozen, with new ones where beams are not explained.
    Refit,
    /// Both views are fitted alone; the Bayesian information criterion chooses the number of components.
    Independent {
        /// Most components tried.
        max_components: usize,
    },
}

impl RevisitModel {
    /// Whether Theta is fitted from Gamma.
    pub fn is_refit(self) -> bool {
        matches!(self, Self::Refit)
    }
}

impl NoveltySettings {
    /// U_th in the unit of the ground distance.
    pub fn u_th(&self) -> f64 {
        match self.quantify.ground {
            GroundDistance::W2 | GroundDistance::Euclid => self.u_th_m,
            GroundDistance::Fm => self.u_th_fm,
        }
    }

    /// What a reference's mixture is made by, as JSON: the version of the fit and the settings that it depends on. A stored
    /// mixture of another text is made anew.
    pub fn reference_model(&self, seed: u64) -> String {
        let range = self
            .max_range_m
            .map_or_else(|| "null".to_owned(), |max_m| max_m.to_string());
        let fit = match self.model {
            RevisitModel::Refit => r#""fit":"flat""#.to_owned(),
            RevisitModel::Independent { max_components } => {
                format!(r#""fit":"bic","max_components":{max_components},"seed":{seed}"#)
            }
        };
        format!(r#"{{"version":{REFERENCE_MODEL_VERSION},{fit},"max_range_m":{range}}}"#)
    }
}

/// Settings of d_GMM.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantifySettings {
    /// Ground distance of paper Eq. 5.
    pub ground: GroundDistance,
    /// Weights that differ by fewer standard deviations of sampling are equal: by chance, 1 in 2 million components differs
    /// by more.
    pub weight_sigmas: f64,
}

impl Default for QuantifySettings {
    fn default() -> Self {
        Self {
            ground: GroundDistance::W2,
            weight_sigmas: 5.0,
        }
    }
}

/// Beyond which limits no answer is possible.
#[derive(Debug, Clone, PartialEq)]
pub struct VerdictSettings {
    /// Largest translation of the registration, metres: beyond it the robot is not at its waypoint.
    pub max_shift_m: f64,
    /// The same for the rotation, radians.
    pub max_rotation_rad: f64,
    /// Largest ratio of the noise between the views to their own noise: beyond it the registration or one of the scans is
    /// bent. 66 simulated quiet pairs with up to twice the sensor's noise are at 0.45-0.97 of what a sweep states (`cargo
    /// test --test gates`).
    pub max_disagreement: f64,
    /// Least share of the reference's solid angle that the visit must be able to judge to be quiet. Its surface does not decide:
    /// half of a sparse corridor's lies at its far end, met at so flat an angle that noise hides it.
    pub min_coverage: f64,
}

impl Default for VerdictSettings {
    fn default() -> Self {
        Self {
            max_shift_m: 1.0,
            max_rotation_rad: 0.5,
            max_disagreement: 1.7,
            min_coverage: 0.7,
        }
    }
}

impl Default for NoveltySettings {
    fn default() -> Self {
        Self {
            u_th_m: 5e-4,
            u_th_fm: 2e-3,
            evidence_source: EvidenceSource::Rays,
            model: RevisitModel::Refit,
            max_range_m: None,
            removal_extent: RemovalExtent::AllCandidates,
            registration: RegistrationSettings::default(),
            evidence: EvidenceSettings::default(),
            segment: SegmentSettings::default(),
            quantify: QuantifySettings::default(),
            verdict: VerdictSettings::default(),
        }
    }
}

/// Settings of visibility and noise (`docs/novelty.md sections 2 and 5`).
#[derive(Debug, Clone, PartialEq)]
pub struct EvidenceSettings {
    /// Smallest edge of the thinning cells, metres. A judgement: finer cells than a few centimetres hold single points.
    pub min_cell_m: f64,
    /// Largest edge of the thinning cells, metres: smaller than the objects looked for.
    pub max_cell_m: f64,
    /// Least edge of the thinning cells in standard deviations of the noise at the median range.
    pub cell_sigmas: f64,
    /// Last gate of the registration in standard deviations of the noise of both views.
    pub gate_sigmas: f64,
    /// Least last gate of the registration, metres: surfaces bend by that much within a cell.
    pub min_gate_m: f64,
    /// Least noise of a view: quantisation and bent surfaces remain.
    pub noise_floor: NoiseLaw,
    /// Cap of a deviation in sigmas (`docs/novelty.md section 5`).
    pub max_sigmas: f64,
    /// Cosine of incidence below which a plane does not determine the range along a ray.
    pub min_incidence_cos: f64,
    /// Cosine of incidence below which a surface may give no return, so that none proves nothing. Twice the value at which
    /// the simulated sensor begins to lose targets.
    pub grazing_cos: f64,
    /// Share of the reach up to which a direction without return proves free space: beyond, surfaces come and go with some
    /// centimetres of range. A judgement.
    pub no_return_reach_share: f64,
    /// A direction is inside the field of view of a bare cloud if it is this many row spacings inside its bounds,
    pub field_margin_spacings: f64,
    /// plus the angle of this length at the range of the point, metres: the origin of a tilting sensor moves, and a cloud
    /// states one.
    pub origin_error_m: f64,
    /// Fields of view are joined if the sensor origins, each in its own view's frame, are closer than this, metres: poses at
    /// a waypoint differ by some centimetres.
    pub same_origin_within_m: f64,
    /// A direction without any ray within this many row spacings is a hole.
    pub hole_spacings: f64,
}

impl Default for EvidenceSettings {
    fn default() -> Self {
        Self {
            min_cell_m: 0.05,
            max_cell_m: 0.2,
            cell_sigmas: 1.0,
            gate_sigmas: 3.0,
            min_gate_m: 0.02,
            noise_floor: NoiseLaw {
                at_zero_m: 0.003,
                per_m: 0.0005,
            },
            max_sigmas: 20.0,
            min_incidence_cos: 0.05,
            grazing_cos: 0.16,
            no_return_reach_share: 0.9,
            field_margin_spacings: 2.0,
            origin_error_m: 0.1,
            same_origin_within_m: 0.3,
            hole_spacings: 1.2,
        }
    }
}

/// Settings of the segmentation (`docs/novelty.md section 6`).
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentSettings {
    /// Deviation of a seed, sigmas.
    pub seed_sigmas: f64,
    /// Deviation of a point that seeds grow to, sigmas.
    pub grow_sigmas: f64,
    /// Distance over which seeds grow, metres.
    pub grow_distance_m: f64,
    /// Points within this distance are one segment, metres.
    pub link_distance_m: f64,
    /// Both distances are at least this many row spacings at the point's range.
    pub link_spacings: f64,
    /// Least support of a listed novelty: the sum over its points of min(z, 20), relative to
    /// [`Self::support_density_per_sr`]. None of 150 quiet sweeps of a prototype reached it; 66 simulated quiet pairs reach
    /// 57 (`cargo test --test gates`).
    pub min_support: f64,
    /// The same for a compact segment: [`Self::compact_min_width_spacings`] wide and [`Self::compact_min_fill`] full. Noise is
    /// strung along edges: the same 66 pairs have no compact segment.
    pub compact_min_support: f64,
    /// Least width of a compact segment, in row spacings.
    pub compact_min_width_spacings: f64,
    /// Least fill of a compact segment.
    pub compact_min_fill: f64,
    /// Beam density to which supports are scaled: 683 x 120 beams over 240 x 78 deg.
    pub support_density_per_sr: f64,
    /// Least number of points of a segment: fewer determine neither extent nor covariance.
    pub min_points: usize,
    /// Width of a segment across its longer side, in row spacings, from which [`Self::min_support`] applies: three rows.
    pub min_width_spacings: f64,
    /// Least width of any segment, in row spacings: two rows, which noise and mixed pixels along an edge can reach.
    pub thin_min_width_spacings: f64,
    /// Least support of a segment thinner than [`Self::min_width_spacings`]. The 66 quiet pairs reach 72 (98 % of them 65);
    /// a recorded quiet pair needs more (`cargo test --test novelty_recorded`).
    pub thin_min_support: f64,
    /// Least share of the beams through the outline of a segment that end on it.
    pub min_fill: f64,
    /// Least support of a segment as wide as a compact one but less full: a plant, a chair, a rack. The 66 quiet pairs reach
    /// 31.
    pub sparse_min_support: f64,
    /// Least fill of such a segment.
    pub sparse_min_fill: f64,
    /// Least ratio of the density of own beams on an oversampled segment to that of the pattern around it, which varies by less
    /// than a factor of two within 2.5 rows, even where lines converge. Its width is measured in its own rows.
    pub oversampled_fill: f64,
    /// Least ratio of own beams on it to beams of the other view within its outline, each relative to its mean density.
    pub oversampled_surplus: f64,
}

impl Default for SegmentSettings {
    fn default() -> Self {
        Self {
            seed_sigmas: 5.0,
            grow_sigmas: 2.5,
            grow_distance_m: 0.15,
            link_distance_m: 0.16,
            link_spacings: 2.2,
            min_support: 300.0,
            compact_min_support: 150.0,
            compact_min_width_spacings: 3.0,
            compact_min_fill: 0.5,
            support_density_per_sr: 15_550.0,
            min_points: 8,
            min_width_spacings: 1.7,
            thin_min_width_spacings: 0.7,
            thin_min_support: 1200.0,
            min_fill: 0.3,
            sparse_min_support: 600.0,
            sparse_min_fill: 0.1,
            oversampled_fill: 3.0,
            oversampled_surplus: 2.0,
        }
    }
}
