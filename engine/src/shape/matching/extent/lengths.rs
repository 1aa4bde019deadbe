//! Lengths from the ends of the points: a plane's sides with its rotation about the normal, a cylinder's length. The
//! moments give the start, the likelihood of the edges ([`edges`](super::edges)) the result.

use super::edges::{BlurredInterval, Likelihood, gap_at_end_m, maximize, point_spacing_m};
use crate::shape::constants::{
    BOUNDS, MIN_BLUR_SHARE, MIN_POINTS, MIN_POINTS_NOISE, OUTLIER_FRACTION, RESOLVED_ROW_SIGMAS,
};
use crate::shape::matching::estimate::PrimitiveEstimate;
use crate::shape::matching::moments::beam_weight;
use crate::shape::primitive::{Cylinder, Plane, Primitive, SurfaceElement, gauss_legendre};
use crate::shape::ransac::smallest_rectangle;
use crate::shape::settings::{BeamDensity, SurfaceModel};
use nalgebra::{Point3, Rotation3, Vector2, Vector3, Vector5};

/// What the likelihood of the edges needs besides the primitive.
pub(in crate::shape) struct EdgeObservations<'a> {
    /// Whether most points lie on the surface. Where not (a person), the edges' likelihood does not hold.
    pub fits_class: bool,
    /// Points next to the surface; all points where `fits_class` is false.
    pub points: &'a [Point3<f64>],
    /// Standard deviation of a point, metres.
    pub noise_m: f64,
    /// Share of the points that count as independent.
    pub independent_share: f64,
    pub sensor: &'a Point3<f64>,
    pub surface: SurfaceModel,
    pub density: &'a BeamDensity,
}

impl EdgeObservations<'_> {
    /// Points per area at a position of a surface, up to a factor.
    fn density_at(&self, position: Point3<f64>, normal: Vector3<f64>) -> f64 {
        match self.surface {
            SurfaceModel::Ideal => 1.0,
            SurfaceModel::Visible => {
                // Whichever side faces the sensor.
                let towards = normal.dot(&(self.sensor - position));
                let element = SurfaceElement {
                    position,
                    normal: if towards < 0.0 { -normal } else { normal },
                    area_m2: 1.0,
                };
                beam_weight(&element, self.sensor, self.density)
            }
        }
    }
}

/// Variance of an edge from the spacing of the points, square metres: it is anywhere between the last row and the next.
fn edge_variance(gap_m: f64) -> f64 {
    gap_m * gap_m / 12.0
}

/// The estimate with its lengths from the points.
pub(in crate::shape) fn measure_lengths(
    estimate: PrimitiveEstimate,
    observed: &EdgeObservations<'_>,
) -> PrimitiveEstimate {
    match estimate.primitive {
        Primitive::Cylinder(c) => cylinder_length(&estimate, &c, observed).unwrap_or(estimate),
        Primitive::Plane(p) => plane_sides(&estimate, &p, observed).unwrap_or(estimate),
        // The surfaces of the others cross at their edges, so surfaces and moments give all lengths.
        _ => estimate,
    }
}

/// A point represents the cell of surface around it, half a gap to either side: offsets in gaps and weights (Simpson) with
/// the variance of a uniform distribution.
const CELL_NODES: [(f64, f64); 3] = [(-0.5, 1.0 / 6.0), (0.0, 4.0 / 6.0), (0.5, 1.0 / 6.0)];

/// Whether rows a gap apart are resolved despite this blur, which leaves exp(-2 (pi sigma / gap)^2) of their contrast. If
/// not, points do as well as cells.
fn rows_resolved(gap_m: f64, sigma: f64) -> bool {
    gap_m > RESOLVED_ROW_SIGMAS * sigma
}

