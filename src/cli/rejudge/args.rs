//! Arguments: numbers of visits, or a stretch of the log.

use crate::cli::filter_args::RangeArgs;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct RejudgeArgs {
    /// Numbers of visits, as `visits`, `visit` and `alarms` report them; several, or a time, list what differs
    pub(super) visit_ids: Vec<i64>,
    #[command(flatten)]
    pub(super) range: RangeArgs,
    /// Only visits of this waypoint
    #[arg(long, value_name = "NAME")]
    pub(super) waypoint: Option<String>,
    /// Use the U_th that was in force at the visit
    #[arg(long)]
    pub(super) stored_u_th: bool,
    /// Write both mixtures as compared to DIR/gamma.json and DIR/theta.json; for one visit
    #[arg(long, value_name = "DIR")]
    pub(super) mixtures_out: Option<PathBuf>,
    /// Visits at a time (0: one for each core)
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) threads: usize,
    /// Configuration file: the settings to judge with, and the place of the store
    #[arg(long, value_name = "FILE")]
    pub(super) config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    pub(super) json: bool,
}
