//! Starts for the fits of box, cone and superquadric. Their attitude is in no eigenvector of the moments once two faces
//! are seen, so small sets of points propose it and all points rate the proposals.

use super::fit::Observation;
use crate::shape::constants::{
    BOUNDS, EDGE_QUANTILE, MAX_STARTS, MIN_NOISE_M, NORMAL_NEIGHBOURS, START_CUTOFF_SIGMAS,
    START_SAMPLES, START_SEED,
};
use crate::shape::primitive::{Cone, Cuboid, Primitive, Superquadric, rotation_with_third};
use crate::shape::ransac::estimate_normals;
use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_4, SQRT_2};

/// Boxes and cones worth fitting; `axes` are the moments' eigenvectors and `sd_m` is the standard deviation of a point
/// about its surface.
pub(super) fn box_and_cone_starts(
    observed: &Observation,
    axes: &[Unit<Vector3<f64>>],
    sd_m: f64,
) -> [Vec<Primitive>; 2] {
    [
        best_proposals(observed, sd_m, propose_boxes(observed, axes)),
        best_proposals(observed, sd_m, propose_cones(observed, axes)),
    ]
}

/// The proposals with the least sum of truncated squared distances.
fn best_proposals(observed: &Observation, sd_m: f64, proposed: Vec<Primitive>) -> Vec<Primitive> {
    let cutoff_m = START_CUTOFF_SIGMAS * sd_m.max(MIN_NOISE_M);
    let cost = |primitive: &Primitive| -> f64 {
        let points = observed.points.iter();
        points
            .map(|p| {
                (observed.distance_m(primitive, p) / cutoff_m)
                    .powi(2)
                    .min(1.0)
            })
            .sum()
    };
    let mut costed: Vec<(f64, Primitive)> = proposed.into_iter().map(|p| (cost(&p), p)).collect();
    costed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let kept = costed.into_iter().take(MAX_STARTS);
    kept.map(|(_, primitive)| primitive).collect()
}

/// The value that is greater than the share `quantile` of `values`; 0 of none.
fn quantile(values: &mut [f64], quantile: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    let at = (quantile * last as f64).round() as usize;
    match values {
        [] => 0.0,
        _ => *values.select_nth_unstable_by(at, f64::total_cmp).1,
    }
}

/// Boxes around all points, with an attitude from every eigenvector and from sets of five points: three on one face, two
/// on a face perpendicular to it.
fn propose_boxes(observed: &Observation, axes: &[Unit<Vector3<f64>>]) -> Vec<Primitive> {
    let points = &observed.points;
    let mut rng = ChaCha8Rng::seed_from_u64(START_SEED);
    let frames = axes.iter().enumerate().map(|(k, third)| {
        let hint = axes[(k + 1) % axes.len()];
        rotation_with_third(third, &hint)
    });
    let mut frames: Vec<Matrix3<f64>> = frames.collect();
    for _ in 0..START_SAMPLES {
        let mut pick = || points[rng.random_range(0..points.len())];
        let (a, b, c) = (pick(), pick(), pick());
        let along = pick() - pick();
        let normal = (b - a).cross(&(c - a));
        if let Some(normal) = Unit::try_new(normal, 1e-12) {
            frames.push(rotation_with_third(&normal, &along));
        }
    }
    frames.iter().map(|f| bounding_box(observed, f)).collect()
}

/// The box with these axes and its faces at the outer quantiles of the points.
fn bounding_box(observed: &Observation, frame: &Matrix3<f64>) -> Primitive {
    let mut middle = Vector3::zeros();
    let mut sides_m = [0.0; 3];
    for (k, side) in sides_m.iter_mut().enumerate() {
        let axis = frame.column(k);
        let positions = observed.points.iter().map(|p| p.coords.dot(&axis));
        let mut positions: Vec<f64> = positions.collect();
        let low = quantile(&mut positions, EDGE_QUANTILE);
        let high = quantile(&mut positions, 1.0 - EDGE_QUANTILE);
        *side = BOUNDS.box_side_m.clamp(high - low);
        middle += axis * f64::midpoint(low, high);
    }
    Primitive::Cuboid(Cuboid {
        centre: Point3::from(middle),
        rotation: Rotation3::from_matrix_unchecked(*frame),
        sides_m,
    })
}

/// Cones about every eigenvector in both directions, and from sets of three points with normals.
fn propose_cones(observed: &Observation, axes: &[Unit<Vector3<f64>>]) -> Vec<Primitive> {
    let points = &observed.points;
    let mut found: Vec<Primitive> = axes
        .iter()
        .flat_map(|axis| [*axis, -*axis])
        .filter_map(|axis| cone_around(observed, &axis))
        .collect();
    let normals = estimate_normals(points, &observed.sensor, NORMAL_NEIGHBOURS);
    let mut rng = ChaCha8Rng::seed_from_u64(START_SEED);
    for _ in 0..START_SAMPLES {
        let picked: [usize; 3] = std::array::from_fn(|_| rng.random_range(0..points.len()));
        // The apex is in all three tangent planes.
        let n = Matrix3::from_rows(&picked.map(|i| normals[i].transpose()));
        let offsets = Vector3::from_fn(|k, _| normals[picked[k]].dot(&points[picked[k]].coords));
        let Some(apex) = n
            .try_inverse()
            .map(|inverse| Point3::from(inverse * offsets))
        else {
            continue;
        };
        let from_apex = picked.map(|i| (points[i] - apex).normalize());
        let axis = (from_apex[1] - from_apex[0]).cross(&(from_apex[2] - from_apex[0]));
        let Some(axis) = Unit::try_new(axis, 1e-9) else {
            continue;
        };
        let axis = if axis.dot(&from_apex[0]) > 0.0 {
            -axis
        } else {
            axis
        };
        let cos = -axis.dot(&from_apex[0]);
        found.extend(cone_from_apex(
            observed,
            &apex,
            &axis,
            (1.0 / (cos * cos) - 1.0).sqrt(),
        ));
    }
    found
}