/// Blur of the edges, metres: the expected noise or that about the surface, whichever is less. With too much blur an edge
/// is found too far inside.
fn edge_blur_m(observed: &EdgeObservations<'_>, primitive: &Primitive, gap_m: f64) -> f64 {
    let square = |p: &Point3<f64>| primitive.visible_distance_m(p, observed.sensor).powi(2);
    let free = observed
        .points
        .len()
        .saturating_sub(primitive.parameter_count())
        .max(1);
    let residual_m = (observed.points.iter().map(square).sum::<f64>() / free as f64).sqrt();
    let noise_m = if observed.points.len() < MIN_POINTS_NOISE {
        observed.noise_m
    } else {
        observed.noise_m.min(residual_m)
    };
    noise_m.max(MIN_BLUR_SHARE * gap_m).max(1e-6)
}

fn cylinder_length(
    estimate: &PrimitiveEstimate,
    c: &Cylinder,
    observed: &EdgeObservations<'_>,
) -> Option<PrimitiveEstimate> {
    // Points on a cap do not show where the lateral surface ends.
    let on_side = |p: &&Point3<f64>| estimate.primitive.visible_face(p, observed.sensor) == 0;
    let mut sorted: Vec<f64> = observed
        .points
        .iter()
        .filter(on_side)
        .map(|p| (p - c.centre).dot(&c.axis))
        .collect();
    if sorted.len() < MIN_POINTS {
        return None;
    }
    if !observed.fits_class {
        return length_from_outermost(estimate, c, observed);
    }
    let gap_m = point_spacing_m(&mut sorted);
    let heights = sorted;
    let (first, last) = (*heights.first()?, *heights.last()?);
    let sigma = edge_blur_m(observed, &estimate.primitive, gap_m);
    let span_m = last - first + gap_m + 2.0 * sigma;
    let cell = if rows_resolved(gap_m, sigma) {
        &CELL_NODES[..]
    } else {
        &[(0.0, 1.0)]
    };
    let side = Vector3::from(c.canonical_rotation(observed.sensor).column(0));
    let density_at = |u: f64| {
        let position = c.centre + side * c.radius_m + c.axis.as_ref() * u;
        observed.density_at(position, side)
    };
    let weights: Vec<f64> = heights.iter().map(|&u| density_at(u)).collect();
    let likelihood = |x: &Vector2<f64>| {
        let (low, high) = (x[0], x[1]);
        if high - low < BOUNDS.cylinder_length_m.min {
            return None;
        }
        let total: f64 = gauss_legendre(low, high)
            .map(|(u, w)| w * density_at(u))
            .sum();
        let total_gradient = Vector2::new(-density_at(low), density_at(high));
        let mut sum = Likelihood::zero();
        for (&u, &w) in heights.iter().zip(&weights) {
            let (mut log, mut gradient) = (0.0, Vector2::zeros());
            for &(offset, share) in cell {
                let b = BlurredInterval::new(u + offset * gap_m, low, high, sigma);
                let own = (1.0 - OUTLIER_FRACTION) * w / total;
                let density = own * b.probability + OUTLIER_FRACTION / span_m;
                log += share * density.ln();
                let probability_gradient =
                    Vector2::new(b.by_low, b.by_high) - total_gradient * (b.probability / total);
                gradient += probability_gradient * (share * own / density);
            }
            sum.add(log, &gradient);
        }
        Some(sum)
    };
    let start = Vector2::new(first - gap_m / 2.0, last + gap_m / 2.0);
    let (edges, at) = maximize(start, likelihood)?;
    let covariance = at.information.try_inverse()? / observed.independent_share;
    let (low, high) = (edges[0], edges[1]);
    let variance = covariance[(0, 0)] + covariance[(1, 1)] - 2.0 * covariance[(0, 1)]
        + 2.0 * edge_variance(gap_m);
    let centre_variance = covariance.sum() / 4.0 + edge_variance(gap_m) / 2.0;
    Some(with_ends(
        estimate,
        c,
        [low, high],
        [variance, centre_variance],
    ))
}

