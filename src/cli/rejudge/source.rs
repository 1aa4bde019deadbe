//! What a visit is judged again from: the bytes of the devices, where they give the stored sweep, else the sweep as stored.

use crate::cli::failure::Failure;
use crate::devices::replay_sweep;
use crate::store::StoredVisit;
use patrold_engine::blob::encode_view;
use patrold_engine::geometry::View;
use patrold_engine::sweep::{RawSweep, SweepQuality, assemble, decode_raw_sweep, encode_raw_sweep};
use serde::Serialize;

/// What a verdict began from.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct SweepSource {
    pub(super) from: SourceKind,
    /// Why it did not begin from the bytes; null where it did.
    pub(super) why: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SourceKind {
    /// The sweep as it was stored.
    #[default]
    StoredSweep,
    /// The bytes of both devices.
    DeviceBytes,
}

impl SourceKind {
    pub(super) fn as_str(self) -> &'static str {
        match self {
            Self::StoredSweep => "the stored sweep",
            Self::DeviceBytes => "the bytes of the devices",
        }
    }
}

/// A sweep with its quality figures, if it has some; or why there is none.
type Points = Result<(View, Option<SweepQuality>), String>;

pub(super) struct LoadedSweep {
    pub(super) sweep: Points,
    pub(super) source: SweepSource,
}

/// # Errors
/// Stored data that cannot be read, and no bytes of the devices either.
pub(super) fn load_sweep(visit: &StoredVisit) -> Result<LoadedSweep, Failure> {
    let why = match assemble_bytes(visit) {
        Ok(sweep) => {
            let from = SourceKind::DeviceBytes;
            let source = SweepSource { from, why: None };
            return Ok(LoadedSweep { sweep, source });
        }
        Err(why) => why,
    };
    if visit.view.is_none() && visit.raw.is_none() {
        return Err(Failure::Failed(why));
    }
    Ok(LoadedSweep {
        sweep: load_stored(visit)?,
        source: SweepSource {
            from: SourceKind::StoredSweep,
            why: Some(why),
        },
    })
}

/// The sweep of the bytes; the reason where they give none, or another one than was stored.
fn assemble_bytes(visit: &StoredVisit) -> Result<Points, String> {
    let bytes = visit.dialogue.as_ref().map_err(Clone::clone)?;
    let replayed = replay_sweep(bytes).map_err(|error| error.to_string())?;
    let raw = match replayed.sweep {
        Ok(raw) => raw,
        Err(_) if visit.view.is_some() || visit.raw.is_some() => {
            return Err("the bytes of the devices give no sweep, and one is stored".to_owned());
        }
        Err(error) => return Ok(Err(error.to_string())),
    };
    let assembled = assemble(&raw).map_err(|error| error.to_string());
    if gives_another(
        visit,
        &raw,
        assembled.as_ref().ok().map(|sweep| &sweep.view),
    ) {
        return Err("the bytes of the devices give another sweep than the stored one".to_owned());
    }
    Ok(assembled.map(|sweep| (sweep.view, Some(sweep.quality))))
}

/// Compared as they are stored: to the last bit.
fn gives_another(visit: &StoredVisit, raw: &RawSweep, view: Option<&View>) -> bool {
    let other_raw = visit
        .raw
        .as_ref()
        .is_some_and(|stored| *stored != encode_raw_sweep(raw));
    let other_view = visit
        .view
        .as_ref()
        .is_some_and(|stored| view.map(encode_view) != Some(encode_view(stored)));
    other_raw || other_view
}

/// The stored view with its quality, or where there is none, the raw sweep assembled again; a reason where that fails.
fn load_stored(visit: &StoredVisit) -> Result<Points, Failure> {
    if let Some(view) = &visit.view {
        let quality = match visit.quality.as_str() {
            "" | "{}" | "null" => None,
            text => Some(
                serde_json::from_str(text)
                    .map_err(|error| Failure::Failed(format!("stored sweep quality: {error}")))?,
            ),
        };
        return Ok(Ok((view.clone(), quality)));
    }
    let raw = visit.raw.as_deref().unwrap_or_default();
    let raw = decode_raw_sweep(raw)
        .map_err(|error| Failure::Failed(format!("stored raw sweep: {error}")))?;
    Ok(assemble(&raw)
        .map(|sweep| (sweep.view, Some(sweep.quality)))
        .map_err(|error| error.to_string()))
}
