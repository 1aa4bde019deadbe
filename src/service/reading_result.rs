//! What became of reading the configuration's files.

use super::record_time::record_time_now;
use super::replies::ReloadReply;
use crate::config::LoadedConfig;

/// What became of reading the files, where `loaded` is what is in force.
pub(super) fn reading_result(loaded: &LoadedConfig) -> ReloadReply {
    ReloadReply {
        taken: loaded.refused.is_empty(),
        at: record_time_now().to_rfc3339(),
        files: loaded
            .files
            .iter()
            .map(|file| file.display().to_string())
            .collect(),
        mistakes: loaded.refused.iter().map(ToString::to_string).collect(),
        needs_restart: Vec::new(),
    }
}
