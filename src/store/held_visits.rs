//! Visits that the disk did not take, in memory until it does.

use super::connection::RecordTime;
use super::sweeps::SweepRecord;
use super::visits::NewVisit;
use patrold_engine::geometry::View;
use patrold_engine::novelty::{PlaceView, Verdict};
use patrold_engine::report::NoveltyRecord;
use std::collections::VecDeque;

/// Visits that are held at most: six rounds of 40 waypoints.
const MAX_HELD: usize = 240;
/// Bytes of their sweeps that are held at most; a sweep of the URG-04LX takes 1 to 4 MB.
const MAX_HELD_BYTES: usize = 128 << 20;

/// A [`NewVisit`] that owns what it has, with its time.
#[derive(Debug, Clone)]
pub(super) struct HeldVisit {
    pub(super) waypoint: String,
    pub(super) stamp: RecordTime,
    pub(super) verdict: Verdict,
    reference_id: Option<i64>,
    sweep: Option<HeldSweep>,
    reason: String,
    d_gmm: Option<f64>,
    u_th: f64,
    seed: u64,
    engine: String,
    report: String,
    novelties: Vec<NoveltyRecord>,
    places: Vec<(i64, PlaceView)>,
    same_place_m: f64,
}

#[derive(Debug, Clone)]
struct HeldSweep {
    view: Option<View>,
    raw: Option<Vec<u8>>,
    dialogue: Option<Vec<u8>>,
    quality: String,
}

impl HeldSweep {
    fn bytes(&self) -> usize {
        let view = self.view.as_ref();
        let points = view.map_or(0, |view| size_of_val(view.points.as_slice()));
        let bytes = self.raw.iter().chain(&self.dialogue).map(Vec::len);
        points + bytes.sum::<usize>()
    }
}

impl HeldVisit {
    /// As it was to be stored.
    pub(super) fn visit(&self) -> NewVisit<'_> {
        NewVisit {
            waypoint: &self.waypoint,
            reference_id: self.reference_id,
            sweep: self.sweep.as_ref().map(|sweep| SweepRecord {
                view: sweep.view.as_ref(),
                raw: sweep.raw.as_deref(),
                dialogue: sweep.dialogue.as_deref(),
                quality: &sweep.quality,
            }),
            verdict: self.verdict,
            reason: &self.reason,
            d_gmm: self.d_gmm,
            u_th: self.u_th,
            seed: self.seed,
            engine: &self.engine,
            report: &self.report,
            novelties: &self.novelties,
            places: &self.places,
            same_place_m: self.same_place_m,
        }
    }

    fn is_changed(&self) -> bool {
        self.verdict == Verdict::Changed
    }
}

/// Oldest first.
#[derive(Debug, Default)]
pub(super) struct HeldVisits {
    visits: VecDeque<HeldVisit>,
}

impl HeldVisits {
    /// Holds a visit; whether it is held. What is beyond the bounds is dropped: of what is no change the oldest, then of changes
    /// the newest, so that what began an alarm is kept longest.
    pub(super) fn push(&mut self, visit: &NewVisit<'_>, stamp: &RecordTime) -> bool {
        let sweep = visit.sweep.as_ref().map(|sweep| HeldSweep {
            view: sweep.view.cloned(),
            raw: sweep.raw.map(<[u8]>::to_vec),
            dialogue: sweep.dialogue.map(<[u8]>::to_vec),
            quality: sweep.quality.to_owned(),
        });
        self.visits.push_back(HeldVisit {
            waypoint: visit.waypoint.to_owned(),
            stamp: stamp.clone(),
            verdict: visit.verdict,
            reference_id: visit.reference_id,
            sweep,
            reason: visit.reason.to_owned(),
            d_gmm: visit.d_gmm,
            u_th: visit.u_th,
            seed: visit.seed,
            engine: visit.engine.to_owned(),
            report: visit.report.to_owned(),
            novelties: visit.novelties.to_vec(),
            places: visit.places.to_vec(),
            same_place_m: visit.same_place_m,
        });
        let mut is_held = true;
        if self.visits.len() > MAX_HELD
            && let Some(at) = self.least_needed(|_| true)
        {
            is_held = at + 1 < self.visits.len();
            self.visits.remove(at);
        }
        while self.bytes() > MAX_HELD_BYTES {
            let Some(at) = self.least_needed(|visit| visit.sweep.is_some()) else {
                break;
            };
            self.visits[at].sweep = None;
        }
        is_held
    }

