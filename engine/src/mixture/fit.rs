//! The front door: one cloud in, its mixture out.

use super::constants::RESTARTS;
use super::split::{SplitSettings, split_until_flat};
use super::{EmSettings, Fit, Mixture, MixtureError, Start, em, mml, order, seed};
use nalgebra::Point3;

/// How many components, and where they start.
#[derive(Debug, Clone, PartialEq)]
pub enum Components {
    /// So many, from k-means++.
    Fixed(usize),
    /// As many as the Bayesian information criterion wants, up to `max`, each from k-means++.
    Bic {
        /// Most components tried.
        max: usize,
    },
    /// As many as the shortest message that tells the points needs (minimum message length), up to `max`,
    /// from k-means++ with `max`.
    Mml {
        /// Most components tried.
        max: usize,
    },
    /// Those of a given mixture, from where they stand.
    Start(Mixture),
    /// As many as it takes until all are flat; no seed.
    Flat(SplitSettings),
}

/// What to fit and how.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSettings {
    /// How many components, and where they start.
    pub components: Components,
    /// Seed of k-means++.
    pub seed: u64,
    /// Starts drawn for k-means++, each anew; the fit of the best likelihood wins. At least one is made.
    pub restarts: usize,
    /// How EM runs.
    pub em: EmSettings,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            components: Components::Flat(SplitSettings::default()),
            seed: 0,
            restarts: RESTARTS,
            em: EmSettings::default(),
        }
    }
}

/// Fits a mixture to `points` (metres), each counting as `weights` says (1 if absent).
///
/// # Errors
/// As [`em::run`], and more components asked for than there are distinct points.
pub fn fit(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    settings: &FitSettings,
) -> Result<Fit, MixtureError> {
    match &settings.components {
        Components::Fixed(k) => best_of_restarts(points, weights, *k, settings),
        Components::Bic { max } => order::least_bic(*max, points.len() as f64, |k| {
            best_of_restarts(points, weights, k, settings)
        }),
        Components::Mml { max } => best(settings.restarts, |restart| {
            let start = most_components(points, weights, *max, settings.seed, restart)?;
            let (fit, length) = mml::shortest(points, weights, start, &settings.em)?;
            let start = Start::KMeans { restart };
            Ok((Fit { start, ..fit }, -length))
        }),
        Components::Start(start) => em::run(points, weights, start.clone(), &settings.em),
        Components::Flat(split) => {
            let start = split_until_flat(points, weights, split)?;
            let fit = em::run(points, weights, start, &settings.em)?;
            Ok(Fit {
                start: Start::Flat,
                ..fit
            })
        }
    }
}

/// k-means++ with `max` components, or as many as there are distinct points.
fn most_components(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    max: usize,
    seed: u64,
    restart: u64,
) -> Result<Mixture, MixtureError> {
    let start = |k| seed::k_means_start(points, weights, k, seed, restart);
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
) -> Result<Fit, MixtureError> {
    best(settings.restarts, |restart| {
        let start = seed::k_means_start(points, weights, components, settings.seed, restart)?;
        let fit = em::run(points, weights, start, &settings.em)?;
        let merit = fit.mean_log_likelihood;
        let start = Start::KMeans { restart };
        Ok((Fit { start, ..fit }, merit))
    })
}

/// The fit of the greatest merit, the first on ties; tells of how many runs it is the best.
fn best(
    restarts: usize,
    mut one: impl FnMut(u64) -> Result<(Fit, f64), MixtureError>,
) -> Result<Fit, MixtureError> {
    let (mut best, mut most) = one(0)?;
    let mut runs = best.runs;
    for restart in 1..restarts as u64 {
        let (next, merit) = one(restart)?;
        runs += next.runs;
        if merit > most {
            (best, most) = (next, merit);
        }
    }
    Ok(Fit { runs, ..best })
}

#[cfg(test)]
mod tests {
    use super::{Components, FitSettings, fit};
    use crate::mixture::{EmSettings, MixtureError, Start};
    use nalgebra::{Point3, Vector3};
    use rand::{RngExt, SeedableRng};

    fn heaps(centres: &[Point3<f64>], each: usize) -> Vec<Point3<f64>> {
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

    fn three() -> Vec<Point3<f64>> {
        heaps(
            &[
                Point3::origin(),
                Point3::new(12.0, 0.0, 0.0),
                Point3::new(0.0, 12.0, 3.0),
            ],
            300,
        )
    }

    #[test]
    fn bic_finds_the_number_of_heaps() {
        let settings = FitSettings {
            components: Components::Bic { max: 6 },
            restarts: 3,
            em: EmSettings {
                iterations: 200,
                tolerance: 1e-6,
                ..EmSettings::default()
            },
            ..FitSettings::default()
        };
        assert_eq!(
            fit(&three(), None, &settings).expect("fits").mixture.len(),
            3
        );
        let few = [Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
        assert!(fit(&few, None, &settings).expect("fits").mixture.len() <= 2);
    }

    #[test]
    fn the_shortest_message_finds_the_number_of_heaps() {
        let settings = FitSettings {
            components: Components::Mml { max: 12 },
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
            let found = fit(&three(), None, &settings).expect("fits");
            assert_eq!(found.mixture.len(), 3);
            assert_eq!(found.start, Start::KMeans { restart: 0 });
            assert!(found.runs >= 3 && found.collapsed.is_empty());
            let heavier = vec![2.5; 900];
            let same = fit(&three(), Some(&heavier), &settings).expect("fits");
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
    fn more_restarts_are_never_worse_and_a_seed_repeats() {
        let points = three();
        let with = |restarts, seed| {
            let settings = FitSettings {
                components: Components::Fixed(5),
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
        let points = three();
        let flat = fit(&points, None, &FitSettings::default()).expect("fits");
        let again = FitSettings {
            components: Components::Start(flat.mixture.clone()),
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
                components: Components::Fixed(3),
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
