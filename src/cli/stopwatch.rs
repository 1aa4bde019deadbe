//! Times of the stages of a comparison (`timing_ms` in `docs/contract.md`).

use patrold_engine::inspect::InspectionStage;
use patrold_engine::novelty::DetectionStage;
use serde::Serialize;
use std::time::Instant;

/// Milliseconds by stage.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(super) struct CompareTiming {
    /// Reading the files.
    pub load: f64,
    /// Preparing the reference. The service does this once per reference.
    pub reference: f64,
    /// Modelling the current view.
    pub fit: f64,
    pub register: f64,
    /// d_GMM.
    pub distance: f64,
    /// Segmentation of the novelties.
    pub segment: f64,
    /// Shape retrieval.
    pub shape: f64,
    pub total: f64,
}

#[derive(Debug, Clone, Copy)]
enum TimedStage {
    Load,
    Reference,
    Fit,
    Register,
    Distance,
    Segment,
    Shape,
}

/// Starts in the stage `load`.
#[derive(Debug)]
pub(super) struct Stopwatch {
    timing: CompareTiming,
    current: TimedStage,
    since: Instant,
}

impl Stopwatch {
    pub(super) fn start() -> Self {
        Self {
            timing: CompareTiming::default(),
            current: TimedStage::Load,
            since: Instant::now(),
        }
    }

    pub(super) fn enter_reference(&mut self) {
        self.switch_to(TimedStage::Reference);
    }

    pub(super) fn enter(&mut self, stage: InspectionStage) {
        self.switch_to(match stage {
            InspectionStage::Detection(DetectionStage::Fit) => TimedStage::Fit,
            InspectionStage::Detection(DetectionStage::Register) => TimedStage::Register,
            InspectionStage::Detection(DetectionStage::Segment) => TimedStage::Segment,
            InspectionStage::Detection(DetectionStage::Distance) => TimedStage::Distance,
            InspectionStage::Shape => TimedStage::Shape,
        });
    }

    pub(super) fn stop(mut self) -> CompareTiming {
        self.switch_to(self.current);
        self.timing
    }

    fn switch_to(&mut self, next: TimedStage) {
        let now = Instant::now();
        let elapsed_ms = now.duration_since(self.since).as_secs_f64() * 1e3;
        let timing = &mut self.timing;
        *match self.current {
            TimedStage::Load => &mut timing.load,
            TimedStage::Reference => &mut timing.reference,
            TimedStage::Fit => &mut timing.fit,
            TimedStage::Register => &mut timing.register,
            TimedStage::Distance => &mut timing.distance,
            TimedStage::Segment => &mut timing.segment,
            TimedStage::Shape => &mut timing.shape,
        } += elapsed_ms;
        timing.total += elapsed_ms;
        self.current = next;
        self.since = now;
    }
}
