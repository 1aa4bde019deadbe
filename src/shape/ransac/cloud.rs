//! Points and normals as the search wants them: one array per coordinate, in f32 from one of the
//! cloud's own points.

use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;

/// Oriented points; `index[k]` is the place of point k in what the caller gave.
///
/// f32 from a point of the cloud keeps 1e-7 of its width, a micrometre in a room.
#[derive(Debug, Clone, Default)]
pub(super) struct Cloud {
    /// Coordinates x, y, z from [`origin`](Self::origin), metres.
    pub at: [Vec<f32>; 3],
    /// Coordinates of the unit normals, of either sign.
    pub normal: [Vec<f32>; 3],
    pub index: Vec<u32>,
    /// Origin of this frame in the caller's: a point of the cloud.
    pub origin: Point3<f64>,
    /// Least coordinates of all points, in this frame, metres.
    pub low: [f32; 3],
    /// Lengths of the box around all points, metres.
    pub sides_m: Vector3<f64>,
}

impl Cloud {
    /// All points that are finite and have a finite normal.
    pub fn of(points: &[Point3<f64>], normals: &[Vector3<f64>]) -> Self {
        let finite = |v: &[f64; 3]| v.iter().all(|c| (*c as f32).is_finite());
        let origin = points.iter().find(|p| finite(&(**p).into()));
        let origin = origin.copied().unwrap_or_default();
        let count = points.len().min(normals.len());
        let (points, normals) = (&points[..count], &normals[..count]);
        let at = columns(points, |p| [p.x - origin.x, p.y - origin.y, p.z - origin.z]);
        let normal = columns(normals, |n| [n.x, n.y, n.z]);
        let mut cloud = Self {
            at,
            normal,
            index: (0..count as u32).collect(),
            origin,
            low: [0.0; 3],
            sides_m: Vector3::zeros(),
        };
        let sound = |column: &Vec<f32>| column.iter().fold(true, |all, v| all & v.is_finite());
        if !cloud.at.iter().chain(&cloud.normal).all(sound) {
            let all = cloud
                .at
                .each_ref()
                .into_iter()
                .chain(cloud.normal.each_ref());
            let all: Vec<&Vec<f32>> = all.collect();
            let unsound = |k: &u32| all.iter().any(|column| !column[*k as usize].is_finite());
            let unsound: Vec<u32> = (0..count as u32).filter(unsound).collect();
            cloud.remove(&unsound);
        }
        for (k, column) in cloud.at.iter().enumerate() {
            let (low, high) = ends(column);
            cloud.low[k] = low;
            cloud.sides_m[k] = (high - low).into();
        }
        cloud
    }

    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Length of the box's diagonal, metres.
    pub fn diagonal_m(&self) -> f64 {
        self.sides_m.norm()
    }

    /// Place of point `k`; the origin if there is none.
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
            origin: self.origin,
            low: self.low,
            sides_m: self.sides_m,
        }
    }

    /// Takes out the points at `places` (rising); the others keep their order.
    pub fn remove(&mut self, places: &[u32]) {
        let mut stays = vec![true; self.len()];
        places.iter().for_each(|&k| stays[k as usize] = false);
        // Every place is written and the next one overwrites it unless it stays.
        let mut kept = vec![0; self.len() + 1];
        let mut count = 0;
        for (k, stays) in (0u32..).zip(&stays) {
            kept[count] = k;
            count += usize::from(*stays);
        }
        kept.truncate(count);
        for column in self.at.iter_mut().chain(&mut self.normal) {
            keep(column, &kept);
        }
        keep(&mut self.index, &kept);
    }
}

fn columns<T>(of: &[T], numbers: impl Fn(&T) -> [f64; 3]) -> [Vec<f32>; 3] {
    let mut columns: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; of.len()]);
    let [x, y, z] = &mut columns;
    for (((x, y), z), from) in x.iter_mut().zip(y).zip(z).zip(of) {
        [*x, *y, *z] = numbers(from).map(|v| v as f32);
    }
    columns
}

/// Least and greatest of finite numbers; zeros of none.
fn ends(column: &[f32]) -> (f32, f32) {
    let Some(&first) = column.first() else {
        return (0.0, 0.0);
    };
    column.iter().fold((first, first), |(low, high), &v| {
        (
            if v < low { v } else { low },
            if v > high { v } else { high },
        )
    })
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
    fn coordinates_are_from_a_point_of_the_cloud() {
        let cloud = cloud(101);
        assert_eq!(cloud.origin, Point3::new(1e6, 0.0, 3.0));
        assert_eq!(cloud.place(50), Vector3::new(50.0, -50.0, 0.0));
        assert_eq!(cloud.low, [0.0, -100.0, 0.0]);
        assert_eq!(cloud.sides_m, Vector3::new(100.0, 100.0, 0.0));
        assert_eq!(cloud.normal(7), Vector3::z());
    }

    #[test]
    fn what_is_not_finite_takes_no_part() {
        let mut points = vec![Point3::new(1.0, 2.0, 3.0); 4];
        points[1].y = f64::NAN;
        points[2].z = f64::INFINITY;
        points.swap(0, 2);
        let mut normals = vec![Vector3::x(); 4];
        normals[3].x = f64::NAN;
        let cloud = Cloud::of(&points, &normals);
        assert_eq!(cloud.index, [2]);
        assert!(cloud.place(0).norm() < 1e-12);
        assert_eq!(Cloud::of(&points[..2], &normals[..2]).len(), 0);
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
                assert_eq!(cloud.place(k).x, f64::from(*i));
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
