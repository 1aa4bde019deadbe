//! The PLY writer: binary little-endian, float32 x y z.

use nalgebra::Point3;

/// A PLY of `points` in metres, rounded to float32; non-finite ones are kept.
pub fn write_ply(points: &[Point3<f64>]) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nend_header\n",
        points.len()
    )
    .into_bytes();
    out.reserve(12 * points.len());
    for point in points {
        for c in point.iter() {
            out.extend_from_slice(&(*c as f32).to_le_bytes());
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::write_ply;
    use crate::formats::read_cloud;
    use nalgebra::Point3;
    use proptest::prelude::*;

    /// What a cloud may hold.
    fn coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![-1e11_f32..=1e11, Just(f32::NAN), Just(f32::NEG_INFINITY)]
    }

    proptest! {
        #[test]
        fn a_written_cloud_is_read_back(
            coords in proptest::collection::vec(proptest::array::uniform3(coordinate()), 0..50),
        ) {
            let points: Vec<_> = coords.iter().map(|c| Point3::from(c.map(f64::from))).collect();
            let bytes = write_ply(&points);
            let cloud = read_cloud(&bytes, Some("ply")).expect("our own PLY");
            prop_assert_eq!(cloud.points.len(), points.len());
            prop_assert_eq!(cloud.normals, None);
            // Byte equality is equality with NaN allowed.
            prop_assert_eq!(write_ply(&cloud.points), bytes);
        }
    }
}
