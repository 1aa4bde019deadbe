//! Algorithm 1 of the paper (`docs/novelty.md section 10`): removes Gaussians from the current mixture, the most changed first,
//! until it is as near to the reference as U_th; then with swapped roles for what disappeared.

use super::common_surface::one_step;
use super::view_pair::ViewPair;
use super::{Evidence, NoveltyError, NoveltySettings, RevisitModel, Segment, Visibility};
use crate::distance::{CostMatrix, GroundDistance, cost_matrix, emd, emd_of_costs};
use crate::geometry::Pose;
use crate::mixture::{Gaussian, Mixture, RefitSettings, Unexplained, refit};
use nalgebra::{Matrix3, Point3, Vector3};

/// Removals tried, most changed first, before the algorithm ends: the first is right in 98-100 %
/// (`docs/novelty.md section 10`).
const MAX_CANDIDATES: usize = 5;
/// A shared component is a candidate if its weight is more than this many times that in the other mixture.
const MIN_WEIGHT_RATIO: f64 = 2.0;

/// Result of Algorithm 1.
pub(super) struct MixtureSegmentation {
    /// Disappeared and appeared segments.
    pub segments: [Vec<Segment>; 2],
    /// Part of d_GMM of each segment.
    pub contributions: [Vec<f64>; 2],
    /// d_GMM of the whole mixtures (line 1).
    pub d: f64,
    /// Number of components: reference, current.
    pub components: [usize; 2],
}

/// Runs Algorithm 1 both ways. `own_mixture` is that of the current view in its own frame if it was fitted alone; otherwise it
/// is refitted from `reference`.
///
/// # Errors
/// Mixtures that cannot be fitted or compared.
pub(super) fn run(
    reference: &Mixture,
    own_mixture: Option<Mixture>,
    pair: &ViewPair<'_>,
    evidence: &[Vec<Evidence>; 2],
    settings: &NoveltySettings,
) -> Result<MixtureSegmentation, NoveltyError> {
    let visible = [0, 1].map(|side| visible_cells(pair, side, &evidence[side]));
    if visible.iter().any(|(points, _)| points.is_empty()) {
        return Ok(MixtureSegmentation {
            segments: [Vec::new(), Vec::new()],
            contributions: [Vec::new(), Vec::new()],
            d: 0.0,
            components: [reference.len(), 0],
        });
    }
    // Both mixtures are weighted by what both views could see, or shadows would move mass as well.
    let reference = &reweighted(reference, &visible[0])?;
    let current = match own_mixture {
        Some(mixture) => {
            let in_reference_frame = transformed(mixture, &pair.reference_from(1).pose);
            reweighted(&in_reference_frame, &visible[1])?
        }
        None => {
            let refit_settings = RefitSettings {
                split: pair.views[1].split_settings(),
                ..one_step()
            };
            let (points, weights) = &visible[1];
            refit(
                reference,
                points,
                Some(weights),
                unexplained(pair),
                &refit_settings,
            )?
            .mixture
        }
    };
    let shared = match settings.model {
        RevisitModel::Refit => reference.len(),
        RevisitModel::Independent { .. } => 0,
    };
    let appeared = remove_changed(&current, reference, shared, settings)?;
    let disappeared = remove_changed(reference, &current, shared, settings)?;
    let grouped = [
        segments(reference, &disappeared, 0, pair, &evidence[0], settings),
        segments(&current, &appeared, 1, pair, &evidence[1], settings),
    ];
    let whole = emd(reference, &current, settings.quantify.ground)?;
    let owner = |side: usize, k: usize| {
        grouped[side]
            .iter()
            .position(|(components, _)| components.contains(&k))
            .map(|segment| (side, segment))
    };
    let mut contributions = grouped.each_ref().map(|list| vec![0.0; list.len()]);
    for flow in &whole.plan {
        let owners: Vec<_> = [owner(0, flow.from), owner(1, flow.to)]
            .into_iter()
            .flatten()
            .collect();
        for (side, segment) in &owners {
            contributions[*side][*segment] += flow.mass * flow.distance / owners.len() as f64;
        }
    }
    Ok(MixtureSegmentation {
        segments: grouped.map(|list| list.into_iter().map(|(_, segment)| segment).collect()),
        contributions,
        d: whole.d,
        components: [reference.len(), current.len()],
    })
}

/// Cells of view `side` that the other view could see, in the reference's frame, with their area in square metres.
fn visible_cells(
    pair: &ViewPair<'_>,
    side: usize,
    evidence: &[Evidence],
) -> (Vec<Point3<f64>>, Vec<f64>) {
    let surfaces = &pair.views[side].surfaces;
    let reference_from_own = pair.reference_from(side);
    let mut visible_points = vec![0.0; surfaces.patches.len()];
    for (cell, e) in surfaces.patch_of_point.iter().zip(evidence) {
        if matches!(e.visibility, Visibility::OnSurface | Visibility::FreeSpace) {
            visible_points[*cell as usize] += 1.0;
        }
    }
    surfaces
        .patches
        .iter()
        .zip(visible_points)
        .filter(|(_, n)| *n > 0.0)
        .map(|(p, n)| {
            (
                reference_from_own.apply(&p.mean),
                n * p.area_m2 / p.count as f64,
            )
        })
        .unzip()
}

/// The mixture with its weights on `visible` cells.
fn reweighted(
    mixture: &Mixture,
    visible: &(Vec<Point3<f64>>, Vec<f64>),
) -> Result<Mixture, NoveltyError> {
    let (points, weights) = visible;
    let none = Unexplained::Listed(&[]);
    Ok(refit(mixture, points, Some(weights), none, &one_step())?.mixture)
}

