//! One visit, in full.

use super::args::RejudgeArgs;
use super::judge::{NewVerdict, judge, prepare};
use super::source::SweepSource;
use crate::cli::alarm_report::novelty_text;
use crate::cli::failure::{CommandResult, Failure};
use crate::cli::progress::PlannedWork;
use crate::cli::{mixtures_out, output};
use crate::config::Settings;
use crate::store::Store;
use serde::Serialize;
use std::time::Duration;

/// What it takes, as shown while it lasts, seconds: a reference whose mixture is made anew, and the usual judgement.
const PHASES: [(&str, u64); 2] = [("reference", 1), ("judging", 2)];

/// The verdict in the log.
#[derive(Debug, Serialize)]
struct StoredVerdict {
    verdict: String,
    d_gmm: Option<f64>,
    u_th: Option<f64>,
}

#[derive(Debug, Serialize)]
struct RejudgeReport<'a> {
    visit_id: i64,
    waypoint: &'a str,
    frame: String,
    seed: u64,
    /// Why the mixture of the reference was made anew; null where the stored one was used.
    reference_made_anew: Option<String>,
    source: SweepSource,
    stored: StoredVerdict,
    judged: NewVerdict,
}

/// Writes nothing to the store.
pub(super) fn run(args: &RejudgeArgs, visit_id: i64, mut settings: Settings) -> CommandResult {
    let store = Store::open_for_reading(&settings.store.dir)?;
    let visit = store.visit(visit_id)?;
    let id = visit.reference_id.ok_or_else(|| {
        let text = format!("visit {}: it was compared with no reference", visit_id);
        Failure::Failed(text)
    })?;
    let reference = store.reference_by_id(id)?;
    if args.stored_u_th {
        let u_th = visit.u_th.ok_or_else(|| {
            Failure::Failed(format!(
                "visit {}: its threshold is not in the store",
                visit_id
            ))
        })?;
        settings.set_u_th(&visit.waypoint, u_th);
    }
    let work = PlannedWork::start(
        format!("visit {visit_id}"),
        PHASES
            .map(|(name, s)| (name.to_owned(), Duration::from_secs(s)))
            .into(),
    );
    let ready = prepare(&visit, &reference, &settings)?;
    work.next_phase();
    let mut judged = judge(&visit, &ready, &settings)?;
    drop(work);
    if let (Some(dir), Some(compared)) = (&args.mixtures_out, &judged.compared) {
        mixtures_out::write(dir, compared)?;
    }
    let report = RejudgeReport {
        visit_id,
        waypoint: &visit.waypoint,
        frame: reference.positions_frame(&visit.waypoint),
        seed: visit.seed,
        reference_made_anew: judged.made_anew.take(),
        source: judged.source.clone(),
        stored: StoredVerdict {
            verdict: visit.verdict.clone(),
            d_gmm: visit.d_gmm,
            u_th: visit.u_th,
        },
        judged,
    };
    if args.json {
        output::json(&report)?;
    } else {
        output::line(report_text(&report))?;
    }
    Ok(report.judged.exit_code)
}

fn report_text(report: &RejudgeReport<'_>) -> String {
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.6}"));
    let (stored, judged) = (&report.stored, &report.judged);
    let mut lines = vec![
        format!(
            "visit {} at {}, positions in the frame of reference {}",
            report.visit_id, report.waypoint, report.frame
        ),
        format!(
            "  stored: {}, d_GMM {}, U_th {}",
            stored.verdict,
            number(stored.d_gmm),
            number(stored.u_th)
        ),
        format!(
            "  now:    {}, d_GMM {}, U_th {}: {}",
            judged.verdict,
            number(judged.d_gmm),
            number(Some(judged.u_th)),
            judged.reason
        ),
    ];
    lines.push(match &report.source.why {
        None => format!("  from {}", report.source.from.as_str()),
        Some(why) => format!("  from {}: {why}", report.source.from.as_str()),
    });
    if let Some(why) = &report.reference_made_anew {
        lines.push(format!(
            "  the mixture of the reference was made anew from its view: {why}"
        ));
    }
    let novelties = judged.novelties.iter();
    lines.extend(novelties.map(|n| format!("  {}, {} points", novelty_text(n), n.points)));
    lines.join("\n")
}
