//! Constants of the retrieval, with unit and origin. What a site may change is in
//! [`ShapeSettings`](super::ShapeSettings).

/// Allowed values of one size (full length, metres) or exponent of a class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ParameterRange {
    pub min: f64,
    pub max: f64,
}

impl ParameterRange {
    pub(super) fn clamp(&self, value: f64) -> f64 {
        value.clamp(self.min, self.max)
    }

    /// `start` changed by `x` (about a factor e^x in the middle of the range) without leaving the range: a logistic
    /// curve over the logarithm.
    pub(super) fn perturbed(&self, start: f64, x: f64) -> f64 {
        let width = (self.max / self.min).ln();
        // At a bound the curve is flat and a solver would be stuck: start a little inside.
        let share = ((start / self.min).ln() / width).clamp(0.01, 0.99);
        let y = (share / (1.0 - share)).ln() + x * 4.0 / width;
        self.clamp(self.min * (width / (1.0 + (-y).exp())).exp())
    }
}

/// Ranges of all classes' parameters.
pub(super) struct ParameterBounds {
    pub sphere_diameter_m: ParameterRange,
    pub cylinder_diameter_m: ParameterRange,
    pub cylinder_length_m: ParameterRange,
    pub plane_side_m: ParameterRange,
    pub box_side_m: ParameterRange,
    pub cone_diameter_m: ParameterRange,
    pub cone_height_m: ParameterRange,
    pub superquadric_side_m: ParameterRange,
    /// Below 0.1 a surface is as square, above 1.9 as pointed as a laser can resolve, and powers lose their digits.
    pub exponent: ParameterRange,
}

/// From 3 cm (five beams of the URG-04LX, 0.36 deg, at 1 m) to what a corridor can hold.
pub(super) const BOUNDS: ParameterBounds = ParameterBounds {
    sphere_diameter_m: ParameterRange {
        min: 0.03,
        max: 3.0,
    },
    cylinder_diameter_m: ParameterRange {
        min: 0.03,
        max: 3.0,
    },
    cylinder_length_m: ParameterRange {
        min: 0.03,
        max: 6.0,
    },
    plane_side_m: ParameterRange {
        min: 0.03,
        max: 10.0,
    },
    box_side_m: ParameterRange {
        min: 0.03,
        max: 6.0,
    },
    cone_diameter_m: ParameterRange {
        min: 0.03,
        max: 3.0,
    },
    cone_height_m: ParameterRange {
        min: 0.03,
        max: 6.0,
    },
    superquadric_side_m: ParameterRange {
        min: 0.03,
        max: 6.0,
    },
    exponent: ParameterRange { min: 0.1, max: 1.9 },
};

// Points that take part.

/// Points that a shape needs: a few more than the nine moments.
pub(super) const MIN_POINTS: usize = 10;
/// Points whose second principal standard deviation is less than this are a line or a spot and have no shape, metres
/// (the sensor's resolution).
pub(super) const MIN_SPREAD_M: f64 = 1e-3;
/// Least noise assumed, metres; keeps the logarithm finite on perfect data.
pub(super) const MIN_NOISE_M: f64 = 1e-4;
/// Roughness of real objects, as a share of their spread; added to the noise of a point about a surface.
pub(super) const ROUGHNESS_SHARE: f64 = 0.02;
/// A point with fewer neighbours within `OUTLIER_RADIUS_SPACINGS` is an outlier; so are clusters of no more points than
/// this.
pub(super) const MIN_NEIGHBOURS: usize = 3;
/// In distances to the sixth neighbour; the third lies at some 0.7 of that, and rows of a scan are up to three times
/// as far apart where a surface slants away.
pub(super) const OUTLIER_RADIUS_SPACINGS: f64 = 2.8;
/// Where more than this share of the points would be outliers, they are kept: a sparse object.
pub(super) const MAX_OUTLIER_SHARE: f64 = 0.2;
/// Share of the points next to a surface from which on the object is of the surface's class: a segment holds a few per
/// cent of other objects' points, and as many lie beyond three standard deviations of a rough one.
pub(super) const MIN_INLIER_SHARE: f64 = 0.8;
/// Share of points next to a surface that belong to something else (segmentation leaves some). Where more than it and
/// `FACE_NOISE_POINTS` lie beyond `OUTLIER_SIGMAS`, they are of a face that the class does not have.
pub(super) const OUTLIER_FRACTION: f64 = 0.02;
/// Points that noise brings over an edge onto a face that no beam meets, or beyond `OUTLIER_SIGMAS` of a surface of at
/// most `MAX_FITTED_POINTS` points (a normal distribution: 0.4).
pub(super) const FACE_NOISE_POINTS: f64 = 1.0;

// Matching of moments.

