//! A random sample of the points as the inner loops want it: one array per coordinate, in f32.

use nalgebra::Vector3;

/// Oriented points in random order, so that every run of them is a random subset.
///
/// f32 from a point of the cloud keeps 1e-7 of its width, a micrometre in a room.
#[derive(Debug, Clone, Default)]
pub(super) struct Sample {
    /// Coordinates x, y, z in the cloud's frame, metres.
    pub at: [Vec<f32>; 3],
    /// Coordinates of the unit normals, of either sign.
    pub normal: [Vec<f32>; 3],
    /// Least coordinates of all points of the cloud, metres.
    pub low: [f32; 3],
    /// Lengths of the box around all points of the cloud, metres.
    pub sides_m: Vector3<f64>,
}

impl Sample {
    /// An empty one with room for `count` points.
    pub fn with_room(count: usize, low: [f32; 3], sides_m: Vector3<f64>) -> Self {
        let columns = || std::array::from_fn(|_| Vec::with_capacity(count));
        Self {
            at: columns(),
            normal: columns(),
            low,
            sides_m,
        }
    }

    pub fn push(&mut self, at: &Vector3<f64>, normal: &Vector3<f64>) {
        for k in 0..3 {
            self.at[k].push(at[k] as f32);
            self.normal[k].push(normal[k] as f32);
        }
    }

    pub fn len(&self) -> usize {
        self.at[0].len()
    }

    /// Place of point `k`; the origin if there is none.
    pub fn place(&self, k: u32) -> Vector3<f64> {
        gathered(&self.at, k)
    }

    /// Normal of point `k`.
    pub fn normal(&self, k: u32) -> Vector3<f64> {
        gathered(&self.normal, k)
    }
}

fn gathered(columns: &[Vec<f32>; 3], k: u32) -> Vector3<f64> {
    let get = |a: usize| columns[a].get(k as usize).copied().unwrap_or(0.0);
    Vector3::new(get(0).into(), get(1).into(), get(2).into())
}

#[cfg(test)]
mod tests {
    use super::Sample;
    use nalgebra::Vector3;

    #[test]
    fn points_and_normals_come_back_in_f32() {
        let mut sample = Sample::with_room(2, [0.0; 3], Vector3::zeros());
        assert_eq!((sample.len(), sample.place(0)), (0, Vector3::zeros()));
        sample.push(&Vector3::new(0.1, -2.0, 3.0), &Vector3::x());
        sample.push(&Vector3::y(), &Vector3::z());
        assert_eq!(sample.len(), 2);
        assert_eq!(sample.place(0), Vector3::new(f64::from(0.1f32), -2.0, 3.0));
        assert_eq!(
            (sample.normal(0), sample.normal(1)),
            (Vector3::x(), Vector3::z())
        );
    }
}
