//! Sweeps: one row each; points and raw data are files. The row of a visit's sweep is written before its files and says
//! whether they are there; that of a reference after them.

use super::blob_files::BlobFiles;
use super::checksum::sha256_hex;
use super::connection::RecordTime;
use super::error::StoreError;
use patrold_engine::blob::encode_view;
use patrold_engine::geometry::View;
use rusqlite::{Transaction, params};

/// A sweep to be stored.
#[derive(Debug, Clone)]
pub struct SweepRecord<'a> {
    /// Points; `None`: the raw data could not be assembled.
    pub view: Option<&'a View>,
    /// Raw sweep, encoded.
    pub raw: Option<&'a [u8]>,
    /// The bytes of both devices as they came: docs/recording.md.
    pub dialogue: Option<&'a [u8]>,
    /// Quality figures, as JSON; `null`: none.
    pub quality: &'a str,
}

/// The files of a sweep: their bytes, and the names that follow from these.
#[derive(Debug, Clone, Default)]
pub(super) struct SweepFiles {
    view: Option<(String, Vec<u8>)>,
    raw: Option<(String, Vec<u8>)>,
    dialogue: Option<(String, Vec<u8>)>,
}

/// Why a sweep has no dialogue.
const NOT_RECORDED: &str = "they were not recorded";

impl SweepRecord<'_> {
    pub(super) fn files(&self) -> SweepFiles {
        let named = |bytes: Vec<u8>| (sha256_hex(&bytes), bytes);
        SweepFiles {
            view: self.view.map(|view| named(encode_view(view))),
            raw: self.raw.map(|raw| named(raw.to_vec())),
            dialogue: self.dialogue.map(|bytes| named(bytes.to_vec())),
        }
    }
}

impl SweepFiles {
    /// View and raw data; on disk when this returns.
    pub(super) fn write(&self, files: &BlobFiles) -> Result<(), StoreError> {
        for (_, bytes) in self.view.iter().chain(&self.raw) {
            files.put(bytes)?;
        }
        Ok(())
    }

    /// The dialogue; on disk when this returns.
    pub(super) fn write_dialogue(&self, files: &BlobFiles) -> Result<(), StoreError> {
        if let Some((_, bytes)) = &self.dialogue {
            files.put(bytes)?;
        }
        Ok(())
    }

    /// Of view and raw data.
    pub(super) fn bytes(&self) -> u64 {
        let files = self.view.iter().chain(&self.raw);
        files.map(|(_, bytes)| bytes.len() as u64).sum()
    }

    pub(super) fn dialogue_bytes(&self) -> u64 {
        self.dialogue
            .as_ref()
            .map_or(0, |(_, bytes)| bytes.len() as u64)
    }
}

/// `evidence` is `stored`, or `pending` where the files are written afterwards.
pub(super) fn insert_sweep(
    change: &Transaction<'_>,
    waypoint_id: i64,
    sweep: &SweepRecord<'_>,
    files: &SweepFiles,
    evidence: &str,
    stamp: &RecordTime,
) -> Result<i64, StoreError> {
    let name = |file: &Option<(String, Vec<u8>)>| file.as_ref().map(|(name, _)| name.clone());
    change.execute(
        "INSERT INTO sweep (waypoint_id, taken_at, boot_id, points, view_file, raw_file, quality, evidence, dialogue_file,
                            dialogue_why)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
        params![
            waypoint_id,
            stamp.to_rfc3339(),
            stamp.boot_id,
            sweep.view.map_or(0, |view| view.points.len() as i64),
            name(&files.view),
            name(&files.raw),
            sweep.quality,
            evidence,
            name(&files.dialogue),
            files.dialogue.is_none().then_some(NOT_RECORDED),
        ],
    )?;
    Ok(change.last_insert_rowid())
}
