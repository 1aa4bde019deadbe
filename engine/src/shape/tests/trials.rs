//! Rates over many simulated views.

use super::scenes::{random_primitive, simulate_view};
use crate::geometry::NoiseLaw;
use crate::mixture::Mixture;
use crate::novelty::Surroundings;
use crate::shape::primitive::Primitive;
use crate::shape::{Class, ShapeSettings, retrieve};
use nalgebra::Point3;
use std::collections::BTreeMap;
use std::ops::Range;

struct Rates {
    right: f64,
    wrong: f64,
    ambiguous: f64,
    size_sd_cm: f64,
    /// Root mean square error of every size, centimetres.
    sizes_cm: [f64; 3],
    z_rms: f64,
    /// Share of the sizes within 1.96 of their stated standard deviations.
    covered: f64,
    /// Median relative error of the sizes.
    median_error: f64,
    /// Counts of the other answers.
    others: BTreeMap<String, usize>,
}

fn rates(class: usize, points: usize, sigma_m: f64, settings: &ShapeSettings) -> Rates {
    rates_with_assumed_noise(class, points, sigma_m, sigma_m, 0..100, settings)
}

/// Seeds that were not used while the constants were chosen.
const HELD_OUT: Range<u64> = 7000..7060;

/// As `rates`, on these seeds, with the noise in the settings differing from that of the points.
fn rates_with_assumed_noise(
    class: usize,
    points: usize,
    sigma_m: f64,
    assumed_m: f64,
    seeds: Range<u64>,
    settings: &ShapeSettings,
) -> Rates {
    let sensor = Point3::origin();
    let settings = ShapeSettings {
        noise: NoiseLaw {
            at_zero_m: assumed_m,
            per_m: 0.0,
        },
        ..settings.clone()
    };
    let (mut right, mut wrong, mut z, mut numbers, mut covered) = (0, 0, 0.0, 0, 0);
    let (mut squares, mut flat) = ([0.0; 3], 0);
    let mut relative = Vec::new();
    let mut others: BTreeMap<String, usize> = BTreeMap::new();
    let (first, all) = (seeds.start, (seeds.end - seeds.start) as usize);
    for seed in seeds {
        let (truth, mut rng) = random_primitive(class, seed);
        let wanted = points + ((seed - first) as usize * points / all);
        // Grids do not give an exact number of points: refined until there are enough.
        let mut extra = 0;
        let view = loop {
            let view = simulate_view(&truth, &sensor, wanted + extra, sigma_m, &mut rng);
            if view.len() >= points {
                break view;
            }
            extra += 2;
        };
        let answer = retrieve(
            &view,
            &Surroundings::default(),
            &Mixture::default(),
            &sensor,
            &settings,
            seed,
        )
        .unwrap_or_else(|e| panic!("{e} {truth:?} {}", view.len()))
        .best;
        // A box of which one face is in sight and a cylinder seen end-on cannot be told from planes.
        if answer.class == Class::Plane && shows_one_flat_face(&truth, &view, &sensor) {
            right += 1;
            flat += 1;
        } else if answer.class == truth.class() {
            right += 1;
            let order = |size_m: [f64; 3]| {
                let mut order = [0, 1, 2];
                // The axis that is the equation's z is ambiguous where a superquadric's exponents are equal.
                if class == 5 {
                    order.sort_by(|&a, &b| size_m[a].total_cmp(&size_m[b]));
                }
                order
            };
            let (order_found, order_true) = (order(answer.size_m), order(truth.size_m()));
            let size_m = order_found.map(|k| answer.size_m[k]);
            let sd_m = order_found.map(|k| answer.size_sd_m[k]);
            let true_m = order_true.map(|k| truth.size_m()[k]);
            for (k, square) in squares.iter_mut().enumerate() {
                let error = size_m[k] - true_m[k];
                *square += error * error;
                if true_m[k] > 0.0 {
                    relative.push(error.abs() / true_m[k]);
                    let in_sds = error.abs() / sd_m[k].max(1e-12);
                    z += in_sds * in_sds;
                    covered += u32::from(in_sds < 1.96);
                    numbers += 1;
                }
            }
        } else {
            *others.entry(format!("{:?}", answer.class)).or_default() += 1;
            wrong += u32::from(answer.class != Class::Ambiguous);
        }
    }
    relative.sort_by(f64::total_cmp);
    if flat > 0 {
        eprintln!("{flat} show one flat face and are reported as planes");
    }
    let numbers = f64::from(numbers).max(1.0);
    Rates {
        right: f64::from(right) / all as f64,
        wrong: f64::from(wrong) / all as f64,
        ambiguous: 1.0 - f64::from(right + wrong) / all as f64,
        size_sd_cm: 100.0 * (squares.iter().sum::<f64>() / numbers).sqrt(),
        sizes_cm: squares.map(|s| 100.0 * (s / f64::from(right - flat).max(1.0)).sqrt()),
        z_rms: (z / numbers).sqrt(),
        covered: f64::from(covered) / numbers,
        median_error: relative
            .get(relative.len() / 2)
            .copied()
            .unwrap_or(f64::NAN),
        others,
    }
}

