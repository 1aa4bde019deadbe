//! What other thresholds U_th would have done to the past. A visit alarms where its distance reaches U_th and something is listed
//! (paper Eq. 7); an alarm is gone where none of its visits would have alarmed.

use super::answer::AlarmAnswer;
use super::constants::MAX_EXAMPLES;
use super::log_histogram::LogHistogram;
use serde::Serialize;

/// What became of a distance in the past.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PastCase {
    /// A quiet visit; whether it listed a thing, so that a lower threshold makes it an alarm.
    Quiet {
        /// Whether a thing was listed.
        listed: bool,
    },
    /// A changed visit.
    Changed,
    /// An alarm, with the greatest distance of its visits, and what a guard said about it.
    Alarm(Option<AlarmAnswer>),
}

/// A distance of the past.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PastDistance {
    /// Number of the visit, or of the alarm.
    pub id: i64,
    /// d_GMM, in the unit of its ground distance.
    pub d_gmm: f64,
    /// What became of it.
    pub case: PastCase,
}

/// Alarms, some of them with a guard's answer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct AlarmCounts {
    /// All of them.
    pub all: u64,
    /// Something had changed.
    pub confirmed: u64,
    /// Nothing had changed.
    pub false_alarms: u64,
}

/// What one threshold would have done.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThresholdEffect {
    /// The threshold, in the unit of the distances.
    pub u_th: f64,
    /// Alarms that would have been raised all the same.
    pub kept: AlarmCounts,
    /// Alarms that would not have been raised.
    pub gone: AlarmCounts,
    /// Quiet visits that would have been changed.
    pub alarming: u64,
    /// Quiet visits that would have been not observed: an unexplained difference.
    pub unexplained: u64,
    /// The newest alarms that would be gone, newest last.
    pub gone_ids: Vec<i64>,
    /// The newest quiet visits that would have been changed, newest last.
    pub alarming_ids: Vec<i64>,
}

/// Counts the past under several thresholds, in fixed memory.
#[derive(Debug, Clone, PartialEq)]
pub struct ThresholdStudy {
    effects: Vec<ThresholdEffect>,
    quiet: LogHistogram,
    changed: LogHistogram,
    /// Of quiet visits, and of alarms that a guard called false.
    unchanged: LogHistogram,
    alarms: AlarmCounts,
}

impl ThresholdStudy {
    /// Under these thresholds.
    pub fn new(thresholds: impl IntoIterator<Item = f64>) -> Self {
        let mut thresholds: Vec<f64> = thresholds.into_iter().collect();
        thresholds.sort_by(f64::total_cmp);
        thresholds.dedup();
        let effect = |u_th| ThresholdEffect {
            u_th,
            kept: AlarmCounts::default(),
            gone: AlarmCounts::default(),
            alarming: 0,
            unexplained: 0,
            gone_ids: Vec::new(),
            alarming_ids: Vec::new(),
        };
        Self {
            effects: thresholds.into_iter().map(effect).collect(),
            quiet: LogHistogram::default(),
            changed: LogHistogram::default(),
            unchanged: LogHistogram::default(),
            alarms: AlarmCounts::default(),
        }
    }

    /// Counts one distance; in the order of the log.
    pub fn add(&mut self, past: &PastDistance) {
        match past.case {
            PastCase::Quiet { .. } => {
                self.quiet.add(past.d_gmm);
                self.unchanged.add(past.d_gmm);
            }
            PastCase::Changed => self.changed.add(past.d_gmm),
            PastCase::Alarm(answer) => {
                self.alarms.add(answer);
                if answer == Some(AlarmAnswer::FalseAlarm) {
                    self.unchanged.add(past.d_gmm);
                }
            }
        }
        for effect in &mut self.effects {
            effect.add(past);
        }
    }

    /// What each threshold would have done, in ascending order.
    pub fn effects(&self) -> &[ThresholdEffect] {
        &self.effects
    }

