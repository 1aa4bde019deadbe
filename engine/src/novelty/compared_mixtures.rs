//! Gamma and Theta as they enter Eq. 6: one list of components, each with its mass in either mixture.

use super::NoveltyError;
use super::constants::ROUNDING;
use crate::distance::{CostMatrix, GroundDistance, cost_matrix, emd_with_prices};
use crate::mixture::{Gaussian, Mixture};
use std::collections::HashMap;

/// A Gaussian with its masses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedComponent {
    /// Mean and covariance, in the reference's frame.
    pub gaussian: Gaussian,
    /// Its weight in Gamma and in Theta; 0 where the mixture does not have it.
    pub masses: [f64; 2],
}

/// Both mixtures of one comparison. A component with mass on both sides is a twin: the same Gaussian in Gamma and Theta.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparedMixtures {
    /// The components of Gamma, in its order, then those that Theta alone has.
    pub components: Vec<ComparedComponent>,
}

/// Mass that goes from a component of Gamma to one of Theta.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedFlow {
    /// Index of the component that gives mass.
    pub from: usize,
    /// Index of the component that takes it.
    pub to: usize,
    /// Mass times ground distance: its part of d_GMM.
    pub cost: f64,
}

impl ComparedMixtures {
    /// Pairs the components of two mixtures that have the same mean and covariance to the bit.
    pub fn from_mixtures(gamma: &Mixture, theta: &Mixture) -> Self {
        let key = |g: &Gaussian| -> Vec<u64> {
            let entries = g.mean.coords.iter().chain(g.covariance.iter());
            entries.map(|x| x.to_bits()).collect()
        };
        let mut compared = Self::default();
        let mut place_of = HashMap::new();
        for (side, mixture) in [gamma, theta].into_iter().enumerate() {
            for (gaussian, weight) in mixture.components.iter().zip(&mixture.weights) {
                let place = *place_of.entry(key(gaussian)).or_insert_with(|| {
                    compared.components.push(ComparedComponent {
                        gaussian: *gaussian,
                        masses: [0.0; 2],
                    });
                    compared.components.len() - 1
                });
                compared.components[place].masses[side] += weight;
            }
        }
        compared
    }

    pub(super) fn push(&mut self, gaussian: Gaussian, masses: [f64; 2]) {
        self.components.push(ComparedComponent { gaussian, masses });
    }

    /// Indices of the components of `side` (0 Gamma, 1 Theta) with mass.
    pub fn present(&self, side: usize) -> impl Iterator<Item = usize> + '_ {
        let indices = 0..self.components.len();
        indices.filter(move |k| self.components[*k].masses[side] > 0.0)
    }

    /// Indices of the components that `side` alone has: candidates of Algorithm 1.
    pub fn unpaired(&self, side: usize) -> impl Iterator<Item = usize> + '_ {
        self.present(side)
            .filter(move |k| self.components[*k].masses[1 - side] <= 0.0)
    }

    /// The mixture of `side`: its components with mass, in order, weights summing to one.
    ///
    /// # Errors
    /// Masses that are not finite, or sum to nothing where there are components.
    pub fn mixture(&self, side: usize) -> Result<Mixture, NoveltyError> {
        let (masses, components) = self
            .present(side)
            .map(|k| (self.components[k].masses[side], self.components[k].gaussian))
            .unzip();
        Ok(Mixture::from_masses(masses, components)?)
    }
}

/// Takes the distance between Gamma and Theta again and again as components are removed. The cost of a pair of components is
/// computed once.
pub(super) struct ResidualTransport<'a> {
    all: Mixture,
    ground: GroundDistance,
    /// Ground distances from a component to all; `None` until needed.
    columns: Vec<Option<Vec<f64>>>,
    /// Duals of the components in the last plan: where the next one starts.
    prices: Vec<f64>,
    compared: &'a ComparedMixtures,
}

