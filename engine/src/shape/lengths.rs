//! Lengths from where the points end: a plane's sides with its turn, a cylinder's length. The
//! moments give a start; the likelihood of the edges ([`edges`](super::edges)) gives the answer.

use super::constants::{
    BOUNDS, FOREIGN_SHARE, LEAST_BLUR_SHARE, LEAST_POINTS, LEAST_SEEN_NOISE, ROWS_SHOW_SIGMAS,
};
use super::covariance::Candidate;
use super::edges::{Between, Likelihood, climb, gap_at_end_m, typical_gap_m};
use super::moments::seen_weight;
use super::primitive::{Cylinder, Patch, Plane, Primitive, interval};
use super::ransac::smallest_rectangle;
use super::settings::{BeamDensity, SurfaceModel};
use nalgebra::{Point3, Rotation3, Vector2, Vector3, Vector5};

/// What the likelihood of edges needs to know about a look.
pub(super) struct Look<'a> {
    /// Whether the points are of the class: those of a thing that is not quite (a person) do not spread as its would.
    pub of_class: bool,
    /// Points next to the surface; all points of a thing that is not of its class.
    pub near: &'a [Point3<f64>],
    /// Standard deviation of a point, metres.
    pub noise_m: f64,
    /// Share of the points that count as independent.
    pub independent_share: f64,
    pub sensor: &'a Point3<f64>,
    pub surface: SurfaceModel,
    pub density: &'a BeamDensity,
}

impl Look<'_> {
    /// Points per area at a place of a surface, up to a factor.
    fn weight(&self, at: Point3<f64>, normal: Vector3<f64>) -> f64 {
        match self.surface {
            SurfaceModel::Ideal => 1.0,
            SurfaceModel::Visible => {
                // Whichever side faces the sensor.
                let towards = normal.dot(&(self.sensor - at));
                let patch = Patch {
                    at,
                    normal: if towards < 0.0 { -normal } else { normal },
                    area: 1.0,
                };
                seen_weight(&patch, self.sensor, self.density)
            }
        }
    }
}

/// Variance that the spacing of the points leaves to an edge, square metres: it lies anywhere
/// between the last row and the next.
fn edge_variance(gap_m: f64) -> f64 {
    gap_m * gap_m / 12.0
}

/// The candidate with its lengths as the points show them.
pub(super) fn measured(candidate: Candidate, look: &Look<'_>) -> Candidate {
    match candidate.primitive {
        Primitive::Cylinder(c) => cylinder(&candidate, &c, look).unwrap_or(candidate),
        Primitive::Plane(p) => plane(&candidate, &p, look).unwrap_or(candidate),
        // Their surfaces cross at their edges, so surfaces and moments tell all lengths.
        _ => candidate,
    }
}

/// Points stand for the cell of surface around them: half a gap to either side. Offsets in gaps
/// and weights (Simpson), whose variance is that of a uniform law.
const CELL: [(f64, f64); 3] = [(-0.5, 1.0 / 6.0), (0.0, 4.0 / 6.0), (0.5, 1.0 / 6.0)];

/// Whether rows a gap apart show through this blur. Where they do not, the points alone are as good
/// as their cells: of a comb of rows the blur leaves exp(-2 (pi sigma / gap)^2).
fn rows_show(gap_m: f64, sigma: f64) -> bool {
    gap_m > ROWS_SHOW_SIGMAS * sigma
}

/// The blur that edges are sought with. Noise as told or as seen about the surface, whichever is less: an edge that
/// is looked for too softly is found too far inside.
fn blur_m(look: &Look<'_>, primitive: &Primitive, gap_m: f64) -> f64 {
    let square = |p: &Point3<f64>| primitive.visible_distance_m(p, look.sensor).powi(2);
    let free = look
        .near
        .len()
        .saturating_sub(primitive.parameters())
        .max(1);
    let seen_m = (look.near.iter().map(square).sum::<f64>() / free as f64).sqrt();
    let noise_m = if look.near.len() < LEAST_SEEN_NOISE {
        look.noise_m
    } else {
        look.noise_m.min(seen_m)
    };
    noise_m.max(LEAST_BLUR_SHARE * gap_m).max(1e-6)
}

