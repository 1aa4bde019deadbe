//! Stored form of a view: version, origin, free range, noise law, tilt axis, points, directions without a return;
//! little-endian f64, so that a comparison can be repeated exactly.

use super::error::BlobError;
use crate::geometry::{NoiseLaw, View};
use nalgebra::{Point3, Unit, Vector3};

const VERSION: u8 = 1;

/// Numbers before the points: origin (3), free range, noise law (2), tilt axis (3), two counts.
const HEADER_NUMBERS: usize = 11;

/// Encodes a view.
pub fn encode_view(view: &View) -> Vec<u8> {
    let numbers = HEADER_NUMBERS + 3 * (view.points.len() + view.no_return.len());
    let mut bytes = Vec::with_capacity(1 + 8 * numbers);
    bytes.push(VERSION);
    let mut put = |x: f64| bytes.extend_from_slice(&x.to_le_bytes());
    let noise = view.noise.unwrap_or(NoiseLaw {
        at_zero_m: f64::NAN,
        per_m: f64::NAN,
    });
    // Unknown values are stored as NaN.
    let axis = view
        .tilt_axis
        .map_or([f64::NAN; 3], |axis| axis.into_inner().into());
    for x in view.origin.iter() {
        put(*x);
    }
    for x in [
        view.free_range_m,
        noise.at_zero_m,
        noise.per_m,
        axis[0],
        axis[1],
        axis[2],
        view.points.len() as f64,
        view.no_return.len() as f64,
    ] {
        put(x);
    }
    for x in view.points.iter().flat_map(|p| p.iter()) {
        put(*x);
    }
    for x in view.no_return.iter().flat_map(|d| d.iter()) {
        put(*x);
    }
    bytes
}

/// Decodes what [`encode_view`] wrote; `name` of the sweep is for the error.
///
/// # Errors
/// Another version, or another number of bytes than the header announces.
pub fn decode_view(name: &str, bytes: &[u8]) -> Result<View, BlobError> {
    let error = |expected: &str, got: String| BlobError {
        what: format!("stored sweep {name}"),
        expected: expected.to_owned(),
        got,
    };
    match bytes.first() {
        Some(&VERSION) => {}
        other => return Err(error("version 1", format!("{other:?}"))),
    }
    let (words, rest) = bytes[1..].as_chunks::<8>();
    let numbers: Vec<f64> = words.iter().map(|w| f64::from_le_bytes(*w)).collect();
    let [
        x,
        y,
        z,
        free_range_m,
        at_zero_m,
        per_m,
        axis_x,
        axis_y,
        axis_z,
        point_count,
        no_return_count,
        ..,
    ] = numbers[..]
    else {
        return Err(error(
            &format!("a header of {HEADER_NUMBERS} numbers"),
            format!("{}", numbers.len()),
        ));
    };
    let expected = HEADER_NUMBERS as f64 + 3.0 * (point_count + no_return_count);
    if expected != numbers.len() as f64 || !rest.is_empty() {
        return Err(error(
            &format!("{expected} numbers"),
            format!("{} bytes", bytes.len()),
        ));
    }
    let split = HEADER_NUMBERS + 3 * point_count as usize;
    let (points, _) = numbers[HEADER_NUMBERS..split].as_chunks::<3>();
    let (directions, _) = numbers[split..].as_chunks::<3>();
    Ok(View {
        origin: Point3::new(x, y, z),
        points: points.iter().map(|p| Point3::from(*p)).collect(),
        no_return: directions
            .iter()
            .map(|d| Unit::new_unchecked(Vector3::from(*d)))
            .collect(),
        free_range_m,
        noise: at_zero_m
            .is_finite()
            .then_some(NoiseLaw { at_zero_m, per_m }),
        tilt_axis: axis_x
            .is_finite()
            .then(|| Unit::new_unchecked(Vector3::new(axis_x, axis_y, axis_z))),
    })
}

#[cfg(test)]
mod tests {
    use super::{decode_view, encode_view};
    use crate::geometry::{NoiseLaw, View};
    use nalgebra::{Point3, Vector3};

    fn view() -> View {
        View {
            origin: Point3::new(0.1, 0.2, 0.3),
            points: vec![
                Point3::new(1.0 / 3.0, 2.0, 3.0),
                Point3::new(-4.0, 5e6, 6.0),
            ],
            no_return: vec![Vector3::x_axis()],
            free_range_m: 4.0,
            noise: Some(NoiseLaw {
                at_zero_m: 0.002,
                per_m: 0.001,
            }),
            tilt_axis: Some(Vector3::y_axis()),
        }
    }

    #[test]
    fn a_view_is_decoded_bit_for_bit() {
        let bytes = encode_view(&view());
        assert_eq!(decode_view("x", &bytes).expect("reads"), view());
        let bare = View::from_points(vec![Point3::origin()], Point3::origin());
        assert_eq!(decode_view("x", &encode_view(&bare)).expect("reads"), bare);
    }

    #[test]
    fn truncated_or_foreign_bytes_are_refused() {
        let bytes = encode_view(&view());
        for cut in 0..bytes.len() {
            assert!(decode_view("x", &bytes[..cut]).is_err(), "cut at {cut}");
        }
        let mut foreign = bytes;
        foreign[0] = 9;
        assert!(decode_view("x", &foreign).is_err());
    }
}
