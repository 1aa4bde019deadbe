//! Algorithm 1 of the paper: the Gaussians that were added to the place, then backwards those that went
//! (`docs/novelty.md section 10`).

use super::NoveltyError;
use super::compared_mixtures::{ComparedFlow, ComparedMixtures, ResidualTransport};
use super::constants::MAX_PLANS;
use crate::distance::GroundDistance;

/// A component that Algorithm 1 moved to Pi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Removal {
    /// Index into [`ComparedMixtures::components`].
    pub component: usize,
    /// 1 if it was taken from Theta (appeared), 0 if from Gamma (disappeared).
    pub side: usize,
    /// Whether d_GMM was at least U_th until it was taken.
    pub needed_for_alarm: bool,
}

/// Result of Algorithm 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChangeSegmentation {
    /// d_GMM of the whole mixtures (line 1), in the unit of the ground distance.
    pub d: f64,
    /// The flows of that distance.
    pub plan: Vec<ComparedFlow>,
    /// Pi, in the order of removal.
    pub removals: Vec<Removal>,
    /// d after each removal.
    pub d_after: Vec<f64>,
}

/// How far Algorithm 1 goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RemovalExtent {
    /// Until d is below U_th, as printed.
    UntilBelowThreshold,
    /// On through all candidates, those after the threshold marked.
    AllCandidates,
}

/// Runs Algorithm 1. Candidates are the components of Theta without a twin in Gamma. The one with the greatest cost in the
/// current plan (the first on ties) goes to Pi, the weights that are left sum to one again, and the distance is taken again,
/// even where it rises, until it is below `u_th` or no candidate is left. Then the same backwards: components of Gamma
/// without mass in Theta, against what is left of Theta. The last component of a mixture is never taken.
///
/// # Errors
/// Ground distances that are not finite.
pub fn segment_changes(
    compared: &ComparedMixtures,
    u_th: f64,
    ground: GroundDistance,
    extent: RemovalExtent,
) -> Result<ChangeSegmentation, NoveltyError> {
    let mut transport = ResidualTransport::new(compared, ground);
    let mut kept = vec![[true; 2]; compared.components.len()];
    let Some((d, plan)) = transport.distance(&kept)? else {
        return Ok(ChangeSegmentation::default());
    };
    let mut found = ChangeSegmentation {
        d,
        plan: plan.clone(),
        ..ChangeSegmentation::default()
    };
    let (mut d, mut plan) = (d, plan);
    let mut reached = false;
    for side in [1, 0] {
        let mut candidates: Vec<usize> = compared.unpaired(side).collect();
        while !candidates.is_empty() {
            reached |= d < u_th;
            if reached && extent == RemovalExtent::UntilBelowThreshold {
                return Ok(found);
            }
            let costs = cost_per_component(&plan, side, kept.len());
            // The greatest cost; the first candidate on ties.
            let greatest = (0..candidates.len()).fold(0, |best, i| {
                if costs[candidates[i]] > costs[candidates[best]] {
                    i
                } else {
                    best
                }
            });
            let component = candidates.remove(greatest);
            kept[component][side] = false;
            if found.removals.len() < MAX_PLANS {
                let Some(next) = transport.distance(&kept)? else {
                    // It was the last one of its mixture.
                    kept[component][side] = true;
                    break;
                };
                (d, plan) = next;
            }
            found.removals.push(Removal {
                component,
                side,
                needed_for_alarm: !reached,
            });
            found.d_after.push(d);
        }
    }
    Ok(found)
}

/// Part of the distance of each component of `side`.
fn cost_per_component(plan: &[ComparedFlow], side: usize, count: usize) -> Vec<f64> {
    let mut costs = vec![0.0; count];
    for flow in plan {
        costs[if side == 0 { flow.from } else { flow.to }] += flow.cost;
    }
    costs
}

#[cfg(test)]
mod tests {
    use super::{ChangeSegmentation, RemovalExtent, segment_changes};
    use crate::distance::{GroundDistance, emd};
    use crate::mixture::{Gaussian, Mixture};
    use crate::novelty::ComparedMixtures;
    use nalgebra::{Matrix3, Point3};

    fn at(x: f64) -> Gaussian {
        Gaussian {
            mean: Point3::new(x, 0.0, 0.0),
            covariance: Matrix3::from_diagonal_element(0.01),
        }
    }

    fn mixture(parts: &[(f64, f64)]) -> Mixture {
        Mixture {
            weights: parts.iter().map(|(_, weight)| *weight).collect(),
            components: parts.iter().map(|(x, _)| at(*x)).collect(),
        }
    }

    fn run(gamma: &Mixture, theta: &Mixture, u_th: f64) -> ChangeSegmentation {
        let compared = ComparedMixtures::from_mixtures(gamma, theta);
        let all = RemovalExtent::AllCandidates;
        segment_changes(&compared, u_th, GroundDistance::Euclid, all).expect("a distance")
    }

