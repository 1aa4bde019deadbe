//! Things that swallow light: a compact part of what the reference saw gave nothing back, though beams beside it did
//! (`docs/novelty.md section 5`).
//!
//! What a sensor lacks by itself runs through its field of view from edge to edge: rows, columns, sectors, bands. A thing ends
//! within it, to the left, to the right, and above or below.

use super::constants::{
    ABSORBING_CELL_SPACINGS, ABSORBING_EDGE_SHARE, ABSORBING_MIN_CELLS, ABSORBING_MIN_SR,
};
use super::gaps::returned_ranges_m;
use super::{AbsorbingThing, Evidence, EvidenceSettings, ObserverView, PreparedView, Visibility};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Most columns of the grid: a thing of the least solid angle is still twenty wide. Bounds time and memory.
const MAX_COLUMNS: f64 = 1800.0;

/// Column and row in [`DirectionGrid`].
type Cell = (i64, i64);

/// Beams of both views through a cell.
#[derive(Debug, Clone, Copy)]
struct CellBeams {
    /// Something came back to the visit.
    is_seen: bool,
    /// Returns of the reference.
    reference: u32,
    /// Range of the nearest surface that those met, from the visit's sensor, metres.
    nearest_m: f32,
}

impl CellBeams {
    const NONE: Self = Self {
        is_seen: false,
        reference: 0,
        nearest_m: f32::INFINITY,
    };
}

/// The things that swallow light where `reference` saw surfaces; `evidence` is that of its points.
pub(super) fn absorbing_things(
    reference: &PreparedView,
    evidence: &[Evidence],
    visit: &ObserverView<'_>,
    settings: &EvidenceSettings,
) -> Vec<AbsorbingThing> {
    let rays = &visit.view.rays;
    let mut grid = DirectionGrid::new(reference.rays.spacing_rad.max(rays.spacing_rad));
    for p in &visit.view.view.points {
        grid.beams_at(&(p - rays.origin())).is_seen = true;
    }
    let returned_m = returned_ranges_m(visit.view);
    let sensor = visit.observer_from_own.pose.inverse() * rays.origin();
    for (i, (p, evidence)) in reference.view.points.iter().zip(evidence).enumerate() {
        let seen = visit.observer_from_own.apply(p) - rays.origin();
        let range_m = seen.norm();
        let margin_rad =
            settings.field_margin_spacings * rays.spacing_rad + settings.origin_error_m / range_m;
        let is_asked = evidence.visibility != Visibility::OutOfRange
            && returned_m.contains(&range_m)
            && rays.field_of_view.contains(&(seen / range_m), margin_rad)
            // Met so flatly, a surface may give nothing back by itself.
            && !reference.is_grazed(i, &sensor, settings.grazing_cos);
        if is_asked {
            let beams = grid.beams_at(&seen);
            beams.reference += 1;
            beams.nearest_m = beams.nearest_m.min(range_m as f32);
        }
    }
    let mut lost = grid.bounded_runs();
    grid.fill_columns(&mut lost);
    let groups = grid.connected(lost);
    let surely_m = visit.view.free_m(settings);
    let things = groups
        .iter()
        .filter_map(|group| grid.thing(group, surely_m));
    things.collect()
}

/// Directions from the visit's sensor in cells of one solid angle: columns of bearing, rows of the sine of elevation.
struct DirectionGrid {
    columns: i64,
    rows: i64,
    cells: Vec<CellBeams>,
}

impl DirectionGrid {
    fn new(spacing_rad: f64) -> Self {
        let width_rad = ABSORBING_CELL_SPACINGS * spacing_rad;
        let columns = (TAU / width_rad).clamp(1.0, MAX_COLUMNS).floor();
        // As high as wide at elevation 0.
        let rows = (columns / PI).ceil();
        Self {
            columns: columns as i64,
            rows: rows as i64,
            cells: vec![CellBeams::NONE; (columns * rows) as usize],
        }
    }

    /// Solid angle of a cell, steradians.
    fn cell_sr(&self) -> f64 {
        2.0 * TAU / (self.columns * self.rows) as f64
    }

    fn bearing_rad(&self, column: i64) -> f64 {
        column as f64 * TAU / self.columns as f64
    }

    fn elevation_rad(&self, row: i64) -> f64 {
        (2.0 * row as f64 / self.rows as f64 - 1.0)
            .clamp(-1.0, 1.0)
            .asin()
    }

    fn index(&self, (column, row): Cell) -> Option<usize> {
        let is_inside = (0..self.rows).contains(&row);
        is_inside.then(|| (row * self.columns + self.wrapped(column)) as usize)
    }

    fn beams(&self, cell: Cell) -> CellBeams {
        let beams = self.index(cell).and_then(|i| self.cells.get(i));
        beams.copied().unwrap_or(CellBeams::NONE)
    }

    fn beams_at(&mut self, direction: &Vector3<f64>) -> &mut CellBeams {
        let sine = direction.z / direction.norm().max(f64::MIN_POSITIVE);
        let turn = direction.y.atan2(direction.x) / TAU;
        let column = ((turn * self.columns as f64).floor() as i64).rem_euclid(self.columns);
        let row = ((0.5 * (sine + 1.0) * self.rows as f64) as i64).clamp(0, self.rows - 1);
        &mut self.cells[(row * self.columns + column) as usize]
    }

