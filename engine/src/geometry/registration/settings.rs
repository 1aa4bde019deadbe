//! Settings of a registration.

/// What a caller may set in a registration (docs/novelty.md section 4).
#[derive(Debug, Clone, PartialEq)]
pub struct RegistrationSettings {
    /// First gates of the starts, metres: the largest distance between matching surfaces at first.
    pub start_gates_m: Vec<f64>,
    /// Agreement by direction from which no further starts are made: three in four changed pairs up to 10 cm and 5 deg off have
    /// .87 and more (`evaluate --seed 13 --pairs 60 --only changed --view bare --pose-error large`).
    pub sure_agreement: f64,
    /// Yaws of further starts, radians,
    pub start_yaws_rad: Vec<f64>,
    /// with each of these ways over the floor, metres,
    pub start_shifts_m: Vec<[f64; 2]>,
    /// and their first gate, metres.
    pub start_around_gate_m: f64,
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
    /// The same where every direction counts alike. A floor alone has one half, at any pose on it; changed pairs that are 20 to
    /// 30 cm and 8 to 15 deg off have .65 and more (that command with `--pose-error widest`).
    pub min_agreement_by_direction: f64,
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
    /// Error of scale that both visits share, one standard deviation.
    pub scale_sd: f64,
}

impl Default for RegistrationSettings {
    fn default() -> Self {
        Self {
            // Several starts: a single one fails where one direction is barely observable. The wide one is for turns of
            // 10 deg seen at 5 m.
            start_gates_m: vec![0.8, 0.25, 0.08, 0.03],
            sure_agreement: 0.85,
            start_yaws_rad: [0.0_f64, -5.0, 5.0, -10.0, 10.0, -15.0, 15.0]
                .map(f64::to_radians)
                .to_vec(),
            start_shifts_m: vec![
                [0.0, 0.0],
                [0.25, 0.0],
                [-0.25, 0.0],
                [0.0, 0.25],
                [0.0, -0.25],
            ],
            start_around_gate_m: 0.25,
            gate_factor: 0.6,
            iterations: 3,
            last_iterations: 8,
            max_points: [1200, 6000],
            min_agreement: 0.4,
            min_agreement_by_direction: 0.55,
            min_observability: 0.004,
            prior_sd_m: 0.1,
            prior_sd_rad: 0.05,
            // The makers' bounds of the ranges are 10 mm and 1 %: the first as one deviation (a cold start may drift by
            // 15 mm), the second as three, for most of it is a bias of the one sensor that both visits share.
            drift_sd_m: 0.01,
            drift_sd_per_m: 0.003,
            // Anywhere within the makers' bound of 1 %.
            scale_sd: 0.0058,
        }
    }
}
