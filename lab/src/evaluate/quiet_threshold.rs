//! U_th of a place from quiet visits to it.

use super::constants::QUIET_SHARE;
use super::pair::{PairError, SimulatedPair};
use super::run_engine::EngineInput;
use crate::constants::ENGINE_SEED;
use crate::statistics::quantile_of_next;
use patrold_engine::geometry::View;
use patrold_engine::novelty::{
    NoveltyError, NoveltySettings, Reference, RemovalExtent, Verdict, detect,
};

/// U_th of a place, and the visits that it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuietThreshold {
    /// The least d_GMM that is above the .95 quantile of quiet visits; unit of the ground distance. `None` if none of them
    /// was observed.
    pub u_th: Option<f64>,
    /// Visits of which there is no d_GMM because the place was not observed.
    pub unobserved: usize,
}

impl QuietThreshold {
    /// From the d_GMM of quiet visits, `None` of those not observed.
    fn new(distances: &[Option<f64>]) -> Self {
        let observed = distances.iter().flatten().copied();
        Self {
            // Equal to the quantile is no alarm: d_GMM of most quiet visits may be zero.
            u_th: quantile_of_next(observed, QUIET_SHARE).map(f64::next_up),
            unobserved: distances.iter().filter(|d| d.is_none()).count(),
        }
    }

    /// The settings with this U_th; as they are without.
    pub fn apply(&self, settings: NoveltySettings) -> NoveltySettings {
        match self.u_th {
            Some(u_th) => with_threshold(settings, u_th),
            None => settings,
        }
    }
}

fn with_threshold(settings: NoveltySettings, u_th: f64) -> NoveltySettings {
    NoveltySettings {
        u_th_m: u_th,
        u_th_fm: u_th,
        ..settings
    }
}

/// Quiet visits to the place of `pair`, from its reference's place and never one of its own sweeps.
///
/// # Errors
/// Never: the place was cast for the pair.
pub fn quiet_visits(pair: &SimulatedPair, visits: u32) -> Result<Vec<View>, PairError> {
    (0..visits).map(|visit| pair.quiet_visit(visit)).collect()
}

/// U_th of the place of `pair`: each of `visits` is compared with its reference, and no shape or truth is looked at.
///
/// # Errors
/// A sweep with too few points.
pub fn quiet_threshold(
    pair: &SimulatedPair,
    visits: &[View],
    input: EngineInput,
    settings: &NoveltySettings,
) -> Result<QuietThreshold, NoveltyError> {
    // Nothing is to be looked for.
    let settings = NoveltySettings {
        removal_extent: RemovalExtent::UntilBelowThreshold,
        ..with_threshold(settings.clone(), f64::MAX)
    };
    let reference = input.of_view(&pair.sweeps[0].view);
    let reference = Reference::prepare(&reference, &settings, ENGINE_SEED)?;
    let distance = |visit: &View| -> Result<Option<f64>, NoveltyError> {
        let view = input.of_view(visit);
        let found = detect(&reference, &view, &settings, ENGINE_SEED, &mut |_| {})?;
        Ok((found.verdict != Verdict::NotObserved).then_some(found.d_gmm))
    };
    let distances: Vec<Option<f64>> = visits.iter().map(distance).collect::<Result<_, _>>()?;
    Ok(QuietThreshold::new(&distances))
}

#[cfg(test)]
mod tests {
    use super::QuietThreshold;

    #[test]
    fn the_threshold_is_just_above_the_quantile_of_the_observed_visits() {
        let zeros = QuietThreshold::new(&[Some(0.0); 20]);
        assert!(
            zeros.u_th.is_some_and(|u| u > 0.0 && u < 1e-300),
            "{zeros:?}"
        );
        // Position .95 x 21 = 19.95 of 1 to 20.
        let mut distances: Vec<Option<f64>> = (1..=20).map(|d| Some(f64::from(d))).collect();
        distances.push(None);
        let ranks = QuietThreshold::new(&distances);
        assert!(ranks.u_th.is_some_and(|u| (u - 19.95).abs() < 1e-12));
        assert_eq!(ranks.unobserved, 1);
        let none = QuietThreshold::new(&[None]);
        assert_eq!((none.u_th, none.unobserved), (None, 1));
    }
}
