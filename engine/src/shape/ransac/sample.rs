//! A random sample of the points for the inner loops: one array per coordinate, in f32.

use nalgebra::Vector3;

/// Oriented points in random order, so that every range of them is a random subset. In f32, relative to a point of the
/// cloud: 1e-7 of its width, a micrometre in a room.
#[derive(Debug, Clone, Default)]
pub(super) struct PointSample {
    /// x, y, z in the cloud's frame, metres.
    pub positions: [Vec<f32>; 3],
    /// Of the unit normals, of either sign.
    pub normals: [Vec<f32>; 3],
    /// Lower corner of the box around all points of the cloud, metres.
    pub low: [f32; 3],
    /// Sides of that box, metres.
    pub sides_m: Vector3<f64>,
}

impl PointSample {
    pub(super) fn with_capacity(count: usize, low: [f32; 3], sides_m: Vector3<f64>) -> Self {
        let columns = || std::array::from_fn(|_| Vec::with_capacity(count));
        Self {
            positions: columns(),
            normals: columns(),
            low,
            sides_m,
        }
    }

    pub(super) fn push(&mut self, position: &Vector3<f64>, normal: &Vector3<f64>) {
        for k in 0..3 {
            self.positions[k].push(position[k] as f32);
            self.normals[k].push(normal[k] as f32);
        }
    }

    pub(super) fn len(&self) -> usize {
        self.positions[0].len()
    }

    /// Position of point `k`; the origin if there is none.
    pub(super) fn position(&self, k: u32) -> Vector3<f64> {
        gather(&self.positions, k)
    }

    /// Normal of point `k`; zero if there is none.
    pub(super) fn normal(&self, k: u32) -> Vector3<f64> {
        gather(&self.normals, k)
    }
}

fn gather(columns: &[Vec<f32>; 3], k: u32) -> Vector3<f64> {
    let get = |a: usize| columns[a].get(k as usize).copied().unwrap_or(0.0);
    Vector3::new(get(0).into(), get(1).into(), get(2).into())
}

#[cfg(test)]
mod tests {
    use super::PointSample;
    use nalgebra::Vector3;

    #[test]
    fn points_and_normals_are_kept_in_f32() {
        let mut sample = PointSample::with_capacity(2, [0.0; 3], Vector3::zeros());
        assert_eq!((sample.len(), sample.position(0)), (0, Vector3::zeros()));
        sample.push(&Vector3::new(0.1, -2.0, 3.0), &Vector3::x());
        sample.push(&Vector3::y(), &Vector3::z());
        assert_eq!(sample.len(), 2);
        assert_eq!(
            sample.position(0),
            Vector3::new(f64::from(0.1f32), -2.0, 3.0)
        );
        assert_eq!(
            (sample.normal(0), sample.normal(1)),
            (Vector3::x(), Vector3::z())
        );
    }
}
