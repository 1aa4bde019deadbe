//! From a stored reference to one that visits are compared with: its mixture as it is, or made anew from its view.

use super::StoredReference;
use super::stored_mixture::StoredMixture;
use patrold_engine::blob::{BlobError, decode_mixture, encode_mixture};
use patrold_engine::inspect::{EngineSettings, prepare};
use patrold_engine::novelty::{NoveltyError, Reference};

/// A reference ready for any number of comparisons.
#[derive(Debug)]
pub struct ReadyReference {
    /// With the stored mixture, or with one that was made anew.
    pub reference: Reference,
    /// What the mixture was made by, as JSON.
    pub model: String,
    /// `None` where the stored mixture is used.
    pub made_anew: Option<MadeAnew>,
}

/// A mixture that was made anew from the view of its reference.
#[derive(Debug)]
pub struct MadeAnew {
    /// Why, for a person to read.
    pub why: String,
    /// Its stored form.
    pub(in crate::store) bytes: Vec<u8>,
}

/// Why a stored reference cannot be compared with.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The stored mixture is damaged.
    #[error(
        "reference {frame}: its mixture is damaged: {why}; make it anew from its view: {command}"
    )]
    Damaged {
        /// Waypoint and version, as `NAME/VERSION`.
        frame: String,
        /// What is wrong.
        why: String,
        /// The command that makes it anew.
        command: String,
    },
    /// The view or the mixture is none for the engine.
    #[error("reference {frame}: {source}")]
    Unusable {
        /// Waypoint and version, as `NAME/VERSION`.
        frame: String,
        /// Error of the engine.
        source: NoveltyError,
    },
    /// A mixture that was just made cannot be stored.
    #[error("reference {frame}: {source}")]
    Unstorable {
        /// Waypoint and version, as `NAME/VERSION`.
        frame: String,
        /// Error of its stored form.
        source: BlobError,
    },
}

impl StoredReference {
    /// Makes it ready for comparisons under `settings`. An intact mixture of the same model is used as it is; nothing is
    /// fitted then. One that is outdated or of another model is made anew from the view. `waypoint` is its name, `seed` is
    /// for fits with random starts.
    ///
    /// # Errors
    /// A damaged mixture, or a view that cannot be compared.
    pub fn make_ready(
        &self,
        waypoint: &str,
        settings: &EngineSettings,
        seed: u64,
    ) -> Result<ReadyReference, ReferenceError> {
        let frame = || self.frame(waypoint);
        let model = settings.novelty.reference_model(seed);
        let why = match &self.mixture {
            StoredMixture::Damaged { why } => {
                return Err(ReferenceError::Damaged {
                    frame: frame(),
                    why: why.clone(),
                    command: self.rebuild_command(waypoint),
                });
            }
            StoredMixture::Intact {
                gamma,
                model: stored,
            } if *stored == model => {
                let reference =
                    Reference::from_stored(&self.view, gamma.clone(), &settings.novelty);
                return Ok(ReadyReference {
                    reference: reference.map_err(|source| ReferenceError::Unusable {
                        frame: frame(),
                        source,
                    })?,
                    model,
                    made_anew: None,
                });
            }
            StoredMixture::Intact { model: stored, .. } => {
                let stored = stored.replace(['\n', '\r'], " ");
                format!("other settings: {model} instead of {stored}")
            }
            StoredMixture::Outdated => "an earlier version of patrold made it".to_owned(),
        };
        self.make_anew(waypoint, settings, seed, why)
    }

    /// Makes it ready with a mixture that is made anew from the view, whatever is stored; `why` is kept in the result.
    ///
    /// # Errors
    /// A view that cannot be compared.
    pub fn make_anew(
        &self,
        waypoint: &str,
        settings: &EngineSettings,
        seed: u64,
        why: String,
    ) -> Result<ReadyReference, ReferenceError> {
        let frame = || self.frame(waypoint);
        let mut reference =
            prepare(&self.view, settings, seed).map_err(|source| ReferenceError::Unusable {
                frame: frame(),
                source,
            })?;
        // Reading scales the weights, which may move their last bit: the first visit compares as all that follow.
        let bytes = encode_mixture(&reference.gamma);
        reference.gamma = decode_mixture(&bytes).map_err(|source| ReferenceError::Unstorable {
            frame: frame(),
            source,
        })?;
        Ok(ReadyReference {
            reference,
            model: settings.novelty.reference_model(seed),
            made_anew: Some(MadeAnew { why, bytes }),
        })
    }

    /// `NAME/VERSION`.
    pub fn frame(&self, waypoint: &str) -> String {
        format!("{waypoint}/{}", self.version)
    }

    /// `NAME/VERSION` of the frame that its positions are in.
    pub fn positions_frame(&self, waypoint: &str) -> String {
        format!("{waypoint}/{}", self.frame_version)
    }

    fn rebuild_command(&self, waypoint: &str) -> String {
        let version = if self.in_use {
            String::new()
        } else {
            format!(" --reference-version {}", self.version)
        };
        format!("patrold waypoints rebuild {waypoint}{version}")
    }
}
