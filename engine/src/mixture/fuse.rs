//! Two mixtures of one place as one (`docs/novelty.md section 3`).

use super::merge::{CountedComponent, MergeLoss, reduce};
use super::own_share::log_own_shares;
use super::{CountedMixture, Gaussian, Mixture, MixtureError};

/// What came of two mixtures.
#[derive(Debug, Clone, PartialEq)]
pub struct Fusion {
    /// The fused mixture.
    pub fused: CountedMixture,
    /// Pairs that were merged.
    pub merges: usize,
    /// Bound of the KL divergence that merging cost, nats per beam (Runnalls 2007).
    pub lost_nats: f64,
}

/// Both mixtures, which are in one frame, as one of at most `max_components` components.
///
/// Beams add. Surface that both saw counts once: at a point x, a beam stands for 1 / density(x) of the surface, so each
/// component keeps of its area the mean over its plate of the posterior (paper Eq. 8) among the components of both, over
/// that among those of its own mixture. Then twins become one, and pairs of least loss until the number is reached.
///
/// Laws: mean and covariance of all beams are those of the beams of `a` and `b` together, however much is merged;
/// `fuse(a, a)` is `a` with twice the beams; the order of three makes no difference as long as the number is not reached.
///
/// # Errors
/// [`MixtureError::BadSetting`] without room for a component; sums that overflow.
pub fn fuse(
    a: &CountedMixture,
    b: &CountedMixture,
    max_components: usize,
) -> Result<Fusion, MixtureError> {
    if max_components == 0 {
        return Err(MixtureError::BadSetting {
            name: "max_components",
            got: 0.0,
            expected: "a number from 1",
        });
    }
    let (mut parts, others) = (parts_of(a), parts_of(b));
    let alone = log_shares(&parts).into_iter().chain(log_shares(&others));
    let alone: Vec<f64> = alone.collect();
    parts.extend(others);
    let together = log_shares(&parts);
    for ((part, alone), together) in parts.iter_mut().zip(alone).zip(together) {
        part.area_m2 *= (together - alone).exp();
    }
    let MergeLoss { merges, nats } = reduce(&mut parts, max_components);
    let total: f64 = parts.iter().map(|p| p.beams).sum();
    Ok(Fusion {
        fused: joined(&parts)?,
        merges,
        lost_nats: nats / total,
    })
}

/// The components that have beams.
fn parts_of(counted: &CountedMixture) -> Vec<CountedComponent> {
    let mixture = counted.mixture();
    let parts = mixture.components.iter().zip(&mixture.weights);
    parts
        .zip(counted.beams())
        .filter(|(_, beams)| **beams > 0.0)
        .map(|((gaussian, weight), beams)| CountedComponent {
            gaussian: *gaussian,
            beams: *beams,
            area_m2: weight * counted.surface_m2(),
        })
        .collect()
}

fn log_shares(parts: &[CountedComponent]) -> Vec<f64> {
    let components: Vec<Gaussian> = parts.iter().map(|p| p.gaussian).collect();
    let beams: Vec<f64> = parts.iter().map(|p| p.beams).collect();
    log_own_shares(&components, &beams)
}

fn joined(parts: &[CountedComponent]) -> Result<CountedMixture, MixtureError> {
    let areas: Vec<f64> = parts.iter().map(|p| p.area_m2).collect();
    let surface_m2 = areas.iter().sum();
    let components = parts.iter().map(|p| p.gaussian).collect();
    let mixture = Mixture::from_masses(areas, components)?;
    let beams = parts.iter().map(|p| p.beams).collect();
    CountedMixture::try_new(mixture, beams, Some(surface_m2))
}

#[cfg(test)]
mod tests {
    use super::fuse;
    use crate::mixture::{CountedMixture, Gaussian, Mixture, MixtureError};
    use nalgebra::{Matrix3, Point3, Vector3};
    use proptest::prelude::*;

