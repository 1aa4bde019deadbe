//! Constants of the mixtures and their comparison: unit and origin of each.

/// Mahalanobis distance up to which a component predicts a cell: 5 standard deviations of its noise and thickness, as for
/// every other statement about one beam (`docs/novelty.md section 5`).
pub(super) const PREDICTED_SIGMAS: f64 = 5.0;

/// A component predicts up to this many of its own standard deviations, besides those of the noise. The corner of a uniform
/// plate is sqrt(6) from its middle.
pub(super) const OWN_SIGMAS: f64 = 2.5;

/// Share of the plate that a component spans which its surface covers at least. EM leaves components of a few far cells,
/// which span a room and cover a thousandth of it; parts of walls cover about all of theirs, racks and plants a third.
pub(super) const MIN_COVERAGE: f64 = 0.1;

/// In each round that adds components to a reference's mixture, parts of this many cells or fewer are not split. The first
/// is that of `SPLIT_MIN_POINTS`; a component of one cell predicts it.
pub(super) const PREDICTION_MIN_POINTS: [usize; 4] = [10, 5, 3, 1];

/// Rounds in which single cells get components of their own; the second is needed where the first takes weight from a
/// component at the limit of [`MIN_COVERAGE`].
pub(super) const SINGLE_CELL_ROUNDS: usize = 8;

/// Beams from which the noise of a component is measured, at least; with fewer, the law of the view holds. The deviation of
/// 8 samples is known to a quarter.
pub(super) const MIN_NOISE_SAMPLES: f64 = 8.0;

/// A component of a stored mixture is not in its view if the view gives it less than this share of its weight. A mixture
/// that was fitted to the view has a share of 1 but for the last step of EM; one half is a doubled weight.
pub(super) const MIN_VIEW_SHARE: f64 = 0.25;

/// Points that stand for a component without beams in the view: at least, and at most.
pub(super) const SAMPLE_BOUNDS: [f64; 2] = [16.0, 4096.0];

/// Largest share of a component's variance that a part taken out of it may claim, so that the rest keeps a volume.
pub(super) const MAX_SPLIT_SHARE: f64 = 0.98;

/// Version of the fit of a reference's mixture. It is raised with every change that gives another mixture for the same view.
pub(super) const REFERENCE_MODEL_VERSION: u32 = 1;

/// Points at which a visit is asked whether it saw a place.
pub(super) const PLACE_SAMPLES: f64 = 64.0;
/// Squared Mahalanobis distance within which surface belongs to a missing thing: the box of its variances reaches as far
/// along each axis.
pub(super) const PLACE_SHELL: f64 = 3.0;
/// More of a place than this unseen: nothing can be said of the whole.
pub(super) const HIDDEN_PLACE_SHARE: f64 = 0.5;
/// More of a place than this unlike the reference: the thing, or another, is there. Edges and feet of what is gone fall on
/// surfaces.
pub(super) const UNLIKE_PLACE_SHARE: f64 = 0.2;

/// A beam that ends within this many standard deviations of its noise of a line met it, as for every other statement about
/// one beam (`docs/novelty.md section 5`).
pub(super) const ON_LINE_SIGMAS: f64 = 5.0;

/// Standard deviations at which two ellipsoids touch: a uniform plate ends at sqrt(3) along each axis, and noise widens it.
pub(super) const TOUCHING_SIGMAS: f64 = 2.0;

/// Differences of two masses below this are rounding of masses that sum to one.
pub(super) const ROUNDING: f64 = 1e-17;

/// Plans that Algorithm 1 solves at most, so that the time is bounded for any input. What is left then is taken in the
/// order of the last plan.
pub(super) const MAX_PLANS: usize = 256;

/// A ray belongs to the silhouette of a thing up to this many row spacings from the thing's own rays: between two rows there is
/// none nearer than half a spacing, and a lost return leaves one and a half.
pub(super) const SILHOUETTE_SPACINGS: f64 = 1.5;

/// Points of a view that are compared with each other to see whether its origin is plausible, at most: 16 million pairs.
pub(super) const PLAUSIBILITY_SAMPLES: usize = 4096;
/// Diagonal of the middle of a view above which it is refused, metres: the lasers of robots measure up to some hundred metres, and
/// a room of a few metres in millimetres has thousands.
pub(super) const MAX_SPREAD_M: f64 = 1000.0;
/// A sensor this share of that diagonal outside is asked whether it looks through the cloud. The recordings have up to a
/// sixth.
pub(super) const MIN_OUTSIDE_SHARE: f64 = 0.25;
/// Rays in one direction whose ranges differ by this share of the diagonal ended on two surfaces.
pub(super) const HIDDEN_DEPTH_SHARE: f64 = 0.1;
/// Neighbours by direction, the ray itself among them: ranges of three others.
pub(super) const LAYER_NEIGHBOURS: usize = 4;
/// Share of rays near another surface from which a sensor looks through the cloud. Edges give .04 to .13 in recordings of rooms
/// and halls, a wrong position .50 to .96 (nine positions 4 m to 5 km outside of a recorded room).
pub(super) const MAX_HIDDEN_SHARE: f64 = 0.3;

/// Distances between neighbouring own beams within which another view with the same pattern has a beam, wherever its own fall: one
/// of two that lie half a distance beside may be lost.
pub(super) const LOOKED_AT_SPACINGS: f64 = 2.0;

/// Share of a view's returns that count as strays, at either end of its ranges. Own choice, not measured: a reflection or a mixed
/// pixel must not vouch for the sensor's reach.
pub(super) const STRAY_SHARE: f64 = 0.001;

/// Solid angle, steradians, from which what gives nothing back is a thing. A third of a person whom 250 beams of a sweep meet
/// (15 550 beams per steradian); `patrold evaluate` counts the quiet pairs that reach it.
pub(super) const ABSORBING_MIN_SR: f64 = 0.005;

/// Width of the cells in which beams are counted for it, in row spacings of the coarser view: each holds a beam of every row and
/// column, wherever they fall.
pub(super) const ABSORBING_CELL_SPACINGS: f64 = 1.5;

/// Fewest rows and columns of such cells. Chosen: what is thinner may lie between two beams.
pub(super) const ABSORBING_MIN_CELLS: usize = 3;

/// Share of the columns below or above such a thing on which something comes back, at least, where it ends within the field of
/// view. Own choice, not measured: one in five may end at another thing's shadow.
pub(super) const ABSORBING_EDGE_SHARE: f64 = 0.8;

/// A neighbour within this many standard deviations, of its noise and of the thickness of the surface, lies on the plane of a
/// surface: by chance 3 in 1,000 do not.
pub(super) const ON_PLANE_SIGMAS: f64 = 3.0;

/// Beams of the reference by which the share of its solid angle is measured, at most: a share is known to one in a hundred.
pub(super) const COVERAGE_SAMPLES: usize = 8192;
/// Width of the bearings that are named as not looked at, degrees: a person is as wide at 5 m.
pub(super) const BEARING_BIN_DEG: f64 = 5.0;
/// Runs of bearings that are named, at most: a line of text.
pub(super) const NAMED_BEARINGS: usize = 3;

/// Components of a reference's mixture at most, so that the time is bounded for any input. The busiest of 124 recorded views,
/// a hall, has 856.
pub(super) const MAX_COMPONENTS: usize = 4096;
