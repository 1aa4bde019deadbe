//! A view made ready to be compared: its rays indexed, its surfaces and its noise known.

use super::{EvidenceSettings, NoveltyError, noise};
use crate::geometry::{Fan, NoiseLaw, Rays, Surfaces, View};

/// Fewest points with which a view says anything.
const FEWEST_POINTS: usize = 20;

/// A view with everything that is asked of it.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The view itself.
    pub view: View,
    /// Where it looked.
    pub rays: Rays,
    /// The surfaces it saw.
    pub surfaces: Surfaces,
    /// How noisy its ranges are: stated by the sensor, or read off its flat places.
    pub noise: NoiseLaw,
    /// Median of its ranges, metres.
    pub middle_range_m: f64,
}

impl Prepared {
    /// Indexes `view`; `which` names it in errors.
    ///
    /// # Errors
    /// Fewer than 20 points, or a coordinate that is not finite.
    pub fn of(
        view: &View,
        which: &'static str,
        settings: &EvidenceSettings,
    ) -> Result<Self, NoveltyError> {
        let got = view.points.len();
        if got < FEWEST_POINTS {
            return Err(NoveltyError::TooFewPoints {
                which,
                got,
                expected: FEWEST_POINTS,
            });
        }
        let finite = |v: &[f64]| v.iter().all(|c| c.is_finite());
        if let Some(at) = view
            .points
            .iter()
            .position(|p| !finite(p.coords.as_slice()))
        {
            return Err(NoveltyError::NotFinite { which, at });
        }
        let fan = Fan::of(view);
        let (spacing_rad, scatter) = (fan.spacing_rad, fan.scatter);
        let middle_range_m = fan.middle_range_m;
        // Neither finer than rows nor cut across by the noise of a wall.
        let cell_m = (0.5 * spacing_rad * middle_range_m)
            .max(settings.cell_sigmas * scatter * middle_range_m)
            .clamp(settings.least_cell_m, settings.most_cell_m);
        let (rays, surfaces) = rayon::join(
            || Rays::of(fan),
            || Surfaces::of(&view.points, &view.origin, spacing_rad, scatter, cell_m),
        );
        let floor = settings.least_noise;
        let found = view
            .noise
            .or_else(|| noise::estimate(&view.points, &view.origin, &surfaces))
            .unwrap_or(floor);
        let noise = NoiseLaw {
            at_zero_m: found.at_zero_m.max(floor.at_zero_m),
            per_m: found.per_m.max(floor.per_m),
        };
        Ok(Self {
            view: view.clone(),
            rays,
            surfaces,
            noise,
            middle_range_m,
        })
    }
}