fn cylinder(candidate: &Candidate, c: &Cylinder, look: &Look<'_>) -> Option<Candidate> {
    // What lies on the cap in sight says nothing of how far the mantle goes.
    let on_mantle = |p: &&Point3<f64>| candidate.primitive.seen_face(p, look.sensor) == 0;
    let mut sorted: Vec<f64> = look
        .near
        .iter()
        .filter(on_mantle)
        .map(|p| (p - c.centre).dot(&c.axis))
        .collect();
    if sorted.len() < LEAST_POINTS {
        return None;
    }
    if !look.of_class {
        return outermost(candidate, c, look);
    }
    let gap_m = typical_gap_m(&mut sorted);
    let heights = sorted;
    let (first, last) = (*heights.first()?, *heights.last()?);
    let sigma = blur_m(look, &candidate.primitive, gap_m);
    let span_m = last - first + gap_m + 2.0 * sigma;
    let cell = if rows_show(gap_m, sigma) {
        &CELL[..]
    } else {
        &[(0.0, 1.0)]
    };
    let side = Vector3::from(c.rotation(look.sensor).column(0));
    let weight = |u: f64| {
        let at = c.centre + side * c.radius_m + c.axis.as_ref() * u;
        look.weight(at, side)
    };
    let weights: Vec<f64> = heights.iter().map(|&u| weight(u)).collect();
    let likelihood = |x: &Vector2<f64>| {
        let (low, high) = (x[0], x[1]);
        if high - low < BOUNDS.cylinder_length_m.least {
            return None;
        }
        let total: f64 = interval(low, high).map(|(u, w)| w * weight(u)).sum();
        let by_edge = Vector2::new(-weight(low), weight(high));
        let mut sum = Likelihood::zero();
        for (&u, &w) in heights.iter().zip(&weights) {
            let (mut log, mut gradient) = (0.0, Vector2::zeros());
            for &(offset, share) in cell {
                let b = Between::new(u + offset * gap_m, low, high, sigma);
                let own = (1.0 - FOREIGN_SHARE) * w / total;
                let density = own * b.share + FOREIGN_SHARE / span_m;
                log += share * density.ln();
                let by_x = Vector2::new(b.by_low, b.by_high) - by_edge * (b.share / total);
                gradient += by_x * (share * own / density);
            }
            sum.add(log, &gradient);
        }
        Some(sum)
    };
    let start = Vector2::new(first - gap_m / 2.0, last + gap_m / 2.0);
    let (edges, at) = climb(start, likelihood)?;
    let covariance = at.information.try_inverse()? / look.independent_share;
    let (low, high) = (edges[0], edges[1]);
    let variance = covariance[(0, 0)] + covariance[(1, 1)] - 2.0 * covariance[(0, 1)]
        + 2.0 * edge_variance(gap_m);
    let of_middle = covariance.sum() / 4.0 + edge_variance(gap_m) / 2.0;
    Some(between(candidate, c, [low, high], [variance, of_middle]))
}

/// Length of what is not quite a cylinder: from end to end of its points and half a row's spacing beyond. Of how they
/// spread between nothing is known, and a thin end would pass for strays.
fn outermost(candidate: &Candidate, c: &Cylinder, look: &Look<'_>) -> Option<Candidate> {
    let frame = c.rotation(look.sensor).transpose();
    let places = |sign: f64| -> Vec<Vector3<f64>> {
        // Along the cylinder's own axis, which the told frame may have turned round.
        let own = look.near.iter().map(|p| p - c.centre);
        own.map(|d| {
            let across = frame * d;
            Vector3::new(sign * c.axis.dot(&d), across.x, across.y)
        })
        .collect()
    };
    let end = |sign: f64| {
        let places = places(sign);
        let last = places.iter().map(|d| d.x).max_by(f64::total_cmp)?;
        let gap_m = gap_at_end_m(&places, LEAST_POINTS);
        let variance = edge_variance(gap_m) + look.noise_m * look.noise_m;
        Some((last + gap_m / 2.0, variance))
    };
    let ((below, of_low), (high, of_high)) = (end(-1.0)?, end(1.0)?);
    let variance = of_low + of_high;
    let variances = [variance, variance / 4.0];
    Some(between(candidate, c, [-below, high], variances))
}

/// The candidate's cylinder between these ends along its axis, with the variances of its length and of its middle.
fn between(
    candidate: &Candidate,
    c: &Cylinder,
    [low, high]: [f64; 2],
    [of_length, of_middle]: [f64; 2],
) -> Candidate {
    let mut measured = candidate.clone();
    measured.primitive = Primitive::Cylinder(Cylinder {
        centre: c.centre + c.axis.as_ref() * f64::midpoint(low, high),
        length_m: BOUNDS.cylinder_length_m.clamp(high - low),
        ..*c
    });
    measured.size_sd_m[2] = of_length.max(0.0).sqrt();
    let along = of_middle.max(0.0).sqrt();
    for k in 0..3 {
        let across = candidate.centre_sd_m[k] * (1.0 - c.axis[k].powi(2)).max(0.0).sqrt();
        measured.centre_sd_m[k] = across.hypot(along * c.axis[k]);
    }
    measured
}

