//! A stretch of the log: only what differs is reported, as it is found. Visits are read one after the other and judged several at a
//! time; what is held in memory does not grow with the log.

use super::args::RejudgeArgs;
use super::judge::{NewVerdict, PreparedReference, judge, prepare};
use super::source::{SourceKind, SweepSource};
use crate::cli::failure::{CommandResult, DONE, FAILED, Failure};
use crate::cli::local_time::local_time;
use crate::cli::output;
use crate::cli::progress::Work;
use crate::config::Settings;
use crate::store::{Store, StoreError, StoredVisit, VisitDetail};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;

/// Numbers of visits read at a time.
const PAGE: u32 = 256;
/// Visits in memory for each thread.
const VISITS_PER_THREAD: usize = 2;
/// Prepared references kept: a round comes by its waypoints in turn.
const MAX_REFERENCES: usize = 16;

/// A visit whose verdict is another one now.
#[derive(Debug, Serialize)]
struct Difference {
    visit_id: i64,
    waypoint: String,
    at: String,
    clock_unset: bool,
    stored: VerdictBrief,
    judged: VerdictBrief,
    /// What it was judged from.
    source: SweepSource,
    /// What else differs: threshold, distance, settings, the reference's mixture.
    why: Vec<String>,
}

#[derive(Debug, Serialize)]
struct VerdictBrief {
    verdict: String,
    reason: String,
    d_gmm: Option<f64>,
    u_th: Option<f64>,
}

/// The last line of the report.
#[derive(Debug, Default, Serialize)]
struct Summary {
    /// Visits judged again.
    judged: u64,
    /// Of these, those judged from the bytes of the devices; the others from the stored sweep.
    from_device_bytes: u64,
    /// Of these, those whose verdict is another one now.
    differ: u64,
    /// Visits without a reference or without a stored sweep.
    not_kept: u64,
    /// Visits whose data is damaged.
    failed: u64,
}

struct Job {
    visit: StoredVisit,
    detail: VisitDetail,
    reference: Arc<PreparedReference>,
    settings: Arc<Settings>,
}

pub(super) fn run(args: &RejudgeArgs, ids: &[i64], settings: &Settings) -> CommandResult {
    let store = Store::open_for_reading(&settings.store.dir)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads)
        .build()
        .map_err(Failure::failed)?;
    let (range, waypoint) = (args.range.range(), args.waypoint.as_deref());
    let all = if ids.is_empty() {
        store.count_visits(&range, waypoint)?
    } else {
        ids.len() as u64
    };
    let mut rejudging = Rejudging {
        args,
        store: &store,
        settings: Arc::new(settings.clone()),
        references: Vec::new(),
        summary: Summary::default(),
        work: Work::of_steps(all as usize, "judging again"),
    };
    let batch = pool.current_num_threads() * VISITS_PER_THREAD;
    let mut judge_all = |page: &[i64]| {
        page.chunks(batch)
            .try_for_each(|ids| rejudging.judge(&pool, ids))
    };
    judge_all(ids)?;
    let mut after = 0;
    while ids.is_empty() {
        let page = store.visit_ids_after(after, &range, waypoint, PAGE)?;
        let Some(last) = page.last() else { break };
        after = *last;
        judge_all(&page)?;
    }
    let summary = rejudging.summary;
    drop(rejudging.work);
    if args.json {
        output::json(&summary)?;
    } else {
        output::line(format!(
            "{} visits judged again, {} from the bytes of the devices: {} differ; {} without a stored sweep or reference, {} failed",
            summary.judged,
            summary.from_device_bytes,
            summary.differ,
            summary.not_kept,
            summary.failed
        ))?;
    }
    Ok(if summary.failed > 0 { FAILED } else { DONE })
}

struct Rejudging<'a> {
    args: &'a RejudgeArgs,
    store: &'a Store,
    settings: Arc<Settings>,
    /// By reference and seed, the last used one last.
    references: Vec<((i64, u64), Arc<PreparedReference>)>,
    summary: Summary,
    work: Work,
}

