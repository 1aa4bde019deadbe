//! How far a request is and how long it still takes, from what the last one took, or else from the plan of its sweep.

use super::replies::WorkProgress;
use crate::config::SweepMode;
use crate::devices::SweepRequest;
use crate::patrol::machine::RequestStage;
use link::Clock;
use std::time::{Duration, Instant};

/// Besides its tilting, one pan segment takes about this on the devices' clock: approach, two time synchronisations.
const SEGMENT_OVERHEAD: Duration = Duration::from_secs(3);
/// A line of step-and-stare on the devices' clock.
const STEP_LINE: Duration = Duration::from_secs(1);
/// Where nothing was judged yet: the usual second, and as much again.
const FIRST_JUDGEMENT: Duration = Duration::from_secs(2);
/// Looking up the reference, and writing the outcome.
const STORE_STEP: Duration = Duration::from_millis(100);
/// A stage that is not over is shown as this much of itself at most.
const MAX_STAGE_SHARE: f64 = 0.98;

/// Wall time throughout.
#[derive(Debug)]
pub(super) struct WorkEstimate {
    /// The request under way, its stage, and since when.
    current: Option<(u64, RequestStage, Instant)>,
    /// What the last sweep took, beside its planned time.
    last_sweep: Option<(Duration, Duration)>,
    last_judgement: Option<Duration>,
    planned_sweep: Duration,
}

impl WorkEstimate {
    pub(super) fn new() -> Self {
        Self {
            current: None,
            last_sweep: None,
            last_judgement: None,
            planned_sweep: Duration::ZERO,
        }
    }

    /// A sweep of this planned duration begins.
    pub(super) fn start_sweep(&mut self, planned: Duration) {
        self.planned_sweep = planned;
    }

    /// Takes note of the stage that a request is in.
    pub(super) fn update(&mut self, request: Option<(u64, RequestStage)>, now: Instant) {
        let before = self.current;
        if before.map(|(id, stage, _)| (id, stage)) == request {
            return;
        }
        self.current = request.map(|(id, stage)| (id, stage, now));
        let (Some((id, stage, since)), Some((next_id, next))) = (before, request) else {
            return;
        };
        let spent = now.saturating_duration_since(since);
        match (stage, next) {
            _ if id != next_id => {}
            (RequestStage::Sweeping, RequestStage::Judging) => {
                self.last_sweep = Some((spent, self.planned_sweep));
            }
            (RequestStage::Judging, RequestStage::Recording) => self.last_judgement = Some(spent),
            _ => {}
        }
    }

    /// Of the request under way; `planned` is the duration of its sweep where none has begun.
    pub(super) fn progress(&self, planned: Duration, now: Instant) -> WorkProgress {
        let Some((_, stage, since)) = self.current else {
            return WorkProgress::default();
        };
        let planned = match stage {
            RequestStage::Preparing | RequestStage::Waiting => planned,
            _ => self.planned_sweep,
        };
        let sweep = match self.last_sweep {
            Some((took, as_planned)) if as_planned == planned => took,
            _ => planned,
        };
        let judgement = self.last_judgement.unwrap_or(FIRST_JUDGEMENT);
        let stages = [STORE_STEP, sweep, judgement, STORE_STEP];
        let at = match stage {
            RequestStage::Preparing | RequestStage::Waiting => 0,
            RequestStage::Sweeping => 1,
            RequestStage::Judging => 2,
            RequestStage::Recording => 3,
        };
        let spent = now.saturating_duration_since(since);
        let shown = spent.min(stages[at].mul_f64(MAX_STAGE_SHARE));
        let done = stages[..at].iter().sum::<Duration>() + shown;
        let total: Duration = stages.iter().sum();
        let left = stages[at].saturating_sub(spent) + stages[at + 1..].iter().sum::<Duration>();
        WorkProgress {
            share: (done.as_secs_f64() / total.as_secs_f64()).clamp(0.0, 1.0),
            // Nobody knows when devices will be there.
            seconds_left: (stage != RequestStage::Waiting).then_some(left.as_secs_f64()),
        }
    }
}

