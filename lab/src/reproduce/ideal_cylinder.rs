//! Fig. 4d: the shapes that each method retrieves from the covariance of an ideal cylinder.

use super::constants::{
    CYLINDER_ATTITUDES, IDEAL_CYLINDER_M, IDEAL_CYLINDER_POINTS, IDEAL_CYLINDER_POSITION_M,
};
use crate::constants::ENGINE_SEED;
use crate::statistics::{median, quantile};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use patrold_engine::mixture::{Gaussian, Mixture};
use patrold_engine::novelty::Surroundings;
use patrold_engine::shape::{
    Class, Cylinder, Primitive, Shape, ShapeError, ShapeSettings, SurfaceModel, retrieve,
    surface_moments,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, UnitSphere};
use serde::Serialize;
use std::f64::consts::TAU;

/// One attitude of the cylinder, and the shapes of both methods.
#[derive(Debug, Clone)]
pub struct CylinderAttitude {
    /// The truth.
    pub cylinder: Cylinder,
    /// Its only Gaussian: the exact moments of its lateral surface.
    pub gaussian: Gaussian,
    /// Method A on 3722 samples of the ellipsoid of that Gaussian.
    pub euclidean: Option<Shape>,
    /// Method B on that Gaussian.
    pub feature: Option<Shape>,
}

/// The errors of a method over all attitudes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AxisAccuracy {
    /// Attitudes with the class cylinder.
    pub right: usize,
    /// Their median angle between the axis and the true one, degrees.
    pub median_deg: Option<f64>,
    /// The greatest such angle, degrees.
    #[serde(rename = "most_deg")]
    pub max_deg: Option<f64>,
}

/// The attitudes of Fig. 4d under this seed, uniform over all directions.
///
/// # Errors
/// Never for a cylinder of this size.
pub fn cylinder_attitudes(seed: u64) -> Result<Vec<CylinderAttitude>, ShapeError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..CYLINDER_ATTITUDES)
        .map(|_| attitude(&mut rng))
        .collect()
}

fn attitude(rng: &mut ChaCha8Rng) -> Result<CylinderAttitude, ShapeError> {
    let axis: [f64; 3] = <UnitSphere as Distribution<[f64; 3]>>::sample(&UnitSphere, rng);
    let [diameter_m, length_m] = IDEAL_CYLINDER_M;
    let cylinder = Cylinder {
        centre: Point3::from(IDEAL_CYLINDER_POSITION_M),
        axis: Unit::new_normalize(Vector3::from(axis)),
        radius_m: diameter_m / 2.0,
        length_m,
    };
    let points = lateral_surface(&cylinder, rng);
    let sensor = Point3::origin();
    let settings = ShapeSettings::paper_independent();
    let ideal = Primitive::Cylinder(cylinder);
    let gaussian = surface_moments(&ideal, &sensor, SurfaceModel::Ideal, &settings.density)
        .or(Gaussian::from_points(&points))
        .ok_or(ShapeError::NothingFits { points: 0 })?;
    let mixture = Mixture {
        weights: vec![1.0],
        components: vec![gaussian],
    };
    let retrieval = retrieve(
        &points,
        &Surroundings::default(),
        &mixture,
        &sensor,
        &settings,
        ENGINE_SEED,
    )?;
    Ok(CylinderAttitude {
        cylinder,
        gaussian,
        euclidean: retrieval.ransac,
        feature: retrieval.covariance,
    })
}

/// Points of the lateral surface, even by area: retrieval needs some besides the Gaussian.
fn lateral_surface(cylinder: &Cylinder, rng: &mut ChaCha8Rng) -> Vec<Point3<f64>> {
    let rotation = Rotation3::rotation_between(&Vector3::z(), &cylinder.axis)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let point = |_| {
        let (angle, height) = (rng.random_range(0.0..TAU), rng.random_range(-0.5..0.5));
        let (sin, cos) = f64::sin_cos(angle);
        let across = Vector3::new(cos, sin, 0.0) * cylinder.radius_m;
        cylinder.centre + rotation * (across + Vector3::z() * (height * cylinder.length_m))
    };
    (0..IDEAL_CYLINDER_POINTS).map(point).collect()
}

/// The errors of the method that `shape_of` chooses.
pub fn axis_accuracy(
    attitudes: &[CylinderAttitude],
    shape_of: fn(&CylinderAttitude) -> Option<&Shape>,
) -> AxisAccuracy {
    let shapes = attitudes.iter().filter_map(|a| shape_of(a).map(|s| (a, s)));
    let angles_deg: Vec<f64> = shapes
        .filter(|(_, shape)| shape.class == Class::Cylinder)
        .map(|(a, shape)| {
            let axis = shape.rotation.column(2);
            let (cos, sin) = (
                a.cylinder.axis.dot(&axis),
                a.cylinder.axis.cross(&axis).norm(),
            );
            sin.atan2(cos.abs()).to_degrees()
        })
        .collect();
    AxisAccuracy {
        right: angles_deg.len(),
        median_deg: median(angles_deg.iter().copied()),
        max_deg: quantile(angles_deg, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::{axis_accuracy, cylinder_attitudes};

    #[test]
    fn feature_space_keeps_the_axis_of_an_ideal_cylinder() {
        let all = cylinder_attitudes(3).expect("shapes");
        let feature = axis_accuracy(&all, |a| a.feature.as_ref());
        assert_eq!(feature.right, all.len());
        // The moments are exact: only the tolerance of the fit is left.
        assert!(feature.max_deg.is_some_and(|deg| deg < 0.1), "{feature:?}");
    }
}