/// Added to observed and to model standard deviations alike, so that the logarithm of a plane's thickness stays
/// finite, metres (the sensor's quantisation).
pub(super) const MOMENT_FLOOR_M: f64 = 1e-3;
/// Error of the visible-surface model: standard deviation of the mean, in units of the spread. Real objects are cut off
/// at the foot and at grazing angles.
pub(super) const MEAN_MISFIT: f64 = 0.05;
/// The same of a log-variance: 0.1 is 5 % of a length.
pub(super) const LOG_VARIANCE_MISFIT: f64 = 0.1;
/// Standard deviation of the logarithm of the noise about its law: colour, material, incidence.
pub(super) const LOG_NOISE_SD: f64 = 0.35;
/// Greatest effective number of points in a likelihood: beyond, the misfit of the ideal shape and not the noise limits
/// what they can tell.
pub(super) const MAX_EFFECTIVE_POINTS: f64 = 150.0;
/// Points that take part in a fit; more of them add time, not knowledge (see `MAX_EFFECTIVE_POINTS`).
pub(super) const MAX_FITTED_POINTS: usize = 160;
/// Where the pull of an outlying point levels off, in standard deviations.
pub(super) const OUTLIER_SIGMAS: f64 = 3.0;
/// Relative tolerance of the matching: a ten-thousandth of a standard deviation is far below it.
pub(super) const FIT_TOLERANCE: f64 = 1e-4;
/// The solver stops after this many evaluations per parameter.
pub(super) const MAX_EVALS_PER_PARAMETER: usize = 12;
/// Step of the numerical derivatives; parameters are of order one.
pub(super) const DERIVATIVE_STEP: f64 = 1e-6;
/// Prior precision of every fitted parameter (units: spreads, radians, logarithms): keeps what the data leave open
/// finite, at ten units.
pub(super) const PRIOR_PRECISION: f64 = 1e-2;
/// Cosine of the azimuth below which the density 1/cos of a tilt sweep stops growing.
pub(super) const MIN_AZIMUTH_COS: f64 = 0.05;
/// Fits of one class and cost whose centres are closer are the same, metres.
pub(super) const SAME_CENTRE_M: f64 = 2e-3;

// Choice of the class. Costs are -2 ln odds.

/// Fits of one class whose moments cost this much more than its best are dropped before the points are compared.
pub(super) const PROMISING_COST: f64 = 40.0;
/// Classes whose moments cost this much more than another's are dropped: the prior against the data would have to be
/// e^40.
pub(super) const RULED_OUT_COST: f64 = 80.0;
/// Fits of one class that are refined with the points.
pub(super) const MAX_REFINED: usize = 1;
/// A cylinder shorter than this share of its width, or whose axis is within `MIN_AXIS_TO_VIEW_RAD` of the line of
/// sight, differs from a disc or a plane by its edge only, and pays `FORM_PENALTY`.
pub(super) const MIN_LENGTH_TO_WIDTH: f64 = 0.5;
/// See `MIN_LENGTH_TO_WIDTH`; 25 deg.
pub(super) const MIN_AXIS_TO_VIEW_RAD: f64 = 0.44;
/// See `MIN_LENGTH_TO_WIDTH`. A box of one visible face pays it too: it differs from a plane by its edge only.
pub(super) const FORM_PENALTY: f64 = 10.0;
/// A box thinner than this share of its second side is a plate, reported as a plane.
pub(super) const PLATE_THICKNESS_SHARE: f64 = 0.0625;
/// Residuals look like noise up to this many standard deviations of a chi-square of noise.
pub(super) const UNEXPLAINED_SIGMAS: f64 = 2.0;
/// Root 2: noise and a bias of its size together. Lasers of this kind are biased by colour and incidence as much as they
/// are noisy (scip2 section 11: repeatability 2-12 mm, bounds 10 mm), and a superquadric would follow that bias. A box,
/// cone or superquadric that leaves more than this does not explain the points.
pub(super) const BIASED_NOISE_RATIO: f64 = std::f64::consts::SQRT_2;
/// Relative standard deviation of a standard deviation taken from a median, times root n (efficiency .37 of 1 / root 2).
pub(super) const MEDIAN_RELATIVE_SD: f64 = 1.17;
/// Points through which a quadric is laid: three for each of its six coefficients.
pub(super) const QUADRIC_NEIGHBOURS: usize = 18;
/// The noise taken from the residuals is at least this share of the expected one.
pub(super) const MIN_NOISE_RATIO: f64 = 0.5;
/// Points whose spread about a surface gives their noise (to a sixth).
pub(super) const MIN_POINTS_NOISE: usize = 20;
/// Classes less probable than this are not listed among the alternatives: a posterior is known to a hundredth at best
/// (rates over a hundred simulated views, `tests/trials.rs`). Those dropped early are far less probable.
pub(super) const MIN_LISTED_PROBABILITY: f64 = 0.01;

// Starts of box, cone and superquadric.

