//! The log of visits: listing and showing them.

use super::connection::Store;
use super::error::StoreError;
use super::lookup::{check_in_log, frame_name, waypoint_ids_in_log};
use super::newest::{Conditions, newest_ids};
use super::novelties::novelties_of_visit;
use super::references::stored_mixture::StoredMixture;
use super::time_range::{TimeRange, is_clock_unset};
use patrold_engine::novelty::{ReferenceMixture, Verdict};
use patrold_engine::report::{CoverageRecord, NoveltyRecord};
use rusqlite::types::Value;
use rusqlite::{Connection, OptionalExtension, Row, params_from_iter};
use serde::Serialize;

/// Which visits to list; `None`: any.
#[derive(Debug, Clone)]
pub struct VisitFilter {
    /// When they were.
    pub range: TimeRange,
    /// Name of the waypoint.
    pub waypoint: Option<String>,
    /// Verdict.
    pub verdict: Option<Verdict>,
    /// The newest N.
    pub limit: u32,
}

/// A visit in the list.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VisitRow {
    /// Sequence number.
    pub id: i64,
    /// When it was, RFC 3339.
    pub at: String,
    /// Whether that stamp comes from a clock that was not set.
    pub clock_unset: bool,
    /// Name of the waypoint.
    pub waypoint: String,
    /// quiet, changed or not_observed.
    pub verdict: String,
    /// Why, one line.
    pub reason: String,
    /// d_GMM, in the unit of its ground distance.
    pub d_gmm: Option<f64>,
    /// U_th then in force.
    pub u_th: Option<f64>,
    /// Ground distance of both: w2 or euclid (metres), fm (no unit); `None` for visits of older versions.
    pub ground: Option<String>,
    /// How much of the reference it could judge; `None` for visits of older versions.
    pub coverage: Option<CoverageRecord>,
    /// Version of the reference; `None`: compared with none.
    pub reference_version: Option<i64>,
    /// The alarms that it is evidence of.
    pub alarms: Vec<i64>,
}

/// All about one visit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VisitDetail {
    /// As in the list.
    #[serde(flatten)]
    pub row: VisitRow,
    /// The kernel's boot id.
    pub boot_id: String,
    /// Seed of the engine's random numbers.
    pub seed: u64,
    /// Points of its sweep; `None` without one.
    pub points: Option<i64>,
    /// Whether the sweep is still stored, so that it can be judged again.
    pub sweep_kept: bool,
    /// Frame of the novelties: NAME/VERSION of the reference.
    pub frame: String,
    /// What appeared and disappeared.
    pub novelties: Vec<NoveltyRecord>,
}

const SELECT: &str = "
    SELECT v.id, v.at, w.name, v.verdict, v.reason, v.d_gmm, v.u_th, v.engine, r.version, coalesce(r.frame_version, r.version),
           v.boot_id, v.seed, s.points, s.view_file IS NOT NULL OR s.raw_file IS NOT NULL,
           CASE WHEN json_valid(v.report) THEN json_extract(v.report, '$.coverage') END
    FROM visit v JOIN waypoint w ON w.id = v.waypoint_id
    LEFT JOIN reference r ON r.id = v.reference_id
    LEFT JOIN sweep s ON s.id = v.sweep_id
    WHERE v.id = ?1";

impl Store {
    /// Visits that match, newest first.
    ///
    /// # Errors
    /// A waypoint name that the log does not know, or the database fails.
    pub fn visits(&self, filter: &VisitFilter) -> Result<Vec<VisitRow>, StoreError> {
        self.query(|db| {
            let ids = newest_ids(
                db,
                "visit",
                &branches(db, filter)?,
                &filter.range,
                filter.limit,
            )?;
            let mut query = db.prepare_cached(SELECT)?;
            let mut visits = Vec::new();
            for id in ids {
                let mut visit = query.query_row([id], read_row)?;
                visit.alarms = alarms_of_visit(db, id)?;
                visits.push(visit);
            }
            Ok(visits)
        })
    }

    /// Numbers of the next visits after number `after`, in the order of the log: to walk through it in pages.
    ///
    /// # Errors
    /// A waypoint name that the log does not know, or the database fails.
    pub fn visit_ids_after(
        &self,
        after: i64,
        range: &TimeRange,
        waypoint: Option<&str>,
        limit: u32,
    ) -> Result<Vec<i64>, StoreError> {
        self.query(|db| {
            let mut conditions = in_range(db, range, waypoint)?;
            conditions.require("id > ?", [Value::from(after)]);
            let condition = conditions.to_where();
            let sql = format!("SELECT id FROM visit {condition} ORDER BY id LIMIT {limit}");
            let mut query = db.prepare_cached(&sql)?;
            let ids = query.query_map(params_from_iter(conditions.values()), |row| row.get(0))?;
            Ok(ids.collect::<Result<_, _>>()?)
        })
    }

