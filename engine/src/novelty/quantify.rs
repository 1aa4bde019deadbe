//! How much changed: d_GMM between what both views could see (Eq. 6), and each novelty's part of it.
//!
//! The revisit is told in the reference's components, whose shapes are frozen, and in components of
//! its own for what appeared; the reference likewise for what disappeared. Weights that differ by no
//! more than sampling explains count as equal. Mass is visible surface: thinning cells, not points,
//! so that it does not depend on how beams crowd.

use super::common_surface::{Share, doubtful_weights};
use super::ledger::Ledger;
use super::sampling::explained_by_sampling;
use super::{NoveltyError, Prepared, QuantifySettings, Sight};
use crate::geometry::Passage;
use crate::mixture::{Mixture, SplitSettings, split_until_flat};
use nalgebra::{Matrix3, Point3};

/// What one view brings into the balance.
pub struct Side<'a> {
    /// The view.
    pub own: &'a Prepared,
    /// Maps it into the reference's frame.
    pub reference_from_own: Passage,
    /// What the other view says about each of its points.
    pub sights: &'a [Sight],
    /// Points of each of its novelties, one list each.
    pub novelties: &'a [Vec<usize>],
}

/// The distance and whose it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// d_GMM, in the unit of the ground distance.
    pub d: f64,
    /// d_GMM times the visible surface, m^2 m (for a ground distance in metres).
    pub work_m3: f64,
    /// Surface that both could see, with what came and went, square metres.
    pub surface_m2: f64,
    /// Mass and contribution of each appeared novelty.
    pub appeared: Vec<(f64, f64)>,
    /// Mass and contribution of each disappeared novelty.
    pub disappeared: Vec<(f64, f64)>,
    /// What no novelty explains; contributions and this sum to `d`.
    pub rest: f64,
    /// Components of the reference and of the revisit that carry mass.
    pub components: [usize; 2],
    /// Share of each view's surface that the other could see: reference, current.
    pub overlap: [f64; 2],
}

impl Balance {
    /// Puts d_GMM as Algorithm 1 took it, of the whole mixtures, in the place of the distance between
    /// what both could see. `contributions` and `components` are those of reference and revisit.
    pub fn restate(&mut self, d: f64, contributions: [Vec<f64>; 2], components: [usize; 2]) {
        let [went, came] = contributions;
        self.rest = d - went.iter().chain(&came).sum::<f64>();
        for (list, parts) in [(&mut self.disappeared, went), (&mut self.appeared, came)] {
            for (entry, part) in list.iter_mut().zip(parts) {
                entry.1 = part;
            }
        }
        self.d = d;
        self.work_m3 = d * self.surface_m2;
        self.components = components;
    }
}

/// Weighs the two views against each other. `mixture` is the reference's, in its frame.
///
/// # Errors
/// Mixtures that cannot be fitted or compared.
pub fn quantify(
    mixture: &Mixture,
    reference: &Side<'_>,
    current: &Side<'_>,
    settings: &QuantifySettings,
) -> Result<Balance, NoveltyError> {
    let (then, now) = rayon::join(|| Share::of(reference), || Share::of(current));
    let sides = [then, now];
    let mut balance = Balance {
        d: 0.0,
        work_m3: 0.0,
        surface_m2: sides[0].total().max(sides[1].total()),
        appeared: vec![(0.0, 0.0); current.novelties.len()],
        disappeared: vec![(0.0, 0.0); reference.novelties.len()],
        rest: 0.0,
        components: [0; 2],
        overlap: [sides[0].overlap, sides[1].overlap],
    };
    if sides.iter().any(|s| s.background <= 0.0) {
        return Ok(balance);
    }
    let wide = widened(mixture, reference.own, current.own);
    let ((then, now), (unsure, deviating)) = rayon::join(
        || {
            rayon::join(
                || sides[0].background_weights(&wide),
                || sides[1].background_weights(&wide),
            )
        },
        || {
            rayon::join(
                || doubtful_weights(&wide, &sides, |s| &s.unsure),
                || doubtful_weights(&wide, &sides, |s| &s.deviating),
            )
        },
    );
    let (weights, unsure, deviating) = ([then?, now?], unsure?, deviating?);
    let [then, now] = explained_by_sampling(
        weights,
        &unsure,
        &deviating,
        [sides[0].samples, sides[1].samples],
        settings,
    );
    let mut ledger = Ledger::default();
    for (k, g) in mixture.components.iter().enumerate() {
        let masses = [
            then[k] * sides[0].background / sides[0].total(),
            now[k] * sides[1].background / sides[1].total(),
        ];
        for (count, mass) in balance.components.iter_mut().zip(masses) {
            *count += usize::from(mass > 0.0);
        }
        ledger.enter(*g, masses, None);
    }
    for (side, view) in [reference, current].into_iter().enumerate() {
        for (index, points) in view.novelties.iter().enumerate() {
            let mass = sides[side].novelties[index] / sides[side].total();
            let own = novelty_mixture(view, points)?;
            for (g, w) in own.components.iter().zip(&own.weights) {
                let mut masses = [0.0; 2];
                masses[side] = mass * w;
                balance.components[side] += 1;
                ledger.enter(*g, masses, Some((side, index)));
            }
            let told = if side == 0 {
                &mut balance.disappeared
            } else {
                &mut balance.appeared
            };
            told[index].0 = mass;
        }
    }
    ledger.settle(settings.ground, &mut balance)?;
    balance.work_m3 = balance.d * balance.surface_m2;
    Ok(balance)
}

/// The Gaussians of one novelty, in the reference's frame.
fn novelty_mixture(side: &Side<'_>, points: &[usize]) -> Result<Mixture, NoveltyError> {
    let places: Vec<Point3<f64>> = points
        .iter()
        .map(|i| side.reference_from_own.carry(&side.own.view.points[*i]))
        .collect();
    Ok(split_until_flat(&places, None, &split_settings(side.own))?)
}

/// How finely a view's surfaces are modelled.
pub fn split_settings(own: &Prepared) -> SplitSettings {
    let middle_m = own.middle_range_m;
    SplitSettings::for_data(
        own.noise.sigma_m(middle_m),
        (own.rays.spacing_rad * middle_m).max(own.surfaces.cell_m),
    )
}

/// The mixture as a view with all the noise of both would see it. Against shapes thinner than its noise
/// a revisit's points would go to whichever neighbour is thick enough.
fn widened(mixture: &Mixture, reference: &Prepared, current: &Prepared) -> Mixture {
    let mut wide = mixture.clone();
    for g in &mut wide.components {
        let range_m = (g.mean - reference.view.origin).norm();
        let sigma_m = reference
            .noise
            .sigma_m(range_m)
            .hypot(current.noise.sigma_m(range_m));
        g.covariance += Matrix3::identity() * sigma_m.powi(2);
    }
    wide
}
