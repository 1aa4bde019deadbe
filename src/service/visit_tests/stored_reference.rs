//! A reference as the store gives it, without a store.

use crate::config::Settings;
use crate::store::{StoredMixture, StoredReference};
use patrold_engine::geometry::View;
use patrold_engine::novelty::ReferenceMixture;

/// The only version of its waypoint, intact, made by the model of `settings`; `checksum` stands for that of its bytes.
pub(in crate::service) fn stored_reference(
    settings: &Settings,
    view: View,
    gamma: ReferenceMixture,
    checksum: &str,
) -> StoredReference {
    let (engine, seed) = (settings.engine_settings(None), settings.mixture.seed);
    StoredReference {
        id: 1,
        version: 1,
        frame_version: 1,
        view,
        components: gamma.mixture.len(),
        mixture: StoredMixture::Intact {
            gamma,
            model: engine.novelty.reference_model(seed),
        },
        checksum: Some(checksum.to_owned()),
        in_use: true,
        engine: settings.engine_json(),
        seed,
    }
}