/// The better of two starts: the turn of the moments, and that of the smallest rectangle, which
/// is right where points are dense and the sides nearly equal.
fn plane(candidate: &Candidate, p: &Plane, look: &Look<'_>) -> Option<Candidate> {
    let p = p.longer_first();
    let rectangle = smallest_rectangle(&p, look.near);
    let starts = [p.rotation, rectangle.rotation];
    let tops = starts.iter().filter_map(|rotation| {
        let start = Plane {
            rotation: *rotation,
            ..p
        };
        turned(candidate, &start, look)
    });
    tops.max_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

/// Edges and turn of a rectangle from one start, with the likelihood's logarithm.
fn turned(candidate: &Candidate, p: &Plane, look: &Look<'_>) -> Option<(f64, Candidate)> {
    let m = p.rotation.matrix();
    let (e1, e2): (Vector3<f64>, Vector3<f64>) = (m.column(0).into(), m.column(1).into());
    let normal = p.normal();
    let places: Vec<Vector2<f64>> = look
        .near
        .iter()
        .map(|q| Vector2::new((q - p.centre).dot(&e1), (q - p.centre).dot(&e2)))
        .collect();
    let mut gaps = [0.0; 2];
    let mut start = Vector5::zeros();
    let mut span = 1.0;
    let mut sigma: f64 = 0.0;
    for k in [0, 1] {
        let mut sorted: Vec<f64> = places.iter().map(|q| q[k]).collect();
        gaps[k] = typical_gap_m(&mut sorted);
        sigma = sigma.max(blur_m(look, &candidate.primitive, gaps[k]));
        let (first, last) = (*sorted.first()?, *sorted.last()?);
        start[2 * k] = first - gaps[k] / 2.0;
        start[2 * k + 1] = last + gaps[k] / 2.0;
        span *= last - first + gaps[k] + 2.0 * sigma;
    }
    let weight = |x: f64, y: f64| look.weight(p.centre + e1 * x + e2 * y, normal);
    let weights: Vec<f64> = places.iter().map(|q| weight(q.x, q.y)).collect();
    let cross = [
        (0.0, 0.0, 2.0 / 6.0),
        (-gaps[0] / 2.0, 0.0, 1.0 / 6.0),
        (gaps[0] / 2.0, 0.0, 1.0 / 6.0),
        (0.0, -gaps[1] / 2.0, 1.0 / 6.0),
        (0.0, gaps[1] / 2.0, 1.0 / 6.0),
    ];
    let cells = if gaps.iter().any(|gap_m| rows_show(*gap_m, sigma)) {
        &cross[..]
    } else {
        &[(0.0, 0.0, 1.0)]
    };
    let likelihood = |x: &Vector5<f64>| {
        let [x_low, x_high, y_low, y_high, turn] = (*x).into();
        let least = BOUNDS.plane_side_m.least;
        if x_high - x_low < least || y_high - y_low < least {
            return None;
        }
        let (sin, cos) = turn.sin_cos();
        let at = |u: f64, v: f64| weight(u * cos - v * sin, u * sin + v * cos);
        let total: f64 = interval(x_low, x_high)
            .map(|(u, wu)| {
                let column = interval(y_low, y_high).map(|(v, wv)| wv * at(u, v));
                wu * column.sum::<f64>()
            })
            .sum();
        let column = |u: f64| -> f64 { interval(y_low, y_high).map(|(v, w)| w * at(u, v)).sum() };
        let row = |v: f64| -> f64 { interval(x_low, x_high).map(|(u, w)| w * at(u, v)).sum() };
        let by_edge = Vector5::new(
            -column(x_low),
            column(x_high),
            -row(y_low),
            row(y_high),
            0.0,
        );
        let mut sum = Likelihood::zero();
        for (q, &w) in places.iter().zip(&weights) {
            let (u, v) = (q.x * cos + q.y * sin, q.y * cos - q.x * sin);
            let (mut log, mut gradient) = (0.0, Vector5::zeros());
            for &(du, dv, share) in cells {
                let a = Between::new(u + du, x_low, x_high, sigma);
                let b = Between::new(v + dv, y_low, y_high, sigma);
                let own = (1.0 - FOREIGN_SHARE) * w / total;
                let inside = a.share * b.share;
                let density = own * inside + FOREIGN_SHARE / span;
                log += share * density.ln();
                let by_x = Vector5::new(
                    a.by_low * b.share,
                    a.by_high * b.share,
                    a.share * b.by_low,
                    a.share * b.by_high,
                    a.by_place() * b.share * v - a.share * b.by_place() * u,
                ) - by_edge * (inside / total);
                gradient += by_x * (share * own / density);
            }
            sum.add(log, &gradient);
        }
        Some(sum)
    };
    let (x, at) = climb(start, likelihood)?;
    let covariance = at.information.try_inverse()? / look.independent_share;
    let (low, high) = (Vector2::new(x[0], x[2]), Vector2::new(x[1], x[3]));
    let rotation = p.rotation * Rotation3::from_axis_angle(&Vector3::z_axis(), x[4]);
    let middle = rotation * Vector3::new((low + high).x / 2.0, (low + high).y / 2.0, 0.0);
    let sides = high - low;
    let found = Plane {
        centre: p.centre + middle,
        rotation,
        sides_m: [0, 1].map(|k| BOUNDS.plane_side_m.clamp(sides[k])),
    };
    let mut measured = candidate.clone();
    measured.primitive = Primitive::Plane(found);
    let of_pair = |k: usize, sign: f64| {
        let (i, j) = (2 * k, 2 * k + 1);
        covariance[(i, i)]
            + covariance[(j, j)]
            + 2.0 * sign * covariance[(i, j)]
            + 2.0 * edge_variance(gaps[k])
    };
    let mut sds = [0, 1].map(|k| of_pair(k, -1.0).max(0.0).sqrt());
    if found.sides_m[0] < found.sides_m[1] {
        sds.swap(0, 1);
    }
    measured.size_sd_m = [sds[0], sds[1], 0.0];
    let along = [0, 1].map(|k| (of_pair(k, 1.0) / 4.0).max(0.0).sqrt());
    let axes = rotation.matrix();
    for k in 0..3 {
        let out = candidate.centre_sd_m[k] * axes[(k, 2)].abs();
        let inside = (along[0] * axes[(k, 0)]).hypot(along[1] * axes[(k, 1)]);
        measured.centre_sd_m[k] = out.hypot(inside);
    }
    Some((at.log, measured))
}

#[cfg(test)]
mod tests {
    use super::{Look, measured};
    use crate::shape::covariance::Candidate;
    use crate::shape::primitive::{Cylinder, Primitive};
    use crate::shape::settings::{BeamDensity, SurfaceModel};
    use nalgebra::{Point3, Unit, Vector3};

    /// Rows 4 cm apart from -0.5 to 0.9 m over the middle of what was fitted: a thing that is not quite a cylinder.
    fn rows() -> Vec<Point3<f64>> {
        let row = |k: i32| {
            let z = -0.5 + 0.04 * f64::from(k);
            let wide = if k % 3 == 0 { 0.15 } else { 0.25 };
            (-4..=4).map(move |i| Point3::new(2.0, wide * f64::from(i) / 4.0, 1.0 + z))
        };
        (0..=35).flat_map(row).collect()
    }

    #[test]
    fn a_thing_that_is_not_quite_a_cylinder_ends_where_its_rows_do_whichever_way_its_axis_points() {
        let (near, sensor) = (rows(), Point3::new(0.0, 0.0, 1.0));
        for axis in [Vector3::z(), -Vector3::z()] {
            let candidate = Candidate {
                primitive: Primitive::Cylinder(Cylinder {
                    centre: Point3::new(2.2, 0.0, 1.0),
                    axis: Unit::new_normalize(axis),
                    radius_m: 0.2,
                    length_m: 1.0,
                }),
                centre_sd_m: [0.01; 3],
                size_sd_m: [0.01; 3],
                probability: 1.0,
                among_fitted: 1.0,
            };
            let look = Look {
                of_class: false,
                near: &near,
                noise_m: 0.005,
                independent_share: 1.0,
                sensor: &sensor,
                surface: SurfaceModel::Visible,
                density: &BeamDensity::SolidAngle,
            };
            let told = measured(candidate, &look);
            let [_, _, length_m] = told.primitive.size_m();
            assert!((length_m - 1.44).abs() < 1e-9, "{length_m}");
            let middle_m = told.primitive.centre().z;
            assert!((middle_m - 1.2).abs() < 1e-9, "{axis:?}: {middle_m}");
            // Both ends lie anywhere in their row: root 2 x 4 cm / root 12, and noise.
            let sd_m = told.size_sd_m[2];
            assert!((sd_m - 0.0178).abs() < 1e-3, "{sd_m}");
        }
    }
}
