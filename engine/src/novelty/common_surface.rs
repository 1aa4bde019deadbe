//! The surface that both views could see, cell by cell, and how the reference's components share it.

use super::quantify::Side;
use super::{NoveltyError, Sight};
use crate::mixture::{EmSettings, Mixture, RefitSettings, Unexplained, refit};
use nalgebra::Point3;

/// Places and how much surface each stands for, square metres.
pub type Surface = (Vec<Point3<f64>>, Vec<f64>);

/// The surface of one view that the other could see, cell by cell.
pub struct Share {
    /// Cells that both views saw, and their surface, square metres.
    places: Vec<Point3<f64>>,
    weights: Vec<f64>,
    /// Cells that the other view did not surely see, and their surface.
    pub unsure: Surface,
    /// Cells with points that the other view looked through and that are no novelty, and their surface.
    pub deviating: Surface,
    /// Surface that is no novelty, square metres.
    pub background: f64,
    /// Surface of each novelty, square metres.
    pub novelties: Vec<f64>,
    /// Number of equal samples that the background's weights are worth.
    pub samples: f64,
    /// Share of the view's surface that the other could see.
    pub overlap: f64,
}

impl Share {
    /// Adds up what `side` saw.
    pub fn of(side: &Side<'_>) -> Self {
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

    /// Background and novelties, square metres.
    pub fn total(&self) -> f64 {
        self.background + self.novelties.iter().sum::<f64>()
    }

    /// Weights of the reference's components for what is no novelty.
    pub fn background_weights(&self, mixture: &Mixture) -> Result<Vec<f64>, NoveltyError> {
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

/// For each component, the weight of a doubtful surface of both views.
pub fn doubtful_weights(
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
