//! Covariance matching as least squares (paper Eq. 10-13, made well-posed): the visible moments of a primitive against
//! the observed ones, and its surface against the points.

use super::moments::surface_moments;
use crate::mixture::Gaussian;
use crate::shape::constants::{
    DERIVATIVE_STEP, FIT_TOLERANCE, LOG_NOISE_SD, LOG_VARIANCE_MISFIT, MAX_EVALS_PER_PARAMETER,
    MEAN_MISFIT, MIN_NOISE_M, MOMENT_FLOOR_M, OUTLIER_SIGMAS, PRIOR_PRECISION,
};
use crate::shape::primitive::Primitive;
use crate::shape::settings::{BeamDensity, SurfaceModel};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Matrix3, Owned, Point3, Vector3};

/// Residuals of the moments and of the noise: three, six and one.
const MOMENT_RESIDUALS: usize = 10;
/// Residual where the parameters allow no surface; no others come near it.
const INVALID_RESIDUAL: f64 = 1e4;

/// Likelihood of the points' distances from a surface (Cauchy loss).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PointLikelihood {
    /// Standard deviation of a point about the surface, metres.
    pub sd_m: f64,
    /// Number of independent points that all of them stand for.
    pub effective_points: f64,
}

/// Points and moments of a novelty, in coordinates about the mean.
pub(super) struct Observation {
    /// Sigma (with the floor) to the power -1/2.
    whitener: Matrix3<f64>,
    mean_weight: f64,
    log_weight: f64,
    /// Number of points that the moments stand for, misfit of the ideal shape included.
    pub effective_points: f64,
    pub independent_points: f64,
    /// Standard deviation over all directions, metres: the unit of lengths.
    pub scale_m: f64,
    /// Expected noise of a point, metres.
    pub noise_m: f64,
    pub sensor: Point3<f64>,
    pub points: Vec<Point3<f64>>,
    pub surface: SurfaceModel,
    pub density: BeamDensity,
}

impl Observation {
    /// `covariance` is about the mean of `independent_points` points.
    pub(super) fn new(
        covariance: &Matrix3<f64>,
        independent_points: f64,
        noise_m: f64,
        sensor: Point3<f64>,
        points: Vec<Point3<f64>>,
        surface: SurfaceModel,
        density: BeamDensity,
    ) -> Self {
        let floor = Matrix3::identity() * (MOMENT_FLOOR_M * MOMENT_FLOOR_M);
        let eigen = (covariance + floor).symmetric_eigen();
        let roots = eigen
            .eigenvalues
            .map(|l| 1.0 / l.max(MOMENT_FLOOR_M * MOMENT_FLOOR_M).sqrt());
        let log_variance = LOG_VARIANCE_MISFIT * LOG_VARIANCE_MISFIT;
        Self {
            whitener: eigen.eigenvectors
                * Matrix3::from_diagonal(&roots)
                * eigen.eigenvectors.transpose(),
            mean_weight: (1.0 / independent_points + MEAN_MISFIT * MEAN_MISFIT)
                .sqrt()
                .recip(),
            log_weight: (2.0 / independent_points + log_variance).sqrt().recip(),
            effective_points: 2.0 / (2.0 / independent_points + log_variance),
            independent_points,
            scale_m: covariance.trace().max(0.0).sqrt().max(MOMENT_FLOOR_M),
            noise_m: noise_m.max(MIN_NOISE_M),
            sensor,
            points,
            surface,
            density,
        }
    }

    /// Signed distance of `p` from the surface that the surface model expects points on, metres.
    pub(super) fn distance_m(&self, primitive: &Primitive, p: &Point3<f64>) -> f64 {
        match self.surface {
            SurfaceModel::Visible => primitive.visible_distance_m(p, &self.sensor),
            SurfaceModel::Ideal => primitive.distance_m(p),
        }
    }

