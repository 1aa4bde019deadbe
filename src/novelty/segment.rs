//! Deviating points become things: seeds, growth, connection, and the gates of a listed novelty.

use super::{Evidence, Prepared, SegmentSettings};
use crate::geometry::Grid;
use nalgebra::{Matrix2, Point3, SymmetricEigen, Vector2, Vector3};

/// A connected set of deviating points of one view.
#[derive(Debug, Clone, PartialEq)]
pub struct Thing {
    /// Indices of its points, ascending.
    pub points: Vec<usize>,
    /// Sum of min(z, 20) over its points, relative to the density of beams.
    pub support: f64,
    /// Angular widths as its own sensor saw it, across and along, radians.
    pub width_rad: [f64; 2],
    /// How many times closer than usual the own rows lie there, 1 at least: lines of a tilted sensor converge.
    pub crowding: f64,
    /// Share of the own beams through its outline that hit it.
    pub fill: f64,
    /// Share of its points where the other view got nothing back.
    pub empty: f64,
}

/// Connects the deviating points of `own` (one evidence per point, judged by rows `other_spacing_rad` apart) and lists the
/// things that pass the gates, largest support first.
pub fn segment(
    own: &Prepared,
    evidence: &[Evidence],
    other_spacing_rad: f64,
    settings: &SegmentSettings,
) -> Vec<Thing> {
    let members = grow(own, evidence, settings);
    // What is thinner than the other view's rows may hide between them.
    let spacing_rad = own.rays.spacing_rad.max(other_spacing_rad);
    let mut things: Vec<Thing> = connect(own, &members, settings)
        .into_iter()
        .filter(|points| points.len() >= settings.least_points)
        .map(|points| measure(own, evidence, points, settings))
        .filter(|thing| passes(thing, spacing_rad, settings))
        .collect();
    things.sort_by(|a, b| {
        b.support
            .total_cmp(&a.support)
            .then(a.points.first().cmp(&b.points.first()))
    });
    things
}

fn passes(thing: &Thing, spacing_rad: f64, settings: &SegmentSettings) -> bool {
    let rows = thing.width_rad[0] * thing.crowding / spacing_rad;
    let wide = rows >= settings.compact_width_spacings;
    if thing.fill < settings.least_fill {
        return wide
            && thing.fill >= settings.sparse_fill
            && thing.support >= settings.sparse_support;
    }
    let least_support = if wide && thing.fill >= settings.compact_fill {
        settings.compact_support
    } else if rows >= settings.least_width_spacings {
        settings.least_support
    } else {
        settings.thin_support
    };
    thing.support >= least_support && rows >= settings.thin_width_spacings
}

/// Distance within which points of one thing lie, at the range of `p`. Where points lie closer together than usual it is
/// their own spacing that counts: a dense thing before a thinly seen wall does not reach across to it.
fn link_m(own: &Prepared, p: &Point3<f64>, least_m: f64, settings: &SegmentSettings) -> f64 {
    let beam = p - own.view.origin;
    let range_m = beam.norm();
    let usual_m = settings.link_spacings * own.rays.spacing_rad * range_m;
    if usual_m <= least_m || range_m <= 0.0 {
        return least_m;
    }
    let (_, crowding) = density(own, &(beam / range_m));
    least_m.max(usual_m / crowding.sqrt())
}

/// Own beams per steradian about a direction, and how many times as many as usual those are: 1 at least, for where
/// neighbours are missing the pattern is no sparser than elsewhere.
fn density(own: &Prepared, direction: &Vector3<f64>) -> (f64, f64) {
    let local = own.rays.density_per_sr(direction).max(1.0);
    (local, (local / own.rays.mean_density_per_sr).max(1.0))
}

