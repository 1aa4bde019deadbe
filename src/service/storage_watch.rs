//! What of the store's upkeep is reported to the event log: each change once.

use crate::patrol::severity::Severity;
use crate::store::{StorageReport, StoreStart};

/// What was last reported of the store.
#[derive(Debug, Default)]
pub(super) struct StorageWatch {
    is_behind: bool,
    /// Why the space is low, as it was when that began.
    low_space: Option<String>,
    journal_fails: bool,
}

type Note = (Severity, String);

impl StorageWatch {
    pub(super) fn note_start(start: &StoreStart) -> Vec<Note> {
        let mut notes = Vec::new();
        if start.evidence_missing > 0 {
            let text = format!(
                "{} sweeps have no files: patrold was stopped before they were written; their verdicts are stored",
                start.evidence_missing
            );
            notes.push((Severity::Warning, text));
        }
        if let Some(files) = start.lost_files {
            let text = format!(
                "the database was lost or set back: it does not know what is in the journal and in {files} evidence files; \
                 nothing is deleted; stop the service and run patrold store rebuild"
            );
            notes.push((Severity::Error, text));
        }
        let failures = start.failures.iter();
        notes.extend(failures.map(|failure| (Severity::Error, failure.to_string())));
        notes
    }

    pub(super) fn note(&mut self, report: &StorageReport) -> Vec<Note> {
        let mut notes = Vec::new();
        let retry = &report.retry;
        for (waypoint, at, outcome) in &retry.stored {
            let alarms = outcome.effects.alarms.iter();
            let alarm: String = alarms.map(|a| format!(", alarm {}", a.id)).collect();
            let (at, visit) = (at.to_rfc3339(), outcome.visit_id);
            let text = format!("{waypoint}: the visit of {at} is stored now: visit {visit}{alarm}");
            notes.push((Severity::Warning, text));
        }
        for (waypoint, at, why) in &retry.refused {
            let text = format!(
                "{waypoint}: the visit of {} is lost: {why}",
                at.to_rfc3339()
            );
            notes.push((Severity::Error, text));
        }
        let is_behind = retry.held + retry.waiting > 0;
        if let (true, false, Some(why)) = (is_behind, self.is_behind, &retry.why) {
            let text = format!(
                "{} visits and the files of {} more are held in memory: {why}",
                retry.held, retry.waiting
            );
            notes.push((Severity::Error, text));
        }
        if self.is_behind && !is_behind {
            let text = "everything that was held in memory is stored".to_owned();
            notes.push((Severity::Info, text));
        }
        self.is_behind = is_behind;
        if let (Some(why), false) = (&report.journal_error, self.journal_fails) {
            let text = format!("the journal is not up to date: {why}");
            notes.push((Severity::Error, text));
        }
        self.journal_fails = report.journal_error.is_some();
        match &report.compacted {
            Ok(Some(done)) => {
                let [before, now] = [done.before, done.after].map(|bytes| bytes / 1_000_000);
                let text = format!("the journal was compacted: {now} MB instead of {before} MB");
                notes.push((Severity::Info, text));
            }
            Ok(None) => {}
            Err(error) => {
                let text = format!("the journal is not compacted: {error}");
                notes.push((Severity::Warning, text));
            }
        }
        notes.extend(self.note_space(report));
        notes
    }

    /// Why the store is without space, as a health incident; `None`: it has some.
    pub(super) fn low_space(&self) -> Option<&str> {
        self.low_space.as_deref()
    }

    fn note_space(&mut self, report: &StorageReport) -> Option<Note> {
        let space = report.space.as_ref().ok()?;
        let free_mb = space.free_bytes / 1_000_000;
        if space.is_low() && self.low_space.is_none() {
            let text = format!(
                "low space: {free_mb} MB are free, room for {} visits; make room or lower store.keep_gib",
                space.visits()
            );
            self.low_space = Some(text.clone());
            return Some((Severity::Warning, text));
        }
        if space.is_ample() && self.low_space.take().is_some() {
            return Some((
                Severity::Info,
                format!("space again: {free_mb} MB are free"),
            ));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::StorageWatch;
    use crate::patrol::severity::Severity;
    use crate::store::{CompactedJournal, DiskSpace, RetryResult, StorageReport, StoreError};

    /// Room for this many visits, beside the reserve of 16 MiB.
    fn report(visits: u64, held: usize, journal_error: Option<&str>) -> StorageReport {
        StorageReport {
            retry: RetryResult {
                held,
                why: (held > 0).then_some(StoreError::UnknownAlarm(7)),
                ..RetryResult::default()
            },
            journal_error: journal_error.map(str::to_owned),
            compacted: Ok(None),
            space: Ok(DiskSpace {
                free_bytes: (16 << 20) + visits * 1000,
                visit_bytes: 1000,
            }),
        }
    }

    fn severities(watch: &mut StorageWatch, report: &StorageReport) -> Vec<Severity> {
        watch.note(report).into_iter().map(|note| note.0).collect()
    }

    #[test]
    fn each_change_is_reported_once() {
        let mut watch = StorageWatch::default();
        for (report, expected) in [
            (report(1000, 0, None), vec![]),
            (report(119, 0, None), vec![Severity::Warning]),
            (report(119, 0, None), vec![]),
            // Not yet ample.
            (report(149, 0, None), vec![]),
            (report(119, 0, None), vec![]),
            (report(150, 0, None), vec![Severity::Info]),
            (report(1000, 2, None), vec![Severity::Error]),
            (report(1000, 3, None), vec![]),
            (
                report(1000, 0, Some("full")),
                vec![Severity::Info, Severity::Error],
            ),
            (report(1000, 0, Some("full")), vec![]),
            (report(1000, 0, None), vec![]),
            (report(1000, 0, Some("full")), vec![Severity::Error]),
        ] {
            assert_eq!(severities(&mut watch, &report), expected, "{report:?}");
        }
    }

    #[test]
    fn a_compacted_journal_is_noted_and_one_that_cannot_be() {
        let mut watch = StorageWatch::default();
        let mut compacted = report(1000, 0, None);
        let (before, after) = (130_000_000, 64_000_000);
        compacted.compacted = Ok(Some(CompactedJournal { before, after }));
        let notes = watch.note(&compacted);
        let text = "the journal was compacted: 64 MB instead of 130 MB".to_owned();
        assert_eq!(notes, [(Severity::Info, text)]);
        compacted.compacted = Err(StoreError::UnknownAlarm(7));
        assert_eq!(severities(&mut watch, &compacted), [Severity::Warning]);
    }
}
