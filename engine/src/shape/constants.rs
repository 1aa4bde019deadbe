//! Every constant that decides something in this room, with unit and origin. What a site may want
//! to change stands in [`ShapeSettings`](super::ShapeSettings) instead.

/// What sizes a class may have, full lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    /// Least.
    pub least: f64,
    /// Greatest.
    pub most: f64,
}

impl Range {
    /// The nearest allowed value.
    pub fn clamp(&self, value: f64) -> f64 {
        value.clamp(self.least, self.most)
    }

    /// `start` moved by `x` (about a factor e^x in the middle of the range) without ever leaving
    /// it: a logistic curve over the logarithm.
    pub fn moved(&self, start: f64, x: f64) -> f64 {
        let width = (self.most / self.least).ln();
        // At a bound the curve is flat and a solver would be stuck; begin a little inside.
        let share = ((start / self.least).ln() / width).clamp(0.01, 0.99);
        let y = (share / (1.0 - share)).ln() + x * 4.0 / width;
        self.clamp(self.least * (width / (1.0 + (-y).exp())).exp())
    }
}

/// Bounds of the classes.
pub(super) struct Bounds {
    pub sphere_diameter_m: Range,
    pub cylinder_diameter_m: Range,
    pub cylinder_length_m: Range,
    pub plane_side_m: Range,
    pub box_side_m: Range,
    pub cone_diameter_m: Range,
    pub cone_height_m: Range,
    pub superquadric_side_m: Range,
    /// Exponents, of no unit: below 0.1 a surface is as square, above 1.9 as pointed as any laser
    /// can tell, and powers lose their digits.
    pub exponent: Range,
}

/// From 3 cm (five beams of the URG-04LX, 0.36 deg, at 1 m) to what a corridor can hold.
pub(super) const BOUNDS: Bounds = Bounds {
    sphere_diameter_m: Range {
        least: 0.03,
        most: 3.0,
    },
    cylinder_diameter_m: Range {
        least: 0.03,
        most: 3.0,
    },
    cylinder_length_m: Range {
        least: 0.03,
        most: 6.0,
    },
    plane_side_m: Range {
        least: 0.03,
        most: 10.0,
    },
    box_side_m: Range {
        least: 0.03,
        most: 6.0,
    },
    cone_diameter_m: Range {
        least: 0.03,
        most: 3.0,
    },
    cone_height_m: Range {
        least: 0.03,
        most: 6.0,
    },
    superquadric_side_m: Range {
        least: 0.03,
        most: 6.0,
    },
    exponent: Range {
        least: 0.1,
        most: 1.9,
    },
};

