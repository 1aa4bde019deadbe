//! Times of the stages of a comparison, as the contract lists them.

use patrold_engine::inspect::Stage;
use patrold_engine::novelty;
use serde::Serialize;
use std::time::Instant;

/// Milliseconds by stage.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Timing {
    /// Reading the files.
    pub load: f64,
    /// Making the reference ready: indexed and modelled. A stored one keeps this for all its revisits.
    pub reference: f64,
    /// Indexing and modelling the current view.
    pub fit: f64,
    /// Bringing them together.
    pub register: f64,
    /// d_GMM.
    pub distance: f64,
    /// Finding what changed.
    pub segment: f64,
    /// Retrieving shapes.
    pub shape: f64,
    /// All of it.
    pub total: f64,
}

#[derive(Debug, Clone, Copy)]
enum Lap {
    Load,
    Reference,
    Fit,
    Register,
    Distance,
    Segment,
    Shape,
}

/// A stopwatch that starts in the stage of loading.
#[derive(Debug)]
pub struct Stopwatch {
    timing: Timing,
    lap: Lap,
    since: Instant,
}

impl Stopwatch {
    /// Starts it.
    pub fn start() -> Self {
        Self {
            timing: Timing::default(),
            lap: Lap::Load,
            since: Instant::now(),
        }
    }

    /// The reference is being made ready from now on.
    pub fn reference(&mut self) {
        self.begin(Lap::Reference);
    }

    /// The inspection has come to this stage.
    pub fn stage(&mut self, stage: Stage) {
        self.begin(match stage {
            Stage::Novelty(novelty::Stage::Fit) => Lap::Fit,
            Stage::Novelty(novelty::Stage::Register) => Lap::Register,
            Stage::Novelty(novelty::Stage::Segment) => Lap::Segment,
            Stage::Novelty(novelty::Stage::Distance) => Lap::Distance,
            Stage::Shape => Lap::Shape,
        });
    }

    /// Stops it.
    pub fn stop(mut self) -> Timing {
        self.begin(self.lap);
        self.timing
    }

    fn begin(&mut self, next: Lap) {
        let now = Instant::now();
        let passed_ms = now.duration_since(self.since).as_secs_f64() * 1e3;
        let timing = &mut self.timing;
        *match self.lap {
            Lap::Load => &mut timing.load,
            Lap::Reference => &mut timing.reference,
            Lap::Fit => &mut timing.fit,
            Lap::Register => &mut timing.register,
            Lap::Distance => &mut timing.distance,
            Lap::Segment => &mut timing.segment,
            Lap::Shape => &mut timing.shape,
        } += passed_ms;
        timing.total += passed_ms;
        self.lap = next;
        self.since = now;
    }
}
