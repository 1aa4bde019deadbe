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
    /// The one that explains the view best.
    pub(super) pose: Pose,
    /// Where its way began.
    pub(super) from: Pose,
    /// Another that is not surely worse, if there is one.
    pub(super) rival: Option<Pose>,
}

/// A pose, and how well it explains the view.
struct Candidate {
    pose: Pose,
    from: Pose,
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
        let lead = |own: &[f64], other: &[f64], shares: &[f64]| {
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
        lead(&own.by_direction, &other.by_direction, &shares.by_direction).max(lead(
            &own.mean,
            &other.mean,
            &shares.mean,
        ))
    }
}

/// Searches the pose that explains the view best. More starts than one are made: a single one fails where one direction is
/// barely fixed. Where the best leaves much unexplained, further starts lie around `start`, as far as a robot stops beside its
/// waypoint.
pub(super) fn search(
    matcher: &Matcher<'_>,
    few: &Witnesses,
    start: Pose,
    origin: &Point3<f64>,
    gate_m: f64,
    settings: &RegistrationSettings,
) -> FoundPoses {
    let judged = |from: Pose, pose: Pose, find: FindPatch| {
        let transform = DriftTransform::to_reference(pose, RangeDrift::default(), *origin);
        let blocks = few.block_agreements(|p| matcher.agrees(&transform.apply(p), gate_m, find));
        Candidate { pose, from, blocks }
    };
    // In parallel, compared in the order of the starts: the result never depends on threads.
    let anneal = |starts: &[(Pose, f64)]| -> Vec<Candidate> {
        starts
            .par_iter()
            .map(|(from, first_gate_m)| {
                let gates = [*first_gate_m, gate_m];
                let pose = matcher.anneal(&few.points, *from, origin, gates, settings);
                judged(*from, pose, PlaneIndex::find_approximate)
            })
            .collect()
    };
    let near: Vec<(Pose, f64)> = settings
        .start_gates_m
        .iter()
        .map(|gate_m| (start, *gate_m))
        .collect();
    let mut found = vec![judged(start, start, PlaneIndex::find_approximate)];
    found.extend(anneal(&near));
    let way = |a: &Candidate, b: &Candidate| matcher.motion(&a.pose, &b.pose).norm();
    let is_sure = |c: &Candidate| c.agreement() >= settings.sure_agreement;
    if !found.iter().any(is_sure) {
        found.extend(anneal(&starts_around(&start, origin, settings)));
    }
    let mut left = contenders(found, gate_m, few, way);
    if left.len() > 1 {
        // Where its way ended early, or on planes found roughly, a pose looks worse than it is.
        let refined = left.par_iter().map(|c| {
            let (pose, _) = matcher.refine(&few.points, c.pose, origin, gate_m, settings);
            judged(c.from, pose, PlaneIndex::find_exact)
        });
        left = contenders(refined.collect(), gate_m, few, way);
    }
    // A pose is no rival of the best if one half-way explains the view as well: nothing fixes the way between them.
    let joined = |c: &Candidate| {
        left.len() == 1
            || left.first().is_none_or(|best| {
                let half = matcher.motion(&best.pose, &c.pose) * 0.5;
                let between = matcher.moved(&best.pose, &half);
                let between = judged(best.from, between, PlaneIndex::find_exact);
                best.lead(&between, few) <= SURE_LEAD_SIGMAS
            })
    };
    // Among these, how well the view is explained against how far off the robot would have stopped.
    let cost = |c: &Candidate| {
        let way = matcher.motion(&start, &c.pose);
        let shift = way.fixed_rows::<3>(0).norm() / settings.prior_sd_m;
        let turn = way.fixed_rows::<3>(3).norm() / settings.prior_sd_rad;
        let lead = left.first().map_or(0.0, |best| best.lead(c, few));
        lead * lead + shift * shift + turn * turn
    };
    let (same, rivals): (Vec<&Candidate>, Vec<&Candidate>) = left.iter().partition(|c| joined(c));
    let chosen = same.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
    let (pose, from) = chosen.map_or((start, start), |c| (c.pose, c.from));
    FoundPoses {
        pose,
        from,
        rival: rivals.first().map(|c| c.pose),
    }
}

/// The best, and after it others that lie at least `apart_m` from it and from one another, none of them surely worse.
fn contenders(
    mut found: Vec<Candidate>,
    apart_m: f64,
    view: &Witnesses,
    way: impl Fn(&Candidate, &Candidate) -> f64,
) -> Vec<Candidate> {
    found.sort_by(|a, b| b.agreement().total_cmp(&a.agreement()));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in found {
        let is_other = kept.iter().all(|k| way(k, &candidate) >= apart_m);
        let is_worse = kept
            .first()
            .is_some_and(|best| best.lead(&candidate, view) > SURE_LEAD_SIGMAS);
        if is_other && !is_worse && kept.len() < MAX_CONTENDERS {
            kept.push(candidate);
        }
    }
    kept
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
