//! Segmentation of deviating points: seeds, growth, connection, and the gates of a listed novelty
//! (`docs/novelty.md section 6`).

mod cut_parts;

use super::outline::Outline;
use super::{Evidence, ObserverView, PreparedView, Segment, SegmentSettings};
use crate::geometry::PointGrid;
use cut_parts::join_parts;
use nalgebra::{Point3, Vector3};

/// Segments of the deviating points of `own` that pass the gates, largest support first. `evidence` is per point, from the
/// view `observer`.
pub(super) fn segment(
    own: &PreparedView,
    evidence: &[Evidence],
    observer: &ObserverView<'_>,
    settings: &SegmentSettings,
) -> Vec<Segment> {
    // What is thinner than the observer's rows may be hidden between them.
    let spacing_rad = own.rays.spacing_rad.max(observer.view.rays.spacing_rad);
    let measured = |members: &[usize]| -> Vec<Segment> {
        connect(own, members, settings)
            .into_iter()
            .filter(|points| points.len() >= settings.min_points)
            .map(|points| measure(own, evidence, points, settings))
            .collect()
    };
    let oversampled = |segment: &Segment| {
        segment.support >= settings.thin_min_support
            && observer.is_undersampled(own, segment, settings)
    };
    let sure = grow(own, evidence, |e| e.z, settings);
    let (whole, parts): (Vec<_>, Vec<_>) = measured(&sure)
        .into_iter()
        .partition(|segment| passes(segment, spacing_rad, settings) || oversampled(segment));
    let joined = join_parts(own, &whole, &parts).into_iter().zip(whole);
    let mut segments: Vec<Segment> = joined
        .map(|(points, segment)| {
            if points.len() == segment.point_indices.len() {
                return segment;
            }
            measure(own, evidence, points, settings)
        })
        .collect();
    // Where the observer's rays are further apart than an object is wide, only the nearest of them end behind it.
    let mut remaining = evidence.to_vec();
    for i in sure {
        remaining[i] = Evidence::none(remaining[i].visibility);
    }
    let mut loose = measured(&grow(own, &remaining, |e| e.z_loose, settings));
    loose.retain(oversampled);
    segments.extend(loose);
    segments.sort_by(|a, b| {
        b.support
            .total_cmp(&a.support)
            .then(a.point_indices.first().cmp(&b.point_indices.first()))
    });
    segments
}

fn passes(segment: &Segment, spacing_rad: f64, settings: &SegmentSettings) -> bool {
    let rows = segment.width_rad[0] * segment.crowding / spacing_rad;
    let wide = rows >= settings.compact_min_width_spacings;
    if segment.fill < settings.min_fill {
        return wide
            && segment.fill >= settings.sparse_min_fill
            && segment.support >= settings.sparse_min_support;
    }
    let min_support = if wide && segment.fill >= settings.compact_min_fill {
        settings.compact_min_support
    } else if rows >= settings.min_width_spacings {
        settings.min_support
    } else {
        settings.thin_min_support
    };
    segment.support >= min_support && rows >= settings.thin_min_width_spacings
}

/// Linking distance at the range of `p`: the row spacing there, less where beams are denser than usual, so that a dense object
/// in front of a thinly seen wall does not reach across to it.
fn link_m(own: &PreparedView, p: &Point3<f64>, min_m: f64, settings: &SegmentSettings) -> f64 {
    let beam = p - own.view.origin;
    let range_m = beam.norm();
    let usual_m = settings.link_spacings * own.rays.spacing_rad * range_m;
    if usual_m <= min_m || range_m <= 0.0 {
        return min_m;
    }
    let (_, crowding) = density(own, &(beam / range_m));
    min_m.max(usual_m / crowding.sqrt())
}

/// Own beams per steradian about a direction, and that over their mean density: at least 1, since missing neighbours do not
/// make the pattern sparser.
fn density(own: &PreparedView, direction: &Vector3<f64>) -> (f64, f64) {
    let local = own.rays.density_per_sr(direction).max(1.0);
    (local, (local / own.rays.mean_density_per_sr).max(1.0))
}

