//! `patrold waypoints rebuild NAME`: the mixture of a reference, made anew from its stored view.

use super::failure::{CommandResult, DONE, Failure};
use super::output;
use crate::config::Settings;
use crate::service::record_time_now;
use crate::store::{NewMixture, Store, StoredMixture};
use serde::Serialize;

#[derive(Debug, Serialize)]
struct RebuildReport<'a> {
    waypoint: &'a str,
    version: i64,
    /// State of the mixture before.
    was: &'static str,
    components_before: usize,
    components: usize,
    /// What the new mixture was made by.
    model: &'a str,
}

/// `version`: another one than the newest. The service may be running; its next visit reads the new mixture.
pub(super) fn run(
    settings: &Settings,
    name: &str,
    version: Option<i64>,
    as_json: bool,
) -> CommandResult {
    let mut store = Store::open_existing(&settings.store.dir)?;
    let stored = match version {
        Some(version) => store.reference_version(name, version)?,
        None => store.reference(name)?,
    };
    let was = stored.mixture.state();
    let why = match &stored.mixture {
        StoredMixture::Damaged { why } => format!("on request; it was damaged: {why}"),
        StoredMixture::Intact { .. } | StoredMixture::Outdated => {
            format!("on request; it was {was}")
        }
    };
    let (engine, seed) = (settings.engine_settings(Some(name)), settings.mixture.seed);
    let ready = stored
        .make_anew(name, &engine, seed, why)
        .map_err(Failure::failed)?;
    if let Some(made_anew) = &ready.made_anew {
        let new = NewMixture {
            waypoint: name,
            stored: &stored,
            ready: &ready,
            made_anew,
            engine: &settings.engine_json(),
            seed,
        };
        if !store.replace_mixture(&new, &record_time_now())? {
            return Err(Failure::Failed(format!(
                "reference {}: another program replaced its mixture meanwhile; try again",
                stored.frame(name)
            )));
        }
    }
    let report = RebuildReport {
        waypoint: name,
        version: stored.version,
        was,
        components_before: stored.components,
        components: ready.reference.gamma.mixture.len(),
        model: &ready.model,
    };
    if as_json {
        output::json(&report)?;
    } else {
        output::line(format!(
            "reference {}: mixture made anew from its view, {} components instead of {} ({was})",
            stored.frame(name),
            report.components,
            report.components_before
        ))?;
    }
    Ok(DONE)
}
