//! Tables I and II of the paper.

use serde::Serialize;

/// A column of the paper's tables.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PaperColumn {
    /// Table, 1 or 2.
    #[serde(skip)]
    pub table: u8,
    /// Heading.
    pub heading: &'static str,
    /// Execution time, milliseconds.
    pub time_ms: f64,
    /// TruePos and FalsePos.
    pub rates: [f64; 2],
    /// Standard deviation of the size, centimetres.
    pub size_cm: [f64; 3],
    /// Standard deviation of the rotation, degrees.
    pub rotation_deg: [f64; 3],
}

/// Tables I and II as printed.
pub const PAPER_COLUMNS: [PaperColumn; 4] = [
    PaperColumn {
        table: 1,
        heading: "Euclidean Space",
        time_ms: 349.1,
        rates: [0.8330, 0.1467],
        size_cm: [12.13, 11.01, 8.09],
        rotation_deg: [2.01, 1.12, 3.22],
    },
    PaperColumn {
        table: 1,
        heading: "Feature Space",
        time_ms: 74.25,
        rates: [0.9367, 0.0400],
        size_cm: [9.11, 7.998, 7.11],
        rotation_deg: [1.32, 1.99, 2.88],
    },
    PaperColumn {
        table: 2,
        heading: "Euclidean Space",
        time_ms: 323.1,
        rates: [0.8667, 0.1912],
        size_cm: [16.21, 13.24, 10.55],
        rotation_deg: [4.21, 3.98, 5.12],
    },
    PaperColumn {
        table: 2,
        heading: "Feature Space",
        time_ms: 315.6,
        rates: [0.9000, 0.0667],
        size_cm: [12.12, 6.22, 8.19],
        rotation_deg: [3.12, 2.01, 3.02],
    },
];