    /// Distances of quiet visits.
    pub fn quiet(&self) -> &LogHistogram {
        &self.quiet
    }

    /// Distances of changed visits.
    pub fn changed(&self) -> &LogHistogram {
        &self.changed
    }

    /// All alarms.
    pub fn alarms(&self) -> AlarmCounts {
        self.alarms
    }

    /// The least threshold that visits to an unchanged place reach at most with this rate; `None` where there was none.
    pub fn threshold_for(&self, false_alarm_rate: f64) -> Option<f64> {
        self.unchanged.edge_exceeded_by(false_alarm_rate)
    }
}

impl ThresholdEffect {
    fn add(&mut self, past: &PastDistance) {
        let reaches = past.d_gmm >= self.u_th;
        match past.case {
            PastCase::Quiet { listed: true } if reaches => {
                self.alarming += 1;
                keep_newest(&mut self.alarming_ids, past.id);
            }
            PastCase::Quiet { listed: false } if reaches => self.unexplained += 1,
            PastCase::Quiet { .. } | PastCase::Changed => {}
            PastCase::Alarm(answer) if reaches => self.kept.add(answer),
            PastCase::Alarm(answer) => {
                self.gone.add(answer);
                keep_newest(&mut self.gone_ids, past.id);
            }
        }
    }

    /// Whether no alarm of the past would have been raised, where there was one.
    pub fn never_alarms(&self) -> bool {
        self.kept.all == 0 && self.gone.all > 0
    }
}

impl AlarmCounts {
    fn add(&mut self, answer: Option<AlarmAnswer>) {
        self.all += 1;
        match answer {
            Some(AlarmAnswer::Confirmed) => self.confirmed += 1,
            Some(AlarmAnswer::FalseAlarm) => self.false_alarms += 1,
            None => {}
        }
    }
}

fn keep_newest(ids: &mut Vec<i64>, id: i64) {
    if ids.len() == MAX_EXAMPLES {
        ids.remove(0);
    }
    ids.push(id);
}

#[cfg(test)]
mod tests {
    use super::{AlarmAnswer, AlarmCounts, MAX_EXAMPLES, PastCase, PastDistance, ThresholdStudy};
    use proptest::prelude::*;

    fn past() -> impl Strategy<Value = Vec<PastDistance>> {
        let case = prop_oneof![
            any::<bool>().prop_map(|listed| PastCase::Quiet { listed }),
            Just(PastCase::Changed),
            Just(PastCase::Alarm(None)),
            Just(PastCase::Alarm(Some(AlarmAnswer::Confirmed))),
            Just(PastCase::Alarm(Some(AlarmAnswer::FalseAlarm))),
        ];
        let one = (case, prop_oneof![Just(0.0), 1e-6..1.0f64]);
        prop::collection::vec(one, 0..80).prop_map(|all| {
            let numbered = (1..).zip(all);
            numbered
                .map(|(id, (case, d_gmm))| PastDistance { id, d_gmm, case })
                .collect()
        })
    }

    fn study(past: &[PastDistance], thresholds: &[f64]) -> ThresholdStudy {
        let mut study = ThresholdStudy::new(thresholds.iter().copied());
        past.iter().for_each(|one| study.add(one));
        study
    }

    const SOME: [f64; 5] = [0.0, 1e-4, 0.02, 0.5, 2.0];

