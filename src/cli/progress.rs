//! Progress of long work on standard error, one way for all: on a terminal a bar with phase, share and seconds left, elsewhere a plain
//! line now and then. Short work shows nothing there.

use super::failure::Failure;
use super::output;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::io::{self, IsTerminal as _};
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Off a terminal the first line comes after this time, the next ones after each other's.
const FIRST_LINE_AFTER: Duration = Duration::from_secs(5);
const NEXT_LINE_AFTER: Duration = Duration::from_secs(10);
/// Period of a bar that moves by itself.
const REDRAW: Duration = Duration::from_millis(200);
/// A share that falls by more than this is of work that is done again; by less, of a better estimate.
const MAX_SHARE_ERROR: f64 = 0.1;
/// Steps of a bar.
const BAR_STEPS: f64 = 1000.0;
/// A phase that is not over is shown as this much of itself at most.
const MAX_PHASE_SHARE: f64 = 0.98;

/// Work that is shown until it is finished or dropped.
pub(super) struct Work(Arc<Mutex<ShownWork>>);

struct ShownWork {
    title: String,
    started: Instant,
    last_line: Option<Instant>,
    /// On a terminal.
    bar: Option<ProgressBar>,
    /// Of counted work.
    steps: (usize, usize),
    /// The largest share so far.
    furthest: f64,
}

impl Work {
    pub(super) fn start(title: impl Into<String>) -> Self {
        let title = title.into();
        let bar = io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(BAR_STEPS as u64);
            // The template is fixed and well-formed.
            if let Ok(style) = ProgressStyle::with_template("{msg} [{wide_bar}] {prefix}") {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_message(title.clone());
            bar
        });
        Self(Arc::new(Mutex::new(ShownWork {
            title,
            started: Instant::now(),
            last_line: None,
            bar,
            steps: (0, 0),
            furthest: 0.0,
        })))
    }

    /// Counted work.
    pub(super) fn of_steps(count: usize, title: impl Into<String>) -> Self {
        let work = Self::start(title);
        work.set_steps(0, count);
        work
    }

    fn lock(&self) -> MutexGuard<'_, ShownWork> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// `share` is 0 to 1; `None` where nobody knows.
    pub(super) fn show(&self, phase: &str, share: Option<f64>, seconds_left: Option<f64>) {
        self.lock().show(Instant::now(), phase, share, seconds_left);
    }

    /// `done` of `count` steps are.
    pub(super) fn set_steps(&self, done: usize, count: usize) {
        let mut shown = self.lock();
        shown.steps = (done, count);
        let now = Instant::now();
        let (share, left) = steps_left(done, count, now.saturating_duration_since(shown.started));
        if count > 0 {
            shown.show(now, &format!("{done} of {count}"), share, left);
        }
    }

    /// So many more steps are done.
    pub(super) fn advance(&self, by: usize) {
        let (done, count) = self.lock().steps;
        self.set_steps(done + by, count);
    }

    /// Prints without tearing the bar.
    pub(super) fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        let bar = self.lock().bar.clone();
        match bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        if let Some(bar) = &self.lock().bar {
            bar.finish_and_clear();
        }
    }
}

impl ShownWork {
    fn show(&mut self, now: Instant, phase: &str, share: Option<f64>, seconds_left: Option<f64>) {
        let phase = &self.with_repeats(phase, share);
        match &self.bar {
            Some(bar) => {
                bar.set_message(format!("{}: {phase}", self.title));
                bar.set_prefix(share_text(share, seconds_left));
                bar.set_position((share.unwrap_or(0.0) * BAR_STEPS) as u64);
            }
            None => {
                if let Some(line) = self.due_line(now, phase, share, seconds_left) {
                    output::progress_line(&line);
                }
            }
        }
    }

    /// The phase, and whether it belongs to a repeat: a bar that goes back is no fault.
    fn with_repeats(&mut self, phase: &str, share: Option<f64>) -> String {
        self.furthest = self.furthest.max(share.unwrap_or(0.0));
        match share {
            Some(share) if share < self.furthest - MAX_SHARE_ERROR => {
                format!("{phase} again: the first attempt was not good enough")
            }
            _ => phase.to_owned(),
        }
    }

