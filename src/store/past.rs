//! The distances of the past, one after the other: what thresholds are tuned on.

use super::connection::Store;
use super::error::StoreError;
use super::lookup::waypoint_ids_in_log;
use super::newest::Conditions;
use super::time_range::TimeRange;
use crate::alarm::{AlarmAnswer, PastCase, PastDistance};
use rusqlite::types::Value;
use rusqlite::{Connection, Row, params_from_iter};

impl Store {
    /// Gives every distance of a waypoint in `range` to `each`: first of visits, then of alarms, in the order of the log. Those of
    /// another ground distance than `ground` are left out: they have another unit.
    ///
    /// # Errors
    /// A waypoint name that the log does not know, or the database fails.
    pub fn each_past_distance(
        &self,
        waypoint: &str,
        range: &TimeRange,
        ground: &str,
        each: &mut dyn FnMut(&PastDistance),
    ) -> Result<(), StoreError> {
        self.query(|db| {
            for id in waypoint_ids_in_log(db, waypoint)? {
                each_visit(db, id, range, ground, each)?;
                each_alarm(db, id, range, ground, each)?;
            }
            Ok(())
        })
    }

    /// The same of its alarms alone.
    ///
    /// # Errors
    /// As [`Store::each_past_distance`].
    pub fn each_past_alarm(
        &self,
        waypoint: &str,
        range: &TimeRange,
        ground: &str,
        each: &mut dyn FnMut(&PastDistance),
    ) -> Result<(), StoreError> {
        self.query(|db| {
            let ids = waypoint_ids_in_log(db, waypoint)?;
            ids.into_iter()
                .try_for_each(|id| each_alarm(db, id, range, ground, each))
        })
    }
}

fn each_visit(
    db: &Connection,
    waypoint_id: i64,
    range: &TimeRange,
    ground: &str,
    each: &mut dyn FnMut(&PastDistance),
) -> Result<(), StoreError> {
    let mut conditions = Conditions::default();
    conditions.require("v.waypoint_id = ?", [Value::from(waypoint_id)]);
    conditions.require("v.d_gmm IS NOT NULL AND v.verdict <> 'not_observed'", []);
    conditions.require_range("v.at", range);
    require_ground(&mut conditions, ground);
    let condition = conditions.to_where();
    let sql = format!(
        "SELECT v.id, v.d_gmm, v.verdict = 'quiet', EXISTS (SELECT 1 FROM novelty n WHERE n.visit_id = v.id)
         FROM visit v {condition} ORDER BY v.id"
    );
    let past = |row: &Row<'_>| {
        let (quiet, listed): (bool, bool) = (row.get(2)?, row.get(3)?);
        let case = if quiet {
            PastCase::Quiet { listed }
        } else {
            PastCase::Changed
        };
        Ok(past_distance(row.get(0)?, row.get(1)?, case))
    };
    give(db, &sql, conditions.values(), past, each)
}

/// An alarm has the greatest distance of its visits.
fn each_alarm(
    db: &Connection,
    waypoint_id: i64,
    range: &TimeRange,
    ground: &str,
    each: &mut dyn FnMut(&PastDistance),
) -> Result<(), StoreError> {
    let mut conditions = Conditions::default();
    let mut of_alarm = Conditions::default();
    of_alarm.require(
        "g.alarm_id = a.id AND g.position IS NOT NULL AND v.d_gmm IS NOT NULL",
        [],
    );
    require_ground(&mut of_alarm, ground);
    conditions.require("a.waypoint_id = ?", [Value::from(waypoint_id)]);
    conditions.require_range("a.raised_at", range);
    let greatest = format!(
        "(SELECT max(v.d_gmm) FROM sighting g JOIN visit v ON v.id = g.visit_id {})",
        of_alarm.to_where()
    );
    conditions.require(
        format!("{greatest} IS NOT NULL"),
        of_alarm.values().to_vec(),
    );
    let condition = conditions.to_where();
    let sql = format!(
        "SELECT a.id, {greatest},
                (SELECT answer FROM alarm_answer s WHERE s.alarm_id = a.id ORDER BY s.id DESC LIMIT 1)
         FROM alarm a {condition} ORDER BY a.id"
    );
    let values = [of_alarm.values(), conditions.values()].concat();
    let past = |row: &Row<'_>| {
        let answer: Option<String> = row.get(2)?;
        let answer = answer.and_then(|text| AlarmAnswer::from_text(&text));
        Ok(past_distance(
            row.get(0)?,
            row.get(1)?,
            PastCase::Alarm(answer),
        ))
    };
    give(db, &sql, &values, past, each)
}

fn past_distance(id: i64, d_gmm: f64, case: PastCase) -> PastDistance {
    PastDistance { id, d_gmm, case }
}

/// Visits of before the ground was noted count as of any.
fn require_ground(conditions: &mut Conditions, ground: &str) {
    let noted = "coalesce(json_extract(iif(json_valid(v.engine), v.engine, '{}'), '$.ground'), ?)";
    conditions.require(
        format!("{noted} = ?"),
        [ground, ground].map(|g| Value::from(g.to_owned())),
    );
}

fn give(
    db: &Connection,
    sql: &str,
    values: &[Value],
    past: impl Fn(&Row<'_>) -> rusqlite::Result<PastDistance>,
    each: &mut dyn FnMut(&PastDistance),
) -> Result<(), StoreError> {
    let mut query = db.prepare_cached(sql)?;
    let mut rows = query.query(params_from_iter(values))?;
    while let Some(row) = rows.next()? {
        each(&past(row)?);
    }
    Ok(())
}
