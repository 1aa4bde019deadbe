//! Replaces the mixture of a stored reference by one that was made anew from its view.

use super::super::checksum::sha256_hex;
use super::super::connection::{RecordTime, Store};
use super::super::error::StoreError;
use super::super::events::insert_event;
use super::StoredReference;
use super::ready_reference::{MadeAnew, ReadyReference};
use crate::patrol::severity::Severity;
use rusqlite::params;

/// A mixture made anew for a stored reference.
#[derive(Debug)]
pub struct NewMixture<'a> {
    /// Name of the reference's waypoint.
    pub waypoint: &'a str,
    /// The reference as it was read.
    pub stored: &'a StoredReference,
    /// The same, ready with the new mixture.
    pub ready: &'a ReadyReference,
    /// The new mixture: that of `ready`.
    pub made_anew: &'a MadeAnew,
    /// Engine settings of the new mixture, as JSON.
    pub engine: &'a str,
    /// Seed of the engine's random numbers.
    pub seed: u64,
}

impl NewMixture<'_> {
    /// What happened and why, one line; an event of the log has this text.
    pub fn text(&self) -> String {
        format!(
            "reference {}: mixture made anew from its view, {} components instead of {}: {}",
            self.stored.frame(self.waypoint),
            self.ready.reference.gamma.mixture.len(),
            self.stored.components,
            self.made_anew.why
        )
    }
}

impl Store {
    /// Puts the new mixture in the place of the old one and notes the event. False, and nothing is changed, if the row is
    /// not as it was read: another program replaced the mixture meanwhile.
    ///
    /// # Errors
    /// The database fails; nothing is changed then.
    pub fn replace_mixture(
        &mut self,
        new: &NewMixture<'_>,
        stamp: &RecordTime,
    ) -> Result<bool, StoreError> {
        let components = new.ready.reference.gamma.mixture.len();
        let bytes = &new.made_anew.bytes;
        self.transaction(|change| {
            let changed = change.execute(
                "UPDATE reference SET mixture = ?3, mixture_sha256 = ?4, model = ?5, components = ?6, engine = ?7, seed = ?8
                 WHERE id = ?1 AND mixture_sha256 IS ?2",
                params![
                    new.stored.id,
                    new.stored.checksum,
                    bytes,
                    sha256_hex(bytes),
                    new.ready.model,
                    components as i64,
                    new.engine,
                    new.seed as i64
                ],
            )?;
            if changed > 0 {
                insert_event(change, Severity::Info, "service", &new.text(), stamp)?;
            }
            Ok(changed > 0)
        })
    }
}