    /// Plates of any attitude, some centimetres thick, with their beams and weights.
    fn counted() -> impl Strategy<Value = CountedMixture> {
        let component = (
            proptest::array::uniform3(-3.0..3.0f64),
            proptest::array::uniform9(-0.5..0.5f64),
            0.05..1.0f64,
            1.0..500.0f64,
        );
        (proptest::collection::vec(component, 1..9), 1.0..60.0f64).prop_map(|(parts, area)| {
            let gaussian = |(mean, root): (&[f64; 3], &[f64; 9])| {
                let mut root = Matrix3::from_row_slice(root);
                root.column_mut(0).scale_mut(0.05);
                Gaussian {
                    mean: Point3::from(*mean),
                    covariance: root * root.transpose(),
                }
            };
            let components = parts.iter().map(|p| gaussian((&p.0, &p.1))).collect();
            let weights = parts.iter().map(|p| p.2).collect();
            let mixture = Mixture::from_masses(weights, components).expect("sound");
            let beams = parts.iter().map(|p| p.3).collect();
            CountedMixture::try_new(mixture, beams, Some(area)).expect("sound")
        })
    }

    /// Moments of all beams of both, from the beams of each.
    fn moments_of_both(a: &CountedMixture, b: &CountedMixture) -> Gaussian {
        let mixture = Mixture {
            weights: [a.beams(), b.beams()].concat(),
            components: [&a.mixture().components[..], &b.mixture().components[..]].concat(),
        };
        mixture.total_moments().expect("beams")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]
        #[test]
        fn fused_with_itself_it_is_itself_with_twice_the_beams(a in counted()) {
            let got = fuse(&a, &a, 100).expect("fused");
            let twice = &got.fused;
            prop_assert_eq!(got.merges, a.beams().len());
            prop_assert!(got.lost_nats < 1e-9);
            prop_assert!((twice.surface_m2() / a.surface_m2() - 1.0).abs() < 1e-9);
            prop_assert_eq!(twice.mixture().len(), a.mixture().len());
            for k in 0..a.mixture().len() {
                let (x, y) = (twice.mixture().components[k], a.mixture().components[k]);
                prop_assert!((x.mean - y.mean).norm() < 1e-12);
                prop_assert!((x.covariance - y.covariance).amax() < 1e-12);
                prop_assert!((twice.mixture().weights[k] - a.mixture().weights[k]).abs() < 1e-9);
                prop_assert!((twice.beams()[k] - 2.0 * a.beams()[k]).abs() < 1e-9);
            }
        }

        #[test]
        fn moments_of_the_beams_and_their_number_are_kept_however_few_components_are_left(a in counted(), b in counted(), max in 1usize..20) {
            let got = fuse(&a, &b, max).expect("fused").fused;
            prop_assert!(got.mixture().len() <= max);
            let (total, expected) = (got.beam_moments().expect("beams"), moments_of_both(&a, &b));
            prop_assert!((total.mean - expected.mean).norm() < 1e-10);
            prop_assert!((total.covariance - expected.covariance).amax() < 1e-10);
            let beams = |m: &CountedMixture| m.beams().iter().sum::<f64>();
            prop_assert!((beams(&got) - beams(&a) - beams(&b)).abs() < 1e-9 * beams(&got));
        }