    /// Whether a visit of this waypoint is held.
    pub(super) fn has_of(&self, waypoint: &str) -> bool {
        self.visits.iter().any(|visit| visit.waypoint == waypoint)
    }

    fn least_needed(&self, may_be: impl Fn(&HeldVisit) -> bool) -> Option<usize> {
        let quiet = |visit: &HeldVisit| may_be(visit) && !visit.is_changed();
        let oldest_quiet = self.visits.iter().position(quiet);
        oldest_quiet.or_else(|| self.visits.iter().rposition(may_be))
    }

    fn bytes(&self) -> usize {
        let sweeps = self.visits.iter().filter_map(|visit| visit.sweep.as_ref());
        sweeps.map(HeldSweep::bytes).sum()
    }

    /// Takes all, to be stored in this order.
    pub(super) fn take_all(&mut self) -> VecDeque<HeldVisit> {
        std::mem::take(&mut self.visits)
    }

    /// Puts back what [`take_all`](Self::take_all) took and the disk did not.
    pub(super) fn put_back(&mut self, visits: VecDeque<HeldVisit>) {
        self.visits = visits;
    }

    pub(super) fn len(&self) -> usize {
        self.visits.len()
    }
}

/// Whether an alarm depends on a visit: it or a later one of its waypoint saw a change. `next` comes after all `later` ones.
pub(super) fn precedes_a_change(
    visit: &HeldVisit,
    later: &VecDeque<HeldVisit>,
    next: Option<&NewVisit<'_>>,
) -> bool {
    let of_its_waypoint = |other: &&HeldVisit| other.waypoint == visit.waypoint;
    visit.is_changed()
        || later
            .iter()
            .filter(of_its_waypoint)
            .any(HeldVisit::is_changed)
        || next
            .is_some_and(|next| next.waypoint == visit.waypoint && next.verdict == Verdict::Changed)
}

#[cfg(test)]
mod tests {
    use super::{HeldVisit, HeldVisits, MAX_HELD, MAX_HELD_BYTES, precedes_a_change};
    use crate::store::{NewVisit, RecordTime, SweepRecord};
    use patrold_engine::novelty::Verdict;

    fn push(held: &mut HeldVisits, second: usize, verdict: Verdict, raw: &[u8]) -> bool {
        push_of(held, "hall", second, verdict, raw)
    }

    fn push_of(
        held: &mut HeldVisits,
        waypoint: &str,
        second: usize,
        verdict: Verdict,
        raw: &[u8],
    ) -> bool {
        let stamp = RecordTime {
            at: jiff::Timestamp::from_second(second as i64).expect("a time"),
            boot_id: "boot".to_owned(),
        };
        let visit = NewVisit {
            waypoint,
            reference_id: None,
            sweep: Some(SweepRecord {
                dialogue: None,
                view: None,
                raw: Some(raw),
                quality: "null",
            }),
            verdict,
            reason: "",
            d_gmm: None,
            u_th: 0.001,
            seed: 7,
            engine: "{}",
            report: "{}",
            novelties: &[],
            places: &[],
            same_place_m: 0.5,
        };
        held.push(&visit, &stamp)
    }

    fn seconds(held: &HeldVisits) -> Vec<usize> {
        let second = |visit: &HeldVisit| visit.stamp.at.as_second() as usize;
        held.visits.iter().map(second).collect()
    }