    /// sqrt(n) Sigma^-1/2 (m - mu), then sqrt(n/2) log(Sigma^-1/2 M Sigma^-1/2) with off-diagonals times sqrt 2: the
    /// squares sum to the mean term and (n/2) d_FM^2 (paper Eq. 10).
    fn moment_residuals(&self, model: &Gaussian, noise_m: f64, out: &mut [f64]) -> Option<()> {
        let extra = noise_m * noise_m + MOMENT_FLOOR_M * MOMENT_FLOOR_M;
        let mean = self.whitener * model.mean.coords * self.mean_weight;
        let m = self.whitener * (model.covariance + Matrix3::identity() * extra) * self.whitener;
        if !m.iter().all(|v| v.is_finite()) {
            return None;
        }
        let eigen = m.symmetric_eigen();
        let logs: Vector3<f64> = eigen.eigenvalues.map(|l| l.max(1e-300).ln());
        let log = eigen.eigenvectors
            * Matrix3::from_diagonal(&logs)
            * eigen.eigenvectors.transpose()
            * self.log_weight;
        let root_2 = std::f64::consts::SQRT_2;
        let all = [
            mean.x,
            mean.y,
            mean.z,
            log[(0, 0)],
            log[(1, 1)],
            log[(2, 2)],
            log[(0, 1)] * root_2,
            log[(0, 2)] * root_2,
            log[(1, 2)] * root_2,
        ];
        out.iter_mut().zip(all).for_each(|(o, v)| *o = v);
        Some(())
    }
}

/// The least-squares problem. Parameters: those of the class, then the noise in its own standard deviations.
struct MatchingProblem<'a> {
    observed: &'a Observation,
    start: Primitive,
    likelihood: Option<PointLikelihood>,
    x: DVector<f64>,
    /// Residuals at `x`, kept for the derivatives.
    residuals: DVector<f64>,
}

impl<'a> MatchingProblem<'a> {
    fn new(
        observed: &'a Observation,
        start: Primitive,
        likelihood: Option<PointLikelihood>,
        x: DVector<f64>,
    ) -> Self {
        let mut new = Self {
            observed,
            start,
            likelihood,
            residuals: DVector::zeros(0),
            x,
        };
        new.residuals = new.residuals_at(&new.x);
        new
    }

    fn primitive(&self, x: &DVector<f64>) -> Option<Primitive> {
        let shape = x.as_slice().get(..self.start.parameter_count())?;
        self.start.perturbed(shape, self.observed.scale_m)
    }

    fn residual_count(&self) -> usize {
        MOMENT_RESIDUALS + self.likelihood.map_or(0, |_| self.observed.points.len())
    }

    fn try_residuals(&self, x: &DVector<f64>) -> Option<DVector<f64>> {
        let o = self.observed;
        let noise = *x.as_slice().last()?;
        if noise.abs() > 20.0 {
            return None;
        }
        let primitive = self.primitive(x)?;
        let model = surface_moments(&primitive, &o.sensor, o.surface, &o.density)?;
        let mut out = DVector::zeros(self.residual_count());
        let slots = out.as_mut_slice();
        let (moments, rest) = slots.split_at_mut_checked(MOMENT_RESIDUALS)?;
        o.moment_residuals(&model, o.noise_m * (LOG_NOISE_SD * noise).exp(), moments)?;
        *moments.last_mut()? = noise;
        if let Some(likelihood) = self.likelihood {
            let weight = (likelihood.effective_points / o.points.len().max(1) as f64).sqrt();
            for (slot, p) in rest.iter_mut().zip(&o.points) {
                *slot = weight * cauchy_residual(o.distance_m(&primitive, p) / likelihood.sd_m);
            }
        }
        out.iter().all(|v| v.is_finite()).then_some(out)
    }

    fn residuals_at(&self, x: &DVector<f64>) -> DVector<f64> {
        self.try_residuals(x)
            .unwrap_or_else(|| DVector::from_element(self.residual_count(), INVALID_RESIDUAL))
    }

