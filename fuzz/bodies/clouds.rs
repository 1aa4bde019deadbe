//! Readers of recorded clouds: PLY, PCD and text.

use nalgebra::Point3;
use patrold_engine::formats::{MeasuredPoints, read_cloud, write_ply};

/// A reader may not make more points than a file can hold; the margin is for compressed files.
const MAX_POINTS_PER_BYTE: usize = 300;

pub(crate) fn run(data: &[u8]) {
    for extension in [None, Some("ply"), Some("pcd"), Some("xyz"), Some("txt")] {
        if let Ok(cloud) = read_cloud(data, extension) {
            assert!(cloud.points.len() <= MAX_POINTS_PER_BYTE * data.len().max(1));
            let measured = MeasuredPoints::of(&cloud.points, &Point3::origin());
            assert_eq!(measured.points.len(), measured.file_index.len());
            assert_eq!(
                measured.points.len() + measured.dropped(),
                cloud.points.len()
            );
            let written = write_ply(&measured.points);
            let reread = read_cloud(&written, Some("ply")).expect("a PLY");
            assert_eq!(reread.points.len(), measured.points.len());
        }
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let ascii = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n\
                 1 2 3\n4 5 6\n";
    let mut binary = b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty double x\nproperty double y\n\
                       property double z\nproperty uchar red\nend_header\n"
        .to_vec();
    binary.extend([0_u8; 25]);
    let pcd_header = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n\
                VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";
    let mut compressed = format!("{pcd_header}DATA binary_compressed\n").into_bytes();
    compressed.extend([7, 0, 0, 0, 24, 0, 0, 0, 0, 1, 0xE0, 14, 0, 0, 2]);
    vec![
        ascii.as_bytes().to_vec(),
        binary,
        format!("{pcd_header}DATA ascii\n1 2 3\nnan nan nan\n").into_bytes(),
        [format!("{pcd_header}DATA binary\n").as_bytes(), &[0; 24]].concat(),
        compressed,
        b"1 2 3\n4 5 6 7\n# no\n".to_vec(),
        b"\"Z [mm]\";t;X;y\n1,5;0;2,5;-1.#IND\n".to_vec(),
        b"//X Y Z R\n2\n0 0 0 1\n0 0 0 1\n".to_vec(),
    ]
}
