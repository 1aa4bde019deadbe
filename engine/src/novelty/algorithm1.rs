//! Algorithm 1 of the paper: take Gaussians out of the revisit's mixture, the most changed first,
//! until it is as near to the reference as U_th; then with swapped roles for what disappeared.

use super::common_surface::one_step;
use super::detect::Pair;
use super::quantify::split_settings;
use super::{Evidence, Model, NoveltyError, Settings, Sight, Thing};
use crate::distance::{CostMatrix, Ground, cost_matrix, emd, emd_of_costs};
use crate::mixture::{Gaussian, Mixture, RefitSettings, Unexplained, refit};
use nalgebra::Point3;

/// Removals tried, most changed first, before the algorithm ends: the first is right in 98-100 %
/// (design section 5).
const CANDIDATES: usize = 5;
/// A component lost its place if its twin has less than half of its weight.
const TWIN_RATIO: f64 = 2.0;

/// What Algorithm 1 gives.
pub struct Outcome {
    /// Things that went, things that came.
    pub things: [Vec<Thing>; 2],
    /// Part of d_GMM of each of these.
    pub contributions: [Vec<f64>; 2],
    /// d_GMM of the whole mixtures (line 1).
    pub d: f64,
    /// Number of components: reference, revisit.
    pub components: [usize; 2],
}

/// Runs Algorithm 1 both ways. `own_model` is the revisit's mixture in its own frame where it was
/// fitted alone; otherwise it is refitted from `reference`.
///
/// # Errors
/// Mixtures that cannot be fitted or compared.
pub fn run(
    reference: &Mixture,
    own_model: Option<Mixture>,
    pair: &Pair<'_>,
    evidence: &[Vec<Evidence>; 2],
    settings: &Settings,
) -> Result<Outcome, NoveltyError> {
    let seen = [0, 1].map(|side| visible(pair, side, &evidence[side]));
    if seen.iter().any(|(places, _)| places.is_empty()) {
        return Ok(Outcome {
            things: [Vec::new(), Vec::new()],
            contributions: [Vec::new(), Vec::new()],
            d: 0.0,
            components: [reference.len(), 0],
        });
    }
    // A thing's shadow would move mass as well: both mixtures weigh what both views could see.
    let reference = &weighed(reference, &seen[0])?;
    let revisit = match own_model {
        Some(mixture) => weighed(&carried(mixture, &pair.reference_from(1).pose), &seen[1])?,
        None => {
            let told = RefitSettings {
                split: split_settings(pair.views[1]),
                ..one_step()
            };
            let (places, weights) = &seen[1];
            refit(reference, places, Some(weights), unexplained(pair), &told)?.mixture
        }
    };
    let shared = match settings.model {
        Model::Refit => reference.len(),
        Model::Independent { .. } => 0,
    };
    let came = removed(&revisit, reference, shared, settings)?;
    let went = removed(reference, &revisit, shared, settings)?;
    let grouped = [
        things(reference, &went, 0, pair, &evidence[0], settings),
        things(&revisit, &came, 1, pair, &evidence[1], settings),
    ];
    let whole = emd(reference, &revisit, settings.quantify.ground)?;
    let owner = |side: usize, k: usize| {
        grouped[side]
            .iter()
            .position(|(components, _)| components.contains(&k))
            .map(|thing| (side, thing))
    };
    let mut contributions = grouped.each_ref().map(|list| vec![0.0; list.len()]);
    for flow in &whole.plan {
        let owners: Vec<_> = [owner(0, flow.from), owner(1, flow.to)]
            .into_iter()
            .flatten()
            .collect();
        for (side, thing) in &owners {
            contributions[*side][*thing] += flow.mass * flow.distance / owners.len() as f64;
        }
    }
    Ok(Outcome {
        things: grouped.map(|list| list.into_iter().map(|(_, thing)| thing).collect()),
        contributions,
        d: whole.d,
        components: [reference.len(), revisit.len()],
    })
}

/// Cells of view `side` that the other view could see, in the reference's frame, with their surface.
fn visible(pair: &Pair<'_>, side: usize, evidence: &[Evidence]) -> (Vec<Point3<f64>>, Vec<f64>) {
    let surfaces = &pair.views[side].surfaces;
    let reference_from_own = pair.reference_from(side);
    let mut seen = vec![0.0; surfaces.patches.len()];
    for (cell, e) in surfaces.patch_of_point.iter().zip(evidence) {
        if matches!(e.sight, Sight::Same | Sight::Through) {
            seen[*cell as usize] += 1.0;
        }
    }
    surfaces
        .patches
        .iter()
        .zip(seen)
        .filter(|(_, n)| *n > 0.0)
        .map(|(p, n)| {
            (
                reference_from_own.carry(&p.mean),
                n * p.area_m2 / p.count as f64,
            )
        })
        .unzip()
}

