//! Fits a mixture to a cloud: the entry point of this module.

use super::constants::DEFAULT_RESTARTS;
use super::split::{SplitSettings, split_until_flat};
use super::{EmFit, EmSettings, FitStart, Mixture, MixtureError, bic, em, kmeans, mml};
use nalgebra::Point3;

/// Number of components, and their start.
#[derive(Debug, Clone, PartialEq)]
pub enum ComponentSelection {
    /// This many, from k-means++.
    Fixed(usize),
    /// By the Bayesian information criterion, up to `max`, each number from k-means++.
    Bic {
        /// Most components tried.
        max: usize,
    },
    /// By minimum message length, from k-means++ with `max` components down.
    Mml {
        /// Most components tried.
        max: usize,
    },
    /// Those of a given mixture, which is the start.
    Start(Mixture),
    /// Split until all are flat; without a seed.
    Flat(SplitSettings),
}

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSettings {
    /// Number of components, and their start.
    pub components: ComponentSelection,
    /// Seed of k-means++.
    pub seed: u64,
    /// Number of k-means++ starts, at least one is made; the fit of the best likelihood wins.
    pub restarts: usize,
    /// Settings of EM.
    pub em: EmSettings,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            components: ComponentSelection::Flat(SplitSettings::default()),
            seed: 0,
            restarts: DEFAULT_RESTARTS,
            em: EmSettings::default(),
        }
    }
}

/// Fits a mixture to `points` (metres) with `weights` (1 if absent).
///
/// # Errors
/// As [`em::run`], and more components than distinct points.
pub fn fit(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    settings: &FitSettings,
) -> Result<EmFit, MixtureError> {
    match &settings.components {
        ComponentSelection::Fixed(k) => best_of_restarts(points, weights, *k, settings),
        ComponentSelection::Bic { max } => bic::least_bic(*max, points.len() as f64, |k| {
            best_of_restarts(points, weights, k, settings)
        }),
        ComponentSelection::Mml { max } => best(settings.restarts, |restart| {
            let start = start_of_at_most(points, weights, *max, settings.seed, restart)?;
            let (fit, length) = mml::fit_least_length(points, weights, start, &settings.em)?;
            let start = FitStart::KMeans { restart };
            Ok((EmFit { start, ..fit }, -length))
        }),
        ComponentSelection::Start(start) => em::run(points, weights, start.clone(), &settings.em),
        ComponentSelection::Flat(split) => {
            let start = split_until_flat(points, weights, split)?;
            let fit = em::run(points, weights, start, &settings.em)?;
            Ok(EmFit {
                start: FitStart::Flat,
                ..fit
            })
        }
    }
}

/// k-means++ with `max` components, or as many as there are distinct points.
fn start_of_at_most(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    max: usize,
    seed: u64,
    restart: u64,
) -> Result<Mixture, MixtureError> {
    let start = |k| kmeans::k_means_start(points, weights, k, seed, restart);
    match start(max) {
        Err(MixtureError::TooFewPoints { distinct, .. }) if distinct > 0 => start(distinct),
        other => other,
    }
}

fn best_of_restarts(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    components: usize,
    settings: &FitSettings,
) -> Result<EmFit, MixtureError> {
    best(settings.restarts, |restart| {
        let start = kmeans::k_means_start(points, weights, components, settings.seed, restart)?;
        let fit = em::run(points, weights, start, &settings.em)?;
        let merit = fit.mean_log_likelihood;
        let start = FitStart::KMeans { restart };
        Ok((EmFit { start, ..fit }, merit))
    })
}

/// The fit of the greatest merit, the first on ties; `runs` becomes the sum over all restarts.
fn best(
    restarts: usize,
    mut one: impl FnMut(u64) -> Result<(EmFit, f64), MixtureError>,
) -> Result<EmFit, MixtureError> {
    let (mut best, mut most) = one(0)?;
    let mut runs = best.runs;
    for restart in 1..restarts as u64 {
        let (next, merit) = one(restart)?;
        runs += next.runs;
        if merit > most {
            (best, most) = (next, merit);
        }
    }
    Ok(EmFit { runs, ..best })
}

