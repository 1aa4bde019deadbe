//! Rows of novelties and their shapes. Figures that are not finite are stored as NULL; where the JSON record of a
//! novelty cannot be read, its columns are used.

use super::error::StoreError;
use patrold_engine::report::{MethodsRecord, NoveltyRecord};
use rusqlite::{Connection, Row, Transaction, params};

pub(super) fn finite_or_null(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

pub(super) fn insert_novelties(
    change: &Transaction<'_>,
    visit_id: i64,
    novelties: &[NoveltyRecord],
) -> Result<(), StoreError> {
    for (position, novelty) in novelties.iter().enumerate() {
        let record = serde_json::to_string(novelty).map_err(|source| StoreError::Record {
            what: "novelty",
            source,
        })?;
        let [x_m, y_m, z_m] = novelty.centre.map(finite_or_null);
        change.execute(
            "INSERT INTO novelty (visit_id, position, kind, x_m, y_m, z_m, points, mass, contribution, record)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
            params![
                visit_id,
                position as i64,
                novelty.kind,
                x_m,
                y_m,
                z_m,
                novelty.points as i64,
                finite_or_null(novelty.mass),
                finite_or_null(novelty.contribution),
                record
            ],
        )?;
        if let Some(shape) = &novelty.shape {
            let novelty_id = change.last_insert_rowid();
            let [size_x_m, size_y_m, size_z_m] = shape.size.map(finite_or_null);
            change.execute(
                "INSERT INTO shape (novelty_id, class, method, probability, size_x_m, size_y_m, size_z_m)
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
                params![
                    novelty_id,
                    shape.class,
                    shape.method,
                    finite_or_null(shape.probability),
                    size_x_m,
                    size_y_m,
                    size_z_m
                ],
            )?;
        }
    }
    Ok(())
}

/// The novelties of a visit, by position.
pub(super) fn novelties_of_visit(
    db: &Connection,
    visit_id: i64,
) -> Result<Vec<NoveltyRecord>, StoreError> {
    let mut query = db.prepare_cached(
        "SELECT record, kind, x_m, y_m, z_m, points, mass, contribution
         FROM novelty WHERE visit_id = ?1 ORDER BY position",
    )?;
    let rows = query.query_map([visit_id], read_novelty)?;
    Ok(rows.collect::<Result<_, _>>()?)
}

/// From the columns record, kind, x_m, y_m, z_m, points, mass, contribution, in this order.
pub(super) fn read_novelty(row: &Row<'_>) -> rusqlite::Result<NoveltyRecord> {
    let record: String = row.get(0)?;
    serde_json::from_str(&record).or_else(|_| from_columns(row))
}

fn from_columns(row: &Row<'_>) -> rusqlite::Result<NoveltyRecord> {
    let figure =
        |at| -> rusqlite::Result<f64> { Ok(row.get::<_, Option<f64>>(at)?.unwrap_or(f64::NAN)) };
    Ok(NoveltyRecord {
        kind: row.get(1)?,
        moved_from: None,
        centre: [figure(2)?, figure(3)?, figure(4)?],
        covariance: [[f64::NAN; 3]; 3],
        pose_sd: None,
        extent: [f64::NAN; 3],
        points: row.get::<_, i64>(5)?.try_into().unwrap_or_default(),
        mass: figure(6)?,
        contribution: figure(7)?,
        support: f64::NAN,
        components: Vec::new(),
        needed_for_alarm: false,
        shape: None,
        shapes: MethodsRecord::default(),
        parts: Vec::new(),
    })
}
