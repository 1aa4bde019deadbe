//! The columns of Tables I and II, one row for each set of scenes and column and for each kind of scene in it.

use super::column_summary::ColumnSummary;
use super::score::SceneScore;
use super::table_column::TableColumn;
use serde::Serialize;
use std::collections::HashSet;

/// The score of one scene in one column.
#[derive(Debug, Clone)]
pub struct SceneResult {
    /// Set that the scene belongs to.
    pub set: &'static str,
    /// Kind of the scene: its object or site.
    pub kind: &'static str,
    /// Column.
    pub column: TableColumn,
    /// Score.
    pub score: SceneScore,
}

impl SceneResult {
    /// Whether the answer is right: the object with its class, and no other shape.
    pub fn is_correct(&self) -> bool {
        self.score.right == self.score.has_object && self.score.wrong == 0
    }
}

/// A row of the report.
#[derive(Debug, Clone, Serialize)]
pub struct ColumnRow {
    /// Set of the scenes.
    pub set: &'static str,
    /// Column.
    pub way: &'static str,
    /// Kind of the scenes, or `all`.
    pub of: &'static str,
    /// Counts and errors.
    #[serde(flatten)]
    pub summary: ColumnSummary,
}

/// The rows of all sets and columns, in their order.
pub fn column_rows(results: &[SceneResult]) -> Vec<ColumnRow> {
    let mut rows = Vec::new();
    let mut columns: Vec<_> = results.iter().map(|r| (r.set, r.column)).collect();
    let mut seen = HashSet::new();
    columns.retain(|column| seen.insert(*column));
    for (set, column) in columns {
        let own = || {
            results
                .iter()
                .filter(|r| r.set == set && r.column == column)
        };
        let mut kinds: Vec<_> = own().map(|r| r.kind).collect();
        kinds.dedup();
        let mut add = |of, summary| {
            rows.push(ColumnRow {
                set,
                way: column.as_str(),
                of,
                summary,
            });
        };
        add("all", ColumnSummary::of_scores(own().map(|r| &r.score)));
        for kind in kinds {
            let scores = own().filter(|r| r.kind == kind).map(|r| &r.score);
            add(kind, ColumnSummary::of_scores(scores));
        }
    }
    rows
}