/// Seeds, which deviate clearly by `z`, and the points near them that deviate less.
fn grow(
    own: &PreparedView,
    evidence: &[Evidence],
    z: impl Fn(&Evidence) -> f64,
    settings: &SegmentSettings,
) -> Vec<usize> {
    let points = &own.view.points;
    let seeds: Vec<Point3<f64>> = evidence
        .iter()
        .zip(points)
        .filter(|(e, _)| z(e) >= settings.seed_sigmas)
        .map(|(_, p)| *p)
        .collect();
    let grid = PointGrid::new(&seeds, settings.grow_distance_m);
    (0..evidence.len())
        .filter(|i| {
            let e = &evidence[*i];
            z(e) >= settings.seed_sigmas || {
                e.z.max(e.z_loose) >= settings.grow_sigmas && {
                    let p = &points[*i];
                    let reach_m = link_m(own, p, settings.grow_distance_m, settings);
                    grid.nearest(p, reach_m).is_some()
                }
            }
        })
        .collect()
}

/// Spacing of the points around `p`, which is one of them: in a regular grid the third nearest is one spacing away. Infinite
/// if there are fewer within `reach_m`.
fn spacing_m(grid: &PointGrid, p: &Point3<f64>, reach_m: f64) -> f64 {
    // The nearest of all is `p` itself.
    let mut nearest = [f64::INFINITY; 4];
    grid.for_each_within(p, reach_m, |_, apart_2| {
        if apart_2 < nearest[3] {
            nearest[3] = apart_2;
            nearest.sort_unstable_by(f64::total_cmp);
        }
    });
    nearest[3].sqrt()
}

/// Distance within which points are linked to each of `points`.
pub(super) fn reaches_m(
    own: &PreparedView,
    points: &[Point3<f64>],
    grid: &PointGrid,
    settings: &SegmentSettings,
) -> Vec<f64> {
    let reach_m = |p: &Point3<f64>| {
        let usual_m = link_m(own, p, settings.link_distance_m, settings);
        let own_m = settings.link_spacings * spacing_m(grid, p, usual_m);
        own_m.clamp(settings.link_distance_m, usual_m)
    };
    points.iter().map(reach_m).collect()
}

/// Connected parts, each ascending, ordered by their first point.
fn connect(own: &PreparedView, members: &[usize], settings: &SegmentSettings) -> Vec<Vec<usize>> {
    let points: Vec<Point3<f64>> = members.iter().map(|i| own.view.points[*i]).collect();
    let grid = PointGrid::new(&points, settings.link_distance_m);
    let reach_m = reaches_m(own, &points, &grid, settings);
    let mut parent: Vec<usize> = (0..points.len()).collect();
    for (i, p) in points.iter().enumerate() {
        grid.for_each_within(p, reach_m[i], |j, apart_2| {
            // Within the reach of both, or far points with a long reach would link to near ones.
            if apart_2.sqrt() > reach_m[j] {
                return;
            }
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            // The lower index becomes the root, whatever the order.
            parent[a.max(b)] = a.min(b);
        });
    }
    let mut parts: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
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

/// The segment of the points with these indices: support, widths and fill.
pub fn measure(
    own: &PreparedView,
    evidence: &[Evidence],
    point_indices: Vec<usize>,
    settings: &SegmentSettings,
) -> Segment {
    let directions: Vec<Vector3<f64>> = point_indices
        .iter()
        .map(|i| (own.view.points[*i] - own.view.origin).normalize())
        .collect();
    let n = point_indices.len() as f64;
    let outline = Outline::new(&directions);
    let mut support = 0.0;
    let (mut through, mut crowding) = (0.0, 0.0);
    for (i, d) in point_indices.iter().zip(&directions) {
        let (local, crowded) = density(own, d);
        support += evidence[*i].z.max(evidence[*i].z_loose).min(20.0)
            * settings.support_density_per_sr
            / (crowded * own.rays.mean_density_per_sr);
        through += 1.0 / local;
        crowding += crowded / n;
    }
    Segment {
        point_indices,
        support,
        crowding,
        width_rad: outline.widths_rad(),
        fill: through / outline.solid_angle_sr().max(1e-12),
    }
}
