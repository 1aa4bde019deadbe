//! Sweeps: one row each; points and raw data are files.

use super::blob_files::BlobFiles;
use super::connection::RecordTime;
use super::error::StoreError;
use patrold_engine::blob::encode_view;
use patrold_engine::geometry::View;
use rusqlite::{Transaction, params};

/// A sweep to be stored.
#[derive(Debug)]
pub struct SweepRecord<'a> {
    /// Points; `None`: the raw data could not be assembled.
    pub view: Option<&'a View>,
    /// Raw sweep, encoded.
    pub raw: Option<&'a [u8]>,
    /// Quality figures, as JSON; `null`: none.
    pub quality: &'a str,
}

/// File names of a sweep.
pub(super) struct SweepFiles {
    view: Option<String>,
    raw: Option<String>,
}

impl SweepRecord<'_> {
    pub(super) fn write_files(&self, files: &BlobFiles) -> Result<SweepFiles, StoreError> {
        let put_view = |view| files.put(&encode_view(view));
        Ok(SweepFiles {
            view: self.view.map(put_view).transpose()?,
            raw: self.raw.map(|raw| files.put(raw)).transpose()?,
        })
    }
}

pub(super) fn insert_sweep(
    change: &Transaction<'_>,
    waypoint_id: i64,
    sweep: &SweepRecord<'_>,
    files: &SweepFiles,
    stamp: &RecordTime,
) -> Result<i64, StoreError> {
    change.execute(
        "INSERT INTO sweep (waypoint_id, taken_at, boot_id, points, view_file, raw_file, quality)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
        params![
            waypoint_id,
            stamp.to_rfc3339(),
            stamp.boot_id,
            sweep.view.map_or(0, |view| view.points.len() as i64),
            files.view,
            files.raw,
            sweep.quality
        ],
    )?;
    Ok(change.last_insert_rowid())
}
