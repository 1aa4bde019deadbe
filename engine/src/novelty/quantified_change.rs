//! d_GMM with its parts.

/// A novelty's share of d_GMM.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct NoveltyShare {
    /// Its share of the mass.
    pub mass: f64,
    /// Its part of d_GMM.
    pub contribution: f64,
}

/// d_GMM and what it consists of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct QuantifiedChange {
    /// d_GMM, in the unit of the ground distance.
    pub d: f64,
    /// d_GMM times the visible surface, m^3 (for a ground distance in metres).
    pub work_m3: f64,
    /// Surface that both views could see, novelties included, square metres.
    pub surface_m2: f64,
    /// Of each appeared novelty.
    pub appeared: Vec<NoveltyShare>,
    /// Of each disappeared novelty.
    pub disappeared: Vec<NoveltyShare>,
    /// Part of `d` that no novelty explains; contributions and this sum to `d`.
    pub unexplained: f64,
    /// Number of components with mass: reference, current.
    pub components: [usize; 2],
    /// Share of each view's surface that the other could see: reference, current.
    pub overlap: [f64; 2],
}

impl QuantifiedChange {
    /// Replaces the distance by that of Algorithm 1, which is taken between the whole mixtures. `contributions` and
    /// `components` are those of reference and current view.
    pub(super) fn replace_distance(
        &mut self,
        d: f64,
        contributions: [Vec<f64>; 2],
        components: [usize; 2],
    ) {
        let [disappeared, appeared] = contributions;
        self.unexplained = d - disappeared.iter().chain(&appeared).sum::<f64>();
        for (shares, contributions) in [
            (&mut self.disappeared, disappeared),
            (&mut self.appeared, appeared),
        ] {
            for (share, contribution) in shares.iter_mut().zip(contributions) {
                share.contribution = contribution;
            }
        }
        self.d = d;
        self.work_m3 = d * self.surface_m2;
        self.components = components;
    }
}