        #[test]
        fn the_area_is_that_of_either_at_least_and_of_both_at_most(a in counted(), b in counted()) {
            let got = fuse(&a, &b, 100).expect("fused").fused;
            prop_assert!(got.surface_m2() <= (a.surface_m2() + b.surface_m2()) * (1.0 + 1e-12));
            let reversed = fuse(&b, &a, 100).expect("fused").fused;
            prop_assert!((got.surface_m2() - reversed.surface_m2()).abs() < 1e-9);
            let moved = moved_away(&b);
            let apart = fuse(&a, &moved, 100).expect("fused").fused;
            prop_assert!((apart.surface_m2() - a.surface_m2() - b.surface_m2()).abs() < 1e-9);
        }
    }

    fn moved_away(b: &CountedMixture) -> CountedMixture {
        let mut mixture = b.mixture().clone();
        let far = Vector3::new(100.0, 0.0, 0.0);
        mixture.components.iter_mut().for_each(|g| g.mean += far);
        CountedMixture::try_new(mixture, b.beams().to_vec(), Some(b.surface_m2())).expect("sound")
    }

    /// A square metre of wall, 1 cm thick, with its middle at (x, y).
    fn wall(x: f64, y: f64) -> Gaussian {
        Gaussian {
            mean: Point3::new(x, y, 0.0),
            covariance: Matrix3::from_diagonal(&Vector3::new(1.0 / 12.0, 1.0 / 12.0, 1e-4)),
        }
    }

    fn walls(of: &[(f64, f64)], beams: f64) -> CountedMixture {
        let components: Vec<Gaussian> = of.iter().map(|&(x, y)| wall(x, y)).collect();
        let mixture = Mixture::from_masses(vec![1.0; of.len()], components).expect("sound");
        CountedMixture::with_total_beams(mixture, beams, None).expect("sound")
    }

    #[test]
    fn a_wall_that_both_saw_counts_once() {
        // Walls 1 and 2 with 100 beams each, then 2 and 3 with 50 each.
        let (a, b) = (
            walls(&[(0.0, 0.0), (9.0, 0.0)], 200.0),
            walls(&[(9.0, 0.0), (18.0, 0.0)], 100.0),
        );
        let got = fuse(&a, &b, 10).expect("fused");
        assert_eq!(got.merges, 1);
        assert!((got.fused.surface_m2() - 3.0).abs() < 1e-9);
        for (weight, (beams, expected)) in got
            .fused
            .mixture()
            .weights
            .iter()
            .zip(got.fused.beams().iter().zip([100.0, 150.0, 50.0]))
        {
            assert!((weight - 1.0 / 3.0).abs() < 1e-9, "{weight}");
            assert!((beams - expected).abs() < 1e-9, "{beams}");
        }
        // Under the beams the middle is at (100 * 0 + 150 * 9 + 50 * 18) / 300, under the areas at 9.
        assert!((got.fused.beam_moments().expect("beams").mean.x - 7.5).abs() < 1e-9);
        assert!((got.fused.mixture().total_moments().expect("mass").mean.x - 9.0).abs() < 1e-9);
    }

    #[test]
    fn a_wall_that_both_saw_in_other_pieces_counts_once() {
        // The same 6 x 6 m of wall, cut half a metre further along both sides the second time, and another wall far away
        // that only the first saw.
        let tiles = |shift: f64| -> Vec<(f64, f64)> {
            (0..36)
                .map(|k| (f64::from(k / 6) + shift, f64::from(k % 6) + shift))
                .collect()
        };
        let mut of_a = tiles(0.0);
        of_a.extend(tiles(100.0));
        let (a, b) = (walls(&of_a, 7200.0), walls(&tiles(0.5), 1800.0));
        let got = fuse(&a, &b, 1000).expect("fused").fused;
        let near = |k: &usize| got.mixture().components[*k].mean.x < 50.0;
        let share: f64 = (0..got.mixture().len())
            .filter(near)
            .map(|k| got.mixture().weights[k])
            .sum();
        // Of the union of 6.5 x 6.5 less two corners of 0.5 x 0.5 and twelve by half a metre at either side.
        let union: f64 = 36.0 + 36.0 - 5.5 * 5.5;
        let expected = union / (union + 36.0);
        eprintln!("share of the wall seen twice: {share:.4}, by area {expected:.4}");
        assert!((share - expected).abs() < 0.02, "{share} {expected}");
    }

    #[test]
    fn no_room_is_refused() {
        let a = walls(&[(0.0, 0.0)], 1.0);
        assert!(matches!(
            fuse(&a, &a, 0),
            Err(MixtureError::BadSetting {
                name: "max_components",
                ..
            })
        ));
    }
}