#[cfg(test)]
mod tests {
    use super::{ComponentSelection, FitSettings, fit};
    use crate::mixture::{EmSettings, FitStart, MixtureError};
    use nalgebra::{Point3, Vector3};
    use rand::{RngExt, SeedableRng};

    fn clusters(centres: &[Point3<f64>], each: usize) -> Vec<Point3<f64>> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut noise = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let at = |&c: &Point3<f64>| {
            (0..each)
                .map(|_| c + Vector3::new(noise(), noise(), noise()))
                .collect::<Vec<_>>()
        };
        centres
            .iter()
            .flat_map({
                let mut at = at;
                move |c| at(c)
            })
            .collect()
    }

    fn three_clusters() -> Vec<Point3<f64>> {
        clusters(
            &[
                Point3::origin(),
                Point3::new(12.0, 0.0, 0.0),
                Point3::new(0.0, 12.0, 3.0),
            ],
            300,
        )
    }

    #[test]
    fn bic_finds_the_number_of_clusters() {
        let settings = FitSettings {
            components: ComponentSelection::Bic { max: 6 },
            restarts: 3,
            em: EmSettings {
                iterations: 200,
                tolerance: 1e-6,
                ..EmSettings::default()
            },
            ..FitSettings::default()
        };
        assert_eq!(
            fit(&three_clusters(), None, &settings)
                .expect("fits")
                .mixture
                .len(),
            3
        );
        let few = [Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
        assert!(fit(&few, None, &settings).expect("fits").mixture.len() <= 2);
    }

    #[test]
    fn message_length_finds_the_number_of_clusters() {
        let settings = FitSettings {
            components: ComponentSelection::Mml { max: 12 },
            em: EmSettings {
                iterations: 300,
                tolerance: 1e-6,
                ..EmSettings::default()
            },
            ..FitSettings::default()
        };
        for seed in 0..4 {
            let settings = FitSettings {
                seed,
                ..settings.clone()
            };
            let found = fit(&three_clusters(), None, &settings).expect("fits");
            assert_eq!(found.mixture.len(), 3);
            assert_eq!(found.start, FitStart::KMeans { restart: 0 });
            assert!(found.runs >= 3 && found.collapsed.is_empty());
            let equal_weights = vec![2.5; 900];
            let same = fit(&three_clusters(), Some(&equal_weights), &settings).expect("fits");
            assert!((same.mean_log_likelihood - found.mean_log_likelihood).abs() < 1e-9);
        }
        let p = Point3::new(1.0, 2.0, 3.0);
        for few in [vec![p], vec![p; 40], vec![p, p + Vector3::x()]] {
            let found = fit(&few, None, &settings).expect("defined");
            assert_eq!(found.mixture.len(), 1);
            assert!(found.mean_log_likelihood.is_finite());
        }
        assert_eq!(fit(&[], None, &settings), Err(MixtureError::NoPoints));
    }

    #[test]
    fn more_restarts_are_never_worse_and_a_seed_is_reproducible() {
        let points = three_clusters();
        let with = |restarts, seed| {
            let settings = FitSettings {
                components: ComponentSelection::Fixed(5),
                restarts,
                seed,
                ..FitSettings::default()
            };
            fit(&points, None, &settings).expect("fits")
        };
        assert!(with(6, 1).mean_log_likelihood >= with(1, 1).mean_log_likelihood);
        assert_eq!(with(2, 1), with(2, 1));
    }

    #[test]
    fn flat_parts_and_given_starts_need_no_seed() {
        let points = three_clusters();
        let flat = fit(&points, None, &FitSettings::default()).expect("fits");
        let again = FitSettings {
            components: ComponentSelection::Start(flat.mixture.clone()),
            em: EmSettings {
                iterations: 0,
                ..EmSettings::default()
            },
            ..FitSettings::default()
        };
        let same = fit(&points, None, &again).expect("fits");
        assert!((same.mean_log_likelihood - flat.mean_log_likelihood).abs() < 1e-9);
        let err = fit(
            &points[..2],
            None,
            &FitSettings {
                components: ComponentSelection::Fixed(3),
                ..FitSettings::default()
            },
        );
        assert_eq!(
            err,
            Err(MixtureError::TooFewPoints {
                components: 3,
                distinct: 2
            })
        );
    }
}
