//! The pose from several starts, and whether others explain the view as well.

use super::agreement::{BlockAgreements, Witnesses};
use super::matcher::{FindPatch, Matcher, about};
use super::settings::RegistrationSettings;
use crate::geometry::constants::{MAX_CONTENDERS, SURE_LEAD_SIGMAS};
use crate::geometry::{DriftTransform, PlaneIndex, Pose, RangeDrift, RollPitchYaw};
use nalgebra::{Point3, Translation3};
use rayon::prelude::*;

/// What the search found; poses map current to reference coordinates.
pub(super) struct FoundPoses {
    /// The one chosen.
    pub(super) pose: Pose,
    /// Another that explains the view as well, if there is one.
    pub(super) rival: Option<Pose>,
}

/// A pose, and how well it explains the view.
struct Candidate {
    pose: Pose,
    /// Agreement of each block of the view.
    blocks: BlockAgreements,
}

impl Candidate {
    fn agreement(&self) -> f64 {
        self.blocks.by_direction.iter().sum()
    }

    /// By how many standard deviations it explains the view better than `other`, counted by direction or by cells, whichever is
    /// more.
    fn lead(&self, other: &Self, view: &Witnesses) -> f64 {
        let of = |own: &[f64], other: &[f64], shares: &[f64]| {
            let differences = || own.iter().zip(other).map(|(a, b)| a - b);
            let mean: f64 = differences().sum();
            // Blocks differ by their share of it, and scatter about that.
            let blocks = differences().zip(shares);
            let variance: f64 = blocks.map(|(d, share)| (d - share * mean).powi(2)).sum();
            if variance > 0.0 {
                mean / variance.sqrt()
            } else {
                0.0
            }
        };
        let (own, other, shares) = (&self.blocks, &other.blocks, &view.block_shares);
        let by_direction = of(&own.by_direction, &other.by_direction, &shares.by_direction);
        by_direction.max(of(&own.mean, &other.mean, &shares.mean))
    }
}

/// Searches the pose that explains the view best. More starts than one are made: a single one fails where one direction is
/// barely fixed. Where the best leaves much unexplained, further starts lie around `start`, as far as a robot stops beside its
/// waypoint.
pub(super) fn search(
    matcher: &Matcher<'_>,
    view: &Witnesses,
    start: Pose,
    origin: &Point3<f64>,
    gate_m: f64,
    settings: &RegistrationSettings,
) -> FoundPoses {
    let search = Search {
        matcher,
        view,
        start,
        origin,
        gate_m,
        settings,
    };
    let near: Vec<(Pose, f64)> = settings
        .start_gates_m
        .iter()
        .map(|gate_m| (start, *gate_m))
        .collect();
    let mut found = vec![search.judge(start, PlaneIndex::find_approximate)];
    found.extend(search.anneal(&near));
    let is_sure = |c: &Candidate| c.agreement() >= settings.sure_agreement;
    if !found.iter().any(is_sure) {
        found.extend(search.anneal(&starts_around(&start, origin, settings)));
    }
    let mut left = search.contenders(found);
    if left.len() > 1 {
        // Where its way ended early, or on planes found roughly, a pose looks worse than it is.
        let refined = left.par_iter().map(|c| {
            let (pose, _) = matcher.refine(&view.points, c.pose, origin, gate_m, settings);
            search.judge(pose, PlaneIndex::find_exact)
        });
        left = search.contenders(refined.collect());
    }
    search.choose(&left)
}

/// What a search works with.
struct Search<'a> {
    matcher: &'a Matcher<'a>,
    view: &'a Witnesses,
    start: Pose,
    origin: &'a Point3<f64>,
    gate_m: f64,
    settings: &'a RegistrationSettings,
}

