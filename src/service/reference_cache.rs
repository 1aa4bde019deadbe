//! References that are ready for visits, shared by all visits under the same settings.

use crate::config::Settings;
use crate::store::{ReadyReference, StoredMixture, StoredReference};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Each takes some tens of megabytes.
const MAX_CACHED_REFERENCES: usize = 8;

/// Newest last.
#[derive(Debug, Clone, Default)]
pub(super) struct ReferenceCache(Arc<Mutex<VecDeque<CachedReference>>>);

type CachedReference = (CacheKey, Arc<ReadyReference>);

/// What decides whether a reference is the one that was made ready. Every visit reads the row anew, so that a mixture that
/// another program replaced has another key.
#[derive(Debug, Clone, PartialEq)]
struct CacheKey {
    /// Sequence number in the store.
    id: i64,
    /// Checksum of the stored mixture.
    checksum: Option<String>,
    /// What the stored mixture was made by; `None` where it is not intact.
    stored_model: Option<String>,
    /// What the mixture has to be made by.
    model: String,
}

impl ReferenceCache {
    /// `stored`, ready to be compared with under `settings`; a reason where it cannot be.
    pub(super) fn get(
        &self,
        waypoint: &str,
        stored: &StoredReference,
        settings: &Settings,
    ) -> Result<Arc<ReadyReference>, String> {
        let (engine, seed) = (
            settings.engine_settings(Some(waypoint)),
            settings.mixture.seed,
        );
        let key = CacheKey {
            id: stored.id,
            checksum: stored.checksum.clone(),
            stored_model: match &stored.mixture {
                StoredMixture::Intact { model, .. } => Some(model.clone()),
                StoredMixture::Outdated | StoredMixture::Damaged { .. } => None,
            },
            model: engine.novelty.reference_model(seed),
        };
        // The checksum stays where the bytes beside it are damaged.
        if !matches!(stored.mixture, StoredMixture::Damaged { .. }) {
            let cached = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, ready)) = cached.iter().find(|(of, _)| *of == key) {
                return Ok(Arc::clone(ready));
            }
        }
        let ready = stored
            .make_ready(waypoint, &engine, seed)
            .map_err(|error| error.to_string())?;
        let ready = Arc::new(ready);
        let mut cached = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        cached.push_back((key, Arc::clone(&ready)));
        if cached.len() > MAX_CACHED_REFERENCES {
            cached.pop_front();
        }
        Ok(ready)
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_CACHED_REFERENCES, ReferenceCache};
    use crate::config::Settings;
    use crate::service::visit_tests::stored_reference::stored_reference;
    use crate::store::{StoredMixture, StoredReference};
    use nalgebra::{Matrix3, Point3};
    use patrold_engine::geometry::View;
    use patrold_engine::mixture::{Gaussian, Mixture};
    use patrold_engine::novelty::{ComponentBeams, ReferenceMixture};
    use std::sync::Arc;

    /// One flat Gaussian for a wall, which no fit gives.
    fn by_hand(y_m: f64) -> ReferenceMixture {
        ReferenceMixture {
            mixture: Mixture {
                weights: vec![1.0],
                components: vec![Gaussian {
                    mean: Point3::new(2.0, y_m, 0.0),
                    covariance: Matrix3::from_diagonal(&[1e-6, 0.4, 0.4].into()),
                }],
            },
            beams: vec![ComponentBeams {
                count: 1681.0,
                noise_m: 0.005,
                lost_share: 0.0,
            }],
        }
    }

    fn stored(settings: &Settings, gamma: ReferenceMixture, checksum: &str) -> StoredReference {
        let side = || (-20..=20).map(|i| 0.05 * f64::from(i));
        let points = side().flat_map(|y| side().map(move |z| Point3::new(2.0, y, z)));
        let view = View::from_points(points.collect(), Point3::origin());
        stored_reference(settings, view, gamma, checksum)
    }

    #[test]
    fn an_intact_mixture_is_used_without_a_fit_and_read_again_when_it_was_replaced() {
        let (cache, settings) = (ReferenceCache::default(), Settings::defaults());
        let first = stored(&settings, by_hand(0.0), "a");
        let ready = cache.get("hall", &first, &settings).expect("ready");
        assert_eq!(ready.reference.gamma, by_hand(0.0));
        assert!(ready.made_anew.is_none());
        let again = cache.get("hall", &first, &settings).expect("ready");
        assert!(Arc::ptr_eq(&ready, &again));
        let replaced = stored(&settings, by_hand(0.1), "b");
        let other = cache.get("hall", &replaced, &settings).expect("ready");
        assert_eq!(other.reference.gamma, by_hand(0.1));
        // The same bytes, of another model.
        let mut relabelled = stored(&settings, by_hand(0.1), "b");
        relabelled.mixture = StoredMixture::Intact {
            gamma: by_hand(0.1),
            model: "another".to_owned(),
        };
        let anew = cache.get("hall", &relabelled, &settings).expect("ready");
        assert!(anew.made_anew.is_some());
    }

    /// Two waypoints may have mixtures of the same bytes: their views are their own.
    #[test]
    fn waypoints_are_not_mixed() {
        let (cache, settings) = (ReferenceCache::default(), Settings::defaults());
        let hall = stored(&settings, by_hand(0.0), "a");
        let mut dock = stored(&settings, by_hand(0.0), "a");
        dock.id = 2;
        let points = dock.view.points.iter().map(|p| p + nalgebra::Vector3::z());
        dock.view = View::from_points(points.collect(), Point3::origin());
        let other = |name, of| cache.get(name, of, &settings).expect("ready");
        let (first, second) = (other("hall", &hall), other("dock", &dock));
        assert!(!Arc::ptr_eq(&first, &second));
        let seen =
            |ready: &Arc<crate::store::ReadyReference>| ready.reference.prepared.view.points[0].z;
        assert!((seen(&second) - seen(&first) - 1.0).abs() < 1e-9);
        for _ in 0..2 {
            assert!(Arc::ptr_eq(&first, &other("hall", &hall)));
            assert!(Arc::ptr_eq(&second, &other("dock", &dock)));
        }
    }

    #[test]
    fn the_newest_are_kept_and_no_more() {
        let (cache, settings) = (ReferenceCache::default(), Settings::defaults());
        let get = |id: usize| {
            let mut reference = stored(&settings, by_hand(0.0), "a");
            reference.id = id as i64;
            cache.get("hall", &reference, &settings).expect("ready")
        };
        let first: Vec<_> = (0..=MAX_CACHED_REFERENCES).map(get).collect();
        for (id, ready) in first.iter().enumerate().skip(1) {
            assert!(Arc::ptr_eq(ready, &get(id)), "{id}");
        }
        assert!(!Arc::ptr_eq(&first[0], &get(0)), "the oldest had to go");
    }

    #[test]
    fn models_are_not_mixed() {
        let (cache, settings) = (ReferenceCache::default(), Settings::defaults());
        let mut near = settings.clone();
        near.novelty.max_range_m = Some(2.2);
        let reference = stored(&settings, by_hand(0.0), "a");
        let get = |settings| cache.get("hall", &reference, settings).expect("ready");
        let (far, made_anew) = (get(&settings), get(&near));
        let why = &made_anew.made_anew.as_ref().expect("another model").why;
        assert!(why.starts_with("other settings: "), "{why}");
        assert_ne!(made_anew.reference.gamma, by_hand(0.0));
        assert!(Arc::ptr_eq(&far, &get(&settings)));
        assert!(Arc::ptr_eq(&made_anew, &get(&near)));
    }

    #[test]
    fn damage_is_refused_although_the_sound_mixture_is_at_hand() {
        let (cache, settings) = (ReferenceCache::default(), Settings::defaults());
        let mut reference = stored(&settings, by_hand(0.0), "a");
        cache.get("hall", &reference, &settings).expect("ready");
        reference.mixture = StoredMixture::Damaged {
            why: "it is torn".to_owned(),
        };
        let reason = cache
            .get("hall", &reference, &settings)
            .expect_err("damaged");
        assert_eq!(
            reason,
            "reference hall/1: its mixture is damaged: it is torn; make it anew from its view: patrold waypoints rebuild hall"
        );
    }
}
