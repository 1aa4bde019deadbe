//! Settings of the retrieval.

use super::constants::{ELLIPSOID_SAMPLES, ELLIPSOID_SIGMAS};
use super::ransac::RansacSettings;
use crate::geometry::NoiseLaw;
use nalgebra::{Unit, Vector3};

/// Which method gives the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MethodChoice {
    /// Method B; method A where B has no answer. The results of both are kept.
    Auto,
    /// Method B alone.
    Covariance,
    /// Method A alone.
    Ransac,
}

/// Which moments a class is expected to have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceModel {
    /// Those of the part of its surface that the sensor sees.
    Visible,
    /// Those of its whole ideal surface, as printed in paper section IV.B. Also used where the sensor is among the
    /// points.
    Ideal,
}

/// How many points fall on an element of visible surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BeamDensity {
    /// Uniform per solid angle: cos(i) / rho^2.
    SolidAngle,
    /// A line scanner tilted about `axis` (through the sensor): as above, times 1 / cos(azimuth), since the rows crowd
    /// towards the axis.
    TiltSweep {
        /// Tilt axis, in the frame of the points.
        axis: Unit<Vector3<f64>>,
    },
    /// Uniform per area: a cloud thinned by voxels.
    Area,
}

/// Input of method A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RansacSource {
    /// The novelty's own points.
    Points,
    /// Samples on the ellipsoids of its Gaussians (paper section IV.A).
    Ellipsoids {
        /// How many; 3722 in the paper.
        samples: usize,
        /// Semi-axes in standard deviations: sqrt 3 gives a ball's surface its radius. The paper prints no factor.
        scale: f64,
    },
}

/// Settings of [`retrieve`](super::retrieve) and [`detect_shapes`](super::detect_shapes).
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeSettings {
    /// Which method gives the answer.
    pub choice: MethodChoice,
    /// Which moments method B expects.
    pub surface: SurfaceModel,
    /// How points spread over a surface.
    pub density: BeamDensity,
    /// Whether method B also fits and compares the distances of the points from the surface; without them it uses the
    /// moments alone, as the paper does.
    pub use_point_distances: bool,
    /// Whether method B takes the moments of the mixture instead of those of the points.
    pub use_mixture_moments: bool,
    /// Noise of a point by its range.
    pub noise: NoiseLaw,
    /// Share of the points that count as independent, (0, 1].
    pub independent_share: f64,
    /// A class less probable than this is reported as ambiguous.
    pub ambiguous_below: f64,
    /// Input of method A.
    pub ransac_source: RansacSource,
    /// Settings of method A; `None` derives them from the noise and the spread of the points.
    pub ransac: Option<RansacSettings>,
    /// Where the residual of one primitive exceeds noise and roughness by this factor, several are sought.
    pub parts_above_ratio: f64,
}

impl Default for ShapeSettings {
    /// The standard engine. Noise: the URG-04LX's repeatability at 0.1-4 m (scip2 section 11, 2-12 mm) with the share
    /// of its bias that does not cancel.
    fn default() -> Self {
        Self {
            choice: MethodChoice::Auto,
            surface: SurfaceModel::Visible,
            density: BeamDensity::SolidAngle,
            use_point_distances: true,
            use_mixture_moments: false,
            noise: NoiseLaw {
                at_zero_m: 0.005,
                per_m: 0.002,
            },
            independent_share: 1.0,
            ambiguous_below: 0.75,
            ransac_source: RansacSource::Points,
            ransac: None,
            parts_above_ratio: 2.0,
        }
    }
}

impl ShapeSettings {
    /// The paper's methods, made well-posed: the mixture's moments against those of the visible side, RANSAC on 3722 samples
    /// of the ellipsoids.
    pub fn paper() -> Self {
        Self {
            use_point_distances: false,
            use_mixture_moments: true,
            ambiguous_below: 0.0,
            ransac_source: RansacSource::Ellipsoids {
                samples: ELLIPSOID_SAMPLES,
                scale: ELLIPSOID_SIGMAS,
            },
            ..Self::default()
        }
    }

    /// The paper's methods to the letter: as [`Self::paper`], but moments are compared with those of whole ideal surfaces.
    pub fn paper_independent() -> Self {
        Self {
            surface: SurfaceModel::Ideal,
            ..Self::paper()
        }
    }

    /// The same with ellipsoids of `sigmas` standard deviations (above zero), where method A takes samples on them.
    pub fn with_ellipsoid_sigmas(mut self, sigmas: f64) -> Self {
        if let RansacSource::Ellipsoids { scale, .. } = &mut self.ransac_source {
            *scale = sigmas;
        }
        self
    }
}