/// Length of what is not quite a cylinder: from end to end of its points and half a row's spacing beyond. How they spread
/// between the ends is unknown, and a thin end would pass for outliers.
fn length_from_outermost(
    estimate: &PrimitiveEstimate,
    c: &Cylinder,
    observed: &EdgeObservations<'_>,
) -> Option<PrimitiveEstimate> {
    let frame = c.canonical_rotation(observed.sensor).transpose();
    let positions = |sign: f64| -> Vec<Vector3<f64>> {
        // Along the cylinder's own axis; that of the frame may point the other way.
        let own = observed.points.iter().map(|p| p - c.centre);
        own.map(|d| {
            let across = frame * d;
            Vector3::new(sign * c.axis.dot(&d), across.x, across.y)
        })
        .collect()
    };
    let end = |sign: f64| {
        let positions = positions(sign);
        let last = positions.iter().map(|d| d.x).max_by(f64::total_cmp)?;
        let gap_m = gap_at_end_m(&positions, MIN_POINTS);
        let variance = edge_variance(gap_m) + observed.noise_m * observed.noise_m;
        Some((last + gap_m / 2.0, variance))
    };
    let ((below, low_variance), (high, high_variance)) = (end(-1.0)?, end(1.0)?);
    let variance = low_variance + high_variance;
    let variances = [variance, variance / 4.0];
    Some(with_ends(estimate, c, [-below, high], variances))
}

/// The estimate with these ends of the cylinder along its axis, and the variances of its length and of its middle.
fn with_ends(
    estimate: &PrimitiveEstimate,
    c: &Cylinder,
    [low, high]: [f64; 2],
    [length_variance, centre_variance]: [f64; 2],
) -> PrimitiveEstimate {
    let mut measured = estimate.clone();
    measured.primitive = Primitive::Cylinder(Cylinder {
        centre: c.centre + c.axis.as_ref() * f64::midpoint(low, high),
        length_m: BOUNDS.cylinder_length_m.clamp(high - low),
        ..*c
    });
    measured.size_sd_m[2] = length_variance.max(0.0).sqrt();
    let along = centre_variance.max(0.0).sqrt();
    for k in 0..3 {
        let across = estimate.centre_sd_m[k] * (1.0 - c.axis[k].powi(2)).max(0.0).sqrt();
        measured.centre_sd_m[k] = across.hypot(along * c.axis[k]);
    }
    measured
}