/// The mixture with the weights that it has on `seen`.
fn weighed(
    mixture: &Mixture,
    seen: &(Vec<Point3<f64>>, Vec<f64>),
) -> Result<Mixture, NoveltyError> {
    let (places, weights) = seen;
    let none = Unexplained::Listed(&[]);
    Ok(refit(mixture, places, Some(weights), none, &one_step())?.mixture)
}

/// What the reference's components do not explain: five sigmas off, widened by the noise between.
fn unexplained(pair: &Pair<'_>) -> Unexplained<'static> {
    let [then, now] = pair.views;
    let at = then.middle_range_m;
    let noise_m2 = then.noise.sigma_m(at).powi(2) + now.noise.sigma_m(at).powi(2);
    match Unexplained::default() {
        Unexplained::Beyond { sigmas, .. } => Unexplained::Beyond { sigmas, noise_m2 },
        listed @ Unexplained::Listed(_) => listed,
    }
}

/// Pi: components of `theta` taken out, in order. The first `shared` components of both are the same
/// Gaussians; one is significantly new only if it has more weight than its twin.
fn removed(
    theta: &Mixture,
    gamma: &Mixture,
    shared: usize,
    settings: &Settings,
) -> Result<Vec<usize>, NoveltyError> {
    let ground: Ground = settings.quantify.ground;
    let costs = cost_matrix(theta, gamma, ground);
    let mut left: Vec<usize> = (0..theta.len()).collect();
    let mut out = Vec::new();
    let (mut d, mut plan) = distance(theta, &left, gamma, &costs)?;
    'removing: while d >= settings.u_th() && left.len() > 1 {
        // Line 4: the greatest quantified change is the greatest part of d_GMM.
        let mut parts = vec![0.0; left.len()];
        for (row, cost) in plan {
            parts[row] += cost;
        }
        let mut candidates: Vec<usize> = (0..left.len())
            .filter(|row| significantly_new(left[*row], theta, gamma, shared))
            .collect();
        candidates.sort_by(|a, b| parts[*b].total_cmp(&parts[*a]).then(a.cmp(b)));
        for row in candidates.into_iter().take(CANDIDATES) {
            let mut fewer = left.clone();
            let taken = fewer.remove(row);
            // Line 7: weights sum to one again.
            let (next, next_plan) = distance(theta, &fewer, gamma, &costs)?;
            if next < d {
                out.push(taken);
                left = fewer;
                d = next;
                plan = next_plan;
                continue 'removing;
            }
        }
        break; // nothing that is left brings the mixtures nearer
    }
    Ok(out)
}

/// Whether component `k` of `theta` can be new: it has no twin in `gamma`, or lost most of its weight
/// there. Without shared components every one can.
fn significantly_new(k: usize, theta: &Mixture, gamma: &Mixture, shared: usize) -> bool {
    k >= shared || theta.weights[k] > TWIN_RATIO * gamma.weights[k]
}

/// d_GMM between the rows `left` of `theta` and `gamma`, with the cost of each flow by row of `left`.
fn distance(
    theta: &Mixture,
    left: &[usize],
    gamma: &Mixture,
    costs: &CostMatrix,
) -> Result<(f64, Vec<(usize, f64)>), NoveltyError> {
    let columns = costs.columns();
    let values: Vec<f64> = left
        .iter()
        .flat_map(|i| &costs.values()[i * columns..(i + 1) * columns])
        .copied()
        .collect();
    let weights: Vec<f64> = left.iter().map(|i| theta.weights[*i]).collect();
    let Some(rows) = CostMatrix::from_rows(left.len(), columns, values) else {
        return Ok((0.0, Vec::new()));
    };
    let solved = emd_of_costs(&weights, &gamma.weights, &rows)?;
    let parts = solved
        .plan
        .iter()
        .map(|f| (f.from, f.mass * f.distance))
        .collect();
    Ok((solved.d, parts))
}

