//! The Earth Mover's Distance between two mixtures (paper Eq. 5 and 6).

use super::transport::transport;
use super::{CostMatrix, DistanceError, GroundDistance, cost_matrix};
use crate::mixture::Mixture;

/// Mass that goes from one component to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow {
    /// Component of the first mixture.
    pub from: usize,
    /// Component of the second.
    pub to: usize,
    /// f_ij, a share of the whole mass.
    pub mass: f64,
    /// d_ij, in the unit of the ground distance.
    pub distance: f64,
}

/// The distance with its plan and duals.
#[derive(Debug, Clone, PartialEq)]
pub struct Emd {
    /// d_GMM of paper Eq. 6, in the unit of the ground distance.
    pub d: f64,
    /// The optimal flows, all positive; their `mass * distance` sum to `d`.
    pub plan: Vec<Flow>,
    /// Dual values of the components of both mixtures: `duals.0[i] + duals.1[j] <= d_ij`, equal where mass flows.
    pub duals: (Vec<f64>, Vec<f64>),
    /// How far `d` may be above the optimum; rounding only.
    pub duality_gap: f64,
}

/// Earth Mover's Distance between `a` and `b`. Both masses are normalised to one first: with the min{W, U} of paper Eq. 5
/// an added object would go unmatched at no cost.
///
/// # Errors
/// A mixture with no mass, or entries that are not finite.
pub fn emd(a: &Mixture, b: &Mixture, ground: GroundDistance) -> Result<Emd, DistanceError> {
    emd_of_costs(&a.weights, &b.weights, &cost_matrix(a, b, ground))
}

/// The same from a given cost matrix; masses are normalised to one.
///
/// # Errors
/// As [`emd`], and a cost matrix of another size.
pub fn emd_of_costs(left: &[f64], right: &[f64], costs: &CostMatrix) -> Result<Emd, DistanceError> {
    emd_with_prices(left, right, costs, None)
}

/// The same, started from `prices`: the duals of the components of the second mixture in a similar problem.
///
/// # Errors
/// As [`emd_of_costs`].
pub(crate) fn emd_with_prices(
    left: &[f64],
    right: &[f64],
    costs: &CostMatrix,
    prices: Option<&[f64]>,
) -> Result<Emd, DistanceError> {
    let (left, right) = (normalised("left", left)?, normalised("right", right)?);
    let solution = transport(&left, &right, costs, prices)?;
    let flow = |&(from, to, mass): &(usize, usize, f64)| {
        Some(Flow {
            from,
            to,
            mass,
            distance: costs.get(from, to)?,
        })
    };
    Ok(Emd {
        d: solution.work,
        plan: solution.plan.iter().filter_map(flow).collect(),
        duals: (solution.row_duals, solution.column_duals),
        duality_gap: solution.duality_gap,
    })
}

fn normalised(side: &'static str, masses: &[f64]) -> Result<Vec<f64>, DistanceError> {
    let total: f64 = masses.iter().sum();
    if let Some(index) = masses.iter().position(|m| !m.is_finite() || *m < 0.0) {
        return Err(DistanceError::BadMass {
            side,
            index,
            got: masses[index],
        });
    }
    if total <= 0.0 || !total.is_finite() {
        return Err(DistanceError::NoMass { side });
    }
    Ok(masses.iter().map(|m| m / total).collect())
}

#[cfg(test)]
mod tests {
    use super::emd;
    use crate::distance::{DistanceError, GroundDistance};
    use crate::mixture::{Gaussian, Mixture};
    use nalgebra::{Matrix3, Point3, Vector3};
    use proptest::prelude::*;

    fn mixture() -> impl Strategy<Value = Mixture> {
        let component = (
            proptest::array::uniform3(-3.0..3.0f64),
            proptest::array::uniform9(-1.0..1.0f64),
            0.01..1.0f64,
        );
        proptest::collection::vec(component, 1..10).prop_map(|parts| {
            let components = parts
                .iter()
                .map(|(mean, root, _)| {
                    let root = Matrix3::from_row_slice(root);
                    Gaussian {
                        mean: Point3::from(*mean),
                        covariance: root * root.transpose(),
                    }
                })
                .collect();
            Mixture::from_masses(parts.iter().map(|p| p.2).collect(), components).expect("sound")
        })
    }

    const GROUND_DISTANCES: [GroundDistance; 3] = [
        GroundDistance::W2,
        GroundDistance::Euclid,
        GroundDistance::Fm,
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn emd_is_a_metric_with_a_tight_dual(a in mixture(), b in mixture(), c in mixture()) {
            for ground in GROUND_DISTANCES {
                let d = |a: &Mixture, b: &Mixture| emd(a, b, ground).expect("mass").d;
                prop_assert!(d(&a, &a).abs() < 1e-12);
                prop_assert!((d(&a, &b) - d(&b, &a)).abs() < 1e-8);
                if ground != GroundDistance::Fm {
                    prop_assert!(d(&a, &c) <= d(&a, &b) + d(&b, &c) + 1e-9);
                }
                let full = emd(&a, &b, ground).expect("mass");
                prop_assert!(full.duality_gap.abs() < 1e-9);
                let work: f64 = full.plan.iter().map(|f| f.mass * f.distance).sum();
                prop_assert!((work - full.d).abs() < 1e-12);
            }
        }

        #[test]
        fn order_and_splitting_of_components_do_not_matter(a in mixture(), b in mixture()) {
            let d = |a: &Mixture| emd(a, &b, GroundDistance::W2).expect("mass").d;
            let reversed = Mixture {
                weights: a.weights.iter().rev().copied().collect(),
                components: a.components.iter().rev().copied().collect(),
            };
            prop_assert!((d(&a) - d(&reversed)).abs() < 1e-12);
            let mut split = a.clone();
            split.weights[0] *= 0.25;
            split.weights.push(a.weights[0] * 0.75);
            split.components.push(a.components[0]);
            prop_assert!((d(&a) - d(&split)).abs() < 1e-12);
        }

        #[test]
        fn a_translated_copy_is_as_far_as_its_translation(a in mixture(), by in proptest::array::uniform3(-0.2..0.2f64)) {
            let by = Vector3::from(by);
            let mut moved = a.clone();
            moved.components.iter_mut().for_each(|g| g.mean += by);
            for ground in [GroundDistance::W2, GroundDistance::Euclid] {
                prop_assert!((emd(&a, &moved, ground).expect("mass").d - by.norm()).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn worked_example_and_a_mixture_without_mass() {
        let at = |x: f64| Gaussian {
            mean: Point3::new(x, 0.0, 0.0),
            covariance: Matrix3::zeros(),
        };
        let a = Mixture {
            weights: vec![0.5, 0.5],
            components: vec![at(0.0), at(1.0)],
        };
        let b = Mixture {
            weights: vec![0.75, 0.25],
            components: vec![at(0.0), at(3.0)],
        };
        // A quarter goes back by 1 m, a quarter forward by 2 m.
        let got = emd(&a, &b, GroundDistance::W2).expect("mass");
        assert!((got.d - 0.75).abs() < 1e-15);
        assert_eq!(got.plan.len(), 3);
        let none = Mixture::default();
        assert_eq!(
            emd(&a, &none, GroundDistance::W2),
            Err(DistanceError::NoMass { side: "right" })
        );
    }
}