/// The better of two starts: the rotation from the moments, and that of the smallest rectangle, which is right where points
/// are dense and the sides nearly equal.
fn plane_sides(
    estimate: &PrimitiveEstimate,
    p: &Plane,
    observed: &EdgeObservations<'_>,
) -> Option<PrimitiveEstimate> {
    let p = p.longer_first();
    let rectangle = smallest_rectangle(&p, observed.points);
    let starts = [p.rotation, rectangle.rotation];
    let fits = starts.iter().filter_map(|rotation| {
        let start = Plane {
            rotation: *rotation,
            ..p
        };
        fit_rectangle(estimate, &start, observed)
    });
    fits.max_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

/// Edges and rotation of a rectangle from one start, with the log-likelihood.
fn fit_rectangle(
    estimate: &PrimitiveEstimate,
    p: &Plane,
    observed: &EdgeObservations<'_>,
) -> Option<(f64, PrimitiveEstimate)> {
    let m = p.rotation.matrix();
    let (e1, e2): (Vector3<f64>, Vector3<f64>) = (m.column(0).into(), m.column(1).into());
    let normal = p.normal();
    let positions: Vec<Vector2<f64>> = observed
        .points
        .iter()
        .map(|q| Vector2::new((q - p.centre).dot(&e1), (q - p.centre).dot(&e2)))
        .collect();
    let mut gaps = [0.0; 2];
    let mut start = Vector5::zeros();
    let mut span = 1.0;
    let mut sigma: f64 = 0.0;
    for k in [0, 1] {
        let mut sorted: Vec<f64> = positions.iter().map(|q| q[k]).collect();
        gaps[k] = point_spacing_m(&mut sorted);
        sigma = sigma.max(edge_blur_m(observed, &estimate.primitive, gaps[k]));
        let (first, last) = (*sorted.first()?, *sorted.last()?);
        start[2 * k] = first - gaps[k] / 2.0;
        start[2 * k + 1] = last + gaps[k] / 2.0;
        span *= last - first + gaps[k] + 2.0 * sigma;
    }
    let density_at = |x: f64, y: f64| observed.density_at(p.centre + e1 * x + e2 * y, normal);
    let weights: Vec<f64> = positions.iter().map(|q| density_at(q.x, q.y)).collect();
    let cross = [
        (0.0, 0.0, 2.0 / 6.0),
        (-gaps[0] / 2.0, 0.0, 1.0 / 6.0),
        (gaps[0] / 2.0, 0.0, 1.0 / 6.0),
        (0.0, -gaps[1] / 2.0, 1.0 / 6.0),
        (0.0, gaps[1] / 2.0, 1.0 / 6.0),
    ];
    let cells = if gaps.iter().any(|gap_m| rows_resolved(*gap_m, sigma)) {
        &cross[..]
    } else {
        &[(0.0, 0.0, 1.0)]
    };
    let likelihood = |x: &Vector5<f64>| {
        let [x_low, x_high, y_low, y_high, angle] = (*x).into();
        let min_m = BOUNDS.plane_side_m.min;
        if x_high - x_low < min_m || y_high - y_low < min_m {
            return None;
        }
        let (sin, cos) = angle.sin_cos();
        let at = |u: f64, v: f64| density_at(u * cos - v * sin, u * sin + v * cos);
        let total: f64 = gauss_legendre(x_low, x_high)
            .map(|(u, wu)| {
                let column = gauss_legendre(y_low, y_high).map(|(v, wv)| wv * at(u, v));
                wu * column.sum::<f64>()
            })
            .sum();
        let column = |u: f64| -> f64 {
            gauss_legendre(y_low, y_high)
                .map(|(v, w)| w * at(u, v))
                .sum()
        };
        let row = |v: f64| -> f64 {
            gauss_legendre(x_low, x_high)
                .map(|(u, w)| w * at(u, v))
                .sum()
        };
        let total_gradient = Vector5::new(
            -column(x_low),
            column(x_high),
            -row(y_low),
            row(y_high),
            0.0,
        );
        let mut sum = Likelihood::zero();
        for (q, &w) in positions.iter().zip(&weights) {
            let (u, v) = (q.x * cos + q.y * sin, q.y * cos - q.x * sin);
            let (mut log, mut gradient) = (0.0, Vector5::zeros());
            for &(du, dv, share) in cells {
                let a = BlurredInterval::new(u + du, x_low, x_high, sigma);
                let b = BlurredInterval::new(v + dv, y_low, y_high, sigma);
                let own = (1.0 - OUTLIER_FRACTION) * w / total;
                let inside = a.probability * b.probability;
                let density = own * inside + OUTLIER_FRACTION / span;
                log += share * density.ln();
                let probability_gradient = Vector5::new(
                    a.by_low * b.probability,
                    a.by_high * b.probability,
                    a.probability * b.by_low,
                    a.probability * b.by_high,
                    a.by_position() * b.probability * v - a.probability * b.by_position() * u,
                ) - total_gradient * (inside / total);
                gradient += probability_gradient * (share * own / density);
            }
            sum.add(log, &gradient);
        }
        Some(sum)
    };
    let (x, at) = maximize(start, likelihood)?;
    let covariance = at.information.try_inverse()? / observed.independent_share;
    let (low, high) = (Vector2::new(x[0], x[2]), Vector2::new(x[1], x[3]));
    let rotation = p.rotation * Rotation3::from_axis_angle(&Vector3::z_axis(), x[4]);
    let middle = rotation * Vector3::new((low + high).x / 2.0, (low + high).y / 2.0, 0.0);
    let sides = high - low;
    let found = Plane {
        centre: p.centre + middle,
        rotation,
        sides_m: [0, 1].map(|k| BOUNDS.plane_side_m.clamp(sides[k])),
    };
    let mut measured = estimate.clone();
    measured.primitive = Primitive::Plane(found);
    let pair_variance = |k: usize, sign: f64| {
        let (i, j) = (2 * k, 2 * k + 1);
        covariance[(i, i)]
            + covariance[(j, j)]
            + 2.0 * sign * covariance[(i, j)]
            + 2.0 * edge_variance(gaps[k])
    };
    let mut sds = [0, 1].map(|k| pair_variance(k, -1.0).max(0.0).sqrt());
    if found.sides_m[0] < found.sides_m[1] {
        sds.swap(0, 1);
    }
    measured.size_sd_m = [sds[0], sds[1], 0.0];
    let along = [0, 1].map(|k| (pair_variance(k, 1.0) / 4.0).max(0.0).sqrt());
    let axes = rotation.matrix();
    for k in 0..3 {
        let out = estimate.centre_sd_m[k] * axes[(k, 2)].abs();
        let inside = (along[0] * axes[(k, 0)]).hypot(along[1] * axes[(k, 1)]);
        measured.centre_sd_m[k] = out.hypot(inside);
    }
    Some((at.log, measured))
}

#[cfg(test)]
mod tests {
    use super::{EdgeObservations, measure_lengths};
    use crate::shape::matching::estimate::PrimitiveEstimate;
    use crate::shape::primitive::{Cylinder, Primitive};
    use crate::shape::settings::{BeamDensity, SurfaceModel};
    use nalgebra::{Point3, Unit, Vector3};

    /// Rows 4 cm apart from -0.5 to 0.9 m over the middle of the fitted cylinder: an object that is not quite one.
    fn rows() -> Vec<Point3<f64>> {
        let row = |k: i32| {
            let z = -0.5 + 0.04 * f64::from(k);
            let wide = if k % 3 == 0 { 0.15 } else { 0.25 };
            (-4..=4).map(move |i| Point3::new(2.0, wide * f64::from(i) / 4.0, 1.0 + z))
        };
        (0..=35).flat_map(row).collect()
    }

    #[test]
    fn an_object_that_is_not_quite_a_cylinder_ends_with_its_rows_whichever_way_the_axis_points() {
        let (points, sensor) = (rows(), Point3::new(0.0, 0.0, 1.0));
        for axis in [Vector3::z(), -Vector3::z()] {
            let estimate = PrimitiveEstimate {
                primitive: Primitive::Cylinder(Cylinder {
                    centre: Point3::new(2.2, 0.0, 1.0),
                    axis: Unit::new_normalize(axis),
                    radius_m: 0.2,
                    length_m: 1.0,
                }),
                centre_sd_m: [0.01; 3],
                size_sd_m: [0.01; 3],
                probability: 1.0,
                probability_among_fitted: 1.0,
            };
            let observed = EdgeObservations {
                fits_class: false,
                points: &points,
                noise_m: 0.005,
                independent_share: 1.0,
                sensor: &sensor,
                surface: SurfaceModel::Visible,
                density: &BeamDensity::SolidAngle,
            };
            let measured = measure_lengths(estimate, &observed);
            let [_, _, length_m] = measured.primitive.size_m();
            assert!((length_m - 1.44).abs() < 1e-9, "{length_m}");
            let middle_m = measured.primitive.centre().z;
            assert!((middle_m - 1.2).abs() < 1e-9, "{axis:?}: {middle_m}");
            // Each end is anywhere in its row: root 2 x 4 cm / root 12, and noise.
            let sd_m = measured.size_sd_m[2];
            assert!((sd_m - 0.0178).abs() < 1e-3, "{sd_m}");
        }
    }
}