impl Search<'_> {
    fn judge(&self, pose: Pose, find: FindPatch) -> Candidate {
        let transform = DriftTransform::to_reference(pose, RangeDrift::default(), *self.origin);
        let agrees = |p: &Point3<f64>| self.matcher.agrees(&transform.apply(p), self.gate_m, find);
        Candidate {
            pose,
            blocks: self.view.block_agreements(agrees),
        }
    }

    /// Where each start leads with its first gate. In parallel, in the order of the starts: the result never depends on threads.
    fn anneal(&self, starts: &[(Pose, f64)]) -> Vec<Candidate> {
        starts
            .par_iter()
            .map(|(from, first_gate_m)| {
                let gates = [*first_gate_m, self.gate_m];
                let points = &self.view.points;
                let pose = self
                    .matcher
                    .anneal(points, *from, self.origin, gates, self.settings);
                self.judge(pose, PlaneIndex::find_approximate)
            })
            .collect()
    }

    /// The best, and after it others that lie apart from it and from one another, none of them surely worse.
    fn contenders(&self, mut found: Vec<Candidate>) -> Vec<Candidate> {
        found.sort_by(|a, b| b.agreement().total_cmp(&a.agreement()));
        let mut kept: Vec<Candidate> = Vec::new();
        for candidate in found {
            let apart =
                |k: &Candidate| self.matcher.motion(&k.pose, &candidate.pose).norm() >= self.gate_m;
            let is_worse = kept
                .first()
                .is_some_and(|best| best.lead(&candidate, self.view) > SURE_LEAD_SIGMAS);
            if kept.iter().all(apart) && !is_worse && kept.len() < MAX_CONTENDERS {
                kept.push(candidate);
            }
        }
        kept
    }

    /// The pose among `contenders`, the best of which comes first. Those that are joined with it explain the view as it does:
    /// how well they do counts against how far off the robot would have stopped. The others are rivals.
    fn choose(&self, contenders: &[Candidate]) -> FoundPoses {
        let Some((best, others)) = contenders.split_first() else {
            return FoundPoses {
                pose: self.start,
                rival: None,
            };
        };
        if others.is_empty() {
            return FoundPoses {
                pose: best.pose,
                rival: None,
            };
        }
        let transform =
            DriftTransform::to_reference(best.pose, RangeDrift::default(), *self.origin);
        let (points, find): (_, FindPatch) = (&self.view.points, PlaneIndex::find_exact);
        let normal = self
            .matcher
            .normal_equations(points, &transform, self.gate_m, find);
        // Whether they differ along directions alone that the surfaces do not fix.
        let is_open = |other: &Candidate| {
            let motion = self.matcher.motion(&best.pose, &other.pose);
            let fixed = motion - normal.unobservable_part(&motion, self.settings);
            fixed.norm() < self.gate_m
        };
        let (joined, rivals): (Vec<&Candidate>, Vec<&Candidate>) = others
            .iter()
            .partition(|other| is_open(other) || self.are_joined(best, other));
        let cost = |c: &Candidate| {
            let motion = self.matcher.motion(&self.start, &c.pose);
            let shift = motion.fixed_rows::<3>(0).norm() / self.settings.prior_sd_m;
            let turn = motion.fixed_rows::<3>(3).norm() / self.settings.prior_sd_rad;
            best.lead(c, self.view).powi(2) + shift * shift + turn * turn
        };
        let chosen = joined.into_iter().fold(best, |least, other| {
            if cost(other) < cost(least) {
                other
            } else {
                least
            }
        });
        FoundPoses {
            pose: chosen.pose,
            rival: rivals.first().map(|c| c.pose),
        }
    }

    /// Whether the pose half-way between two explains the view as well as the first: then nothing fixes the way between them.
    fn are_joined(&self, best: &Candidate, other: &Candidate) -> bool {
        let half = self.matcher.motion(&best.pose, &other.pose) * 0.5;
        let between = self.matcher.moved(&best.pose, &half);
        let between = self.judge(between, PlaneIndex::find_exact);
        best.lead(&between, self.view) <= SURE_LEAD_SIGMAS
    }
}

/// Starts turned and moved away from `start`, each with its first gate.
fn starts_around(
    start: &Pose,
    origin: &Point3<f64>,
    settings: &RegistrationSettings,
) -> Vec<(Pose, f64)> {
    let turned = settings.start_yaws_rad.iter().map(|yaw_rad| {
        let turn = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: *yaw_rad,
        }
        .with_translation([0.0; 3]);
        *start * about(origin, &turn)
    });
    turned
        .flat_map(|pose| {
            settings.start_shifts_m.iter().map(move |[x, y]| {
                let moved = Translation3::new(*x, *y, 0.0) * pose;
                (moved, settings.start_around_gate_m)
            })
        })
        .collect()
}
