//! What may be chosen about the retrieval of shapes.

use super::ransac::RansacSettings;
use crate::geometry::NoiseLaw;
use nalgebra::{Unit, Vector3};

/// Which method answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// Covariance matching with the points as judge; RANSAC where that has no answer. Both are told.
    Auto,
    /// Method B alone is asked.
    Covariance,
    /// Method A alone is asked.
    Ransac,
}

/// Which moments a class is expected to have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceModel {
    /// Those of the part of its surface that the sensor sees.
    Visible,
    /// Those of its whole ideal surface, as printed in section IV.B. Also used wherever the sensor
    /// stands among the points.
    Ideal,
}

/// How many points fall on a patch of visible surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BeamDensity {
    /// Uniform per solid angle: cos(i) / rho^2.
    SolidAngle,
    /// A line scanner tilted about `axis` (through the sensor): as above, times 1 / cos(azimuth),
    /// since the rows crowd towards the axis.
    TiltSweep {
        /// Tilt axis, in the frame of the points.
        axis: Unit<Vector3<f64>>,
    },
    /// Uniform per area: a cloud thinned by voxels.
    Area,
}

/// What method A looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RansacSource {
    /// The novelty's own points.
    Points,
    /// Samples on the ellipsoids of its Gaussians (section IV.A).
    Ellipsoids {
        /// How many; 3722 in the paper.
        samples: usize,
        /// Semi-axes in standard deviations: 1 as printed; sqrt 3 gives a ball's surface its radius.
        scale: f64,
    },
}

/// Settings of the room.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeSettings {
    /// Which method answers.
    pub choice: Choice,
    /// Whose moments are matched.
    pub surface: SurfaceModel,
    /// How points spread over a surface.
    pub density: BeamDensity,
    /// Whether the points' distances from the surface take part in method B (fit and class);
    /// without them it knows the moments alone, as the paper does.
    pub points_judge: bool,
    /// Whether the moments are the mixture's instead of the points' own.
    pub moments_of_mixture: bool,
    /// Noise of a point as a law of its range.
    pub noise: NoiseLaw,
    /// Share of the points that count as independent, (0, 1].
    pub independent_share: f64,
    /// A class less probable than this is told as ambiguous.
    pub ambiguous_below: f64,
    /// What method A looks at.
    pub ransac_source: RansacSource,
    /// Method A's own settings; `None` derives them from the noise and the spread of the points.
    pub ransac: Option<RansacSettings>,
    /// One primitive whose residual exceeds the noise (with roughness) by this factor does not
    /// explain the thing; its parts are sought.
    pub parts_above: f64,
}

impl Default for ShapeSettings {
    /// The standard engine. Noise: the URG-04LX's repeatability at 0.1-4 m (protocols/scip2.md
    /// section 11, 2-12 mm) with the share of its bias that does not cancel.
    fn default() -> Self {
        Self {
            choice: Choice::Auto,
            surface: SurfaceModel::Visible,
            density: BeamDensity::SolidAngle,
            points_judge: true,
            moments_of_mixture: false,
            noise: NoiseLaw {
                at_zero_m: 0.005,
                per_m: 0.002,
            },
            independent_share: 1.0,
            ambiguous_below: 0.75,
            ransac_source: RansacSource::Points,
            ransac: None,
            parts_above: 2.0,
        }
    }
}

impl ShapeSettings {
    /// The paper's way, made well-posed: the mixture's moments against ideal surfaces, RANSAC on
    /// 3722 samples of the ellipsoids.
    pub fn ideal() -> Self {
        Self {
            surface: SurfaceModel::Ideal,
            points_judge: false,
            moments_of_mixture: true,
            ambiguous_below: 0.0,
            ransac_source: RansacSource::Ellipsoids {
                samples: 3722,
                scale: 1.0,
            },
            ..Self::default()
        }
    }
}
