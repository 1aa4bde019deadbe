//! Rates over many simulated looks.

use super::scenes::{look, thing};
use super::{Class, ShapeSettings, retrieve};
use crate::geometry::NoiseLaw;
use crate::mixture::Mixture;
use nalgebra::Point3;

struct Rates {
    right: f64,
    wrong: f64,
    ambiguous: f64,
    size_sd_cm: f64,
    z_rms: f64,
}

fn rates(class: usize, points: usize, sigma_m: f64, settings: &ShapeSettings) -> Rates {
    let sensor = Point3::origin();
    let settings = ShapeSettings {
        noise: NoiseLaw {
            at_zero_m: sigma_m,
            per_m: 0.0,
        },
        ..settings.clone()
    };
    let (mut right, mut wrong, mut squares, mut z, mut numbers) = (0, 0, 0.0, 0.0, 0);
    for seed in 0..100 {
        let (truth, mut rng) = thing(class, seed);
        let wanted = points + (seed as usize * points / 100);
        // Grids do not give an exact number: look closer until there are enough points.
        let mut closer = 0;
        let seen = loop {
            let seen = look(&truth, &sensor, wanted + closer, sigma_m, &mut rng);
            if seen.len() >= points {
                break seen;
            }
            closer += 2;
        };
        let answer = retrieve(&seen, &Mixture::default(), &sensor, &settings, seed)
            .unwrap_or_else(|e| panic!("{e} {truth:?} {}", seen.len()))
            .best;
        if answer.class == truth.class() {
            right += 1;
            for k in 0..3 {
                let error = answer.size_m[k] - truth.size_m()[k];
                squares += error * error;
                if answer.size_sd_m[k] > 0.0 {
                    z += (error / answer.size_sd_m[k]).powi(2);
                }
                numbers += usize::from(truth.size_m()[k] > 0.0);
            }
        } else if answer.class != Class::Ambiguous {
            wrong += 1;
        }
    }
    Rates {
        right: f64::from(right) / 100.0,
        wrong: f64::from(wrong) / 100.0,
        ambiguous: f64::from(100 - right - wrong) / 100.0,
        size_sd_cm: 100.0 * (squares / f64::from(numbers as u32).max(1.0)).sqrt(),
        z_rms: (z / f64::from(numbers as u32).max(1.0)).sqrt(),
    }
}

#[test]
fn classes_are_told_at_the_papers_noise_and_at_the_sensors() {
    let names = ["sphere", "cylinder", "plane"];
    for (points, sigma_m) in [(60, 0.032), (15, 0.032), (60, 0.005), (15, 0.005)] {
        for (class, name) in names.iter().enumerate() {
            let r = rates(class, points, sigma_m, &ShapeSettings::default());
            eprintln!(
                "{points}-{} points, sigma {sigma_m} m, {name}: right {:.2} wrong {:.2} ambiguous {:.2} size sd {:.2} cm (z {:.2})",
                2 * points,
                r.right,
                r.wrong,
                r.ambiguous,
                r.size_sd_cm,
                r.z_rms
            );
        }
    }
}
