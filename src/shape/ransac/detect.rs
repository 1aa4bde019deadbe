//! Efficient RANSAC: draw locally, score by subsets, take the best once a better one is unlikely,
//! refit, remove, go on.

use super::candidate::{Oriented, agrees, suggested};
use super::cells::Cells;
use super::connect::largest_patch;
use super::normals::spacing_m;
use super::refit::refitted;
use crate::shape::constants::{
    BATCH, CONNECTED_M, CONSENSUS_ANGLE_RAD, ENOUGH, FIRST_SUBSET, LARGEST_DIAGONALS,
    LEAST_PART_SHARE, LEAST_POINTS, MOST_CANDIDATES, MOST_DRAWS, SIMPLER_SHARE,
};
use crate::shape::primitive::{Plane, Primitive, Sphere};
use nalgebra::{Point3, Rotation3, Vector3};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What makes a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RansacSettings {
    /// Greatest distance of an inlier from the surface, metres.
    pub epsilon_m: f64,
    /// Greatest angle between an inlier's normal and the surface's, radians.
    pub normal_angle_rad: f64,
    /// Least number of inliers.
    pub min_points: usize,
    /// Search until a better primitive was missed with at most the rest of this probability.
    pub probability: f64,
    /// Stop after this many primitives.
    pub most: usize,
    /// Side of the cells through which inliers must hang together, metres; `None` takes twice the
    /// distance to the sixth neighbour.
    pub cell_m: Option<f64>,
}

impl RansacSettings {
    /// What suits one novelty of `points` points: parts of a twelfth of them at least, found with
    /// 99 % probability, at most `most` of them.
    pub fn derived(points: usize, epsilon_m: f64, most: usize) -> Self {
        let share = (points as f64 * LEAST_PART_SHARE).ceil() as usize;
        Self {
            epsilon_m,
            normal_angle_rad: CONSENSUS_ANGLE_RAD,
            min_points: share.max(LEAST_POINTS),
            probability: 0.99,
            most,
            cell_m: Some(CONNECTED_M),
        }
    }
}

/// A primitive and the points that lie on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Detected {
    /// The refitted primitive with the extent of its inliers.
    pub primitive: Primitive,
    /// Indices of its points, rising.
    pub inliers: Vec<usize>,
}

struct Candidate {
    primitive: Primitive,
    level: u32,
    seen: usize,
    hits: usize,
}

impl Candidate {
    /// Expected inliers among `n` and the half-width of one standard deviation: the
    /// hypergeometric estimate from those seen.
    fn estimate(&self, n: usize) -> (f64, f64) {
        let (n, seen, hits) = (n as f64, self.seen as f64, self.hits as f64);
        if seen >= n {
            return (hits, 0.0);
        }
        let share = hits / seen.max(1.0);
        let spread =
            (share * (1.0 - share) / seen.max(1.0) * (n - seen) / (n - 1.0).max(1.0)).sqrt();
        (share * n, spread.max(0.5 / seen.max(1.0)) * n)
    }

    fn upper(&self, n: usize) -> f64 {
        let (expected, spread) = self.estimate(n);
        expected + spread
    }
}

/// The state of one search over the points that are left.
struct Search<'a> {
    oriented: &'a [Oriented],
    points: &'a [Point3<f64>],
    settings: &'a RansacSettings,
    cos_angle: f64,
    cell_m: f64,
    largest_m: f64,
}

