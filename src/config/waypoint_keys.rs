//! Every key of `[waypoint.NAME]`.

use super::keys::{ConfigKey, FULL_TURN_DEG, MAX_M, key};
use super::value::ValueKind::{Float, Floats};

/// Keys of `[waypoint.NAME]`; `name` is the last part of `waypoint.NAME.key`.
pub(super) const WAYPOINT_KEYS: &[ConfigKey] = &[
    key(
        "u_th_m",
        Float(1e-9, MAX_M),
        "0.0005",
        "m",
        "novelty.u_th_m for this waypoint alone.",
    ),
    key(
        "u_th_fm",
        Float(1e-9, MAX_M),
        "0.002",
        "",
        "novelty.u_th_fm for this waypoint alone.",
    ),
    key(
        "pans_deg",
        Floats(1, 16, -FULL_TURN_DEG, FULL_TURN_DEG),
        "[0.0]",
        "deg",
        "sweep.pans_deg for this waypoint alone.",
    ),
    key(
        "map_pose",
        Floats(3, 3, -1e6, 1e6),
        "[0.0, 0.0, 0.0]",
        "m, m, deg",
        "x, y, yaw of the robot's base on the site's map when it stands here.",
    ),
];
