//! EM, ground distances and the EMD against scikit-learn, SciPy and POT, from the table that
//! `tests/data/make_reference_numbers.py` makes.

use nalgebra::Point3;
use patrold_engine::distance::{GroundDistance, cost_matrix, emd, partial_emd_of_costs};
use patrold_engine::mixture::{EmSettings, Mixture, MixtureRecord, em};
use serde::Deserialize;

#[derive(Deserialize)]
struct ReferenceTable {
    em: EmTable,
    emd: Vec<EmdCase>,
    partial: Vec<PartialCase>,
}

#[derive(Deserialize)]
struct EmTable {
    points: Vec<[f64; 3]>,
    start: MixtureRecord,
    cases: Vec<EmCase>,
}

#[derive(Deserialize)]
struct EmCase {
    iterations: usize,
    mean_log_likelihood: f64,
    mixture: MixtureRecord,
}

#[derive(Deserialize)]
struct EmdCase {
    a: MixtureRecord,
    b: MixtureRecord,
    w2: ExpectedDistances,
    fm: ExpectedDistances,
    euclid: ExpectedDistances,
}

#[derive(Deserialize)]
struct ExpectedDistances {
    emd: f64,
    first_row: Vec<f64>,
}

/// Weights of any sum.
#[derive(Deserialize)]
struct PartialCase {
    a: MixtureRecord,
    b: MixtureRecord,
    w2: f64,
}

fn table() -> ReferenceTable {
    serde_json::from_str(include_str!("data/reference_numbers.json")).expect("the table reads")
}

fn mixture(record: MixtureRecord) -> Mixture {
    Mixture::try_from(record).expect("a sound mixture")
}

#[test]
fn em_agrees_with_scikit_learn() {
    let EmTable {
        points,
        start,
        cases,
    } = table().em;
    let points: Vec<Point3<f64>> = points.into_iter().map(Point3::from).collect();
    let start = mixture(start);
    for case in cases {
        let settings = EmSettings {
            iterations: case.iterations,
            tolerance: 0.0,
            ..EmSettings::default()
        };
        let fit = em::run(&points, None, start.clone(), &settings).expect("fits");
        assert_eq!(fit.iterations, case.iterations);
        assert!((fit.mean_log_likelihood - case.mean_log_likelihood).abs() < 1e-9);
        let theirs = mixture(case.mixture);
        for k in 0..theirs.len() {
            assert!((fit.mixture.weights[k] - theirs.weights[k]).abs() < 1e-9);
            let (a, b) = (fit.mixture.components[k], theirs.components[k]);
            assert!((a.mean - b.mean).norm() < 1e-9);
            assert!((a.covariance - b.covariance).amax() < 1e-9);
        }
    }
}

#[test]
fn distances_agree_with_scipy_and_pot() {
    for pair in table().emd {
        let (a, b) = (mixture(pair.a), mixture(pair.b));
        for (ground, expected) in [
            (GroundDistance::W2, pair.w2),
            (GroundDistance::Fm, pair.fm),
            (GroundDistance::Euclid, pair.euclid),
        ] {
            let costs = cost_matrix(&a, &b, ground);
            for (j, theirs) in expected.first_row.iter().enumerate() {
                let ours = costs.get(0, j).expect("inside");
                assert!((ours - theirs).abs() < 1e-9, "{ground:?} {ours} {theirs}");
            }
            let ours = emd(&a, &b, ground).expect("mass");
            assert!(
                (ours.d - expected.emd).abs() < 1e-9,
                "{ground:?} {} {}",
                ours.d,
                expected.emd
            );
            assert!(ours.duality_gap.abs() < 1e-12);
        }
    }
}

#[test]
fn distances_of_unequal_masses_agree_with_pot() {
    for case in table().partial {
        let masses = |record: MixtureRecord| {
            let json = serde_json::to_string(&record).expect("serialises");
            MixtureRecord::parse_masses(&json).expect("sound")
        };
        let ((left, a), (right, b)) = (masses(case.a), masses(case.b));
        let costs = cost_matrix(&a, &b, GroundDistance::W2);
        let ours = partial_emd_of_costs(&left, &right, &costs).expect("mass");
        assert!((ours.d - case.w2).abs() < 1e-9, "{} {}", ours.d, case.w2);
    }
}
