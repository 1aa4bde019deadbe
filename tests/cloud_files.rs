//! Cloud files of other tools (`data/cases/a`): each is read as it is meant, or refused by a line that names what it is.
//! `cargo test --test cloud_files`

use nalgebra::{Point3, Vector3};
use patrold_engine::formats::{CloudFile, FormatError, MeasuredPoints, read_cloud};
use std::path::Path;

/// Mean of the forty points that most of the files hold, metres.
const MEAN: [f64; 3] = [3.79458, -1.99490, 0.82742];

/// Files of the forty points.
const FORTY: [&str; 34] = [
    "cc_header.txt",
    "csv_decimal_comma.csv",
    "csv_header_quoted.csv",
    "csv_header_units.csv",
    "csv_index_first.csv",
    "csv_named_order.csv",
    "pcd_comment_mid.pcd",
    "pcd_count0.pcd",
    "pcd_crlf_bin.pcd",
    "pcd_lower_data.pcd",
    "pcd_no_points.pcd",
    "pcd_order.pcd",
    "pcd_organised.pcd",
    "pcd_padding.pcd",
    "pcd_rgb_nan.pcd",
    "pcd_trailing.pcd",
    "pcd_v5_no_count.pcd",
    "pcd_viewpoint.pcd",
    "ply_bom.ply",
    "ply_capital.ply",
    "ply_crlf_bin.ply",
    "ply_faces_first_bin.ply",
    "ply_lfcr_bin.ply",
    "ply_list_after_xyz.ply",
    "ply_other_elements.ply",
    "ply_tabs_spaces.ply",
    "ply_uppercase_kw.ply",
    "pts_count.pts",
    "txt_decimal_comma.txt",
    "xyz_fortran.xyz",
    "xyz_nbsp.txt",
    "xyz_percent_comment.xyz",
    "xyz_plus.xyz",
    "xyz_semicolon_comment.xyz",
];

/// Files that are refused, and what the line names.
const REFUSED: [(&str, &str); 12] = [
    ("las.las", "LAS is not read; convert it to PLY"),
    ("kitti.bin", "KITTI"),
    ("ply_gz.ply.gz", "gzip is not read; unpack it"),
    ("obj.obj", "OBJ is not read; convert it to PLY"),
    ("off.off", "OFF is not read; convert it to PLY"),
    ("xyz_utf16.txt", "UTF-16 is not read; save it as UTF-8"),
    ("ply_utf16.ply", "UTF-16 is not read; save it as UTF-8"),
    ("pcd_wh_mismatch.pcd", "got POINTS 40, WIDTH x HEIGHT "),
    (
        "csv_thousands.txt",
        "line 1: expected a number for x, got \"3,198.100\"",
    ),
    ("xyz_molecule.xyz", "line 2: expected a number for x"),
    ("pcd_trunc_bin.pcd", "expected 40 points"),
    ("ply_short_rows.ply", "expected 45 vertices"),
];

fn read(folder: &Path, name: &str) -> Result<CloudFile, FormatError> {
    let path = folder.join(name);
    let bytes = std::fs::read(&path).expect(name);
    read_cloud(&bytes, path.extension().and_then(|e| e.to_str()))
}

fn mean(points: &[Point3<f64>]) -> Vector3<f64> {
    points
        .iter()
        .fold(Vector3::zeros(), |sum, p| sum + p.coords)
        / points.len() as f64
}

#[test]
fn files_of_other_tools_are_read_as_they_are_meant() {
    let Some(folder) = patrold_test_support::data("cases/a") else {
        return;
    };
    for name in FORTY {
        let cloud = read(&folder, name).unwrap_or_else(|error| panic!("{name}: {error}"));
        let off = mean(&cloud.points) - Vector3::from(MEAN);
        assert!(
            cloud.points.len() == 40 && off.norm() < 1e-4,
            "{name}: {off:?}"
        );
    }
    for (name, expected) in REFUSED {
        let error = read(&folder, name).expect_err(name).to_string();
        assert!(error.contains(expected), "{name}: {error}");
    }
    // Points without a number are dropped and counted.
    for name in ["ply_nan.ply", "ply_nan_ind.ply"] {
        let cloud = read(&folder, name).expect(name);
        let measured = MeasuredPoints::of(&cloud.points, &Point3::origin());
        assert_eq!(
            measured.points.len() + measured.not_finite,
            cloud.points.len()
        );
        assert!(
            measured.not_finite > 0 && measured.points.len() > 30,
            "{name}"
        );
    }
    // Columns in another order.
    for (name, first) in [
        ("csv_xzy.csv", [1.0, 3.0, 2.0]),
        ("csv_zyx.csv", [3.0, 2.0, 1.0]),
    ] {
        let cloud = read(&folder, name).expect(name);
        assert_eq!(cloud.points[0], Point3::from(first), "{name}");
    }
    let seen_from = |name| read(&folder, name).expect(name).viewpoint;
    let viewpoint = Point3::new(-1.5, 2.0, 0.5);
    assert_eq!(seen_from("pcd_viewpoint.pcd"), Some(viewpoint));
    assert_eq!(seen_from("ply_bom.ply"), None);
}

#[test]
fn a_point_of_no_place_is_refused() {
    let Some(folder) = patrold_test_support::data("cases/b") else {
        return;
    };
    let error = read(&folder, "outlier300.xyz")
        .expect_err("1e300")
        .to_string();
    assert!(error.contains("expected coordinates up to"), "{error}");
}