/// Points from which on boxes and cones are tried: four for every parameter of a box.
pub(super) const MIN_POINTS_BOX_CONE: usize = 36;
/// The same of a superquadric.
pub(super) const MIN_POINTS_SUPERQUADRIC: usize = 44;
/// Sets of points that propose a box or a cone: with three faces in sight one set in thirty has the true attitude, so
/// that some five do.
pub(super) const START_SAMPLES: usize = 200;
/// Proposals that are fitted.
pub(super) const MAX_STARTS: usize = 3;
/// Cutoff of a point's residual from a proposal, in standard deviations: small sets give rough attitudes.
pub(super) const START_CUTOFF_SIGMAS: f64 = 4.0;
/// Fixed, since the sets only start fits.
pub(super) const START_SEED: u64 = 7;
/// Share of the points beyond each end of an object when a fit starts.
pub(super) const EDGE_QUANTILE: f64 = 0.02;
/// A superquadric whose residual is more than this many times the largest that a class may leave is dropped: its
/// equivalents fit no better.
pub(super) const MAX_RESIDUAL_RATIO: f64 = 2.0;
/// Rounds in which equivalents of the best superquadric are tried: two rotations reach any other from any.
pub(super) const EQUIVALENT_ROUNDS: usize = 2;
/// Newton steps to a superquadric's surface along a line: from a body's length away a step halves the way at worst.
pub(super) const NEWTON_STEPS: usize = 12;
/// See `NEWTON_STEPS`, metres: a hundredth of the noise.
pub(super) const NEWTON_TOLERANCE_M: f64 = 1e-4;
/// Sine of the elevation over a cap or a cone's base from which on it counts as fully in sight; 3 deg, below which a row
/// of beams rarely meets it at all.
pub(super) const FULL_VIEW_ELEVATION_SIN: f64 = 0.05;

// Lengths from edges.

/// Rows farther apart than this many standard deviations of the noise are resolved: at 1.5 the blur leaves e^-9 of
/// their contrast.
pub(super) const RESOLVED_ROW_SIGMAS: f64 = 1.5;
/// Least blur of an edge, share of the spacing of the points: keeps the likelihood smooth.
pub(super) const MIN_BLUR_SHARE: f64 = 0.1;
/// Standard deviations from an edge beyond which it has no effect (a normal distribution's 1e-9).
pub(super) const EDGE_CUTOFF_SIGMAS: f64 = 6.0;
/// Steps to the likeliest edges at most; about ten are taken.
pub(super) const MAX_LIKELIHOOD_STEPS: usize = 40;
/// Gain of log-likelihood that ends the ascent.
pub(super) const LIKELIHOOD_TOLERANCE: f64 = 1e-4;

// Method A.

/// Samples on a novelty's ellipsoids (paper section V).
pub(super) const ELLIPSOID_SAMPLES: usize = 3722;
/// Semi-axes of the ellipsoids, standard deviations: sqrt 3, since a sphere's surface of radius r has the variance r^2 / 3
/// along every axis. The paper prints no factor (`docs/shapes.md section 8`).
pub const ELLIPSOID_SIGMAS: f64 = 1.732_050_807_568_877_2;
/// Greatest distance of ellipsoid samples from a primitive, share of their spread.
pub(super) const CONSENSUS_EPSILON_SHARE: f64 = 0.1;
/// Points that method A uses for a single primitive; more do not improve it.
pub(super) const MAX_CONSENSUS_POINTS: usize = 2000;
/// Points of a primitive from which its residual is known to 1 %.
pub(super) const RESIDUAL_POINTS: usize = 4096;
/// Neighbours from which a normal is estimated.
pub(super) const NORMAL_NEIGHBOURS: usize = 12;

// Points of the surroundings.

/// A point is of the surface that this share of the points around it is on. Where another surface crosses, a band of
/// `1 / NEIGHBOURHOOD_BANDS` of the neighbourhood's radius to either side holds 0.42 of it.
pub(super) const MIN_ON_SURFACE_SHARE: f64 = 0.6;
/// Radius of that neighbourhood, in half widths of the band about a surface.
pub(super) const NEIGHBOURHOOD_BANDS: f64 = 3.0;
/// Points on a surface from which on a view counts as having the surface there.
pub(super) const MIN_ON_SURFACE: usize = 3;
/// Points that fix a flat surface and their scatter about it: two for each of its three parameters.
pub(super) const MIN_FORMER_POINTS: usize = 6;
/// What stands on a surface is above it at this slope or more, height over distance: 27 deg off its normal. Where a wall
/// ends, it rises beside a point of the floor beyond, not over it.
pub(super) const MIN_RISE_SLOPE: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::BOUNDS;

    #[test]
    fn perturbed_sizes_start_at_the_given_value_and_stay_inside() {
        let range = BOUNDS.sphere_diameter_m;
        assert!((range.perturbed(0.4, 0.0) - 0.4).abs() < 1e-12);
        assert!(range.perturbed(0.4, 1e6) <= range.max);
        assert!(range.perturbed(0.4, -1e6) >= range.min);
        let slope = (range.perturbed(0.3, 1e-6) / 0.3).ln() / 1e-6;
        assert!((slope - 1.0).abs() < 0.01);
    }
}
