//! Settings of a registration.

/// What a caller may set in a registration (docs/novelty.md section 4).
#[derive(Debug, Clone, PartialEq)]
pub struct RegistrationSettings {
    /// First gates of the starts, metres: the largest distance between matching surfaces at first.
    pub start_gates_m: Vec<f64>,
    /// Yaws of further starts, radians, tried only where the plain starts explain little.
    pub start_yaws_rad: Vec<f64>,
    /// Factor of the gate from stage to stage.
    pub gate_factor: f64,
    /// Iterations per stage.
    pub iterations: usize,
    /// Most iterations of the last stage, which also estimates the drift.
    pub last_iterations: usize,
    /// Most current points used while the gate is wide, and in the last stage.
    pub max_points: [usize; 2],
    /// Agreement below which the views do not show the same scene. Simulated quiet pairs lie at 0.86-0.96
    /// (`cargo test --test gates`); half of that leaves room for what changed.
    pub min_agreement: f64,
    /// A direction is unobservable if less than this share of the surface resists a motion along it.
    pub min_observability: f64,
    /// How well the robot stops at a waypoint, one standard deviation, metres: the prior along unobservable directions.
    pub prior_sd_m: f64,
    /// The same for its heading, radians.
    pub prior_sd_rad: f64,
    /// Drift of all ranges between two visits, one standard deviation, metres.
    pub drift_sd_m: f64,
    /// The same per metre of range.
    pub drift_sd_per_m: f64,
}

impl Default for RegistrationSettings {
    fn default() -> Self {
        Self {
            // Several starts: a single one fails where one direction is barely observable. The wide one is for turns of
            // 10 deg seen at 5 m.
            start_gates_m: vec![0.8, 0.25, 0.08, 0.03],
            start_yaws_rad: [-8.0_f64, -4.0, 4.0, 8.0].map(f64::to_radians).to_vec(),
            gate_factor: 0.6,
            iterations: 3,
            last_iterations: 8,
            max_points: [1200, 6000],
            min_agreement: 0.4,
            min_observability: 0.004,
            prior_sd_m: 0.1,
            prior_sd_rad: 0.05,
            // The makers' bounds of the ranges are 10 mm and 1 %: the first as one deviation (a cold start may drift by
            // 15 mm), the second as three, for most of it is a bias of the one sensor that both visits share.
            drift_sd_m: 0.01,
            drift_sd_per_m: 0.003,
        }
    }
}
