//! Every constant that decides about novelties, with its unit and where it comes from.

use crate::distance::Ground;
use crate::geometry::{NoiseLaw, RegistrationSettings};

/// What the engine is asked to do. The defaults are the standard engine's.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Distance in metres from which a place counts as changed (U_th of Eq. 7). Quiet pairs lie at zero but for weights
    /// that sampling does not explain (66 of 66 simulated ones at zero; `tests/gates.rs`); the smallest thing that passes
    /// the gates of [`SegmentSettings`], some 1e-3 sr in a view of 5 sr, moves 2e-4 of the mass by metres.
    pub u_th_m: f64,
    /// The same for [`Ground::Fm`], which is no length.
    pub u_th_fm: f64,
    /// How changes are found.
    pub segmentation: Segmentation,
    /// What the revisit's mixture starts from, where changes are found in mixtures.
    pub model: Model,
    /// Points further from either sensor than this become neither novelty nor mass, metres. What stands before them was
    /// looked through all the same.
    pub max_range_m: Option<f64>,
    /// How the views are brought together.
    pub registration: RegistrationSettings,
    /// What counts as the same place, and what as noise.
    pub evidence: EvidenceSettings,
    /// How deviating points become things.
    pub segment: SegmentSettings,
    /// How d_GMM is taken.
    pub quantify: QuantifySettings,
    /// When nothing can be said.
    pub verdict: VerdictSettings,
}

/// Where changes are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Segmentation {
    /// In points and rays: what the other view looked through.
    Evidence,
    /// In the mixtures: Algorithm 1 as the paper has it.
    Mixture,
}

/// What the revisit's mixture starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Model {
    /// The reference's components, frozen; new ones where points stay unexplained.
    Refit,
    /// Nothing: both views are fitted alone, with as many components (at most `most`) as the
    /// Bayesian information criterion asks for.
    Independent {
        /// Most components tried.
        most: usize,
    },
}

impl Settings {
    /// U_th in the unit of the ground distance in force.
    pub fn u_th(&self) -> f64 {
        match self.quantify.ground {
            Ground::W2 | Ground::Euclid => self.u_th_m,
            Ground::Fm => self.u_th_fm,
        }
    }
}

/// How d_GMM is taken.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantifySettings {
    /// Ground distance of Eq. 5.
    pub ground: Ground,
    /// Weights that differ by fewer standard deviations of sampling are equal: 1 in 2 million
    /// components by chance.
    pub weight_sigmas: f64,
}

impl Default for QuantifySettings {
    fn default() -> Self {
        Self {
            ground: Ground::W2,
            weight_sigmas: 5.0,
        }
    }
}

/// When nothing can be said.
#[derive(Debug, Clone, PartialEq)]
pub struct VerdictSettings {
    /// A correction beyond this is not a robot that stopped at its waypoint, metres.
    pub most_shift_m: f64,
    /// The same for turns, radians.
    pub most_turn_rad: f64,
    /// Ratio of the distance between common surfaces to the views' own noise beyond which the
    /// registration or one of the scans is bent. 66 simulated quiet pairs with up to twice the sensor's noise lie at
    /// 0.45-0.97 of what a sweep states (`tests/gates.rs`).
    pub most_disagreement: f64,
    /// Least share of either view's surface that the other could see.
    pub least_overlap: f64,
}

