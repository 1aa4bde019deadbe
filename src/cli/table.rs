//! Tables in the terminal.

use comfy_table::{ContentArrangement, Table, presets};

/// A table as wide as the terminal.
pub(super) fn table(headings: &[&str]) -> Table {
    let mut table = Table::new();
    table
        .load_style(presets::UTF8_HORIZONTAL_ONLY)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(headings);
    table
}

/// Metres with two decimals, as `x, y, z`.
pub(super) fn format_point(p: [f64; 3]) -> String {
    format!("{:.2}, {:.2}, {:.2}", p[0], p[1], p[2])
}

/// A distance with the unit of its ground distance; `fm` has none.
pub(super) fn distance_text(x: Option<f64>, digits: usize, ground: Option<&str>) -> String {
    let unit = match ground {
        Some("w2" | "euclid") => " m",
        _ => "",
    };
    x.map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}{unit}"))
}
