//! Where a ray hits a superquadric ellipsoid (|x/a|^(2/e2) + |y/b|^(2/e2))^(e2/e1) + |z/c|^(2/e1) = 1 of exponents up
//! to 2. The left side to the power e1/2 is a norm, so along a ray it has one minimum.

use super::ray_box::{MIN_HIT_RANGE_M, RangeAndCosine, slab};
use nalgebra::Vector3;

/// Golden sections to the minimum, and bisections from there to the surface: (0.618)^60 and 2^-50 of the way through
/// the bounding box are below the rounding of a range.
const GOLDEN_SECTIONS: usize = 60;
/// See [`GOLDEN_SECTIONS`].
const BISECTIONS: usize = 50;

/// The nearest hit from `o` along `d` (unit), both in the frame of the superquadric.
pub(crate) fn hit(
    o: &Vector3<f64>,
    d: &Vector3<f64>,
    half: &Vector3<f64>,
    exponents: [f64; 2],
) -> Option<RangeAndCosine> {
    let [enter, leave] = slab(o, d, half)?;
    let outside = |t: f64| norm((o + d * t).component_div(half), exponents) - 1.0;
    let minimum = minimise(enter, leave, outside);
    if outside(minimum) > 0.0 {
        return None;
    }
    [(enter, minimum), (leave, minimum)]
        .into_iter()
        .map(|(out, within)| bisect(out, within, outside))
        .find(|t| *t > MIN_HIT_RANGE_M)
        .map(|t| (t, cosine(&(o + d * t), d, half, exponents)))
}

/// The left side to the power e1/2 at `u`, in units of the half sizes.
fn norm(u: Vector3<f64>, [e1, e2]: [f64; 2]) -> f64 {
    // Of degree one: dividing by the greatest coordinate keeps powers in range.
    let max = u.amax();
    if max == 0.0 {
        return 0.0;
    }
    let v = u.abs() / max;
    let across = v.x.powf(2.0 / e2) + v.y.powf(2.0 / e2);
    max * (across.powf(e2 / e1) + v.z.powf(2.0 / e1)).powf(e1 / 2.0)
}

/// Where `f`, which has one minimum, is least between `a` and `b`; stops at the first value below zero.
fn minimise(mut a: f64, mut b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut at_c, mut at_d) = (f(c), f(d));
    for _ in 0..GOLDEN_SECTIONS {
        if at_c < 0.0 {
            return c;
        }
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - golden * (b - a);
            at_c = f(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + golden * (b - a);
            at_d = f(d);
        }
    }
    f64::midpoint(a, b)
}

/// Where `f` changes its sign between `out` and `within`.
fn bisect(mut out: f64, mut within: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(out, within);
        if f(middle) > 0.0 {
            out = middle;
        } else {
            within = middle;
        }
    }
    f64::midpoint(out, within)
}

/// Cosine of incidence at `p` on the surface.
fn cosine(p: &Vector3<f64>, d: &Vector3<f64>, half: &Vector3<f64>, [e1, e2]: [f64; 2]) -> f64 {
    let u = p.component_div(half);
    let power = |x: f64, e: f64| x.abs().max(1e-12).powf(e).copysign(x);
    let across = (u.x.abs().powf(2.0 / e2) + u.y.abs().powf(2.0 / e2)).max(1e-300);
    let shared = across.powf(e2 / e1 - 1.0);
    let normal = Vector3::new(
        shared * power(u.x, 2.0 / e2 - 1.0) / half.x,
        shared * power(u.y, 2.0 / e2 - 1.0) / half.y,
        power(u.z, 2.0 / e1 - 1.0) / half.z,
    );
    let scaled = normal / normal.amax().max(1e-300);
    scaled.try_normalize(1e-12).map_or(1.0, |n| n.dot(d).abs())
}

#[cfg(test)]
mod tests {
    use super::hit;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    const HALF: [f64; 3] = [0.5, 0.3, 0.8];

    fn at(o: [f64; 3], d: [f64; 3], exponents: [f64; 2]) -> Option<(f64, f64)> {
        hit(
            &o.into(),
            &Vector3::from(d).normalize(),
            &HALF.into(),
            exponents,
        )
    }

    #[test]
    fn exponents_of_one_make_an_ellipsoid() {
        // x^2 / 0.25 + y^2 / 0.09 = 1 at y = 0.15: x = -0.5 sqrt(3/4).
        let (range, cosine) = at([-2.0, 0.15, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0]).expect("a hit");
        let x = -0.5 * 0.75f64.sqrt();
        assert!((range - (2.0 + x)).abs() < 1e-9, "{range}");
        let normal = Vector3::new(x / 0.25, 0.15 / 0.09, 0.0).normalize();
        assert!((cosine - normal.x.abs()).abs() < 1e-6, "{cosine}");
        assert_eq!(at([-2.0, 0.31, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0]), None);
        // From inside, the far wall.
        let (range, _) = at([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0]).expect("a hit");
        assert!((range - 0.8).abs() < 1e-9);
        assert_eq!(at([2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0]), None);
    }

    #[test]
    fn exponents_of_two_make_an_octahedron() {
        // |x| / 0.5 + |y| / 0.3 + |z| / 0.8 = 1.
        let (range, cosine) = at([-2.0, 0.1, 0.2], [1.0, 0.0, 0.0], [2.0, 2.0]).expect("a hit");
        let x = -0.5 * (1.0 - 0.1 / 0.3 - 0.2 / 0.8);
        assert!((range - (2.0 + x)).abs() < 1e-9, "{range}");
        let normal = Vector3::new(1.0 / 0.5, 1.0 / 0.3, 1.0 / 0.8).normalize();
        assert!((cosine - normal.x).abs() < 1e-6, "{cosine}");
    }

    proptest! {
        #[test]
        fn a_hit_lies_on_the_surface_and_nothing_before_it(
            e in (0.1..2.0, 0.1..2.0),
            from in (-3.0..3.0, -3.0..3.0, -3.0..3.0),
            to in (-0.4..0.4, -0.25..0.25, -0.7..0.7),
        ) {
            let (o, target) = (Vector3::from(<[f64; 3]>::from(from)), Vector3::from(<[f64; 3]>::from(to)));
            prop_assume!((target - o).norm() > 0.01);
            let d = (target - o).normalize();
            let half = Vector3::from(HALF);
            let exponents = [e.0, e.1];
            // By the equation itself.
            let side = |t: f64| {
                let u = (o + d * t).component_div(&half).abs();
                let across = u.x.powf(2.0 / e.1) + u.y.powf(2.0 / e.1);
                across.powf(e.1 / e.0) + u.z.powf(2.0 / e.0) - 1.0
            };
            if let Some((t, cosine)) = hit(&o, &d, &half, exponents) {
                prop_assert!(t > 0.0 && (0.0..=1.0 + 1e-9).contains(&cosine));
                prop_assert!(side(t - 1e-6) * side(t + 1e-6) <= 0.0);
                let outside = side(0.0) > 0.0;
                for k in 0..50 {
                    prop_assert_eq!(side(t * f64::from(k) / 50.0) > 0.0, outside);
                }
            } else {
                prop_assert!(side((target - o).norm()) > 0.0);
            }
        }
    }
}