impl Rejudging<'_> {
    /// Judges a few visits at a time and reports in their order.
    fn judge(&mut self, pool: &rayon::ThreadPool, ids: &[i64]) -> Result<(), Failure> {
        let mut jobs = Vec::new();
        for id in ids {
            match self.load(*id) {
                Ok(Some(job)) => jobs.push(job),
                Ok(None) => self.summary.not_kept += 1,
                Err(failure) => self.report_failure(*id, &failure),
            }
        }
        let judged: Vec<Result<NewVerdict, Failure>> = pool.install(|| {
            let jobs = jobs.par_iter().with_max_len(1);
            jobs.map(|job| judge(&job.visit, &job.reference, &job.settings))
                .collect()
        });
        for (job, verdict) in jobs.iter().zip(judged) {
            match verdict {
                Ok(verdict) => self.report(job, &verdict)?,
                Err(failure) => self.report_failure(job.detail.row.id, &failure),
            }
        }
        self.work.advance(ids.len());
        Ok(())
    }

    /// `None` where the visit has no reference or no sweep.
    fn load(&mut self, id: i64) -> Result<Option<Job>, Failure> {
        let visit = match self.store.visit(id) {
            Ok(visit) => visit,
            Err(StoreError::NotKept { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let Some(reference_id) = visit.reference_id else {
            return Ok(None);
        };
        let mut settings = Arc::clone(&self.settings);
        if let Some(u_th) = visit.u_th.filter(|_| self.args.stored_u_th) {
            Arc::make_mut(&mut settings).set_u_th(&visit.waypoint, u_th);
        }
        let Some(reference) = self.reference(reference_id, &visit)? else {
            return Ok(None);
        };
        Ok(Some(Job {
            detail: self.store.visit_detail(id)?,
            visit,
            reference,
            settings,
        }))
    }

    /// A reference does not depend on the threshold: one serves all visits of its seed.
    fn reference(
        &mut self,
        id: i64,
        visit: &StoredVisit,
    ) -> Result<Option<Arc<PreparedReference>>, Failure> {
        let key = (id, visit.seed);
        if let Some(at) = self.references.iter().position(|(known, _)| *known == key) {
            let found = self.references.remove(at);
            self.references.push(found);
        } else {
            let stored = match self.store.reference_by_id(id) {
                Ok(stored) => stored,
                Err(StoreError::NotKept { .. }) => return Ok(None),
                Err(error) => return Err(error.into()),
            };
            let prepared = prepare(visit, &stored, &self.settings)?;
            if self.references.len() == MAX_REFERENCES {
                self.references.remove(0);
            }
            self.references.push((key, Arc::new(prepared)));
        }
        Ok(self
            .references
            .last()
            .map(|(_, reference)| Arc::clone(reference)))
    }

    fn report(&mut self, job: &Job, judged: &NewVerdict) -> Result<(), Failure> {
        self.summary.judged += 1;
        let from_bytes = judged.source.from == SourceKind::DeviceBytes;
        self.summary.from_device_bytes += u64::from(from_bytes);
        let row = &job.detail.row;
        if row.verdict == judged.verdict {
            return Ok(());
        }
        self.summary.differ += 1;
        let difference = Difference {
            visit_id: row.id,
            waypoint: row.waypoint.clone(),
            at: row.at.clone(),
            clock_unset: row.clock_unset,
            source: judged.source.clone(),
            why: reasons(job, judged),
            stored: VerdictBrief {
                verdict: row.verdict.clone(),
                reason: row.reason.clone(),
                d_gmm: row.d_gmm,
                u_th: row.u_th,
            },
            judged: VerdictBrief {
                verdict: judged.verdict.to_owned(),
                reason: judged.reason.clone(),
                d_gmm: judged.d_gmm,
                u_th: Some(judged.u_th),
            },
        };
        // A bar in the way of the text would be torn.
        self.work.suspend(|| {
            if self.args.json {
                output::json(&difference)
            } else {
                output::line(difference_text(&difference))
            }
        })
    }

    fn report_failure(&mut self, id: i64, failure: &Failure) {
        self.summary.failed += 1;
        self.work
            .suspend(|| output::warning(&format!("visit {id}: {failure}")));
    }
}

/// What differs between then and now, as far as it leads to another verdict.
fn reasons(job: &Job, judged: &NewVerdict) -> Vec<String> {
    let row = &job.detail.row;
    let mut reasons = Vec::new();
    if row.u_th != Some(judged.u_th) {
        reasons.push(format!(
            "U_th {} instead of {}",
            number(Some(judged.u_th)),
            number(row.u_th)
        ));
    }
    if row.d_gmm != judged.d_gmm {
        reasons.push(format!(
            "d_GMM {} instead of {}",
            number(judged.d_gmm),
            number(row.d_gmm)
        ));
    }
    let (then, now) = (&job.visit.engine, job.settings.engine_json());
    if *then != now {
        reasons.push(format!("settings {now} instead of {then}"));
    }
    if let Some(why) = &judged.made_anew {
        reasons.push(format!("the mixture of the reference was made anew: {why}"));
    }
    reasons
}

fn number(x: Option<f64>) -> String {
    x.map_or_else(|| "none".to_owned(), |x| format!("{x:.6}"))
}

fn difference_text(difference: &Difference) -> String {
    let brief = |verdict: &VerdictBrief| {
        format!("{} ({})", verdict.verdict.replace('_', " "), verdict.reason)
    };
    let mut lines = vec![format!(
        "visit {} at {}, {}: {} instead of {}",
        difference.visit_id,
        difference.waypoint,
        local_time(&difference.at, difference.clock_unset),
        brief(&difference.judged),
        brief(&difference.stored)
    )];
    lines.extend(difference.why.iter().map(|why| format!("  {why}")));
    lines.join("\n")
}
