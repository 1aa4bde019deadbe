//! The report: tables and JSON.

use super::figure_numbers::FigureNumbers;
use crate::cli::experiment::{markdown_table, number};
use patrold_engine::report::class_name;
use patrold_lab::reproduce::{ColumnRow, PAPER_COLUMNS, PaperColumn, SceneResult, column_rows};
use serde::Serialize;

/// The report.
#[derive(Debug, Serialize)]
pub(super) struct ReproduceReport {
    #[serde(flatten)]
    head: ReportHead,
    paper: Vec<PaperColumn>,
    rows: Vec<ColumnRow>,
    figures: Option<FigureNumbers>,
    misses: Vec<SceneMiss>,
}

/// What was run.
#[derive(Debug, Serialize)]
pub(super) struct ReportHead {
    /// 1, 2, or 3 for the furnished room.
    pub table: u8,
    pub seed: u64,
    /// Layout of the beams in table 1.
    pub beams: Option<&'static str>,
    /// Semi-axes of the ellipsoids that method A samples, standard deviations.
    pub ellipsoid_sigmas: f64,
    /// Duration of the run.
    pub seconds: f64,
}

/// A scene judged wrongly: the object missed or of another class, or a false shape.
#[derive(Debug, Serialize)]
struct SceneMiss {
    scene: String,
    set: &'static str,
    way: &'static str,
    told: Option<&'static str>,
    wrong: usize,
}

impl SceneMiss {
    fn new(result: &SceneResult) -> Self {
        Self {
            scene: result.score.name.clone(),
            set: result.set,
            way: result.column.as_str(),
            told: result.score.class.map(class_name),
            wrong: result.score.wrong,
        }
    }
}

impl ReproduceReport {
    /// The report of these results.
    pub(super) fn new(
        head: ReportHead,
        results: &[SceneResult],
        figures: Option<FigureNumbers>,
    ) -> Self {
        let paper = PAPER_COLUMNS.into_iter().filter(|p| p.table == head.table);
        let wrong = results.iter().filter(|r| !r.is_correct());
        Self {
            paper: paper.collect(),
            rows: column_rows(results),
            figures,
            misses: wrong.map(SceneMiss::new).collect(),
            head,
        }
    }

    /// One table for each set.
    pub(super) fn tables(&self, timed: bool) -> String {
        let ReportHead {
            table,
            seed,
            beams,
            ellipsoid_sigmas,
            seconds,
        } = &self.head;
        let beams = beams.map_or(String::new(), |b| format!(", beams {b}"));
        let title = match table {
            1 => "Table I",
            2 => "Table II",
            _ => "Furnished room",
        };
        let mut parts = vec![format!(
            "{title}, seed {seed}{beams}, ellipsoids at {ellipsoid_sigmas:.2} sigmas, {seconds:.0} s; rates per object (Table I's counts), per reported shape (Eq. 14 as printed), and of objects not reported as ambiguous"
        )];
        for rows in self.rows.chunk_by(|a, b| a.set == b.set) {
            let Some(first) = rows.first() else { continue };
            parts.push(format!("\n{}\n{}", first.set, self.set_table(rows, timed)));
        }
        parts.extend(self.figures.as_ref().map(|f| format!("\n{}", f.text())));
        parts.join("\n")
    }

    fn set_table(&self, rows: &[ColumnRow], timed: bool) -> String {
        let mut table = markdown_table(&[
            "column",
            "of",
            "n",
            "TruePos",
            "FalsePos",
            "per shape",
            "definite",
            "amb. %",
            "size cm",
            "%",
            "rotation deg",
            "95 %",
            "ms",
        ]);
        for p in &self.paper {
            table.add_row([
                format!("paper, {}", p.heading),
                "all".to_owned(),
                String::new(),
                format!("{:.3}", p.rates[0]),
                format!("{:.3}", p.rates[1]),
                String::new(),
                String::new(),
                String::new(),
                p.size_cm.map(|v| format!("{v:.1}")).join(" "),
                String::new(),
                p.rotation_deg.map(|v| format!("{v:.1}")).join(" "),
                String::new(),
                format!("{:.0}", p.time_ms),
            ]);
        }
        let numbers = |v: [Option<f64>; 3]| v.map(|v| number(v, 1)).join(" ");
        let percent =
            |share: Option<f64>| share.map_or(String::new(), |s| format!("{:.1}", 100.0 * s));
        for row in rows {
            let s = &row.summary;
            table.add_row([
                row.way.to_owned(),
                row.of.to_owned(),
                (s.objects + s.empty).to_string(),
                format!("{:.3}", s.per_object[0]),
                format!("{:.3}", s.per_object[1]),
                s.per_shape.map(|v| format!("{v:.3}")).join(" "),
                s.definite.map_or(String::new(), |s| format!("{s:.3}")),
                percent(s.ambiguous_share),
                numbers(s.size_cm),
                percent(s.size_share),
                numbers(s.rotation_deg),
                percent(s.coverage),
                if timed {
                    format!("{:.1} (+{:.1})", s.chain_ms, s.reference_ms)
                } else {
                    String::new()
                },
            ]);
        }
        let [mixture, cloud] = rows.first().map_or([0.0; 2], |r| r.summary.bytes);
        format!(
            "{table}\nof the first column, as stored: {mixture:.0} bytes of mixture stand for {cloud:.0} of cloud ({:.0} times as many); ms: from the view to the answer (+ preparation of the reference)",
            cloud / mixture.max(1.0)
        )
    }
}