/// The cone with this apex, axis (towards the apex) and slope (radius over depth) that ends with the points.
fn cone_from_apex(
    observed: &Observation,
    apex: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    slope: f64,
) -> Option<Primitive> {
    let depths = observed.points.iter().map(|p| (apex - p).dot(axis));
    let mut depths: Vec<f64> = depths.collect();
    let depth = quantile(&mut depths, 1.0 - EDGE_QUANTILE);
    let radius_m = slope * depth;
    let (across, along) = (BOUNDS.cone_diameter_m, BOUNDS.cone_height_m);
    let in_range = radius_m.is_finite() && along.clamp(depth) == depth;
    (in_range && across.clamp(2.0 * radius_m) == 2.0 * radius_m).then(|| {
        Primitive::Cone(Cone {
            centre: apex - axis.as_ref() * (depth / 2.0),
            axis: *axis,
            radius_m,
            height_m: depth,
        })
    })
}

/// The cone about `axis` around the points: as wide as they are, its axis a radius behind the nearest of them.
fn cone_around(observed: &Observation, axis: &Unit<Vector3<f64>>) -> Option<Primitive> {
    let frame = rotation_with_third(axis, &observed.sensor.coords);
    let along = |k: usize, share: f64| {
        let positions = observed
            .points
            .iter()
            .map(|p| p.coords.dot(&frame.column(k)));
        quantile(&mut positions.collect::<Vec<f64>>(), share)
    };
    let (left, right) = (along(1, EDGE_QUANTILE), along(1, 1.0 - EDGE_QUANTILE));
    let (low, high) = (along(2, EDGE_QUANTILE), along(2, 1.0 - EDGE_QUANTILE));
    let radius_m = (right - left) / 2.0;
    let near = along(0, 1.0 - EDGE_QUANTILE);
    let apex = frame * Vector3::new(near - radius_m, f64::midpoint(left, right), high);
    cone_from_apex(observed, &Point3::from(apex), axis, radius_m / (high - low))
}

/// Superquadrics close to the fitted boxes, spheres and cylinders, each with every axis as the equation's z.
pub(super) fn superquadric_starts(
    observed: &Observation,
    axes: &[Unit<Vector3<f64>>],
    fitted: &[Primitive],
    sd_m: f64,
) -> Vec<Primitive> {
    let eigen = rotation_with_third(&axes[2], &axes[0]);
    let mut proposed = Vec::new();
    for primitive in fitted {
        let (frame, sides_m, exponent) = match primitive {
            Primitive::Cuboid(b) => (*b.rotation.matrix(), b.sides_m, 0.4),
            Primitive::Sphere(s) => (eigen, [2.0 * s.radius_m; 3], 1.0),
            Primitive::Cylinder(c) => (
                primitive.canonical_rotation(&observed.sensor),
                [2.0 * c.radius_m, 2.0 * c.radius_m, c.length_m],
                0.7,
            ),
            _ => continue,
        };
        for turn in 0..3 {
            let order = [(turn + 1) % 3, (turn + 2) % 3, turn];
            let columns = order.map(|k| frame.column(k).into_owned());
            proposed.push(Primitive::Superquadric(Superquadric {
                centre: primitive.centre(),
                rotation: Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns)),
                sides_m: order.map(|k| BOUNDS.superquadric_side_m.clamp(sides_m[k])),
                exponents: [exponent; 2],
            }));
        }
    }
    best_proposals(observed, sd_m.max(0.1 * observed.scale_m), proposed)
}

/// Superquadrics of nearly the same surface: the dual, turned by 45 deg about z with e2 on the other side of round, and
/// those with another axis as the equation's z. A fit ends in the one nearest to its start, so all are tried (Liu et al.
/// 2022, "Robust and accurate superquadric recovery: a probabilistic approach").
pub(super) fn equivalents(found: &Superquadric) -> Vec<Primitive> {
    let [a, b, c] = found.sides_m;
    let [e1, e2] = found.exponents;
    let frame = found.rotation.matrix();
    let reordered = |order: [usize; 3], exponents: [f64; 2]| Superquadric {
        rotation: Rotation3::from_matrix_unchecked(Matrix3::from_columns(
            &order.map(|k| frame.column(k).into_owned()),
        )),
        sides_m: order.map(|k| found.sides_m[k]),
        exponents,
        ..*found
    };
    // From a square of side 1 to the rhombus of the same outline, its axes are sqrt 2 long.
    let square = e2.min(2.0 - e2).max(BOUNDS.exponent.min);
    let longer = (1.0 - SQRT_2) * square + SQRT_2;
    let side = (a * b).sqrt() * if e2 < 1.0 { longer } else { 1.0 / longer };
    let dual = Superquadric {
        rotation: found.rotation * Rotation3::from_axis_angle(&Vector3::z_axis(), FRAC_PI_4),
        sides_m: [side, side, c],
        exponents: [e1, BOUNDS.exponent.clamp(2.0 - e2)],
        ..*found
    };
    let all = [
        dual,
        reordered([1, 2, 0], [e2, e1]),
        reordered([2, 0, 1], [e2, e1]),
    ];
    all.map(Primitive::Superquadric).into()
}