    fn derivatives(&self) -> DMatrix<f64> {
        let mut j = DMatrix::zeros(self.residuals.len(), self.x.len());
        for k in 0..self.x.len() {
            let mut x = self.x.clone();
            x[k] += DERIVATIVE_STEP;
            j.set_column(
                k,
                &((self.residuals_at(&x) - &self.residuals) / DERIVATIVE_STEP),
            );
        }
        j
    }
}

/// Residual whose square is the Cauchy loss of `z` standard deviations, of scale `OUTLIER_SIGMAS`.
fn cauchy_residual(z: f64) -> f64 {
    let c = OUTLIER_SIGMAS;
    (z / c).powi(2).ln_1p().sqrt() * c * z.signum()
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for MatchingProblem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.x.copy_from(x);
        self.residuals = self.residuals_at(x);
    }

    fn params(&self) -> DVector<f64> {
        self.x.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.derivatives())
    }
}

/// A primitive after matching.
#[derive(Debug, Clone)]
pub(super) struct MatchedPrimitive {
    /// In the coordinates of the observation.
    pub primitive: Primitive,
    /// Sum of squared residuals: (n/2) d_FM^2, the mean term, the noise's prior and the points.
    pub cost: f64,
    likelihood: Option<PointLikelihood>,
    /// In standard deviations of its own.
    noise: f64,
}

impl MatchedPrimitive {
    /// Standard deviations of centre and size, metres; as expensive as a step of the fit.
    pub(super) fn standard_deviations(&self, observed: &Observation) -> ([f64; 3], [f64; 3]) {
        // About the fitted primitive: a length at its bound has no slope in the parameters that brought it there.
        let mut x = DVector::zeros(self.primitive.parameter_count() + 1);
        if let Some(noise) = x.as_mut_slice().last_mut() {
            *noise = self.noise;
        }
        standard_deviations(&MatchingProblem::new(
            observed,
            self.primitive,
            self.likelihood,
            x,
        ))
    }
}

/// Fits from `start`; `None` if the parameters found allow no surface.
pub(super) fn match_primitive(
    observed: &Observation,
    start: Primitive,
    likelihood: Option<PointLikelihood>,
) -> Option<MatchedPrimitive> {
    let x = DVector::zeros(start.parameter_count() + 1);
    let problem = MatchingProblem::new(observed, start, likelihood, x);
    let (problem, _) = LevenbergMarquardt::new()
        .with_tol(FIT_TOLERANCE)
        .with_patience(MAX_EVALS_PER_PARAMETER)
        .minimize(problem);
    let cost = problem.try_residuals(&problem.x)?.norm_squared();
    let primitive = problem.primitive(&problem.x)?;
    let noise = *problem.x.as_slice().last()?;
    Some(MatchedPrimitive {
        primitive,
        cost,
        likelihood,
        noise,
    })
}

/// Standard deviations of centre and size from (J^T J + prior)^-1.
fn standard_deviations(problem: &MatchingProblem<'_>) -> ([f64; 3], [f64; 3]) {
    let wide = [problem.observed.scale_m * 10.0; 3];
    let n = problem.x.len();
    let j = problem.derivatives();
    let normal = j.transpose() * j + DMatrix::identity(n, n) * PRIOR_PRECISION;
    let Some(inverse) = normal.cholesky().map(|c| c.inverse()) else {
        return (wide, wide);
    };
    let centre_and_size = |x: &DVector<f64>| {
        let p = problem.primitive(x)?;
        let (c, s) = (p.centre(), p.size_m());
        Some([c.x, c.y, c.z, s[0], s[1], s[2]])
    };
    let (Some(here), Some(root)) = (centre_and_size(&problem.x), inverse.cholesky()) else {
        return (wide, wide);
    };
    // One standard deviation to either side along every column of the root: a length that the data leave open is where
    // its bounded curve is flat, and has no slope there.
    let mut variance = [0.0; 6];
    for column in root.l().column_iter() {
        let step = column * (1.0 / column.norm()).min(1.0);
        for sign in [1.0, -1.0] {
            let there = centre_and_size(&(&problem.x + &step * sign)).unwrap_or(here);
            for (sum, (there, here)) in variance.iter_mut().zip(there.iter().zip(here)) {
                *sum += (there - here).powi(2) / 2.0;
            }
        }
    }
    let [x, y, z, first, second, third] = variance.map(f64::sqrt);
    ([x, y, z], [first, second, third])
}