    fn due_line(
        &mut self,
        now: Instant,
        phase: &str,
        share: Option<f64>,
        seconds_left: Option<f64>,
    ) -> Option<String> {
        let (since, after) = match self.last_line {
            None => (self.started, FIRST_LINE_AFTER),
            Some(last) => (last, NEXT_LINE_AFTER),
        };
        if now.saturating_duration_since(since) < after {
            return None;
        }
        self.last_line = Some(now);
        let share = share_text(share, seconds_left);
        let parts = [phase, &share].into_iter().filter(|part| !part.is_empty());
        let parts: Vec<&str> = parts.collect();
        Some(format!("{}: {}", self.title, parts.join(", ")))
    }
}

fn share_text(share: Option<f64>, seconds_left: Option<f64>) -> String {
    let share = share.map(|share| format!("{:.0} %", 100.0 * share));
    let left = seconds_left.map(|left| format!("{:.0} s left", left.ceil()));
    let parts: Vec<String> = share.into_iter().chain(left).collect();
    parts.join(", ")
}

/// Share, and the time left if the rest takes as long as what is done.
fn steps_left(done: usize, count: usize, spent: Duration) -> (Option<f64>, Option<f64>) {
    if count == 0 {
        return (None, None);
    }
    let share = done.min(count) as f64 / count as f64;
    let left = (done > 0).then(|| spent.as_secs_f64() * (1.0 - share) / share);
    (Some(share), left)
}

/// Work whose phases are planned, in wall time; it moves by itself.
pub(super) struct PlannedWork {
    plan: Arc<Mutex<Plan>>,
    /// Dropped to end the thread.
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

struct Plan {
    phases: Vec<(String, Duration)>,
    /// The phase under way, and since when.
    at: (usize, Instant),
}

impl PlannedWork {
    pub(super) fn start(title: impl Into<String>, phases: Vec<(String, Duration)>) -> Self {
        let work = Work::start(title);
        let at = (0, Instant::now());
        let plan = Arc::new(Mutex::new(Plan { phases, at }));
        let shared = Arc::clone(&plan);
        let (stop, stopped) = mpsc::channel();
        let redraw = move || {
            while stopped.recv_timeout(REDRAW) == Err(mpsc::RecvTimeoutError::Timeout) {
                let plan = shared.lock().unwrap_or_else(PoisonError::into_inner);
                let (phase, share, left) = plan.progress(Instant::now());
                work.show(phase, Some(share), Some(left));
            }
        };
        // Without a thread nothing is shown, and the work is done.
        let thread = thread::Builder::new().spawn(redraw).ok();
        Self {
            plan,
            stop: Some(stop),
            thread,
        }
    }

    /// The next phase begins.
    pub(super) fn next_phase(&self) {
        let mut plan = self.plan.lock().unwrap_or_else(PoisonError::into_inner);
        plan.at = (plan.at.0 + 1, Instant::now());
    }
}

impl Drop for PlannedWork {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // It only draws.
            let _ = thread.join();
        }
    }
}

impl Plan {
    /// Phase, share and seconds left.
    fn progress(&self, now: Instant) -> (&str, f64, f64) {
        let (at, since) = self.at;
        let spent = now.saturating_duration_since(since).as_secs_f64();
        let seconds = |phases: &[(String, Duration)]| -> f64 {
            phases
                .iter()
                .map(|(_, planned)| planned.as_secs_f64())
                .sum()
        };
        let Some((name, planned)) = self.phases.get(at) else {
            return ("", 1.0, 0.0);
        };
        let planned = planned.as_secs_f64();
        let done = seconds(&self.phases[..at]) + spent.min(MAX_PHASE_SHARE * planned);
        let left = (planned - spent).max(0.0) + seconds(&self.phases[at + 1..]);
        (
            name,
            done / seconds(&self.phases).max(f64::MIN_POSITIVE),
            left,
        )
    }
}