    proptest! {
        #[test]
        fn a_higher_threshold_alarms_less(past in past()) {
            for pair in study(&past, &SOME).effects().windows(2) {
                prop_assert!(pair[0].gone.all <= pair[1].gone.all);
                prop_assert!(pair[0].gone.confirmed <= pair[1].gone.confirmed);
                prop_assert!(pair[0].alarming >= pair[1].alarming);
                prop_assert!(pair[0].unexplained >= pair[1].unexplained);
            }
        }

        #[test]
        fn every_alarm_is_kept_or_gone_and_the_extremes_keep_all_or_none(past in past()) {
            let study = study(&past, &SOME);
            let alarms = past.iter().filter(|p| matches!(p.case, PastCase::Alarm(_))).count() as u64;
            let listed = past.iter().filter(|p| p.case == PastCase::Quiet { listed: true }).count();
            prop_assert_eq!(study.alarms().all, alarms);
            for effect in study.effects() {
                let sum = |of: fn(&AlarmCounts) -> u64| of(&effect.kept) + of(&effect.gone);
                prop_assert_eq!(sum(|c| c.all), alarms);
                prop_assert_eq!(sum(|c| c.confirmed), study.alarms().confirmed);
                prop_assert_eq!(sum(|c| c.false_alarms), study.alarms().false_alarms);
            }
            let (first, last) = (&study.effects()[0], &study.effects()[4]);
            prop_assert_eq!((first.gone.all, first.alarming), (0, listed as u64));
            prop_assert_eq!((last.kept.all, last.alarming), (0, 0));
            prop_assert_eq!(last.never_alarms(), alarms > 0);
            prop_assert!(!first.never_alarms());
        }

        /// The examples are the newest of what is counted, whatever came before.
        #[test]
        fn examples_are_the_newest(past in past()) {
            for effect in study(&past, &SOME).effects() {
                let gone: Vec<i64> = past.iter()
                    .filter(|p| matches!(p.case, PastCase::Alarm(_)) && p.d_gmm < effect.u_th)
                    .map(|p| p.id).collect();
                let newest = &gone[gone.len().saturating_sub(MAX_EXAMPLES)..];
                prop_assert_eq!(&effect.gone_ids[..], newest);
                prop_assert!(effect.alarming_ids.len() as u64 <= effect.alarming);
            }
        }

        #[test]
        fn the_threshold_of_a_rate_is_reached_by_at_most_that_share_of_unchanged_visits(
            past in past(), rate in 0.0..0.5f64,
        ) {
            let study = study(&past, &[]);
            let unchanged: Vec<f64> = past.iter().filter(|p| matches!(p.case,
                PastCase::Quiet { .. } | PastCase::Alarm(Some(AlarmAnswer::FalseAlarm))))
                .map(|p| p.d_gmm).collect();
            let Some(u_th) = study.threshold_for(rate) else {
                prop_assert!(unchanged.is_empty());
                return Ok(());
            };
            let reached = unchanged.iter().filter(|d| **d >= u_th).count();
            prop_assert!(reached as f64 <= rate * (unchanged.len() + 1) as f64);
        }
    }

    #[test]
    fn a_known_past() {
        let quiet = |id, d_gmm, listed| PastDistance {
            id,
            d_gmm,
            case: PastCase::Quiet { listed },
        };
        let alarm = |id, d_gmm, answer| PastDistance {
            id,
            d_gmm,
            case: PastCase::Alarm(answer),
        };
        let past = [
            quiet(1, 0.0, false),
            quiet(2, 3e-4, true),
            quiet(3, 2e-4, false),
            alarm(1, 6e-4, Some(AlarmAnswer::FalseAlarm)),
            alarm(2, 0.004, Some(AlarmAnswer::Confirmed)),
            alarm(3, 0.001, None),
        ];
        let study = study(&past, &[1e-4, 3e-4, 0.001, 0.002]);
        let counts: Vec<_> = study
            .effects()
            .iter()
            .map(|e| {
                (
                    e.gone.all,
                    e.gone.confirmed,
                    e.gone.false_alarms,
                    e.alarming,
                    e.unexplained,
                )
            })
            .collect();
        assert_eq!(
            counts,
            [
                (0, 0, 0, 1, 1),
                (0, 0, 0, 1, 0),
                (1, 0, 1, 0, 0),
                (2, 0, 1, 0, 0)
            ]
        );
        assert_eq!(study.effects()[3].gone_ids, [1, 3]);
        assert_eq!(study.effects()[0].alarming_ids, [2]);
    }
}