impl Search<'_> {
    fn fits(&self, primitive: &Primitive, i: u32, epsilon_m: f64) -> bool {
        let point = self.oriented.get(i as usize);
        point.is_some_and(|p| agrees(primitive, p, epsilon_m, self.cos_angle))
    }

    fn extend(&self, c: &mut Candidate, alive: &[u32], to: usize) {
        let to = to.min(alive.len());
        let more = alive.get(c.seen..to).unwrap_or_default();
        let hit = |i: &&u32| self.fits(&c.primitive, **i, self.settings.epsilon_m);
        c.hits += more.iter().filter(hit).count();
        c.seen = c.seen.max(to);
    }

    /// The largest connected patch of points within `epsilon_m`.
    fn patch(&self, primitive: &Primitive, alive: &[u32], epsilon_m: f64) -> Vec<u32> {
        let near: Vec<u32> = alive
            .iter()
            .copied()
            .filter(|&i| self.fits(primitive, i, epsilon_m))
            .collect();
        largest_patch(self.points, &near, self.cell_m)
    }

    fn at(&self, indices: &[u32]) -> Vec<Point3<f64>> {
        let points = indices.iter().filter_map(|&i| self.points.get(i as usize));
        points.copied().collect()
    }

    /// Refits on the patch within 3 epsilon and collects the inliers again.
    fn settled(&self, primitive: &Primitive, alive: &[u32]) -> (Primitive, Vec<u32>) {
        let wide = self.patch(primitive, alive, 3.0 * self.settings.epsilon_m);
        let mut fitted = refitted(primitive, &self.at(&wide));
        let mut inliers = self.patch(&fitted, alive, self.settings.epsilon_m);
        for _ in 0..2 {
            let again = refitted(&fitted, &self.at(&inliers));
            let kept = self.patch(&again, alive, self.settings.epsilon_m);
            if kept.len() < inliers.len() {
                break;
            }
            (fitted, inliers) = (again, kept);
        }
        // Extents are those of the final inliers.
        (refitted(&fitted, &self.at(&inliers)), inliers)
    }

    /// The best of the surface and of simpler ones on the same points: a huge ball is a plane.
    fn simplest(&self, primitive: &Primitive, alive: &[u32]) -> (Primitive, Vec<u32>) {
        let (fitted, inliers) = self.settled(primitive, alive);
        let simpler = match primitive {
            Primitive::Plane(_) => Vec::new(),
            Primitive::Sphere(_) => vec![start_plane(fitted.centre())],
            Primitive::Cylinder(c) => vec![
                start_plane(fitted.centre()),
                Primitive::Sphere(Sphere {
                    centre: fitted.centre(),
                    radius_m: c.radius_m,
                }),
            ],
        };
        let own = self.at(&inliers);
        for start in simpler {
            let other = refitted(&start, &own);
            let kept = self.patch(&other, &inliers, self.settings.epsilon_m);
            if kept.len() as f64 >= SIMPLER_SHARE * inliers.len() as f64 {
                return (other, kept);
            }
        }
        (fitted, inliers)
    }

    /// Probability that one draw hits a primitive of `size` points among `n` (section 4.3 of
    /// Schnabel et al. with three points and `levels` cell sizes).
    fn chance(size: f64, n: usize, levels: u32) -> f64 {
        (size / (n as f64 * f64::from(levels) * 4.0)).clamp(0.0, 1.0)
    }

    fn sure(&self, chance: f64, draws: usize) -> bool {
        1.0 - (1.0 - chance).powf(draws as f64) >= self.settings.probability
    }

    /// The next primitive among `alive` (in random order), or `None` if none is left that the
    /// settings would want found.
    fn next(&self, alive: &[u32], rng: &mut ChaCha8Rng) -> Option<(Primitive, Vec<u32>)> {
        let n = alive.len();
        let cells = Cells::new(self.points, alive, 4.0 * self.settings.epsilon_m);
        let least = self.settings.min_points as f64;
        let mut levels = Levels::new(cells.levels);
        let mut candidates: Vec<Candidate> = Vec::new();
        let mut draws = 0;
        while draws < MOST_DRAWS {
            for _ in 0..BATCH {
                draws += 1;
                let level = levels.draw(rng);
                for primitive in self.drawn(&cells, level, rng) {
                    let mut c = Candidate {
                        primitive,
                        level,
                        seen: 0,
                        hits: 0,
                    };
                    self.extend(&mut c, alive, FIRST_SUBSET);
                    levels.credit(level, c.estimate(n).0);
                    if c.upper(n) >= least {
                        candidates.push(c);
                    }
                }
            }
            levels.reweigh();
            candidates.sort_by(|a, b| b.upper(n).total_cmp(&a.upper(n)));
            candidates.truncate(MOST_CANDIDATES);
            let exhausted = self.sure(Self::chance(least, n, cells.levels), draws);
            while let Some(best) = self.best(&mut candidates, alive) {
                let (expected, _) = best.estimate(n);
                let certain = self.sure(Self::chance(expected, n, cells.levels), draws);
                if expected < least || !(certain || exhausted || draws >= MOST_DRAWS) {
                    candidates.push(best);
                    break;
                }
                // Cheaply first: most junk does not hang together even roughly.
                let rough = self.patch(&best.primitive, alive, 3.0 * self.settings.epsilon_m);
                if rough.len() < self.settings.min_points {
                    continue;
                }
                let (primitive, inliers) = self.simplest(&best.primitive, alive);
                if inliers.len() >= self.settings.min_points {
                    return Some((primitive, inliers));
                }
                // Its points do not hang together: it was never one surface.
                levels.credit(best.level, -expected);
            }
            if exhausted {
                return None;
            }
        }
        None
    }

    fn drawn(
        &self,
        cells: &Cells,
        level: u32,
        rng: &mut ChaCha8Rng,
    ) -> impl Iterator<Item = Primitive> + use<> {
        let three = cells.draw(level, 3, rng).and_then(|drawn| {
            let mut at = drawn.iter().filter_map(|&i| self.oriented.get(i as usize));
            Some([*at.next()?, *at.next()?, *at.next()?])
        });
        let (epsilon_m, cos_angle) = (self.settings.epsilon_m, self.cos_angle);
        let largest_m = self.largest_m;
        three
            .into_iter()
            .flat_map(move |t| suggested(&t, epsilon_m, cos_angle, largest_m))
    }

    /// Takes out the best candidate, scoring the promising ones on more points until it stands out.
    fn best(&self, candidates: &mut Vec<Candidate>, alive: &[u32]) -> Option<Candidate> {
        let n = alive.len();
        loop {
            let top = (0..candidates.len())
                .rev()
                .max_by(|&a, &b| candidates[a].upper(n).total_cmp(&candidates[b].upper(n)))?;
            let seen = candidates.get(top)?.seen;
            if seen >= n.min(ENOUGH) {
                return Some(candidates.swap_remove(top));
            }
            self.extend(candidates.get_mut(top)?, alive, 2 * seen.max(FIRST_SUBSET));
        }
    }
}

