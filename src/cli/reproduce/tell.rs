//! The tables for people, and the JSON.

use super::command::Done;
use super::numbers::Figures;
use crate::cli::table;
use comfy_table::presets;
use patrold_engine::report::class_word;
use patrold_lab::reproduce::{Mark, PAPER, PaperColumn, Row};
use serde::Serialize;

/// What the command tells.
#[derive(Debug, Serialize)]
pub struct Report {
    table: u8,
    seed: u64,
    beams: Option<&'static str>,
    seconds: f64,
    paper: Vec<Paper>,
    rows: Vec<Line>,
    figures: Option<Figures>,
    misses: Vec<Miss>,
}

/// A column of the paper.
#[derive(Debug, Serialize)]
struct Paper {
    heading: &'static str,
    time_ms: f64,
    rates: [f64; 2],
    size_cm: [f64; 3],
    rotation_deg: [f64; 3],
}

/// One of ours.
#[derive(Debug, Serialize)]
struct Line {
    set: &'static str,
    way: &'static str,
    of: &'static str,
    objects: usize,
    empty: usize,
    shapes: usize,
    right: usize,
    ambiguous: usize,
    wrong: usize,
    definite: Option<f64>,
    ambiguous_share: Option<f64>,
    per_object: [f64; 2],
    per_shape: [f64; 2],
    size_cm: [Option<f64>; 3],
    size_bias_cm: [Option<f64>; 3],
    size_share: Option<f64>,
    rotation_deg: [Option<f64>; 3],
    coverage: Option<f64>,
    chain_ms: f64,
    reference_ms: f64,
    bytes: [f64; 2],
}

/// A scene that was not told right and nothing else.
#[derive(Debug, Serialize)]
struct Miss {
    scene: String,
    set: &'static str,
    way: &'static str,
    told: Option<&'static str>,
    wrong: usize,
}

impl Line {
    fn of(set: &'static str, way: &'static str, of: &'static str, row: &Row) -> Self {
        Self {
            set,
            way,
            of,
            objects: row.objects,
            empty: row.empty,
            shapes: row.shapes,
            right: row.right,
            ambiguous: row.ambiguous,
            wrong: row.wrong,
            definite: row.definite(),
            ambiguous_share: row.ambiguous_share(),
            per_object: row.per_object(),
            per_shape: row.per_shape(),
            size_cm: row.size_cm,
            size_bias_cm: row.size_bias_cm,
            size_share: row.size_share,
            rotation_deg: row.rotation_deg,
            coverage: row.coverage,
            chain_ms: row.chain_ms,
            reference_ms: row.reference_ms,
            bytes: row.bytes,
        }
    }
}

impl Report {
    /// The report of these scenes.
    pub fn new(
        table: u8,
        seed: u64,
        beams: Option<&'static str>,
        seconds: f64,
        done: &[Done],
        figures: Option<Figures>,
    ) -> Self {
        let mut rows = Vec::new();
        let mut keys: Vec<_> = done.iter().map(|d| (d.set, d.way)).collect();
        let mut seen = std::collections::HashSet::new();
        keys.retain(|key| seen.insert(*key));
        for (set, way) in keys {
            let own = || done.iter().filter(|d| d.set == set && d.way == way);
            let mut kinds: Vec<_> = own().map(|d| d.of).collect();
            kinds.dedup();
            let all = Row::of(own().map(|d| &d.mark));
            rows.push(Line::of(set, way.word(), "all", &all));
            for kind in kinds {
                let row = Row::of(own().filter(|d| d.of == kind).map(|d| &d.mark));
                rows.push(Line::of(set, way.word(), kind, &row));
            }
        }
        let good = |m: &Mark| m.right == m.real && m.wrong == 0;
        let misses = done.iter().filter(|d| !good(&d.mark)).map(|d| Miss {
            scene: d.mark.name.clone(),
            set: d.set,
            way: d.way.word(),
            told: d.mark.told.map(class_word),
            wrong: d.mark.wrong,
        });
        let paper = |p: &PaperColumn| Paper {
            heading: p.heading,
            time_ms: p.time_ms,
            rates: p.rates,
            size_cm: p.size_cm,
            rotation_deg: p.rotation_deg,
        };
        Self {
            table,
            seed,
            beams,
            seconds,
            paper: PAPER
                .iter()
                .filter(|p| p.table == table)
                .map(paper)
                .collect(),
            rows,
            figures,
            misses: misses.collect(),
        }
    }

    /// One table for each set.
    pub fn prose(&self, timed: bool) -> String {
        let beams = self.beams.map_or(String::new(), |b| format!(", beams {b}"));
        let mut parts = vec![format!(
            "{}, seed {}{beams}, {:.0} s; rates per object (Table I's counts), per told shape (Eq. 14 as printed), and of things not told as ambiguous",
            match self.table {
                1 => "Table I",
                2 => "Table II",
                _ => "Furnished room",
            },
            self.seed,
            self.seconds
        )];
        for rows in self.rows.chunk_by(|a, b| a.set == b.set) {
            let Some(first) = rows.first() else { continue };
            parts.push(format!("\n{}\n{}", first.set, self.set(rows, timed)));
        }
        parts.extend(self.figures.as_ref().map(|f| format!("\n{}", f.prose())));
        parts.join("\n")
    }

    fn set(&self, rows: &[Line], timed: bool) -> String {
        let mut table = table::table(&[
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
        table.load_style(presets::ASCII_MARKDOWN);
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
        let numbers =
            |v: [Option<f64>; 3]| v.map(|v| v.map_or("-".to_owned(), |v| format!("{v:.1}")));
        let percent =
            |share: Option<f64>| share.map_or(String::new(), |s| format!("{:.1}", 100.0 * s));
        for row in rows {
            table.add_row([
                row.way.to_owned(),
                row.of.to_owned(),
                (row.objects + row.empty).to_string(),
                format!("{:.3}", row.per_object[0]),
                format!("{:.3}", row.per_object[1]),
                row.per_shape.map(|v| format!("{v:.3}")).join(" "),
                row.definite.map_or(String::new(), |s| format!("{s:.3}")),
                percent(row.ambiguous_share),
                numbers(row.size_cm).join(" "),
                percent(row.size_share),
                numbers(row.rotation_deg).join(" "),
                percent(row.coverage),
                if timed {
                    format!("{:.1} (+{:.1})", row.chain_ms, row.reference_ms)
                } else {
                    String::new()
                },
            ]);
        }
        let bytes = rows.first().map_or([0.0; 2], |r| r.bytes);
        format!(
            "{table}\n{:.0} bytes of mixture stand for {:.0} of cloud; ms: the chain (+ making the reference ready)",
            bytes[0], bytes[1]
        )
    }
}