#[cfg(test)]
mod tests {
    use super::{Observation, cauchy_residual, match_primitive};
    use crate::shape::matching::moments::surface_moments;
    use crate::shape::primitive::{Cylinder, Plane, Primitive, Sphere};
    use crate::shape::settings::{BeamDensity, SurfaceModel};
    use nalgebra::{Point3, Rotation3, Unit, Vector3};

    /// Fits the exact visible moments of `truth`.
    fn recovered(truth: Primitive, start: impl Fn(&Point3<f64>) -> Primitive) -> (Primitive, f64) {
        let sensor = Point3::new(-2.0, 0.4, 0.6);
        let (surface, density) = (SurfaceModel::Visible, BeamDensity::SolidAngle);
        let seen = surface_moments(&truth, &sensor, surface, &density).expect("visible");
        let about_mean = Point3::from(sensor - seen.mean);
        let observed = Observation::new(
            &seen.covariance,
            1e3,
            0.0,
            about_mean,
            Vec::new(),
            surface,
            density,
        );
        let found = match_primitive(&observed, start(&(Point3::origin())), None).expect("a fit");
        let back = nalgebra::Isometry3::from_parts(seen.mean.coords.into(), Default::default());
        (found.primitive.transformed(&back), found.cost)
    }

    #[test]
    fn a_sphere_is_recovered_from_its_moments() {
        let truth = Primitive::Sphere(Sphere {
            centre: Point3::new(0.5, 0.1, 0.3),
            radius_m: 0.27,
        });
        let (found, cost) = recovered(truth, |mean| {
            Primitive::Sphere(Sphere {
                centre: mean + Vector3::new(0.1, 0.0, 0.0),
                radius_m: 0.2,
            })
        });
        assert!((found.size_m()[0] - 0.54).abs() < 1e-5, "{found:?} {cost}");
        assert!((found.centre() - truth.centre()).norm() < 1e-5);
    }

    #[test]
    fn a_cylinder_is_recovered_from_its_moments() {
        let axis = Unit::new_normalize(Vector3::new(0.1, -0.3, 1.0));
        let truth = Primitive::Cylinder(Cylinder {
            centre: Point3::new(0.5, 0.1, 0.3),
            axis,
            radius_m: 0.15,
            length_m: 1.2,
        });
        let (found, cost) = recovered(truth, |mean| {
            Primitive::Cylinder(Cylinder {
                centre: mean + Vector3::new(0.1, 0.0, 0.0),
                axis: Vector3::z_axis(),
                radius_m: 0.12,
                length_m: 1.0,
            })
        });
        assert!((found.size_m()[0] - 0.30).abs() < 1e-4, "{found:?} {cost}");
        assert!((found.size_m()[2] - 1.2).abs() < 1e-4, "{found:?} {cost}");
    }

    #[test]
    fn a_plane_is_recovered_from_its_moments() {
        let truth = Primitive::Plane(Plane {
            centre: Point3::new(0.5, 0.1, 0.3),
            rotation: Rotation3::from_euler_angles(0.2, 1.3, -0.2),
            sides_m: [1.1, 0.6],
        });
        let (found, cost) = recovered(truth, |mean| {
            Primitive::Plane(Plane {
                centre: *mean,
                rotation: Rotation3::from_euler_angles(0.3, 1.2, -0.3),
                sides_m: [1.0, 0.5],
            })
        });
        assert!((found.size_m()[0] - 1.1).abs() < 1e-4, "{found:?} {cost}");
        assert!((found.size_m()[1] - 0.6).abs() < 1e-4, "{found:?} {cost}");
    }

    #[test]
    fn outliers_have_a_bounded_residual() {
        assert!((cauchy_residual(0.1) - 0.1).abs() < 1e-4);
        assert!(cauchy_residual(-100.0) > -9.0);
    }
}
