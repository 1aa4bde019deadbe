//! Fusion in mixture space, measured by the Earth Mover's Distance: the order of three, and views of one place.

mod harness;

use nalgebra::{Point3, Vector3};
use patrold_engine::distance::{GroundDistance, emd};
use patrold_engine::mixture::{
    ComponentSelection, CountedMixture, FitSettings, Gaussian, Mixture, SplitSettings, fit, fuse,
};
use proptest::prelude::*;

/// More than any of these fusions has.
const ROOM_FOR_ALL: usize = 5000;

fn w2(a: &Mixture, b: &Mixture) -> f64 {
    emd(a, b, GroundDistance::W2).expect("mass").d
}

fn fused(a: &CountedMixture, b: &CountedMixture, max: usize) -> CountedMixture {
    fuse(a, b, max).expect("fused").fused
}

/// The largest distance between the three ways to fuse three in pairs.
fn spread_of_orders([a, b, c]: &[CountedMixture; 3], max: usize) -> f64 {
    let ways = [[a, b, c], [a, c, b], [b, c, a]].map(|[x, y, z]| fused(&fused(x, y, max), z, max));
    let between = |i: usize, j: usize| w2(ways[i].mixture(), ways[j].mixture());
    between(0, 1).max(between(0, 2)).max(between(1, 2))
}

fn fit_flat(points: &[Point3<f64>]) -> Mixture {
    let settings = FitSettings {
        components: ComponentSelection::Flat(SplitSettings::default()),
        ..FitSettings::default()
    };
    fit(points, None, &settings).expect("fits").mixture
}

fn counted(points: &[Point3<f64>]) -> CountedMixture {
    let total = points.len() as f64;
    CountedMixture::with_total_beams(fit_flat(points), total, None).expect("sound")
}

/// Those of `points` whose direction lies in this range of azimuths.
fn sector(points: &[Point3<f64>], azimuths_deg: std::ops::Range<f64>) -> Vec<Point3<f64>> {
    let is_inside = |p: &&Point3<f64>| azimuths_deg.contains(&p.y.atan2(p.x).to_degrees());
    points.iter().filter(is_inside).copied().collect()
}

/// A place of plates of any attitude; a visit sees some of them, each some millimetres off, with beams of its own.
fn visits() -> impl Strategy<Value = [CountedMixture; 3]> {
    let plate = (
        proptest::array::uniform3(-3.0..3.0f64),
        proptest::array::uniform9(-0.5..0.5f64),
        proptest::array::uniform3((
            0.0..1.0f64,
            proptest::array::uniform3(-0.005..0.005f64),
            1.0..500.0f64,
        )),
    );
    proptest::collection::vec(plate, 2..14).prop_map(|plates| {
        std::array::from_fn(|visit| {
            let (mut components, mut beams) = (Vec::new(), Vec::new());
            for (k, (mean, root, seen)) in plates.iter().enumerate() {
                let (chance, off, count) = seen[visit];
                if chance < 0.7 || k == 0 {
                    let mut root = nalgebra::Matrix3::from_row_slice(root);
                    root.column_mut(0).scale_mut(0.04);
                    components.push(Gaussian {
                        mean: Point3::from(*mean) + Vector3::from(off),
                        covariance: root * root.transpose(),
                    });
                    beams.push(count);
                }
            }
            let weights = vec![1.0; components.len()];
            let mixture = Mixture::from_masses(weights, components).expect("sound");
            CountedMixture::try_new(mixture, beams, None).expect("sound")
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn the_order_of_three_makes_no_difference(visits in visits()) {
        let spread = spread_of_orders(&visits, ROOM_FOR_ALL);
        prop_assert!(spread < 1e-3, "{spread}");
    }
}

#[test]
fn the_order_of_three_views_of_a_room_makes_no_difference() {
    let whole = harness::clouds::room_points(&[harness::clouds::CRATE], 1);
    let left = sector(&harness::clouds::room_points(&[], 2), -20.0..121.0);
    let right = sector(&harness::clouds::room_points(&[], 3), -121.0..30.0);
    let views = [whole, left, right].map(|points| counted(&points));
    let sizes = [0, 1, 2].map(|k| views[k].mixture().len());
    for (max, bound_m) in [(ROOM_FOR_ALL, 1e-3), (100, f64::INFINITY)] {
        let spread = spread_of_orders(&views, max);
        eprintln!(
            "components {sizes:?}, at most {max}: orders differ by {:.3} mm",
            spread * 1e3
        );
        assert!(spread < bound_m, "{spread}");
    }
}

#[test]
fn halves_and_overlapping_parts_fused_are_nearer_to_the_whole_than_either() {
    let first = harness::clouds::room_points(&[harness::clouds::CRATE], 1);
    let second = harness::clouds::room_points(&[harness::clouds::CRATE], 2);
    // Every surface once: what two overlapping views together should amount to.
    let whole = fit_flat(&first);
    for (name, a, b) in [
        (
            "halves",
            sector(&first, -121.0..0.0),
            sector(&first, 0.0..121.0),
        ),
        (
            "overlapping",
            sector(&first, -121.0..40.0),
            sector(&second, -40.0..121.0),
        ),
    ] {
        let (a, b) = (counted(&a), counted(&b));
        let got = fused(&a, &b, ROOM_FOR_ALL);
        let to_whole = [&a, &b, &got].map(|m| w2(m.mixture(), &whole));
        let surfaces = [&a, &b, &got].map(CountedMixture::surface_m2);
        eprintln!("{name}: A, B, fused to the whole {to_whole:.4?} m; surfaces {surfaces:.1?} m2");
        assert!(to_whole[2] < 0.5 * to_whole[0].min(to_whole[1]));
    }
}

#[test]
fn two_samples_of_a_room_fused_are_no_farther_from_the_fit_of_both_than_they_are_on_average() {
    let [a, b] = [1, 2].map(|seed| harness::clouds::room_points(&[harness::clouds::CRATE], seed));
    let both = fit_flat(&[&a[..], &b[..]].concat());
    let (a, b) = (counted(&a), counted(&b));
    let got = fused(&a, &b, ROOM_FOR_ALL);
    let to_both = [&a, &b, &got].map(|m| w2(m.mixture(), &both));
    let surfaces = [&a, &b, &got].map(CountedMixture::surface_m2);
    eprintln!("A, B, fused to the fit of both {to_both:.4?} m; surfaces {surfaces:.1?} m2");
    // The Earth Mover's Distance is convex.
    assert!(to_both[2] < 0.5 * (to_both[0] + to_both[1]));
    assert!((surfaces[2] / surfaces[0] - 1.0).abs() < 0.05);
}