/// Least number of points that bear a shape: nine moments need some more points than moments.
pub(super) const LEAST_POINTS: usize = 10;
/// Points whose second principal standard deviation is less than this are a line or a spot and
/// carry no shape, metres (the sensor's resolution).
pub(super) const LEAST_SPREAD_M: f64 = 1e-3;
/// Added to observed and to model standard deviations alike, so that the logarithm of a flat
/// thing's thickness stays finite, metres (the sensor's quantisation).
pub(super) const MOMENT_FLOOR_M: f64 = 1e-3;
/// How well real surfaces follow the visible-surface moments: standard deviation of the mean, in
/// units of the spread. Things are clipped at the foot and at grazing angles.
pub(super) const MEAN_MISFIT: f64 = 0.05;
/// The same of a log-variance: 0.1 is 5 % of a length.
pub(super) const LOG_VARIANCE_MISFIT: f64 = 0.1;
/// Standard deviation of the logarithm of the noise about its law: colour, material, incidence.
pub(super) const LOG_NOISE_SD: f64 = 0.35;
/// Least noise assumed, metres; keeps the logarithm finite on perfect data.
pub(super) const LEAST_NOISE_M: f64 = 1e-4;
/// Roughness of real things, share of their spread: joins the noise where points judge a surface.
pub(super) const ROUGHNESS_SHARE: f64 = 0.02;
/// Points count as at most this many independent witnesses of a surface; beyond, misfit of the
/// ideal shape, not noise, sets what they can tell.
pub(super) const MOST_WITNESSES: f64 = 150.0;
/// Points that take part in a fit; more of them add time, not knowledge (see above).
pub(super) const MOST_FITTED_POINTS: usize = 160;
/// Where the pull of an outlying point levels off, in standard deviations.
pub(super) const OUTLIER_SIGMAS: f64 = 3.0;
/// A cylinder shorter than this share of its width, or whose axis lies within
/// `LEAST_AXIS_VIEW_RAD` of the line of sight, is told apart from a disc or a plane by its edge
/// only; such answers pay `UNLIKELY_PENALTY` (as -2 ln odds).
pub(super) const LEAST_LENGTH_SHARE: f64 = 0.5;
/// See `LEAST_LENGTH_SHARE`; 25 deg.
pub(super) const LEAST_AXIS_VIEW_RAD: f64 = 0.44;
/// See `LEAST_LENGTH_SHARE`. A box pays it, too, behind whose first face no more points lie than
/// strays do: its edge alone tells it from a plane.
pub(super) const UNLIKELY_PENALTY: f64 = 10.0;
/// Fits of one class whose moments cost this much more than its best (as -2 ln odds) are given up
/// before the points are asked.
pub(super) const PROMISING_COST: f64 = 40.0;
/// Share of the points next to a surface from which on it is the thing's: a segmented thing holds a
/// few per cent of others, and as many lie beyond three standard deviations of rough ones.
pub(super) const LEAST_NEAR_SHARE: f64 = 0.8;
/// Neighbours that a point of a thing has within `LONELY_SPACINGS`; clusters of no more are strays.
pub(super) const LONELY_COMPANY: usize = 3;
/// See `LONELY_COMPANY`; in distances to the sixth neighbour, within which the third lies at some
/// 0.7: rows of a scan part by up to three times where a surface slants away.
pub(super) const LONELY_SPACINGS: f64 = 2.8;
/// More than this share of all points is no set of strays but a thing of its own kind.
pub(super) const MOST_LONELY_SHARE: f64 = 0.2;
/// Classes less probable than this are not listed among the alternatives: a posterior is known to a
/// hundredth at best (rates over a hundred looks, `trials.rs`). Those ruled out early lie far below.
pub(super) const LEAST_LISTED_PROBABILITY: f64 = 0.01;
/// Classes whose moments cost this much more than another's (as -2 ln odds) are no candidates: the
/// prior against the data would have to be e^40.
pub(super) const RULED_OUT_COST: f64 = 80.0;
/// Points from which on further classes are asked: four for every parameter of a box.
pub(super) const LEAST_FURTHER_POINTS: usize = 36;
/// The same of a superquadric.
pub(super) const LEAST_SUPERQUADRIC_POINTS: usize = 44;
/// Sets of points that propose a box or a cone: with three faces in sight one set in thirty lies
/// as it should, so that some five of them do.
pub(super) const START_TRIES: usize = 200;
/// Proposals that are fitted.
pub(super) const STARTS_KEPT: usize = 3;
/// Where the pull of a point on a proposal ends, in standard deviations: small sets give rough
/// attitudes.
pub(super) const START_SIGMAS: f64 = 4.0;
/// Seed of the sets: a fixed choice, since they only begin fits.
pub(super) const START_SEED: u64 = 7;
/// Superquadrics farther from the points than this many times what a class may be are given up: those
/// alike to them lie no nearer.
pub(super) const HOPEFUL: f64 = 2.0;
/// Times that those alike to the best superquadric are tried: two turns reach any other from any.
pub(super) const ROUNDS_OF_ALIKE: usize = 2;
/// Steps to a surface along a line: from a body's length away Newton halves the way at worst.
pub(super) const NEWTON_STEPS: usize = 12;
/// See `NEWTON_STEPS`, metres: a hundredth of the noise.
pub(super) const NEWTON_TOLERANCE_M: f64 = 1e-4;
/// Share of the points taken to lie beyond each end of a thing when a fit begins.
pub(super) const EDGE_QUANTILE: f64 = 0.02;
/// What is left between a surface and its points looks like noise up to this many standard
/// deviations of a chi-square of noise.
pub(super) const UNEXPLAINED_SIGMAS: f64 = 2.0;
/// Root 2: noise and a bias of its size together. Lasers of this kind are biased by colour and
/// incidence as much as they are noisy (protocols/scip2.md section 11: repeatability 2-12 mm, bounds 10 mm),
/// and a superquadric would follow that. A further class that leaves more than this does not explain the
/// points.
pub(super) const BIASED_NOISE: f64 = std::f64::consts::SQRT_2;
/// Relative standard deviation of a standard deviation that is told by a median, times root n
/// (efficiency .37 of 1 / root 2).
pub(super) const MEDIAN_SCATTER: f64 = 1.17;
/// Points through which a quadric is laid: three for each of its six coefficients.
pub(super) const QUADRIC_NEIGHBOURS: usize = 18;
/// A box thinner than this share of its second side is a board, told as plane.
pub(super) const BOARD_SHARE: f64 = 0.0625;
/// Points that noise brings over an edge onto a face that no beam meets, or beyond `OUTLIER_SIGMAS`
/// of a surface of at most `MOST_FITTED_POINTS` points (a normal law: 0.4).
pub(super) const FACE_FLOOR_POINTS: f64 = 1.0;
/// Fits of one class that are judged again by the spread of the points.
pub(super) const MOST_JUDGED: usize = 1;
/// Share of points next to a surface that belong to something else (segmentation leaves some). Where
/// more than it and `FACE_FLOOR_POINTS` lie beyond `OUTLIER_SIGMAS`, they are no strays but of a face
/// that the class does not have.
pub(super) const FOREIGN_SHARE: f64 = 0.02;
/// Rows farther apart than this many standard deviations show through the noise: at 1.5 what is left of
/// them is e^-9 of the mean density.
pub(super) const ROWS_SHOW_SIGMAS: f64 = 1.5;
/// Least blur of an edge, share of the spacing of the points: keeps the likelihood smooth.
pub(super) const LEAST_BLUR_SHARE: f64 = 0.1;
/// Noise is told at most this many times too large.
pub(super) const LEAST_NOISE_SHARE: f64 = 0.5;
/// Points from which on their own spread about a surface tells their noise (to a sixth).
pub(super) const LEAST_SEEN_NOISE: usize = 20;
/// Standard deviations from an edge at which it has no more say (a normal law's 1e-9).
pub(super) const SHARP_EDGE_SIGMAS: f64 = 6.0;
/// Steps of the climb to the likeliest edges at most; it settles in about ten.
pub(super) const CLIMB_STEPS: usize = 40;
/// Gain of log-likelihood that ends the climb.
pub(super) const CLIMB_TOLERANCE: f64 = 1e-4;
/// Greatest distance of ellipsoid samples from a primitive, share of their spread.
pub(super) const CONSENSUS_EPSILON_SHARE: f64 = 0.1;
/// Points that method A looks at; it answers with one primitive, which more do not better.
pub(super) const MOST_CONSENSUS_POINTS: usize = 2000;
/// Points of a primitive that tell its residual, to 1 %.
pub(super) const RESIDUAL_POINTS: usize = 4096;
/// Neighbours that give a normal.
pub(super) const NORMAL_NEIGHBOURS: usize = 12;
/// Fits of one class and cost whose centres lie closer are the same, metres.
pub(super) const SAME_ANSWER_M: f64 = 2e-3;
/// Sine of the elevation over a cap or a cone's base from which it is in full sight; 3 deg, below which
/// a row of beams rarely meets it at all.
pub(super) const CAP_IN_SIGHT_SIN: f64 = 0.05;
/// Relative tolerance of the matching: a ten-thousandth of a standard deviation is far below it.
pub(super) const TOLERANCE: f64 = 1e-4;
/// Evaluations per parameter at most.
pub(super) const PATIENCE: usize = 12;
/// Prior precision of every fitted parameter (units: spreads, radians, logarithms): keeps what
/// the data leave open finite, at ten units.
pub(super) const PRIOR_PRECISION: f64 = 1e-2;
/// Cosine of the azimuth below which a tilt sweep's density 1/cos stops growing.
pub(super) const LEAST_AZIMUTH_COS: f64 = 0.05;