    #[test]
    fn the_oldest_changes_are_kept_longest() {
        let mut held = HeldVisits::default();
        for second in 0..MAX_HELD {
            let verdict = match second {
                1 => Verdict::Quiet,
                2 => Verdict::NotObserved,
                _ => Verdict::Changed,
            };
            assert!(push(&mut held, second, verdict, b""));
        }
        assert!(push(&mut held, MAX_HELD, Verdict::Changed, b""));
        assert!(push(&mut held, MAX_HELD + 1, Verdict::Changed, b""));
        let kept: Vec<usize> = [0].into_iter().chain(3..MAX_HELD + 2).collect();
        assert_eq!(seconds(&held), kept, "what is no change went first");
        assert!(!push(&mut held, MAX_HELD + 2, Verdict::Changed, b""));
        assert_eq!(seconds(&held), kept, "then the newest change");
    }

    #[test]
    fn sweeps_beyond_the_bound_are_dropped_and_their_verdicts_are_not() {
        let mut held = HeldVisits::default();
        let big = vec![0; MAX_HELD_BYTES / 2];
        push(&mut held, 0, Verdict::Changed, &big);
        push(&mut held, 1, Verdict::Quiet, &big);
        push(&mut held, 2, Verdict::Changed, &big);
        let with_sweep = |held: &HeldVisits| -> Vec<bool> {
            held.visits
                .iter()
                .map(|visit| visit.sweep.is_some())
                .collect()
        };
        assert_eq!(with_sweep(&held), [true, false, true]);
        push(&mut held, 3, Verdict::Changed, b"a little more");
        assert_eq!(with_sweep(&held), [true, false, true, false]);
    }

    #[test]
    fn what_is_taken_is_gone_until_it_is_put_back() {
        let mut held = HeldVisits::default();
        push_of(&mut held, "hall", 1, Verdict::Quiet, b"");
        push_of(&mut held, "yard", 2, Verdict::Changed, b"");
        let of = |held: &HeldVisits| ["hall", "yard", "dock"].map(|name| held.has_of(name));
        assert_eq!((of(&held), held.len()), ([true, true, false], 2));
        let mut taken = held.take_all();
        assert_eq!((of(&held), held.len()), ([false; 3], 0));
        let waypoints: Vec<&str> = taken.iter().map(|visit| visit.waypoint.as_str()).collect();
        assert_eq!(waypoints, ["hall", "yard"], "the oldest first");
        taken.pop_front();
        held.put_back(taken);
        assert_eq!((of(&held), held.len()), ([false, true, false], 1));
    }

    #[test]
    fn an_alarm_depends_on_changes_and_on_what_its_waypoint_saw_before_them() {
        let queue = |visits: &[(&str, Verdict)]| {
            let mut held = HeldVisits::default();
            for (waypoint, verdict) in visits {
                push_of(&mut held, waypoint, 0, *verdict, b"");
            }
            held.take_all()
        };
        let (quiet, changed) = (Verdict::Quiet, Verdict::Changed);
        for (own, later, next, expected) in [
            (changed, None, None, true),
            (quiet, None, None, false),
            (quiet, Some(("hall", changed)), None, true),
            (quiet, Some(("hall", quiet)), None, false),
            (quiet, Some(("yard", changed)), None, false),
            (quiet, None, Some(("hall", changed)), true),
            (quiet, None, Some(("hall", quiet)), false),
            (quiet, None, Some(("yard", changed)), false),
        ] {
            let visit = queue(&[("hall", own)]).remove(0).expect("held");
            let later: Vec<_> = later.into_iter().collect();
            let next = next.map(|next| queue(&[next]).remove(0).expect("held"));
            let next = next.as_ref().map(HeldVisit::visit);
            let depends = precedes_a_change(&visit, &queue(&later), next.as_ref());
            assert_eq!(depends, expected, "{own:?}, {later:?}, {next:?}");
        }
    }
}
