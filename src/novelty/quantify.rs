//! How much changed: d_GMM between what both views could see (Eq. 6), and each novelty's part of it.
//!
//! The revisit is told in the reference's components, whose shapes are frozen, and in components of
//! its own for what appeared; the reference likewise for what disappeared. Weights that differ by no
//! more than sampling explains count as equal. Mass is visible surface: thinning cells, not points,
//! so that it does not depend on how beams crowd.

use super::ledger::Ledger;
use super::{NoveltyError, Prepared, QuantifySettings, Sight};
use crate::geometry::Passage;
use crate::mixture::{
    EmSettings, Mixture, RefitSettings, SplitSettings, Unexplained, refit, split_until_flat,
};
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
pub fn novelty_mixture(side: &Side<'_>, points: &[usize]) -> Result<Mixture, NoveltyError> {
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

/// Places and how much surface each stands for, square metres.
type Surface = (Vec<Point3<f64>>, Vec<f64>);

/// The surface of one view that the other could see, cell by cell.
struct Share {
    places: Vec<Point3<f64>>,
    weights: Vec<f64>,
    /// Cells that the other view did not surely see, and their surface.
    unsure: Surface,
    /// Cells with points that the other view looked through and that are no novelty, and their surface.
    deviating: Surface,
    background: f64,
    novelties: Vec<f64>,
    /// Number of equal samples that the background's weights are worth.
    samples: f64,
    overlap: f64,
}

impl Share {
    fn of(side: &Side<'_>) -> Self {
        let surfaces = &side.own.surfaces;
        let mut seen = vec![0.0; surfaces.patches.len()];
        let mut through = vec![0.0; surfaces.patches.len()];
        // Points of each cell within the range that is looked at.
        let mut asked = vec![0.0; surfaces.patches.len()];
        for (cell, sight) in surfaces.patch_of_point.iter().zip(side.sights) {
            // Deviating points that are no novelty are noise: they weigh on neither side.
            if *sight == Sight::Same {
                seen[*cell as usize] += 1.0;
            }
            if *sight == Sight::Through {
                through[*cell as usize] += 1.0;
            }
            if *sight != Sight::Beyond {
                asked[*cell as usize] += 1.0;
            }
        }
        // Surface that one point of a cell stands for.
        let share = |cell: u32| {
            let patch = &surfaces.patches[cell as usize];
            patch.area_m2 / patch.count.max(1) as f64
        };
        let mut novelties = Vec::with_capacity(side.novelties.len());
        for points in side.novelties {
            let mut mass = 0.0;
            for i in points {
                let cell = surfaces.patch_of_point[*i];
                mass += share(cell);
                match side.sights[*i] {
                    Sight::Same => seen[cell as usize] -= 1.0,
                    Sight::Through => through[cell as usize] -= 1.0,
                    Sight::Unseen | Sight::Hidden | Sight::Beyond => {}
                }
            }
            novelties.push(mass);
        }
        let mut places = Vec::new();
        let mut weights = Vec::new();
        let (mut unsure, mut deviating) = (Surface::default(), Surface::default());
        for (cell, n) in seen.iter().enumerate() {
            let patch = &surfaces.patches[cell];
            let place = side.reference_from_own.carry(&patch.mean);
            if *n > 0.0 {
                places.push(place);
                weights.push(n * share(cell as u32));
            }
            if through[cell] > 0.0 {
                deviating.0.push(place);
                deviating.1.push(through[cell] * share(cell as u32));
            }
            if *n < asked[cell] {
                unsure.0.push(place);
                unsure
                    .1
                    .push((asked[cell] - n.max(0.0)) * share(cell as u32));
            }
        }
        let background: f64 = weights.iter().sum();
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        let known = background + novelties.iter().sum::<f64>();
        let all: f64 = asked
            .iter()
            .enumerate()
            .map(|(cell, n)| n * share(cell as u32))
            .sum();
        Self {
            samples: background * background / squares.max(f64::MIN_POSITIVE),
            places,
            weights,
            unsure,
            deviating,
            background,
            novelties,
            overlap: known / all.max(f64::MIN_POSITIVE),
        }
    }

    fn total(&self) -> f64 {
        self.background + self.novelties.iter().sum::<f64>()
    }

    /// Weights of the reference's components for what is no novelty.
    fn background_weights(&self, mixture: &Mixture) -> Result<Vec<f64>, NoveltyError> {
        let told = refit(
            mixture,
            &self.places,
            Some(&self.weights),
            Unexplained::Listed(&[]),
            &one_step(),
        )?;
        let mut weights = told.mixture.weights;
        weights.truncate(told.frozen);
        Ok(weights)
    }
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

/// One M step from the reference's weights: each place is shared out as the reference would. More
/// steps let overlapping components take weight from one another for no reason of the scene.
pub fn one_step() -> RefitSettings {
    RefitSettings {
        em: EmSettings {
            iterations: 1,
            tolerance: 0.0,
            ..RefitSettings::default().em
        },
        ..RefitSettings::default()
    }
}

/// For each component, the weight of a doubtful surface of both views.
fn doubtful_weights(
    mixture: &Mixture,
    sides: &[Share; 2],
    which: impl Fn(&Share) -> &Surface,
) -> Result<Vec<f64>, NoveltyError> {
    let places: Vec<Point3<f64>> = sides.iter().flat_map(|s| which(s).0.clone()).collect();
    if places.is_empty() {
        return Ok(vec![0.0; mixture.len()]);
    }
    // In shares of each side's own background, so that they compare with its weights.
    let weights: Vec<f64> = sides
        .iter()
        .flat_map(|s| which(s).1.iter().map(|w| w / s.background))
        .collect();
    let total: f64 = weights.iter().sum();
    let told = refit(
        mixture,
        &places,
        Some(&weights),
        Unexplained::Listed(&[]),
        &one_step(),
    )?;
    Ok(told.mixture.weights[..told.frozen]
        .iter()
        .map(|w| w * total)
        .collect())
}

/// Where two weights of a component differ by no more than two samples of one and the same weight
/// would, both take their common value. The scatter of samples is measured on the components
/// themselves (its median; neighbouring cells are not independent), so that no threshold of size enters. `unsure` is
/// surface that one view or the other did not surely see: visible weights may differ by that much. No difference is
/// larger than the surface of the component that deviates: all else was seen in its place by both views.
fn explained_by_sampling(
    weights: [Vec<f64>; 2],
    unsure: &[f64],
    deviating: &[f64],
    masses: [f64; 2],
    settings: &QuantifySettings,
) -> [Vec<f64>; 2] {
    let [mut then, mut now] = weights;
    let pooled: Vec<f64> = then
        .iter()
        .zip(&now)
        .map(|(a, b)| (a * masses[0] + b * masses[1]) / (masses[0] + masses[1]))
        .collect();
    let square: Vec<f64> = (0..then.len())
        .map(|k| {
            let variance = pooled[k] * (1.0 / masses[0] + 1.0 / masses[1]);
            // Less than one cell is no sample.
            if pooled[k] * masses[0].min(masses[1]) < 1.0 {
                0.0
            } else {
                let beyond = (then[k] - now[k]).abs() - unsure[k];
                beyond.max(0.0).powi(2) / variance
            }
        })
        .collect();
    let mut sorted: Vec<f64> = square.iter().copied().filter(|s| *s > 0.0).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    // The median of chi-squared with one degree of freedom is 0.455.
    let scatter = sorted
        .get(sorted.len() / 2)
        .map_or(1.0, |m| m / 0.455)
        .max(1.0);
    let limit = settings.weight_sigmas.powi(2) * scatter;
    let mut excess = [0.0; 2];
    let mut common = 0.0;
    for k in 0..pooled.len() {
        let difference = (then[k] - now[k]).abs();
        if square[k] > limit && deviating[k] < difference {
            let believed = deviating[k] / difference;
            then[k] = pooled[k] + believed * (then[k] - pooled[k]);
            now[k] = pooled[k] + believed * (now[k] - pooled[k]);
        }
        if square[k] <= limit {
            then[k] = pooled[k];
            now[k] = pooled[k];
            common += pooled[k];
        } else {
            excess[0] += then[k];
            excess[1] += now[k];
        }
    }
    for (side, weights) in [&mut then, &mut now].into_iter().enumerate() {
        let left = 1.0 - excess[side];
        for (weight, s) in weights.iter_mut().zip(&square) {
            if *s <= limit && common > 0.0 {
                *weight *= left / common;
            }
        }
    }
    [then, now]
}

#[cfg(test)]
mod tests {
    use super::{QuantifySettings, explained_by_sampling};
    use rand::SeedableRng;
    use rand_distr::{Binomial, Distribution};

    #[test]
    fn samples_of_one_mixture_count_as_equal_and_a_real_change_does_not() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let n = 20_000.0;
        let coin = Binomial::new(20_000, 0.01).expect("a share");
        let mut sample = || -> Vec<f64> {
            let counts: Vec<f64> = (0..100).map(|_| coin.sample(&mut rng) as f64).collect();
            let sum: f64 = counts.iter().sum();
            counts.iter().map(|c| c / sum).collect()
        };
        let (a, mut b) = (sample(), sample());
        let settings = QuantifySettings::default();
        let [then, now] = explained_by_sampling(
            [a.clone(), b.clone()],
            &[0.0; 100],
            &[1.0; 100],
            [n, n],
            &settings,
        );
        assert!(then.iter().zip(&now).all(|(t, n)| (t - n).abs() < 1e-15));
        b[7] *= 2.0;
        let sum: f64 = b.iter().sum();
        b.iter_mut().for_each(|w| *w /= sum);
        let [then, now] = explained_by_sampling(
            [a.clone(), b.clone()],
            &[0.0; 100],
            &[1.0; 100],
            [n, n],
            &settings,
        );
        assert!(now[7] > 1.8 * then[7]);
        assert!((now.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Nothing deviates: whatever it is, it is no change of the scene.
        let [then, now] =
            explained_by_sampling([a, b], &[0.0; 100], &[0.0; 100], [n, n], &settings);
        assert!(then.iter().zip(&now).all(|(t, n)| (t - n).abs() < 1e-6));
    }
}
