//! What visits are to alarms: the incidents of a waypoint as the rule needs them, and the rule's decisions as rows.

use super::super::connection::{RecordTime, Store};
use super::super::error::StoreError;
use super::super::lookup::{newest_reference_id, waypoint_id};
use super::super::novelties::read_novelty;
use crate::alarm::{AlarmDecision, AlarmState, Incident, Relation, Sighting, VisitFacts, decide};
use rusqlite::{Connection, Row, Transaction, params};

/// Things that are gone and may come back: the latest of a waypoint.
const MAX_GONE_INCIDENTS: i64 = 32;

/// What a visit was to one alarm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlarmSighting {
    /// Number of the alarm.
    pub id: i64,
    /// Raised, seen, moved, changed or back.
    pub relation: Relation,
    /// Position of the thing among the visit's novelties.
    pub position: usize,
    /// Distance from where it was, metres; none for a new one.
    pub distance_m: Option<f64>,
}

/// What a visit did to the alarms of its waypoint.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AlarmEffects {
    /// Alarms raised or seen again, in the order of their novelties.
    pub alarms: Vec<AlarmSighting>,
    /// Alarms cleared.
    pub cleared: Vec<i64>,
    /// Standing alarms whose places could not be seen.
    pub unobserved: Vec<i64>,
}

impl Store {
    /// The incidents of a waypoint that a visit may see again: standing ones, and things that are gone. In the frame of the
    /// reference in use.
    ///
    /// # Errors
    /// Unknown waypoint, or the database fails.
    pub fn incidents(&self, waypoint: &str) -> Result<Vec<Incident>, StoreError> {
        self.query(|db| incidents(db, waypoint_id(db, waypoint)?))
    }
}

/// See [`Store::incidents`].
fn incidents(db: &Connection, waypoint_id: i64) -> Result<Vec<Incident>, StoreError> {
    let Some(reference) = newest_reference_id(db, waypoint_id)? else {
        return Ok(Vec::new());
    };
    let anchors = Relation::ANCHORS.map(|relation| format!("'{}'", relation.as_str()));
    let anchors = anchors.join(", ");
    let mut query = db.prepare(&format!(
        "WITH frame AS (SELECT coalesce(frame_version, version) AS version FROM reference WHERE id = ?2),
              anchor AS (
            SELECT a.id AS alarm_id, a.state, max(s.id) AS sighting_id,
                   (SELECT relation FROM sighting last WHERE last.alarm_id = a.id ORDER BY last.id DESC LIMIT 1) AS last
            FROM alarm a JOIN sighting s ON s.alarm_id = a.id AND s.relation IN ({anchors})
            WHERE a.waypoint_id = ?1 GROUP BY a.id)
         SELECT n.record, n.kind, n.x_m, n.y_m, n.z_m, n.points, n.mass, n.contribution, anchor.alarm_id, anchor.state
         FROM anchor JOIN sighting s ON s.id = anchor.sighting_id
         JOIN novelty n ON n.visit_id = s.visit_id AND n.position = s.position
         JOIN visit v ON v.id = s.visit_id JOIN reference r ON r.id = v.reference_id
         WHERE (anchor.state <> 'cleared' OR anchor.last = 'gone')
           AND coalesce(r.frame_version, r.version) = (SELECT version FROM frame)
         ORDER BY anchor.alarm_id DESC"
    ))?;
    let rows = query.query_map([waypoint_id, reference], read_incident)?;
    let mut gone = 0;
    let mut found = Vec::new();
    for row in rows {
        let incident = row?;
        gone += i64::from(incident.state == AlarmState::Cleared);
        if incident.state != AlarmState::Cleared || gone <= MAX_GONE_INCIDENTS {
            found.push(incident);
        }
    }
    found.reverse();
    Ok(found)
}

fn read_incident(row: &Row<'_>) -> rusqlite::Result<Incident> {
    let state: String = row.get(9)?;
    Ok(Incident {
        id: row.get(8)?,
        // The table allows no other text.
        state: state.parse().unwrap_or(AlarmState::Open),
        anchor: Sighting::new(&read_novelty(row)?),
    })
}