/// Step of the numerical derivatives; parameters are of order one.
pub(super) const STEP: f64 = 1e-6;

/// A point counts as of the surface that most of the points around it lie on: this share. Where another surface crosses,
/// a band of `1 / NEIGHBOURHOOD_NEARS` of the neighbourhood's radius to either side holds 0.42 of it.
pub(super) const ALONG_SHARE: f64 = 0.6;
/// Radius of that neighbourhood, in half widths of the band about a surface.
pub(super) const NEIGHBOURHOOD_NEARS: f64 = 3.0;
/// Fewest points along a surface, of which each view is to have so many before it is said to have the surface there.
pub(super) const LEAST_ALONG: usize = 3;
/// Points that tell a flat surface and their own scatter about it: two for each of its three parameters.
pub(super) const LEAST_FORMER: usize = 6;
/// What stands on a surface is looked for over a point within this slope, height over distance: 27 deg off
/// its normal. Where a wall ends, it rises beside a point of the floor beyond, not over it.
pub(super) const LEAST_RISE: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::BOUNDS;

    #[test]
    fn bounded_sizes_start_where_told_and_stay_inside() {
        let range = BOUNDS.sphere_diameter_m;
        assert!((range.moved(0.4, 0.0) - 0.4).abs() < 1e-12);
        assert!(range.moved(0.4, 1e6) <= range.most);
        assert!(range.moved(0.4, -1e6) >= range.least);
        let slope = (range.moved(0.3, 1e-6) / 0.3).ln() / 1e-6;
        assert!((slope - 1.0).abs() < 0.01);
    }
}