    /// Position along x, side and need of every removal.
    fn order(
        gamma: &Mixture,
        theta: &Mixture,
        found: &ChangeSegmentation,
    ) -> Vec<(f64, usize, bool)> {
        let compared = ComparedMixtures::from_mixtures(gamma, theta);
        let removals = found.removals.iter();
        removals
            .map(|r| {
                let mean = compared.components[r.component].gaussian.mean;
                (mean.x, r.side, r.needed_for_alarm)
            })
            .collect()
    }

    #[test]
    fn the_costliest_goes_first_and_the_rest_is_marked() {
        // Worked by hand: a tenth of Theta lies 9 m and a twentieth 4 m from where Gamma has it, .15 in all.
        let gamma = mixture(&[(0.0, 0.5), (1.0, 0.5)]);
        let theta = mixture(&[(0.0, 0.425), (1.0, 0.425), (10.0, 0.1), (5.0, 0.05)]);
        let found = run(&gamma, &theta, 0.5);
        // From 0: .075, from 1: .075; .1 to 10 and .05 to 5: all .15 pay their way to 5 or 10 less their own position.
        let expected = 0.1 * 10.0 + 0.05 * 5.0 - 0.075;
        assert!((found.d - expected).abs() < 1e-12, "{}", found.d);
        assert_eq!(
            order(&gamma, &theta, &found),
            [(10.0, 1, true), (5.0, 1, false)]
        );
        // Without the first, .05 / .9 of Theta is at 5; without both the mixtures are one.
        let expected = 0.05 / 0.9 * 4.5;
        assert!((found.d_after[0] - expected).abs() < 1e-12);
        assert!(found.d_after[1].abs() < 1e-12);
    }

    #[test]
    fn a_moved_object_is_taken_from_both_though_the_distance_rises() {
        // Its new place is beside its old one, both far from all else.
        let gamma = mixture(&[(0.0, 0.9), (20.0, 0.1)]);
        let theta = mixture(&[(0.0, 0.9), (21.0, 0.1)]);
        let found = run(&gamma, &theta, 0.05);
        assert!((found.d - 0.1).abs() < 1e-12);
        assert_eq!(
            order(&gamma, &theta, &found),
            [(21.0, 1, true), (20.0, 0, true)]
        );
        assert!(
            (found.d_after[0] - 2.0).abs() < 1e-12,
            "{:?}",
            found.d_after
        );
        assert!(found.d_after[1].abs() < 1e-12);
    }

    #[test]
    fn below_the_threshold_nothing_is_needed_and_as_printed_nothing_is_taken() {
        let gamma = mixture(&[(0.0, 1.0)]);
        let theta = mixture(&[(0.0, 0.9), (1.0, 0.1)]);
        let found = run(&gamma, &theta, 0.2);
        assert_eq!(order(&gamma, &theta, &found), [(1.0, 1, false)]);
        let compared = ComparedMixtures::from_mixtures(&gamma, &theta);
        let printed = RemovalExtent::UntilBelowThreshold;
        let ground = GroundDistance::Euclid;
        let found = segment_changes(&compared, 0.2, ground, printed).expect("a distance");
        assert!(found.removals.is_empty());
        // The other side of the limit.
        let found = segment_changes(&compared, 0.0999, ground, printed).expect("a distance");
        assert_eq!(found.removals.len(), 1);
    }

    #[test]
    fn the_last_component_stays() {
        let found = run(&mixture(&[(0.0, 1.0)]), &mixture(&[(3.0, 1.0)]), 0.1);
        assert!(found.removals.is_empty() && (found.d - 3.0).abs() < 1e-12);
    }

    #[test]
    fn common_mass_that_stays_is_the_distance_of_the_whole() {
        let gamma = mixture(&[(0.0, 0.3), (1.5, 0.3), (4.0, 0.4)]);
        let theta = mixture(&[(0.0, 0.2), (1.5, 0.35), (4.0, 0.15), (6.0, 0.3)]);
        for ground in [
            GroundDistance::W2,
            GroundDistance::Euclid,
            GroundDistance::Fm,
        ] {
            let compared = ComparedMixtures::from_mixtures(&gamma, &theta);
            let all = RemovalExtent::AllCandidates;
            let found = segment_changes(&compared, 0.1, ground, all).expect("a distance");
            let whole = emd(&gamma, &theta, ground).expect("a distance").d;
            assert!((found.d - whole).abs() < 1e-12, "{ground:?}");
            let booked: f64 = found.plan.iter().map(|flow| flow.cost).sum();
            assert!((booked - whole).abs() < 1e-12);
        }
    }
}
