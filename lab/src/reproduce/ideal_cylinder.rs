//! Fig. 4d: what each method makes of the covariance of an ideal cylinder.

use super::constants::{
    CYLINDER_ATTITUDES, ENGINE_SEED, IDEAL_CYLINDER_AT_M, IDEAL_CYLINDER_M, IDEAL_CYLINDER_POINTS,
};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use patrold_engine::mixture::{Gaussian, Mixture};
use patrold_engine::novelty::Rim;
use patrold_engine::shape::{
    Class, Cylinder, Primitive, Shape, ShapeError, ShapeSettings, SurfaceModel, retrieve,
    surface_moments,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, UnitSphere};
use std::f64::consts::TAU;

/// One attitude of the cylinder, and both answers.
#[derive(Debug, Clone)]
pub struct Attitude {
    /// The truth.
    pub cylinder: Cylinder,
    /// Its only Gaussian: the exact moments of its mantle.
    pub gaussian: Gaussian,
    /// Method A, on 3722 samples of that Gaussian's ellipsoid.
    pub euclidean: Option<Shape>,
    /// Method B, on that Gaussian.
    pub feature: Option<Shape>,
}

/// What a method made of all attitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// How often it said cylinder.
    pub right: usize,
    /// Median angle between its axis and the true one where it did, degrees.
    pub median_deg: Option<f64>,
    /// The greatest.
    pub most_deg: Option<f64>,
}

/// The attitudes of Fig. 4d under this seed, evenly drawn over all directions.
///
/// # Errors
/// Never for a cylinder of this size.
pub fn attitudes(seed: u64) -> Result<Vec<Attitude>, ShapeError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..CYLINDER_ATTITUDES)
        .map(|_| attitude(&mut rng))
        .collect()
}

fn attitude(rng: &mut ChaCha8Rng) -> Result<Attitude, ShapeError> {
    let axis: [f64; 3] = <UnitSphere as Distribution<[f64; 3]>>::sample(&UnitSphere, rng);
    let [diameter_m, length_m] = IDEAL_CYLINDER_M;
    let cylinder = Cylinder {
        centre: Point3::from(IDEAL_CYLINDER_AT_M),
        axis: Unit::new_normalize(Vector3::from(axis)),
        radius_m: diameter_m / 2.0,
        length_m,
    };
    let points = mantle(&cylinder, rng);
    let sensor = Point3::origin();
    let settings = ShapeSettings::ideal();
    let ideal = Primitive::Cylinder(cylinder);
    let gaussian = surface_moments(&ideal, &sensor, SurfaceModel::Ideal, &settings.density)
        .or(Gaussian::of_points(&points))
        .ok_or(ShapeError::NothingFits { points: 0 })?;
    let mixture = Mixture {
        weights: vec![1.0],
        components: vec![gaussian],
    };
    let told = retrieve(
        &points,
        &Rim::default(),
        &mixture,
        &sensor,
        &settings,
        ENGINE_SEED,
    )?;
    Ok(Attitude {
        cylinder,
        gaussian,
        euclidean: told.ransac,
        feature: told.covariance,
    })
}

/// Points of the mantle, even by area: retrieval asks for some beside the Gaussian.
fn mantle(cylinder: &Cylinder, rng: &mut ChaCha8Rng) -> Vec<Point3<f64>> {
    let turn = Rotation3::rotation_between(&Vector3::z(), &cylinder.axis)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let point = |_| {
        let (angle, height) = (rng.random_range(0.0..TAU), rng.random_range(-0.5..0.5));
        let (sin, cos) = f64::sin_cos(angle);
        let across = Vector3::new(cos, sin, 0.0) * cylinder.radius_m;
        cylinder.centre + turn * (across + Vector3::z() * (height * cylinder.length_m))
    };
    (0..IDEAL_CYLINDER_POINTS).map(point).collect()
}

/// What the method chosen by `of` made of them.
pub fn told(attitudes: &[Attitude], of: fn(&Attitude) -> Option<&Shape>) -> Told {
    let own = attitudes.iter().filter_map(|a| of(a).map(|s| (a, s)));
    let mut angles: Vec<f64> = own
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
    angles.sort_by(f64::total_cmp);
    Told {
        right: angles.len(),
        median_deg: angles.get(angles.len() / 2).copied(),
        most_deg: angles.last().copied(),
    }
}

#[cfg(test)]
mod tests {
    use super::{attitudes, told};

    #[test]
    fn feature_space_keeps_the_axis_of_an_ideal_cylinder() {
        let all = attitudes(3).expect("shapes");
        let feature = told(&all, |a| a.feature.as_ref());
        assert_eq!(feature.right, all.len());
        // The moments are exact, so only the fit's own tolerance is left.
        assert!(feature.most_deg.is_some_and(|deg| deg < 0.1), "{feature:?}");
    }
}