impl Default for VerdictSettings {
    fn default() -> Self {
        Self {
            most_shift_m: 1.0,
            most_turn_rad: 0.5,
            most_disagreement: 1.7,
            least_overlap: 0.25,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            u_th_m: 5e-4,
            u_th_fm: 2e-3,
            segmentation: Segmentation::Evidence,
            model: Model::Refit,
            max_range_m: None,
            registration: RegistrationSettings::default(),
            evidence: EvidenceSettings::default(),
            segment: SegmentSettings::default(),
            quantify: QuantifySettings::default(),
            verdict: VerdictSettings::default(),
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
    /// Thinning cells are this many standard deviations of a middle range wide, at least.
    pub cell_sigmas: f64,
    /// Surfaces this many sigmas apart count as the same in the end of the registration.
    pub gate_sigmas: f64,
    /// The same at least, metres: surfaces bend by that much within a cell.
    pub least_gate_m: f64,
    /// Smallest noise believed, whatever the data say: quantisation and bent surfaces remain.
    pub least_noise: NoiseLaw,
    /// Deviations beyond this many sigmas weigh no more (design section 5).
    pub most_sigmas: f64,
    /// Cosine of incidence below which a plane says nothing about the range along a ray.
    pub least_incidence: f64,
    /// Cosine of incidence below which a surface need not give anything back: that nothing came proves nothing. Twice
    /// where the simulated sensor begins to lose targets.
    pub grazing: f64,
    /// Share of the reach up to which a direction without return proves free space: beyond it surfaces come and go with
    /// some centimetres of range. A judgement.
    pub hole_reach: f64,
    /// A direction so many row spacings inside the bounds of a bare cloud's field was looked at,
    pub field_margin_spacings: f64,
    /// if it is also inside by what this much looks like from there, metres: a tilted sensor's eye moves about its axis,
    /// and a cloud names one place for it.
    pub eye_wanders_m: f64,
    /// Sensors nearer to one another than this, each in its own view's frame, have one field, metres: poses at a waypoint
    /// differ by some centimetres.
    pub same_stand_m: f64,
    /// A hole is a direction without any ray nearer than this many row spacings.
    pub hole_spacings: f64,
}

impl Default for EvidenceSettings {
    fn default() -> Self {
        Self {
            least_cell_m: 0.05,
            most_cell_m: 0.2,
            cell_sigmas: 1.0,
            gate_sigmas: 3.0,
            least_gate_m: 0.02,
            least_noise: NoiseLaw {
                at_zero_m: 0.003,
                per_m: 0.0005,
            },
            most_sigmas: 20.0,
            least_incidence: 0.05,
            grazing: 0.16,
            hole_reach: 0.9,
            field_margin_spacings: 2.0,
            eye_wanders_m: 0.1,
            same_stand_m: 0.3,
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
    /// [`Self::support_density_per_sr`] (design section 5: 0 of 150 quiet sweeps reached it; of 66 simulated quiet pairs the
    /// most is 57, `tests/gates.rs`).
    pub least_support: f64,
    /// The same for a compact thing: at least [`Self::compact_width_spacings`] rows wide and [`Self::compact_fill`] full.
    /// Noise strings points along edges: the same 66 pairs have no such thing at all.
    pub compact_support: f64,
    /// Least width of a compact thing, in row spacings.
    pub compact_width_spacings: f64,
    /// Least fill of a compact thing.
    pub compact_fill: f64,
    /// Beam density that supports are told for: 683 x 120 beams over 240 x 78 deg (design section 5).
    pub support_density_per_sr: f64,
    /// Fewest points of a thing: fewer fix neither extent nor covariance.
    pub least_points: usize,
    /// Angular width of a thing across its longer side, in row spacings, from which it is judged by
    /// [`Self::least_support`]: three rows.
    pub least_width_spacings: f64,
    /// Least width of all: two rows, of which chance and mixed pixels along an edge are capable.
    pub thin_width_spacings: f64,
    /// Least support of a thing that thin: four times that of a wide one. Quiet simulated sweeps reach 72 (98 % of 66
    /// pairs: 65; wider things 57; `tests/gates.rs`) and would do with less; the value stands on a recorded quiet pair that a smaller one
    /// did not leave quiet (`tests/novelty_recorded.rs`).
    pub thin_support: f64,
    /// Least share of the beams through a thing's outline that hit it.
    pub least_fill: f64,
    /// Support from which a thing as wide as a compact one may be less full: a plant, a chair, a rack. Less full things of
    /// the same 66 pairs reach 31.
    pub sparse_support: f64,
    /// Least fill of such a thing.
    pub sparse_fill: f64,
    /// A thing drew its beams if so many times more of them end on it than the pattern around has: even where lines
    /// converge a pattern is level to a factor of two within 2.5 rows. It is judged by its own rows, not the other view's.
    pub drawn_fill: f64,
    /// And at least so many times more than the other view has within its outline.
    pub drawn_surplus: f64,
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
            compact_support: 150.0,
            compact_width_spacings: 3.0,
            compact_fill: 0.5,
            support_density_per_sr: 15_550.0,
            least_points: 8,
            least_width_spacings: 1.7,
            thin_width_spacings: 0.7,
            thin_support: 1200.0,
            least_fill: 0.3,
            sparse_support: 600.0,
            sparse_fill: 0.1,
            drawn_fill: 3.0,
            drawn_surplus: 2.0,
        }
    }
}
