//! Who pays for d_GMM: mass that is too much here and missing there, and the flows between.

use super::NoveltyError;
use super::quantify::Balance;
use crate::distance::{Ground, emd};
use crate::mixture::{Gaussian, Mixture};

/// Who has mass left and who lacks it once common mass stays where it is. All ground distances are
/// metrics, so that leaving common mass in place costs nothing and the EMD stays exact.
#[derive(Default)]
pub struct Ledger {
    surplus: Mixture,
    from: Vec<Option<(usize, usize)>>,
    lack: Mixture,
    to: Vec<Option<(usize, usize)>>,
}

impl Ledger {
    /// Enters a component with its masses in reference and revisit, and the novelty that owns it.
    pub fn enter(&mut self, g: Gaussian, masses: [f64; 2], owner: Option<(usize, usize)>) {
        let difference = masses[0] - masses[1];
        // Below rounding of masses that sum to one, nothing moves.
        if difference > 1e-12 {
            self.surplus.components.push(g);
            self.surplus.weights.push(difference);
            self.from.push(owner);
        } else if difference < -1e-12 {
            self.lack.components.push(g);
            self.lack.weights.push(-difference);
            self.to.push(owner);
        }
    }

    /// Moves what is left the cheapest way and books every flow's cost to the novelties at its ends, or to
    /// the rest.
    ///
    /// # Errors
    /// Ground distances that are not finite.
    pub fn settle(&self, ground: Ground, balance: &mut Balance) -> Result<(), NoveltyError> {
        let moved: f64 = self.surplus.weights.iter().sum();
        if moved <= 0.0 || self.lack.is_empty() {
            return Ok(());
        }
        let solved = emd(&self.surplus, &self.lack, ground)?;
        for flow in &solved.plan {
            let cost = moved * flow.mass * flow.distance;
            balance.d += cost;
            let owners: Vec<(usize, usize)> = [self.from[flow.from], self.to[flow.to]]
                .into_iter()
                .flatten()
                .collect();
            if owners.is_empty() {
                balance.rest += cost;
            }
            for (side, index) in &owners {
                let part = cost / owners.len() as f64;
                if *side == 0 {
                    balance.disappeared[*index].1 += part;
                } else {
                    balance.appeared[*index].1 += part;
                }
            }
        }
        Ok(())
    }
}