    /// How many visits there are.
    ///
    /// # Errors
    /// As [`Store::visit_ids_after`].
    pub fn count_visits(
        &self,
        range: &TimeRange,
        waypoint: Option<&str>,
    ) -> Result<u64, StoreError> {
        self.query(|db| {
            let conditions = in_range(db, range, waypoint)?;
            let sql = format!("SELECT count(*) FROM visit {}", conditions.to_where());
            let count: i64 = db.query_row(&sql, params_from_iter(conditions.values()), |row| {
                row.get(0)
            })?;
            Ok(count as u64)
        })
    }

    /// All about one visit.
    ///
    /// # Errors
    /// No such visit.
    pub fn visit_detail(&self, id: i64) -> Result<VisitDetail, StoreError> {
        self.query(|db| {
            let found = db.query_row(SELECT, [id], |row| {
                let (row, columns) = (read_row(row)?, row);
                let frame = frame_name(&row.waypoint, columns.get(9)?);
                Ok(VisitDetail {
                    boot_id: columns.get(10)?,
                    seed: columns.get::<_, i64>(11)? as u64,
                    points: columns.get(12)?,
                    sweep_kept: columns.get::<_, Option<bool>>(13)?.unwrap_or(false),
                    frame,
                    novelties: Vec::new(),
                    row,
                })
            });
            let mut visit = found.optional()?.ok_or(StoreError::UnknownVisit(id))?;
            visit.novelties = novelties_of_visit(db, id)?;
            visit.row.alarms = alarms_of_visit(db, id)?;
            Ok(visit)
        })
    }

    /// The mixture that a visit was compared with; `None` where it was compared with none, or the mixture is damaged or of an
    /// earlier version.
    ///
    /// # Errors
    /// The database fails.
    pub fn reference_of_visit(&self, id: i64) -> Result<Option<ReferenceMixture>, StoreError> {
        self.query(|db| {
            let sql = "SELECT r.mixture, r.mixture_sha256, r.model
                       FROM visit v JOIN reference r ON r.id = v.reference_id WHERE v.id = ?1";
            let stored = db.query_row(sql, [id], |row| {
                let (bytes, checksum): (Vec<u8>, Option<String>) = (row.get(0)?, row.get(1)?);
                Ok(StoredMixture::from_row(
                    &bytes,
                    checksum.as_deref(),
                    row.get(2)?,
                ))
            });
            Ok(match stored.optional()? {
                Some(StoredMixture::Intact { gamma, .. }) => Some(gamma),
                _ => None,
            })
        })
    }
}

/// Visits of a waypoint in a stretch of time; those of a clock that was not set are in every one.
fn in_range(
    db: &Connection,
    range: &TimeRange,
    waypoint: Option<&str>,
) -> Result<Conditions, StoreError> {
    let mut conditions = Conditions::default();
    if let Some(name) = waypoint {
        check_in_log(db, name)?;
        let of_name = "waypoint_id IN (SELECT id FROM waypoint WHERE name = ?)";
        conditions.require(of_name, [name.to_owned().into()]);
    }
    conditions.require_range("at", range);
    Ok(conditions)
}

/// One walk along an index for each waypoint of the name: a name that was forgotten and taught again is several.
fn branches(db: &Connection, filter: &VisitFilter) -> Result<Vec<Conditions>, StoreError> {
    let mut all = Conditions::default();
    let verdict = filter.verdict.map(|verdict| verdict.as_str().to_owned());
    all.require_some("verdict = ?", verdict);
    let Some(name) = &filter.waypoint else {
        return Ok(vec![all]);
    };
    let at_waypoint = |id| {
        let mut branch = all.clone();
        branch.require("waypoint_id = ?", [Value::from(id)]);
        branch
    };
    Ok(waypoint_ids_in_log(db, name)?
        .into_iter()
        .map(at_waypoint)
        .collect())
}

/// The alarms whose thing a visit saw.
fn alarms_of_visit(db: &Connection, id: i64) -> Result<Vec<i64>, StoreError> {
    let mut query = db.prepare_cached(
        "SELECT DISTINCT alarm_id FROM sighting WHERE visit_id = ?1 AND position IS NOT NULL ORDER BY alarm_id",
    )?;
    let ids = query.query_map([id], |row| row.get(0))?;
    Ok(ids.collect::<Result<_, _>>()?)
}

fn read_row(row: &Row<'_>) -> rusqlite::Result<VisitRow> {
    let at: String = row.get(1)?;
    let engine: String = row.get(7)?;
    let coverage: Option<String> = row.get(14)?;
    Ok(VisitRow {
        id: row.get(0)?,
        clock_unset: is_clock_unset(&at),
        at,
        waypoint: row.get(2)?,
        verdict: row.get(3)?,
        reason: row.get(4)?,
        d_gmm: row.get(5)?,
        u_th: row.get(6)?,
        ground: ground_of(&engine),
        coverage: coverage.and_then(|text| serde_json::from_str(&text).ok()),
        reference_version: row.get(8)?,
        alarms: Vec::new(),
    })
}

/// Ground distance in the engine settings of a visit.
pub(super) fn ground_of(engine: &str) -> Option<String> {
    let engine: serde_json::Value = serde_json::from_str(engine).ok()?;
    Some(engine.get("ground")?.as_str()?.to_owned())
}