/// The planned duration of a sweep, wall time.
pub fn planned_sweep(request: &SweepRequest, clock: &Clock) -> Duration {
    let span_rad = (request.tilt_to_rad - request.tilt_from_rad).abs();
    let tilting_s = match request.mode {
        SweepMode::Continuous => span_rad / request.speed_rad_s,
        SweepMode::Step => STEP_LINE.as_secs_f64() * (span_rad / request.step_rad + 1.0),
    };
    let tilting = Duration::try_from_secs_f64(tilting_s).unwrap_or(Duration::ZERO);
    let segments = u32::try_from(request.pans_rad.len()).unwrap_or(u32::MAX);
    clock.wall_time((tilting + SEGMENT_OVERHEAD) * segments)
}

#[cfg(test)]
mod tests {
    use super::{WorkEstimate, planned_sweep};
    use crate::config::Settings;
    use crate::devices::SweepRequest;
    use crate::patrol::machine::RequestStage;
    use link::Clock;
    use std::time::{Duration, Instant};

    const PLANNED: Duration = Duration::from_secs(20);

    fn seconds(s: f64) -> Duration {
        Duration::from_secs_f64(s)
    }

    #[test]
    fn the_share_rises_through_the_stages_and_the_time_left_falls() {
        let start = Instant::now();
        let mut estimate = WorkEstimate::new();
        let mut last = (-1.0, f64::INFINITY);
        let stages = [
            (RequestStage::Preparing, 0.0),
            (RequestStage::Sweeping, 0.1),
            (RequestStage::Sweeping, 10.0),
            (RequestStage::Sweeping, 19.0),
            (RequestStage::Judging, 20.1),
            (RequestStage::Recording, 22.0),
        ];
        for (stage, at) in stages {
            if stage == RequestStage::Sweeping {
                estimate.start_sweep(PLANNED);
            }
            let now = start + seconds(at);
            estimate.update(Some((1, stage)), now);
            let progress = estimate.progress(PLANNED, now);
            let left = progress.seconds_left.expect("known");
            assert!(
                progress.share > last.0 && left < last.1,
                "{stage:?} {progress:?}"
            );
            last = (progress.share, left);
        }
        assert!(last.0 < 1.0);
    }

    #[test]
    fn the_next_one_is_expected_to_take_as_long_as_the_last_of_its_plan() {
        let start = Instant::now();
        let mut estimate = WorkEstimate::new();
        estimate.start_sweep(PLANNED);
        estimate.update(Some((1, RequestStage::Sweeping)), start);
        estimate.update(Some((1, RequestStage::Judging)), start + seconds(40.0));
        estimate.update(Some((1, RequestStage::Recording)), start + seconds(45.0));
        estimate.update(None, start + seconds(46.0));
        let left = |estimate: &mut WorkEstimate, planned, id| {
            let now = start + seconds(50.0);
            estimate.start_sweep(planned);
            estimate.update(Some((id, RequestStage::Sweeping)), now);
            estimate.progress(planned, now).seconds_left.expect("known")
        };
        assert!((left(&mut estimate, PLANNED, 2) - 45.1).abs() < 1e-6);
        assert!((left(&mut estimate, seconds(60.0), 3) - 65.1).abs() < 1e-6);
        // A sweep that takes longer than it should is not over.
        let late = start + seconds(500.0);
        let progress = estimate.progress(PLANNED, late);
        assert!(progress.share < 1.0 && progress.seconds_left < Some(6.0));
        // One that waits for devices may wait for ever.
        estimate.update(Some((4, RequestStage::Waiting)), late);
        assert_eq!(estimate.progress(PLANNED, late).seconds_left, None);
    }

    #[test]
    fn a_plan_follows_pans_and_the_time_scale() {
        let settings = Settings::defaults();
        let plan = |pans, scale| {
            let mut request = SweepRequest::new(&settings, None);
            request.pans_rad = vec![0.0; pans];
            planned_sweep(&request, &Clock::scaled(scale)).as_secs_f64()
        };
        // 60 deg at 5 deg/s, and 3 s.
        assert!((plan(1, 1.0) - 15.0).abs() < 1e-6);
        assert!((plan(3, 1.0) - 45.0).abs() < 1e-6);
        assert!((plan(1, 10.0) - 1.5).abs() < 1e-6);
    }
}
