//! Deviating points become things: seeds, growth, connection, and the gates of a listed novelty.

use super::outline::Outline;
use super::{Evidence, Onlooker, Prepared, SegmentSettings};
use crate::geometry::Grid;
use nalgebra::{Point3, Vector3};

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

impl Thing {
    /// How many rows of its own points lie across its shorter side, whatever the pattern elsewhere.
    pub fn own_rows(&self) -> f64 {
        let [small, large] = self.width_rad;
        (self.points.len() as f64 * small / large.max(1e-9)).sqrt()
    }

    /// How many of its points it has per steradian of its outline.
    pub fn own_density_per_sr(&self) -> f64 {
        let [small, large] = self.width_rad;
        // Of an ellipse: width is sqrt(12) standard deviations, the half axis two.
        let outline_sr = std::f64::consts::PI * small * large / 3.0;
        self.points.len() as f64 / outline_sr.max(1e-12)
    }
}

/// Connects the deviating points of `own` (one evidence per point, judged by the view `other`) and lists the things that
/// pass the gates, largest support first.
pub fn segment(
    own: &Prepared,
    evidence: &[Evidence],
    other: &Onlooker<'_>,
    settings: &SegmentSettings,
) -> Vec<Thing> {
    // What is thinner than the other view's rows may hide between them.
    let spacing_rad = own.rays.spacing_rad.max(other.view.rays.spacing_rad);
    let measured = |members: &[usize]| -> Vec<Thing> {
        connect(own, members, settings)
            .into_iter()
            .filter(|points| points.len() >= settings.least_points)
            .map(|points| measure(own, evidence, points, settings))
            .collect()
    };
    let drawn =
        |thing: &Thing| thing.support >= settings.thin_support && other.lacks(own, thing, settings);
    let sure = grow(own, evidence, |e| e.z, settings);
    let mut things = measured(&sure);
    things.retain(|thing| passes(thing, spacing_rad, settings) || drawn(thing));
    // Where the other view's rays lie further apart than a thing is wide, not all of them end behind it; the nearest do.
    let mut left = evidence.to_vec();
    for i in sure {
        left[i] = Evidence::none(left[i].sight);
    }
    let mut loose = measured(&grow(own, &left, |e| e.z_loose, settings));
    loose.retain(drawn);
    things.extend(loose);
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

/// Seeds, surely off by `z`, and the less sure points near them.
fn grow(
    own: &Prepared,
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
    let grid = Grid::new(&seeds, settings.grow_within_m);
    (0..evidence.len())
        .filter(|i| {
            let e = &evidence[*i];
            z(e) >= settings.seed_sigmas || {
                e.z.max(e.z_loose) >= settings.grow_sigmas && {
                    let p = &points[*i];
                    let reach_m = link_m(own, p, settings.grow_within_m, settings);
                    grid.nearest(p, reach_m).is_some()
                }
            }
        })
        .collect()
}

/// How far apart places lie around `p`, one of them: the third nearest is as far away as the next in a grid. Infinite
/// where there are fewer within `reach_m`.
fn spacing_m(grid: &Grid, p: &Point3<f64>, reach_m: f64) -> f64 {
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

/// Distance within which what lies beside each of `places` may be of one thing with it.
pub(super) fn reaches_m(
    own: &Prepared,
    places: &[Point3<f64>],
    grid: &Grid,
    settings: &SegmentSettings,
) -> Vec<f64> {
    let reach_m = |p: &Point3<f64>| {
        let usual_m = link_m(own, p, settings.link_m, settings);
        let own_m = settings.link_spacings * spacing_m(grid, p, usual_m);
        own_m.clamp(settings.link_m, usual_m)
    };
    places.iter().map(reach_m).collect()
}

/// Connected parts, each ascending, ordered by their first point.
fn connect(own: &Prepared, members: &[usize], settings: &SegmentSettings) -> Vec<Vec<usize>> {
    let places: Vec<Point3<f64>> = members.iter().map(|i| own.view.points[*i]).collect();
    let grid = Grid::new(&places, settings.link_m);
    let reach_m = reaches_m(own, &places, &grid, settings);
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
    let outline = Outline::of(&directions);
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
    let empty = points.iter().filter(|i| evidence[**i].empty).count() as f64 / n;
    Thing {
        points,
        support,
        crowding,
        width_rad: outline.widths_rad(),
        fill: through / outline.solid_angle_sr().max(1e-12),
        empty,
    }
}