/// Applies what a visit is to the incidents of its waypoint.
pub(in crate::store) fn apply_decisions(
    change: &Transaction<'_>,
    waypoint_id: i64,
    visit_id: i64,
    facts: &VisitFacts<'_>,
    stamp: &RecordTime,
) -> Result<AlarmEffects, StoreError> {
    let mut outcome = AlarmEffects::default();
    let known = incidents(change, waypoint_id)?;
    for decision in decide(facts, &known) {
        match decision {
            AlarmDecision::Raise { sighting } => {
                let id = raise(change, waypoint_id, visit_id, stamp)?;
                let (relation, distance_m) = (Relation::Raised, None);
                outcome.alarms.push(AlarmSighting {
                    id,
                    relation,
                    position: sighting,
                    distance_m,
                });
            }
            AlarmDecision::Continue {
                incident,
                sighting,
                relation,
                distance_m,
            } => {
                let before = known.iter().find(|k| k.id == incident);
                let state = relation.state_after(before.map_or(AlarmState::Open, |k| k.state));
                continue_alarm(change, incident, state, visit_id, stamp)?;
                outcome.alarms.push(AlarmSighting {
                    id: incident,
                    relation,
                    position: sighting,
                    distance_m: Some(distance_m),
                });
            }
            AlarmDecision::Clear { incident } => {
                clear(
                    change,
                    incident,
                    &stamp.to_rfc3339(),
                    "seen without the change",
                )?;
                insert_sighting(change, incident, visit_id, None, Relation::Gone, None)?;
                outcome.cleared.push(incident);
            }
            AlarmDecision::NotObserved { incident } => {
                change.execute(
                    "UPDATE alarm SET unobserved_since = coalesce(unobserved_since, ?2) WHERE id = ?1",
                    params![incident, stamp.to_rfc3339()],
                )?;
                outcome.unobserved.push(incident);
            }
        }
    }
    for alarm in &outcome.alarms {
        insert_sighting(
            change,
            alarm.id,
            visit_id,
            Some(alarm.position),
            alarm.relation,
            alarm.distance_m,
        )?;
    }
    // A visit that saw a thing is evidence.
    if let Some(first) = outcome.alarms.first() {
        change.execute(
            "UPDATE visit SET alarm_id = ?2 WHERE id = ?1",
            params![visit_id, first.id],
        )?;
    }
    Ok(outcome)
}

fn raise(
    change: &Transaction<'_>,
    waypoint_id: i64,
    visit_id: i64,
    stamp: &RecordTime,
) -> Result<i64, StoreError> {
    change.execute(
        "INSERT INTO alarm (waypoint_id, raised_at, boot_id, first_visit_id, last_visit_id, last_seen_at, state)
         VALUES (?1, ?2, ?3, ?4, ?4, ?2, 'open')",
        params![waypoint_id, stamp.to_rfc3339(), stamp.boot_id, visit_id],
    )?;
    Ok(change.last_insert_rowid())
}

fn continue_alarm(
    change: &Transaction<'_>,
    id: i64,
    state: AlarmState,
    visit_id: i64,
    stamp: &RecordTime,
) -> Result<(), StoreError> {
    change.execute(
        "UPDATE alarm SET last_visit_id = ?2, last_seen_at = ?3, visits = visits + 1, state = ?4, unobserved_since = NULL,
                          cleared_at = NULL, cleared_because = NULL
         WHERE id = ?1",
        params![id, visit_id, stamp.to_rfc3339(), state.as_str()],
    )?;
    Ok(())
}

fn insert_sighting(
    change: &Transaction<'_>,
    alarm_id: i64,
    visit_id: i64,
    position: Option<usize>,
    relation: Relation,
    distance_m: Option<f64>,
) -> Result<(), StoreError> {
    change.execute(
        "INSERT INTO sighting (alarm_id, visit_id, position, relation, distance_m) VALUES (?1, ?2, ?3, ?4, ?5)",
        params![
            alarm_id,
            visit_id,
            position.map(|p| p as i64),
            relation.as_str(),
            distance_m
        ],
    )?;
    Ok(())
}

