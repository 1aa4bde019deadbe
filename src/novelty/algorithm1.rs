//! Algorithm 1 of the paper: take Gaussians out of the revisit's mixture, the most changed first,
//! until it is as near to the reference as U_th; then with swapped roles for what disappeared.

use super::detect::Pair;
use super::quantify::split_settings;
use super::{Evidence, Model, NoveltyError, Settings, Sight, Thing};
use crate::distance::{CostMatrix, Ground, cost_matrix, emd_of_costs};
use crate::mixture::{Gaussian, Mixture, RefitSettings, Unexplained, refit};
use nalgebra::Point3;

/// Things that went (first) and came (second), by Algorithm 1. `own_model` is the revisit's mixture in
/// its own frame where it was fitted alone; otherwise it is refitted from `reference`.
///
/// # Errors
/// Mixtures that cannot be fitted or compared.
pub fn segment(
    reference: &Mixture,
    own_model: Option<Mixture>,
    pair: &Pair<'_>,
    evidence: &[Vec<Evidence>; 2],
    settings: &Settings,
) -> Result<[Vec<Thing>; 2], NoveltyError> {
    let reference_from_current = pair.reference_from(1);
    let revisit = match own_model {
        Some(mixture) => carried(mixture, &reference_from_current),
        None => {
            let places: Vec<Point3<f64>> = pair.views[1]
                .surfaces
                .patches
                .iter()
                .map(|p| reference_from_current * p.mean)
                .collect();
            let told = RefitSettings {
                split: split_settings(pair.views[1]),
                ..RefitSettings::default()
            };
            refit(reference, &places, None, unexplained(pair), &told)?.mixture
        }
    };
    let shared = match settings.model {
        Model::Refit => reference.len(),
        Model::Independent { .. } => 0,
    };
    let came = removed(&revisit, reference, shared, settings)?;
    let went = removed(reference, &revisit, shared, settings)?;
    Ok([
        things(reference, &went, 0, pair, &evidence[0], settings),
        things(&revisit, &came, 1, pair, &evidence[1], settings),
    ])
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
    while d >= settings.u_th() && left.len() > 1 {
        // Line 4: the greatest quantified change is the greatest part of d_GMM.
        let mut parts = vec![0.0; left.len()];
        for (row, cost) in plan {
            parts[row] += cost;
        }
        let Some(worst) = (0..left.len())
            .filter(|r| {
                left[*r] >= shared
                    || left[*r] >= gamma.len()
                    || theta.weights[left[*r]] > gamma.weights[left[*r]]
            })
            .max_by(|a, b| parts[*a].total_cmp(&parts[*b]).then(b.cmp(a)))
        else {
            break;
        };
        let mut fewer = left.clone();
        let taken = fewer.remove(worst);
        // Line 7: weights sum to one again.
        let (next, next_plan) = distance(theta, &fewer, gamma, &costs)?;
        if next >= d {
            break; // nothing left is significantly new
        }
        out.push(taken);
        left = fewer;
        d = next;
        plan = next_plan;
    }
    Ok(out)
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
) -> Vec<Thing> {
    let groups = touching(mixture, removed, settings.segment.link_m);
    let densities: Vec<_> = mixture.components.iter().map(|g| Explains::of(g)).collect();
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
        let place = reference_from_own * patch.mean;
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
    lists
        .into_iter()
        .filter(|points| points.len() >= settings.segment.least_points)
        .map(|points| super::segment::measure(own, evidence, points, &settings.segment))
        .filter(|thing| {
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
