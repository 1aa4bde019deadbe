//! Books the cost of d_GMM: which mass is in surplus, which is missing, and whose flows move it.

use super::NoveltyError;
use super::quantified_change::QuantifiedChange;
use crate::distance::{GroundDistance, emd};
use crate::mixture::{Gaussian, Mixture};

/// A novelty: side (0 reference, 1 current) and index.
type Owner = (usize, usize);

/// Surplus and missing mass once common mass stays in place. That costs nothing and keeps the EMD exact, since all ground
/// distances are metrics.
#[derive(Default)]
pub(super) struct Ledger {
    surplus: Mixture,
    surplus_owners: Vec<Option<Owner>>,
    missing: Mixture,
    missing_owners: Vec<Option<Owner>>,
}

impl Ledger {
    /// Adds a component with its masses in reference and current view, and the novelty that owns it.
    pub(super) fn add(&mut self, g: Gaussian, masses: [f64; 2], owner: Option<Owner>) {
        let difference = masses[0] - masses[1];
        // Smaller differences are rounding of masses that sum to one.
        if difference > 1e-12 {
            self.surplus.components.push(g);
            self.surplus.weights.push(difference);
            self.surplus_owners.push(owner);
        } else if difference < -1e-12 {
            self.missing.components.push(g);
            self.missing.weights.push(-difference);
            self.missing_owners.push(owner);
        }
    }

    /// Moves the surplus to where mass is missing at the least cost, and books the cost of every flow to the novelties at its
    /// ends, or as unexplained.
    ///
    /// # Errors
    /// Ground distances that are not finite.
    pub(super) fn settle(
        &self,
        ground: GroundDistance,
        change: &mut QuantifiedChange,
    ) -> Result<(), NoveltyError> {
        let moved: f64 = self.surplus.weights.iter().sum();
        if moved <= 0.0 || self.missing.is_empty() {
            return Ok(());
        }
        let solved = emd(&self.surplus, &self.missing, ground)?;
        for flow in &solved.plan {
            let cost = moved * flow.mass * flow.distance;
            change.d += cost;
            let owners: Vec<Owner> = [self.surplus_owners[flow.from], self.missing_owners[flow.to]]
                .into_iter()
                .flatten()
                .collect();
            if owners.is_empty() {
                change.unexplained += cost;
            }
            for (side, index) in &owners {
                let part = cost / owners.len() as f64;
                if *side == 0 {
                    change.disappeared[*index].contribution += part;
                } else {
                    change.appeared[*index].contribution += part;
                }
            }
        }
        Ok(())
    }
}
