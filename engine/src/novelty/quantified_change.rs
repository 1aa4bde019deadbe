//! d_GMM with its parts.

use super::algorithm1::ChangeSegmentation;
use super::model::SegmentId;

/// A novelty's share of d_GMM.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct NoveltyShare {
    /// Its share of the mass.
    pub mass: f64,
    /// Its part of d_GMM.
    pub contribution: f64,
    /// Its components, as indices into the compared mixtures.
    pub components: Vec<usize>,
    /// Whether d_GMM was at least U_th until one of its components was taken out.
    pub needed_for_alarm: bool,
}

/// d_GMM and what it consists of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct QuantifiedChange {
    /// d_GMM, in the unit of the ground distance.
    pub d: f64,
    /// d_GMM times the visible surface, m^3 (for a ground distance in metres).
    pub work_m3: f64,
    /// Disappeared and appeared novelties, in the order of their segments.
    pub shares: [Vec<NoveltyShare>; 2],
    /// Part of `d` that no novelty explains; contributions and this sum to `d`.
    pub unexplained: f64,
    /// Number of components with mass: reference, current.
    pub components: [usize; 2],
    /// Share of each view's surface that the other could see: reference, current.
    pub overlap: [f64; 2],
}

impl QuantifiedChange {
    /// Books the cost of every flow of the first plan to the segments at its ends: half and half where there is one at both,
    /// `unexplained` where there is none. `owners` is the side and index of the segment of each component.
    pub(super) fn book(&mut self, found: &ChangeSegmentation, owners: &[Option<SegmentId>]) {
        for (k, owner) in owners.iter().enumerate() {
            if let Some((side, index)) = owner {
                self.shares[*side][*index].components.push(k);
            }
        }
        for flow in &found.plan {
            let ends: Vec<SegmentId> = [owners[flow.from], owners[flow.to]]
                .into_iter()
                .flatten()
                .collect();
            if ends.is_empty() {
                self.unexplained += flow.cost;
            }
            for (side, index) in &ends {
                self.shares[*side][*index].contribution += flow.cost / ends.len() as f64;
            }
        }
        for removal in &found.removals {
            if let Some((side, index)) = owners[removal.component] {
                self.shares[side][index].needed_for_alarm |= removal.needed_for_alarm;
            }
        }
    }
}