/// Seeds, and the less sure points near them.
fn grow(own: &Prepared, evidence: &[Evidence], settings: &SegmentSettings) -> Vec<usize> {
    let points = &own.view.points;
    let seeds: Vec<Point3<f64>> = evidence
        .iter()
        .zip(points)
        .filter(|(e, _)| e.z >= settings.seed_sigmas)
        .map(|(_, p)| *p)
        .collect();
    let grid = Grid::new(&seeds, settings.grow_within_m);
    (0..evidence.len())
        .filter(|i| {
            let e = &evidence[*i];
            e.z >= settings.seed_sigmas || {
                e.z.max(e.z_loose) >= settings.grow_sigmas && {
                    let p = &points[*i];
                    let reach_m = link_m(own, p, settings.grow_within_m, settings);
                    grid.nearest(p, reach_m).is_some()
                }
            }
        })
        .collect()
}

/// Connected parts, each ascending, ordered by their first point.
fn connect(own: &Prepared, members: &[usize], settings: &SegmentSettings) -> Vec<Vec<usize>> {
    let places: Vec<Point3<f64>> = members.iter().map(|i| own.view.points[*i]).collect();
    let grid = Grid::new(&places, settings.link_m);
    let reach_m: Vec<f64> = places
        .iter()
        .map(|p| link_m(own, p, settings.link_m, settings))
        .collect();
    let mut parent: Vec<usize> = (0..places.len()).collect();
    for (i, p) in places.iter().enumerate() {
        grid.for_each_within(p, reach_m[i], |j, apart_2| {
            // Near by the measure of both, or far things at long range draw in what is near.
            if apart_2.sqrt() > reach_m[j] {
                return;
            }
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            // The lower index leads, whatever the order of the visits.
            parent[a.max(b)] = a.min(b);
        });
    }
    let mut parts: Vec<Vec<usize>> = vec![Vec::new(); places.len()];
    for (i, member) in members.iter().enumerate() {
        parts[root(&mut parent, i)].push(*member);
    }
    parts.retain(|part| !part.is_empty());
    parts
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// Support, widths and fill of a set of points.
pub fn measure(
    own: &Prepared,
    evidence: &[Evidence],
    points: Vec<usize>,
    settings: &SegmentSettings,
) -> Thing {
    let directions: Vec<Vector3<f64>> = points
        .iter()
        .map(|i| (own.view.points[*i] - own.view.origin).normalize())
        .collect();
    let n = points.len() as f64;
    let axis = directions
        .iter()
        .sum::<Vector3<f64>>()
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::x);
    let across = axis
        .cross(&if axis.z.abs() < 0.9 {
            Vector3::z()
        } else {
            Vector3::x()
        })
        .normalize();
    let up = axis.cross(&across);
    let flat: Vec<Vector2<f64>> = directions
        .iter()
        .map(|d| Vector2::new(d.dot(&across), d.dot(&up)))
        .collect();
    let mean = flat.iter().sum::<Vector2<f64>>() / n;
    let covariance = flat
        .iter()
        .map(|v| (v - mean) * (v - mean).transpose())
        .sum::<Matrix2<f64>>()
        / n;
    let eigen = SymmetricEigen::new(covariance);
    // A uniform spread of width w has the standard deviation w / sqrt(12).
    let width = |v: f64| (12.0 * v.max(0.0)).sqrt();
    let (small, large) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
    let mut support = 0.0;
    let (mut through, mut crowding) = (0.0, 0.0);
    for (i, d) in points.iter().zip(&directions) {
        let (local, crowded) = density(own, d);
        support += evidence[*i].z.max(evidence[*i].z_loose).min(20.0)
            * settings.support_density_per_sr
            / (crowded * own.rays.mean_density_per_sr);
        through += 1.0 / local;
        crowding += crowded / n;
    }
    // Solid angle of its own beams over that of the ellipse with the same moments.
    let outline = std::f64::consts::PI * 4.0 * (small.max(0.0) * large.max(0.0)).sqrt();
    let empty = points.iter().filter(|i| evidence[**i].empty).count() as f64 / n;
    Thing {
        points,
        support,
        crowding,
        width_rad: [width(small), width(large)],
        fill: through / outline.max(1e-12),
        empty,
    }
}