    fn wrapped(&self, column: i64) -> i64 {
        column.rem_euclid(self.columns)
    }

    fn is_lost(&self, cell: Cell) -> bool {
        let beams = self.beams(cell);
        beams.reference > 0 && !beams.is_seen
    }

    fn is_unknown(&self, cell: Cell) -> bool {
        let beams = self.beams(cell);
        beams.reference == 0 && !beams.is_seen
    }

    /// The lost cells of runs along a row that end beside cells from which something came back, on both sides.
    fn bounded_runs(&self) -> BTreeSet<Cell> {
        let mut bounded = BTreeSet::new();
        for row in 0..self.rows {
            for column in 0..self.columns {
                if !self.beams((column, row)).is_seen {
                    continue;
                }
                // A run begins beside a cell that is seen, and ends before that one at the latest.
                let length = (1..)
                    .take_while(|n| self.is_lost((column + n, row)))
                    .count() as i64;
                if length > 0 && self.beams((column + length + 1, row)).is_seen {
                    bounded.extend((1..=length).map(|n| (self.wrapped(column + n), row)));
                }
            }
        }
        bounded
    }

    /// Adds what nobody looked at between two of these cells of a column: one thing may stand before the wall and the floor, which
    /// is met at grazing incidence in between.
    fn fill_columns(&self, lost: &mut BTreeSet<Cell>) {
        let mut last_of_column: BTreeMap<i64, i64> = BTreeMap::new();
        let mut between = Vec::new();
        let mut cells: Vec<Cell> = lost.iter().copied().collect();
        cells.sort_unstable_by_key(|(column, row)| (*row, *column));
        for (column, row) in cells {
            let Some(last) = last_of_column.insert(column, row) else {
                continue;
            };
            let unknown = (last + 1..row).map(|row| (column, row));
            if unknown.clone().all(|cell| self.is_unknown(cell)) {
                between.extend(unknown);
            }
        }
        lost.extend(between);
    }

    /// The groups of cells that share a side.
    fn connected(&self, mut cells: BTreeSet<Cell>) -> Vec<Vec<Cell>> {
        let mut groups = Vec::new();
        while let Some(first) = cells.pop_first() {
            let mut group = vec![first];
            let mut next = 0;
            while let Some((column, row)) = group.get(next).copied() {
                next += 1;
                for (right, up) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                    let beside = (self.wrapped(column + right), row + up);
                    if cells.remove(&beside) {
                        group.push(beside);
                    }
                }
            }
            groups.push(group);
        }
        groups
    }

    /// The thing that stands in a group of cells; none where it is too small, or goes on above and below. Beyond `surely_m`
    /// surfaces come and go: what vanished there alone is none.
    fn thing(&self, group: &[Cell], surely_m: f64) -> Option<AbsorbingThing> {
        let (first, _) = *group.first()?;
        // Lowest and highest row by column; columns count from the first cell, so that none jumps by a turn.
        let mut columns: BTreeMap<i64, [i64; 2]> = BTreeMap::new();
        for (column, row) in group {
            let half = self.columns / 2;
            let from_first = self.wrapped(column - first + half) - half;
            let ends = columns.entry(from_first).or_insert([*row, *row]);
            *ends = [ends[0].min(*row), ends[1].max(*row)];
        }
        let low = columns.values().map(|[low, _]| *low).min()?;
        let high = columns.values().map(|[_, high]| *high).max()?;
        let width = columns.len();
        let is_sure = |cell: &&Cell| f64::from(self.beams(**cell).nearest_m) <= surely_m;
        let sure = group.iter().filter(is_sure).count();
        let is_large = sure as f64 * self.cell_sr() >= ABSORBING_MIN_SR
            && width >= ABSORBING_MIN_CELLS
            && high - low + 1 >= ABSORBING_MIN_CELLS as i64;
        let ends_at = |beyond: &dyn Fn(&[i64; 2]) -> Range<i64>| {
            let ends_in = |column: i64, mut rows: Range<i64>| {
                rows.any(|row| self.beams((first + column, row)).is_seen)
            };
            let ended = columns
                .iter()
                .filter(|(column, ends)| ends_in(**column, beyond(ends)));
            ended.count() as f64 >= ABSORBING_EDGE_SHARE * width as f64
        };
        let ends_below = ends_at(&|ends| 0..ends[0]);
        let ends_above = ends_at(&|ends| ends[1] + 1..self.rows);
        if !is_large || !(ends_below || ends_above) {
            return None;
        }
        let beams = || group.iter().map(|cell| self.beams(*cell));
        let nearest_m = beams().map(|b| f64::from(b.nearest_m));
        let [right, left] = [*columns.keys().next()?, *columns.keys().next_back()? + 1];
        // The middle lies within half a turn.
        let middle = self.bearing_rad(2 * first + right + left) / 2.0;
        let turns = (middle / TAU).round() * TAU;
        Some(AbsorbingThing {
            bearings_rad: [right, left].map(|column| self.bearing_rad(first + column) - turns),
            elevations_rad: [low, high + 1].map(|row| self.elevation_rad(row)),
            far_m: nearest_m.fold(f64::INFINITY, f64::min),
            beams: beams().map(|b| b.reference as usize).sum(),
        })
    }
}