fn clear(db: &Connection, id: i64, at: &str, because: &str) -> Result<(), StoreError> {
    db.execute(
        "UPDATE alarm SET state = 'cleared', cleared_at = ?2, cleared_because = ?3, unobserved_since = NULL WHERE id = ?1",
        params![id, at, because],
    )?;
    Ok(())
}

/// The alarms of a waypoint that are not cleared.
pub(in crate::store) fn standing_alarms(
    db: &Connection,
    waypoint_id: i64,
) -> Result<Vec<i64>, StoreError> {
    let mut query = db.prepare(
        "SELECT id FROM alarm WHERE waypoint_id = ?1 AND state <> 'cleared' ORDER BY id",
    )?;
    let ids = query.query_map([waypoint_id], |row| row.get(0))?;
    Ok(ids.collect::<Result<_, _>>()?)
}

/// Clears these alarms.
pub(in crate::store) fn clear_alarms(
    db: &Connection,
    ids: &[i64],
    at: &str,
    because: &str,
) -> Result<(), StoreError> {
    ids.iter().try_for_each(|id| clear(db, *id, at, because))
}

/// Clears all alarms of a waypoint.
pub(in crate::store) fn clear_all(
    db: &Connection,
    waypoint_id: i64,
    at: &str,
    because: &str,
) -> Result<(), StoreError> {
    db.execute(
        "UPDATE alarm SET state = 'cleared', cleared_at = ?2, cleared_because = ?3, unobserved_since = NULL
         WHERE waypoint_id = ?1 AND state <> 'cleared'",
        params![waypoint_id, at, because],
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::Store;
    use rusqlite::Connection;
    use std::path::Path;

    /// A database of the second version. Alarm 1 (hall) has three things and two visits, 2 (dock) one of each, 3 (hall) is
    /// cleared and has two things, 4 (dock) was acknowledged with two things.
    fn second_version(dir: &Path) {
        let db = Connection::open(dir.join("patrold.db")).expect("database");
        db.execute_batch(include_str!("../../../migrations/0001_patrol.sql"))
            .expect("first");
        db.execute_batch(include_str!(
            "../../../migrations/0002_reference_mixture.sql"
        ))
        .expect("second");
        db.execute_batch(
            "PRAGMA user_version = 2;
             INSERT INTO waypoint (name, created_at) VALUES ('hall', ''), ('dock', '');
             INSERT INTO sweep (waypoint_id, taken_at, boot_id, points, quality) VALUES (1, '', '', 4, ''), (2, '', '', 4, '');
             INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, seed, engine, mixture)
             VALUES (1, 1, 1, '', '', 1, 7, '', x'02'), (2, 1, 2, '', '', 1, 7, '', x'02');
             INSERT INTO visit (waypoint_id, reference_id, alarm_id, at, boot_id, verdict, reason, seed, engine, report)
             VALUES (1, 1, NULL, 't1', '', 'changed', '', 7, '', ''), (1, 1, NULL, 't2', '', 'changed', '', 7, '', ''),
                    (2, 2, NULL, 't3', '', 'changed', '', 7, '', ''), (1, 1, NULL, 't4', '', 'changed', '', 7, '', ''),
                    (2, 2, NULL, 't5', '', 'changed', '', 7, '', ''), (1, 1, NULL, 't6', '', 'quiet', '', 7, '', '');
             INSERT INTO alarm (waypoint_id, raised_at, boot_id, first_visit_id, last_visit_id, last_seen_at, visits, state,
                                acknowledged_at, acknowledged_by, note)
             VALUES (1, 't1', 'b1', 1, 2, 't2', 2, 'open', NULL, NULL, NULL),
                    (2, 't3', 'b3', 3, 3, 't3', 1, 'open', NULL, NULL, NULL),
                    (1, 't4', 'b4', 4, 4, 't4', 1, 'cleared', NULL, NULL, NULL),
                    (2, 't5', 'b5', 5, 5, 't5', 1, 'acknowledged', 't5', 'ana', 'a cart');
             UPDATE visit SET alarm_id = CASE id WHEN 1 THEN 1 WHEN 2 THEN 1 WHEN 3 THEN 2 WHEN 4 THEN 3 WHEN 5 THEN 4 END;
             INSERT INTO novelty (visit_id, position, kind, x_m, y_m, z_m, points, record)
             VALUES (1, 0, 'appeared', 1, 0, 0, 9, '{}'), (1, 1, 'appeared', 4, 0, 0, 9, '{}'),
                    (1, 2, 'disappeared', 4, 0, 0, 9, '{}'),
                    (2, 0, 'appeared', 4.1, 0, 0, 9, '{}'), (2, 1, 'appeared', 1.1, 0, 0, 9, '{}'),
                    (3, 0, 'appeared', 1, 0, 0, 9, '{}'),
                    (4, 0, 'appeared', 1, 0, 0, 9, '{}'), (4, 1, 'disappeared', 2, 0, 0, 9, '{}'),
                    (5, 0, 'appeared', 1, 0, 0, 9, '{}'), (5, 1, 'appeared', 3, 0, 0, 9, '{}'),
                    (6, 0, 'appeared', 9, 0, 0, 9, '{}');",
        )
        .expect("rows");
    }

    #[test]
    fn a_standing_alarm_of_several_things_becomes_several_and_nothing_is_lost() {
        let dir = tempfile::tempdir().expect("temp dir");
        second_version(dir.path());
        let store = Store::open(dir.path()).expect("migrated");
        let places = |id: i64| -> Vec<(i64, String, f64)> {
            let row = store.alarm(id).expect("alarm");
            let rows = store.query(|db| {
                let mut query = db.prepare(
                    "SELECT s.visit_id, s.relation, n.x_m FROM sighting s
                     JOIN novelty n ON n.visit_id = s.visit_id AND n.position = s.position
                     WHERE s.alarm_id = ?1 ORDER BY s.id",
                )?;
                let rows =
                    query.query_map([id], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?;
                Ok(rows.collect::<Result<Vec<_>, _>>()?)
            });
            assert!(!row.novelties.is_empty(), "{id}");
            rows.expect("rows")
        };
        let (raised, seen) = (|| "raised".to_owned(), || "seen".to_owned());
        assert_eq!(places(1), [(1, raised(), 1.0), (2, seen(), 1.1)]);
        assert_eq!(places(5), [(1, raised(), 4.0), (2, seen(), 4.1)]);
        assert_eq!(places(6), [(1, raised(), 4.0)]);
        assert_eq!(places(2), [(3, raised(), 1.0)]);
        assert_eq!(places(3), [(4, raised(), 1.0), (4, raised(), 2.0)]);
        assert_eq!(places(4), [(5, raised(), 1.0)]);
        assert_eq!(places(7), [(5, raised(), 3.0)]);
        let kind = |id| store.alarm(id).expect("alarm").novelties[0].kind.clone();
        assert_eq!(
            (kind(5), kind(6)),
            ("appeared".into(), "disappeared".into())
        );
        let row = |id: i64| {
            let alarm = store.alarm(id).expect("alarm");
            (alarm.visits, alarm.last_seen_at, alarm.state)
        };
        assert_eq!(row(1), (2, "t2".to_owned(), "open".to_owned()));
        assert_eq!(row(5), (2, "t2".to_owned(), "open".to_owned()));
        assert_eq!(row(6), (1, "t1".to_owned(), "open".to_owned()));
        assert_eq!(row(7), (1, "t5".to_owned(), "acknowledged".to_owned()));
        let split = store.alarm(7).expect("alarm");
        assert_eq!(
            (split.acknowledged_by, split.note),
            (Some("ana".into()), Some("a cart".into()))
        );
        let ids = |name| -> Vec<i64> {
            let incidents = store.incidents(name).expect("incidents");
            incidents.iter().map(|incident| incident.id).collect()
        };
        assert_eq!((ids("hall"), ids("dock")), (vec![1, 5, 6], vec![2, 4, 7]));
    }
}
