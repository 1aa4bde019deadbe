//! Look-ups of rows by name or number that several files of the store need.

use super::error::StoreError;
use rusqlite::{Connection, OptionalExtension};

/// Id of a waypoint that is not forgotten.
pub(super) fn waypoint_id(db: &Connection, name: &str) -> Result<i64, StoreError> {
    if let Some(id) = find_waypoint_id(db, name)? {
        return Ok(id);
    }
    let known = join_names(db, "WHERE forgotten_at IS NULL")?;
    let name = name.to_owned();
    Err(StoreError::UnknownWaypoint { name, known })
}

/// Refuses a name that no waypoint ever had; a forgotten waypoint is still in the log.
pub(super) fn check_in_log(db: &Connection, name: &str) -> Result<(), StoreError> {
    let sql = "SELECT EXISTS (SELECT 1 FROM waypoint WHERE name = ?1)";
    if db.query_row(sql, [name], |row| row.get(0))? {
        return Ok(());
    }
    let known = join_names(db, "")?;
    let name = name.to_owned();
    Err(StoreError::NotInLog { name, known })
}

/// Ids of all waypoints that ever had the name, forgotten ones too.
pub(super) fn waypoint_ids_in_log(db: &Connection, name: &str) -> Result<Vec<i64>, StoreError> {
    check_in_log(db, name)?;
    let mut query = db.prepare_cached("SELECT id FROM waypoint WHERE name = ?1 ORDER BY id")?;
    let ids = query.query_map([name], |row| row.get(0))?;
    Ok(ids.collect::<Result<_, _>>()?)
}

/// Frame of positions: NAME/VERSION of the reference, the name alone where there is none.
pub(super) fn frame_name(waypoint: &str, version: Option<i64>) -> String {
    version.map_or_else(|| waypoint.to_owned(), |v| format!("{waypoint}/{v}"))
}

fn join_names(db: &Connection, condition: &str) -> Result<String, StoreError> {
    let sql = format!("SELECT DISTINCT name FROM waypoint {condition} ORDER BY name");
    let mut query = db.prepare(&sql)?;
    let names: Vec<String> = query
        .query_map([], |row| row.get(0))?
        .collect::<Result<_, _>>()?;
    Ok(if names.is_empty() {
        "none yet".to_owned()
    } else {
        names.join(", ")
    })
}

/// Id of a waypoint, if it exists and is not forgotten.
pub(super) fn find_waypoint_id(db: &Connection, name: &str) -> rusqlite::Result<Option<i64>> {
    db.query_row(
        "SELECT id FROM waypoint WHERE name = ?1 AND forgotten_at IS NULL",
        [name],
        |row| row.get(0),
    )
    .optional()
}

/// Id of the reference in use at a waypoint.
pub(super) fn newest_reference_id(
    db: &Connection,
    waypoint_id: i64,
) -> rusqlite::Result<Option<i64>> {
    db.query_row(
        "SELECT id FROM reference WHERE waypoint_id = ?1 ORDER BY version DESC LIMIT 1",
        [waypoint_id],
        |row| row.get(0),
    )
    .optional()
}