impl<'a> ResidualTransport<'a> {
    pub(super) fn new(compared: &'a ComparedMixtures, ground: GroundDistance) -> Self {
        let components = &compared.components;
        Self {
            all: Mixture {
                weights: vec![0.0; components.len()],
                components: components.iter().map(|c| c.gaussian).collect(),
            },
            ground,
            columns: vec![None; components.len()],
            prices: vec![0.0; components.len()],
            compared,
        }
    }

    /// The distance between the components `kept` of Gamma and of Theta, the weights of each made to sum to one, with the
    /// flows. Mass that both have in one component stays there: it costs nothing, and the ground distances are metrics, so no
    /// plan is better. `None` where a side has no mass left.
    ///
    /// # Errors
    /// Ground distances that are not finite.
    pub(super) fn distance(
        &mut self,
        kept: &[[bool; 2]],
    ) -> Result<Option<(f64, Vec<ComparedFlow>)>, NoveltyError> {
        let mass = |k: usize, side: usize| {
            if kept[k][side] {
                self.compared.components[k].masses[side]
            } else {
                0.0
            }
        };
        let count = self.compared.components.len();
        let totals = [0, 1].map(|side| (0..count).map(|k| mass(k, side)).sum::<f64>());
        if totals.iter().any(|total| *total <= 0.0) {
            return Ok(None);
        }
        let mut ends: [Vec<usize>; 2] = [Vec::new(), Vec::new()];
        let mut masses: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
        for k in 0..count {
            let difference = mass(k, 0) / totals[0] - mass(k, 1) / totals[1];
            if difference.abs() > ROUNDING {
                let side = usize::from(difference < 0.0);
                ends[side].push(k);
                masses[side].push(difference.abs());
            }
        }
        if ends.iter().any(Vec::is_empty) {
            return Ok(Some((0.0, Vec::new())));
        }
        let moved: f64 = masses[0].iter().sum();
        // The simplex is fast where the columns are the fewer.
        let columns = usize::from(ends[1].len() <= ends[0].len());
        let [row_ends, column_ends] = [&ends[1 - columns], &ends[columns]];
        let costs = self.costs(row_ends, column_ends);
        let prices: Vec<f64> = column_ends.iter().map(|k| self.prices[*k]).collect();
        let [row_masses, column_masses] = [&masses[1 - columns], &masses[columns]];
        let solved = emd_with_prices(row_masses, column_masses, &costs, Some(&prices))?;
        for (k, dual) in column_ends.iter().zip(&solved.duals.1) {
            self.prices[*k] = *dual;
        }
        let flows: Vec<ComparedFlow> = solved
            .plan
            .iter()
            .map(|flow| {
                let [row, column] = [row_ends[flow.from], column_ends[flow.to]];
                let [from, to] = if columns == 1 {
                    [row, column]
                } else {
                    [column, row]
                };
                let cost = moved * flow.mass * flow.distance;
                ComparedFlow { from, to, cost }
            })
            .collect();
        Ok(Some((flows.iter().map(|f| f.cost).sum(), flows)))
    }

    /// Costs between the components `row_ends` and the fewer `column_ends`.
    fn costs(&mut self, row_ends: &[usize], column_ends: &[usize]) -> CostMatrix {
        let needed: Vec<usize> = column_ends
            .iter()
            .copied()
            .filter(|k| self.columns[*k].is_none())
            .collect();
        if !needed.is_empty() {
            let from = Mixture {
                weights: vec![0.0; needed.len()],
                components: needed.iter().map(|k| self.all.components[*k]).collect(),
            };
            let table = cost_matrix(&from, &self.all, self.ground);
            let columns = table.values().chunks(self.all.len().max(1));
            for (k, column) in needed.iter().zip(columns) {
                self.columns[*k] = Some(column.to_vec());
            }
        }
        let columns: Vec<&[f64]> = column_ends
            .iter()
            .filter_map(|k| self.columns[*k].as_deref())
            .collect();
        let values = row_ends
            .iter()
            .flat_map(|row| columns.iter().map(|column| column[*row]))
            .collect();
        CostMatrix::new(row_ends.len(), column_ends.len(), values)
    }
}