/// Points are unexplained relative to the components widened by the noise of both views.
fn unexplained(pair: &ViewPair<'_>) -> Unexplained<'static> {
    let [reference, current] = pair.views;
    let range_m = reference.median_range_m;
    let noise_m2 =
        reference.noise.sigma_m(range_m).powi(2) + current.noise.sigma_m(range_m).powi(2);
    match Unexplained::default() {
        Unexplained::Beyond { sigmas, .. } => Unexplained::Beyond { sigmas, noise_m2 },
        listed @ Unexplained::Listed(_) => listed,
    }
}

/// Pi: the components removed from `theta`, in order. The first `shared` components of both mixtures are the same Gaussians.
fn remove_changed(
    theta: &Mixture,
    gamma: &Mixture,
    shared: usize,
    settings: &NoveltySettings,
) -> Result<Vec<usize>, NoveltyError> {
    let ground: GroundDistance = settings.quantify.ground;
    let costs = cost_matrix(theta, gamma, ground);
    let mut left: Vec<usize> = (0..theta.len()).collect();
    let mut removed = Vec::new();
    let (mut d, mut plan) = distance(theta, &left, gamma, &costs)?;
    'removing: while d >= settings.u_th() && left.len() > 1 {
        // Line 4: the greatest quantified change is the greatest part of d_GMM.
        let mut parts = vec![0.0; left.len()];
        for (row, cost) in plan {
            parts[row] += cost;
        }
        let mut candidates: Vec<usize> = (0..left.len())
            .filter(|row| is_candidate(left[*row], theta, gamma, shared))
            .collect();
        candidates.sort_by(|a, b| parts[*b].total_cmp(&parts[*a]).then(a.cmp(b)));
        for row in candidates.into_iter().take(MAX_CANDIDATES) {
            let mut fewer = left.clone();
            let taken = fewer.remove(row);
            // Line 7: weights sum to one again.
            let (next, next_plan) = distance(theta, &fewer, gamma, &costs)?;
            if next < d {
                removed.push(taken);
                left = fewer;
                d = next;
                plan = next_plan;
                continue 'removing;
            }
        }
        break; // no removal brings the mixtures nearer
    }
    Ok(removed)
}

/// Whether component `k` of `theta` may be removed: it is not shared with `gamma`, or has much less weight there.
fn is_candidate(k: usize, theta: &Mixture, gamma: &Mixture, shared: usize) -> bool {
    k >= shared || theta.weights[k] > MIN_WEIGHT_RATIO * gamma.weights[k]
}

/// d_GMM between the components `left` of `theta` and `gamma`, with the cost of each flow by index into `left`.
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

/// Segments of `removed` components: those that touch are one segment, with the points that they explain best.
fn segments(
    mixture: &Mixture,
    removed: &[usize],
    side: usize,
    pair: &ViewPair<'_>,
    evidence: &[Evidence],
    settings: &NoveltySettings,
) -> Vec<(Vec<usize>, Segment)> {
    let groups = touching(mixture, removed, settings.segment.link_distance_m);
    let densities: Vec<_> = mixture
        .components
        .iter()
        .map(ComponentDensity::new)
        .collect();
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
        let point = reference_from_own.apply(&patch.mean);
        let best = (0..mixture.len())
            .filter(|k| mixture.weights[*k] > 0.0)
            .map(|k| (densities[k].log_at(&point) + mixture.weights[k].ln(), k))
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
        .filter(|(_, points)| points.len() >= settings.segment.min_points)
        .map(|(components, points)| {
            let segment = super::segment::measure(own, evidence, points, &settings.segment);
            (components, segment)
        })
        .filter(|(_, segment)| {
            // More than half of it must have been in the other view's sight.
            let seen = segment
                .point_indices
                .iter()
                .filter(|i| {
                    matches!(
                        evidence[**i].visibility,
                        Visibility::OnSurface | Visibility::FreeSpace
                    )
                })
                .count();
            2 * seen > segment.point_indices.len()
        })
        .collect()
}

/// Groups of `removed` whose ellipsoids (two sigmas) come within `link_distance_m` of one another.
fn touching(mixture: &Mixture, removed: &[usize], link_distance_m: f64) -> Vec<Vec<usize>> {
    let reach = |g: &Gaussian, towards: &Vector3<f64>| {
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
                .is_none_or(|u| off.norm() - reach(a, &u) - reach(b, &u) <= link_distance_m)
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

/// A Gaussian prepared for evaluation, made one millimetre thicker so that flat ones have a density.
struct ComponentDensity {
    mean: Point3<f64>,
    inverse: Matrix3<f64>,
    log_norm: f64,
}

impl ComponentDensity {
    fn new(g: &Gaussian) -> Self {
        let full = g.covariance + Matrix3::identity() * 1e-6;
        Self {
            mean: g.mean,
            inverse: full.try_inverse().unwrap_or_else(Matrix3::zeros),
            log_norm: -0.5 * full.determinant().max(f64::MIN_POSITIVE).ln(),
        }
    }

    fn log_at(&self, p: &Point3<f64>) -> f64 {
        let d = p - self.mean;
        self.log_norm - 0.5 * d.dot(&(self.inverse * d))
    }
}

fn transformed(mut mixture: Mixture, pose: &Pose) -> Mixture {
    let rotation = pose.rotation.to_rotation_matrix().into_inner();
    for g in &mut mixture.components {
        g.mean = pose * g.mean;
        g.covariance = rotation * g.covariance * rotation.transpose();
    }
    mixture
}