/// Removed components that touch are one thing; its points are those that it explains best.
fn things(
    mixture: &Mixture,
    removed: &[usize],
    side: usize,
    pair: &Pair<'_>,
    evidence: &[Evidence],
    settings: &Settings,
) -> Vec<(Vec<usize>, Thing)> {
    let groups = touching(mixture, removed, settings.segment.link_m);
    let densities: Vec<_> = mixture.components.iter().map(Explains::of).collect();
    let reference_from_own = pair.reference_from(side);
    let own = pair.views[side];
    let mut points: Vec<Vec<usize>> = vec![Vec::new(); groups.len()];
    let mut group_of = vec![None; mixture.len()];
    for (g, members) in groups.iter().enumerate() {
        for m in members {
            group_of[*m] = Some(g);
        }
    }
    for (cell, patch) in own.surfaces.patches.iter().enumerate() {
        let place = reference_from_own.carry(&patch.mean);
        let best = (0..mixture.len())
            .filter(|k| mixture.weights[*k] > 0.0)
            .map(|k| (densities[k].log(&place) + mixture.weights[k].ln(), k))
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        if let Some(group) = best.and_then(|(_, k)| group_of[k]) {
            points[group].push(cell);
        }
    }
    let mut cells: Vec<Option<usize>> = vec![None; own.surfaces.patches.len()];
    for (g, members) in points.iter().enumerate() {
        for cell in members {
            cells[*cell] = Some(g);
        }
    }
    let mut lists: Vec<Vec<usize>> = vec![Vec::new(); groups.len()];
    for (i, cell) in own.surfaces.patch_of_point.iter().enumerate() {
        if let Some(g) = cells[*cell as usize] {
            lists[g].push(i);
        }
    }
    groups
        .into_iter()
        .zip(lists)
        .filter(|(_, points)| points.len() >= settings.segment.least_points)
        .map(|(components, points)| {
            let thing = super::segment::measure(own, evidence, points, &settings.segment);
            (components, thing)
        })
        .filter(|(_, thing)| {
            // Out of the other view's sight is no change: more than half must have been in sight.
            let seen = thing
                .points
                .iter()
                .filter(|i| matches!(evidence[**i].sight, Sight::Same | Sight::Through))
                .count();
            2 * seen > thing.points.len()
        })
        .collect()
}

/// Groups of `removed` whose ellipsoids (two sigmas) come within `link_m` of one another.
fn touching(mixture: &Mixture, removed: &[usize], link_m: f64) -> Vec<Vec<usize>> {
    let reach = |g: &Gaussian, towards: &nalgebra::Vector3<f64>| {
        2.0 * towards.dot(&(g.covariance * towards)).max(0.0).sqrt()
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut sorted = removed.to_vec();
    sorted.sort_unstable();
    for k in sorted {
        let a = &mixture.components[k];
        let near = |m: &usize| {
            let b = &mixture.components[*m];
            let off = b.mean - a.mean;
            off.try_normalize(1e-9)
                .is_none_or(|u| off.norm() - reach(a, &u) - reach(b, &u) <= link_m)
        };
        let (mut joined, rest): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|g| g.iter().any(near));
        groups = rest;
        let mut group: Vec<usize> = joined.drain(..).flatten().collect();
        group.push(k);
        group.sort_unstable();
        groups.push(group);
    }
    groups.sort();
    groups
}

/// A Gaussian ready to be evaluated.
struct Explains {
    mean: Point3<f64>,
    inverse: nalgebra::Matrix3<f64>,
    log_norm: f64,
}

impl Explains {
    fn of(g: &Gaussian) -> Self {
        // One millimetre, squared: a flat component still has a density.
        let full = g.covariance + nalgebra::Matrix3::identity() * 1e-6;
        Self {
            mean: g.mean,
            inverse: full.try_inverse().unwrap_or_else(nalgebra::Matrix3::zeros),
            log_norm: -0.5 * full.determinant().max(f64::MIN_POSITIVE).ln(),
        }
    }

    fn log(&self, p: &Point3<f64>) -> f64 {
        let d = p - self.mean;
        self.log_norm - 0.5 * d.dot(&(self.inverse * d))
    }
}

fn carried(mut mixture: Mixture, pose: &crate::geometry::Pose) -> Mixture {
    let turn = pose.rotation.to_rotation_matrix().into_inner();
    for g in &mut mixture.components {
        g.mean = pose * g.mean;
        g.covariance = turn * g.covariance * turn.transpose();
    }
    mixture
}
