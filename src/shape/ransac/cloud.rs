//! Points and normals as the search wants them: one array per coordinate, in f32 about the middle
//! of the cloud.

use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;

/// Oriented points; `index[k]` is the place of point k in what the caller gave.
///
/// f32 about the middle keeps 1e-7 of the cloud's width, a micrometre in a room.
#[derive(Debug, Clone, Default)]
pub(super) struct Cloud {
    /// Coordinates x, y, z from [`middle`](Self::middle), metres.
    pub at: [Vec<f32>; 3],
    /// Coordinates of the unit normals, of either sign.
    pub normal: [Vec<f32>; 3],
    pub index: Vec<u32>,
    /// Origin of this frame in the caller's.
    pub middle: Point3<f64>,
    /// Lengths of the box around all points, metres.
    pub sides_m: Vector3<f64>,
}

impl Cloud {
    /// All points that are finite and have a finite normal.
    pub fn of(points: &[Point3<f64>], normals: &[Vector3<f64>]) -> Self {
        let oriented = || points.iter().zip(normals);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut sound = 0;
        for (p, _) in oriented().filter(is_finite) {
            sound += 1;
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        if sound == 0 {
            return Self::default();
        }
        let middle: [f64; 3] = std::array::from_fn(|k| f64::midpoint(low[k], high[k]));
        let all = sound == points.len();
        // One column after the other: where every point counts, their lengths are known.
        let at = |k: usize| -> Vec<f32> {
            let narrow = |p: &Point3<f64>| (p[k] - middle[k]) as f32;
            if all {
                points.iter().map(narrow).collect()
            } else {
                let sound = oriented().filter(is_finite);
                sound.map(|(p, _)| narrow(p)).collect()
            }
        };
        let normal = |k: usize| -> Vec<f32> {
            if all {
                normals.iter().take(sound).map(|n| n[k] as f32).collect()
            } else {
                let sound = oriented().filter(is_finite);
                sound.map(|(_, n)| n[k] as f32).collect()
            }
        };
        let (at, normal) = rayon::join(|| std::array::from_fn(at), || std::array::from_fn(normal));
        let index = (0u32..).zip(oriented());
        Self {
            at,
            normal,
            index: index
                .filter(|(_, o)| all || is_finite(o))
                .map(|(i, _)| i)
                .collect(),
            middle: Point3::from(middle),
            sides_m: Vector3::from_fn(|k, _| high[k] - low[k]),
        }
    }

    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Length of the box's diagonal, metres.
    pub fn diagonal_m(&self) -> f64 {
        self.sides_m.norm()
    }

    /// Place of point `k`; the middle if there is none.
    pub fn place(&self, k: u32) -> Vector3<f64> {
        gathered(&self.at, k)
    }

    /// The same in the width in which it is kept.
    pub fn narrow_place(&self, k: u32) -> Vector3<f32> {
        let get = |a: usize| self.at[a].get(k as usize).copied().unwrap_or(0.0);
        Vector3::new(get(0), get(1), get(2))
    }

    /// Normal of point `k`.
    pub fn normal(&self, k: u32) -> Vector3<f64> {
        gathered(&self.normal, k)
    }

    /// `count` different points (all, if there are fewer) in random order, with their places here
    /// as index.
    pub fn sample(&self, count: usize, rng: &mut ChaCha8Rng) -> Self {
        let count = count.min(self.len());
        let chosen = rand::seq::index::sample(rng, self.len(), count);
        let index: Vec<u32> = chosen.iter().map(|k| k as u32).collect();
        Self {
            at: std::array::from_fn(|a| taken(&self.at[a], &index)),
            normal: std::array::from_fn(|a| taken(&self.normal[a], &index)),
            index,
            middle: self.middle,
            sides_m: self.sides_m,
        }
    }

    /// Takes out the points at `places` (rising); the others keep their order.
    pub fn remove(&mut self, places: &[u32]) {
        let mut gone = places.iter().copied().peekable();
        let kept: Vec<u32> = (0..self.len() as u32)
            .filter(|k| gone.next_if_eq(k).is_none())
            .collect();
        for column in self.at.iter_mut().chain(&mut self.normal) {
            keep(column, &kept);
        }
        keep(&mut self.index, &kept);
    }
}

fn is_finite(&(p, n): &(&Point3<f64>, &Vector3<f64>)) -> bool {
    // A sum is finite only if all its terms are, but for sums beyond the largest number.
    (p.x + p.y + p.z + n.x + n.y + n.z).is_finite()
}

fn gathered(columns: &[Vec<f32>; 3], k: u32) -> Vector3<f64> {
    let get = |a: usize| columns[a].get(k as usize).copied().unwrap_or(0.0);
    Vector3::new(get(0).into(), get(1).into(), get(2).into())
}

fn taken(column: &[f32], places: &[u32]) -> Vec<f32> {
    let values = places.iter().filter_map(|&k| column.get(k as usize));
    values.copied().collect()
}

/// What stands at `kept` (rising) and nothing else.
fn keep<T: Copy>(column: &mut Vec<T>, kept: &[u32]) {
    for (to, &from) in kept.iter().enumerate() {
        column[to] = column[from as usize];
    }
    column.truncate(kept.len());
}

#[cfg(test)]
mod tests {
    use super::Cloud;
    use nalgebra::{Point3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn cloud(n: u32) -> Cloud {
        let points: Vec<_> = (0..n)
            .map(|i| Point3::new(1e6 + f64::from(i), -f64::from(i), 3.0))
            .collect();
        Cloud::of(&points, &vec![Vector3::z(); n as usize])
    }

    #[test]
    fn coordinates_are_about_the_middle_of_the_box() {
        let cloud = cloud(101);
        assert_eq!(cloud.middle, Point3::new(1e6 + 50.0, -50.0, 3.0));
        assert_eq!(cloud.place(0), Vector3::new(-50.0, 50.0, 0.0));
        assert_eq!(cloud.normal(7), Vector3::z());
    }

    #[test]
    fn what_is_not_finite_takes_no_part() {
        let mut points = vec![Point3::new(1.0, 2.0, 3.0); 4];
        points[1].y = f64::NAN;
        points[2].z = f64::INFINITY;
        let mut normals = vec![Vector3::x(); 4];
        normals[3].x = f64::NAN;
        let cloud = Cloud::of(&points, &normals);
        assert_eq!(cloud.index, [0]);
        assert!(cloud.place(0).norm() < 1e-12);
        assert_eq!(Cloud::of(&points[1..3], &normals[1..3]).len(), 0);
    }

    #[test]
    fn points_taken_out_leave_the_others_in_order() {
        for gone in [
            &[][..],
            &[0],
            &[9],
            &[0, 1, 2, 9],
            &[3, 5, 6],
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
        ] {
            let mut cloud = cloud(10);
            cloud.remove(gone);
            let left: Vec<u32> = (0..10).filter(|k| !gone.contains(k)).collect();
            assert_eq!(cloud.index, left);
            for (k, i) in (0u32..).zip(&left) {
                assert_eq!(cloud.place(k).x, f64::from(*i) - 4.5);
            }
        }
    }

    #[test]
    fn a_sample_has_no_point_twice() {
        let cloud = cloud(100);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for count in [0, 1, 50, 100, 300] {
            let sample = cloud.sample(count, &mut rng);
            let mut index = sample.index.clone();
            index.sort_unstable();
            index.dedup();
            assert_eq!(index.len(), count.min(100));
            for (k, &i) in (0u32..).zip(&sample.index) {
                assert_eq!(sample.place(k), cloud.place(i));
            }
        }
    }
}