/// How often each octree level is drawn from: mostly as its candidates scored.
struct Levels {
    share: Vec<f64>,
    score: Vec<f64>,
}

impl Levels {
    fn new(count: u32) -> Self {
        let count = count.max(1) as usize;
        Self {
            share: vec![1.0 / count as f64; count],
            score: vec![0.0; count],
        }
    }

    fn draw(&self, rng: &mut ChaCha8Rng) -> u32 {
        let mut left: f64 = rng.random();
        let level = self.share.iter().position(|s| {
            left -= s;
            left <= 0.0
        });
        level.unwrap_or(self.share.len() - 1) as u32
    }

    fn credit(&mut self, level: u32, score: f64) {
        if let Some(s) = self.score.get_mut(level as usize) {
            *s = (*s + score).max(0.0);
        }
    }

    fn reweigh(&mut self) {
        let rated: Vec<f64> = self
            .score
            .iter()
            .zip(&self.share)
            .map(|(s, p)| s / p)
            .collect();
        let total: f64 = rated.iter().sum();
        if total > 0.0 {
            let even = 0.1 / self.share.len() as f64;
            for (share, rate) in self.share.iter_mut().zip(rated) {
                *share = 0.9 * rate / total + even;
            }
        }
    }
}

fn start_plane(centre: Point3<f64>) -> Primitive {
    Primitive::Plane(Plane {
        centre,
        rotation: Rotation3::identity(),
        sides_m: [0.0; 2],
    })
}

/// Primitives with disjoint inliers, in the order found (mostly the largest first); points of no
/// primitive are the remainder. `normals[i]` is the unit normal of `points[i]`, of either sign;
/// points without one, or with coordinates that are not finite, take no part.
pub fn detect(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    settings: &RansacSettings,
    seed: u64,
) -> Vec<Detected> {
    let oriented: Vec<Oriented> = points
        .iter()
        .copied()
        .zip(normals.iter().copied())
        .collect();
    let finite = |(p, n): &Oriented| p.iter().chain(n.iter()).all(|v| v.is_finite());
    let mut alive: Vec<u32> = (0u32..)
        .zip(&oriented)
        .filter(|(_, o)| finite(o))
        .map(|(i, _)| i)
        .collect();
    let kept: Vec<Point3<f64>> = alive.iter().map(|&i| points[i as usize]).collect();
    let diagonal = kept.first().map_or(0.0, |first| {
        let (low, high) = kept
            .iter()
            .fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
        (high - low).norm()
    });
    let search = Search {
        oriented: &oriented,
        points,
        settings,
        cos_angle: settings.normal_angle_rad.cos(),
        cell_m: settings
            .cell_m
            .unwrap_or_else(|| 2.0 * spacing_m(&kept))
            .max(2.0 * settings.epsilon_m)
            .max(1e-9),
        largest_m: LARGEST_DIAGONALS * diagonal,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    alive.shuffle(&mut rng);
    let mut found = Vec::new();
    while found.len() < settings.most && alive.len() >= settings.min_points.max(3) {
        let Some((primitive, inliers)) = search.next(&alive, &mut rng) else {
            break;
        };
        let mut taken = vec![false; points.len()];
        inliers.iter().for_each(|&i| taken[i as usize] = true);
        alive.retain(|&i| !taken[i as usize]);
        let mut inliers: Vec<usize> = inliers.into_iter().map(|i| i as usize).collect();
        inliers.sort_unstable();
        found.push(Detected { primitive, inliers });
    }
    found
}