/// Whether all but one point in twenty are on one flat face of `truth`.
fn shows_one_flat_face(truth: &Primitive, view: &[Point3<f64>], sensor: &Point3<f64>) -> bool {
    let mut on = [0; 3];
    for p in view {
        on[truth.visible_face(p, sensor)] += 1;
    }
    let flat = match truth {
        Primitive::Cuboid(_) => on.iter().max(),
        // The cap of a cylinder, the base of a cone.
        Primitive::Cylinder(_) | Primitive::Cone(_) => on.get(1),
        _ => None,
    };
    flat.is_some_and(|n| n * 20 >= view.len() * 19)
}

fn show(points: usize, sigma_m: f64, name: &str, r: &Rates) {
    eprintln!(
        "{points}-{} points, sigma {sigma_m} m, {name}: right {:.2} wrong {:.2} ambiguous {:.2} size sd {:.2} cm {:.2?} median {:.3}, {:.2} of the stated, {:.2} covered, else {:?}",
        2 * points,
        r.right,
        r.wrong,
        r.ambiguous,
        r.size_sd_cm,
        r.sizes_cm,
        r.median_error,
        r.z_rms,
        r.covered,
        r.others
    );
}

/// Asserts, for each of the paper's classes, at least this share of right answers, at most this share of wrong ones, and a
/// largest standard deviation of the sizes.
fn expect(
    points: usize,
    sigma_m: f64,
    settings: &ShapeSettings,
    right: [f64; 3],
    wrong: f64,
    size_sd_cm: [f64; 3],
) {
    for (class, name) in ["sphere", "cylinder", "plane"].iter().enumerate() {
        let r = rates(class, points, sigma_m, settings);
        show(points, sigma_m, name, &r);
        assert!(r.right >= right[class], "{name}: right {:.2}", r.right);
        assert!(r.wrong <= wrong, "{name}: wrong {:.2}", r.wrong);
        assert!(
            r.size_sd_cm <= size_sd_cm[class],
            "{name}: {:.2} cm",
            r.size_sd_cm
        );
    }
}

#[test]
fn classes_are_found_at_the_papers_noise() {
    let s = ShapeSettings::default();
    expect(60, 0.032, &s, [0.98, 0.98, 0.97], 0.02, [2.0, 3.2, 3.6]);
}

#[test]
fn classes_are_found_at_the_sensors_noise() {
    let s = ShapeSettings::default();
    expect(60, 0.005, &s, [0.98, 0.98, 0.98], 0.02, [0.7, 2.0, 3.5]);
}

#[test]
fn few_points_give_less_certain_classes() {
    let s = ShapeSettings::default();
    expect(15, 0.032, &s, [0.90, 0.80, 0.95], 0.12, [5.0, 9.0, 9.0]);
    expect(15, 0.005, &s, [0.95, 0.90, 0.95], 0.08, [2.0, 6.5, 9.0]);
}

#[test]
fn moments_alone_are_nearly_as_good_at_the_papers_noise() {
    let s = ShapeSettings {
        use_point_distances: false,
        ..ShapeSettings::default()
    };
    expect(60, 0.032, &s, [0.95, 0.90, 0.90], 0.08, [4.0, 6.0, 6.0]);
}

/// Sphere, cylinder and plane where the assumed noise is too small, so that box, cone and superquadric are tried.
#[test]
fn simple_objects_stay_simple_where_all_classes_are_tried() {
    for (points, sigma_m) in [(60, 0.005), (60, 0.01), (400, 0.01)] {
        for (class, name) in [(0, "sphere"), (1, "cylinder"), (2, "plane")] {
            let settings = ShapeSettings::default();
            let r = rates_with_assumed_noise(
                class,
                points,
                sigma_m,
                0.6 * sigma_m,
                HELD_OUT,
                &settings,
            );
            show(points, sigma_m, name, &r);
            assert!(r.right >= 0.93, "{name}: right {:.2}", r.right);
            assert!(r.wrong <= 0.04, "{name}: wrong {:.2}", r.wrong);
        }
    }
}

/// Boxes (of one, two or three faces in sight), cones and superquadrics of 60-800 points.
#[test]
fn box_cone_and_superquadric_are_found() {
    let settings = ShapeSettings::default();
    for (points, sigma_m) in [(60, 0.005), (60, 0.01), (400, 0.01)] {
        for (class, name) in [(3, "box"), (4, "cone"), (5, "superquadric")] {
            let r = rates_with_assumed_noise(class, points, sigma_m, sigma_m, HELD_OUT, &settings);
            show(points, sigma_m, name, &r);
            let definite = r.right / (r.right + r.wrong);
            assert!(definite >= 0.90, "{name}: right {definite:.2}");
            assert!(
                r.median_error <= 0.05,
                "{name}: median error {:.3}",
                r.median_error
            );
            assert!(r.covered >= 0.85, "{name}: covered {:.2}", r.covered);
        }
    }
}

/// Cylinders that are nearly discs, or seen nearly end-on.
#[test]
fn difficult_cylinders_are_mostly_found() {
    let settings = ShapeSettings::default();
    for (points, sigma_m) in [(60, 0.01), (400, 0.01)] {
        for (class, name) in [(6, "short cylinder"), (7, "cylinder end-on")] {
            let r =
                rates_with_assumed_noise(class, points, sigma_m, sigma_m, 7000..7060, &settings);
            show(points, sigma_m, name, &r);
            // A disc with a few points of the lateral surface is reported as a plane.
            let least = if class == 6 { 0.85 } else { 0.70 };
            assert!(r.right >= least, "{name}: right {:.2}", r.right);
        }
    }
}