/// Applies `function` to every item on `threads` threads (0: one for each core), with a bar. The results are in the order
/// of the items.
///
/// # Errors
/// Threads that cannot be started; the first failure in the order of the items.
pub(super) fn map_parallel<I: Sync, T: Send>(
    items: &[I],
    title: &'static str,
    threads: usize,
    function: impl Fn(&I) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(Failure::failed)?;
    let work = Work::of_steps(items.len(), title);
    let counted = |item| {
        let result = function(item);
        work.advance(1);
        result
    };
    // Collected before a failure is returned: which one comes first does not depend on the threads.
    let results: Vec<Result<T, Failure>> =
        pool.install(|| items.par_iter().with_max_len(1).map(counted).collect());
    drop(work);
    results.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::{Plan, ShownWork, share_text, steps_left};
    use std::time::{Duration, Instant};

    #[test]
    fn off_a_terminal_a_line_comes_after_five_seconds_and_then_each_ten() {
        let started = Instant::now();
        let mut work = ShownWork {
            title: "hall".to_owned(),
            started,
            last_line: None,
            bar: None,
            steps: (0, 0),
            furthest: 0.0,
        };
        let mut lines = Vec::new();
        for second in 0..30_u64 {
            let share = second as f64 / 40.0;
            let now = started + Duration::from_secs(second);
            let line = work.due_line(now, "sweeping", Some(share), Some(40.0 - second as f64));
            lines.extend(line);
        }
        let expected = [
            "hall: sweeping, 12 %, 35 s left",
            "hall: sweeping, 38 %, 25 s left",
            "hall: sweeping, 62 %, 15 s left",
        ];
        assert_eq!(lines, expected);
    }

    #[test]
    fn a_share_that_falls_is_of_a_repeat() {
        let mut work = ShownWork {
            title: String::new(),
            started: Instant::now(),
            last_line: None,
            bar: None,
            steps: (0, 0),
            furthest: 0.0,
        };
        let mut shown = |share| work.with_repeats("sweeping", share);
        assert_eq!(shown(Some(0.5)), "sweeping");
        assert_eq!(shown(Some(0.41)), "sweeping", "another estimate");
        assert_eq!(shown(None), "sweeping");
        let again = "sweeping again: the first attempt was not good enough";
        assert_eq!(shown(Some(0.1)), again);
        assert_eq!(shown(Some(0.6)), "sweeping");
    }

    #[test]
    fn what_nobody_knows_is_left_out() {
        assert_eq!(share_text(None, None), "");
        assert_eq!(share_text(Some(0.5), None), "50 %");
        assert_eq!(share_text(None, Some(0.2)), "1 s left");
        assert_eq!(steps_left(0, 0, Duration::ZERO), (None, None));
        assert_eq!(steps_left(0, 4, Duration::from_secs(9)), (Some(0.0), None));
        let (share, left) = steps_left(1, 4, Duration::from_secs(2));
        assert_eq!((share, left), (Some(0.25), Some(6.0)));
    }

    #[test]
    fn planned_phases_add_up_and_one_that_lasts_longer_is_not_over() {
        let start = Instant::now();
        let seconds = Duration::from_secs;
        let phases = [("sweep 1 of 2", 10), ("sweep 2 of 2", 30)];
        let mut plan = Plan {
            phases: phases.map(|(name, s)| (name.to_owned(), seconds(s))).into(),
            at: (0, start),
        };
        assert_eq!(
            plan.progress(start + seconds(5)),
            ("sweep 1 of 2", 0.125, 35.0)
        );
        let (_, share, left) = plan.progress(start + seconds(50));
        assert!(share < 0.25 && left == 30.0, "{share} {left}");
        plan.at = (1, start);
        assert_eq!(plan.progress(start), ("sweep 2 of 2", 0.25, 30.0));
        plan.at = (2, start);
        assert_eq!(plan.progress(start), ("", 1.0, 0.0));
    }
}
