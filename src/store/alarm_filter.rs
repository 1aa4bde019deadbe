//! Which alarms to list, and the SQL that selects their numbers.

use super::error::StoreError;
use super::lookup::check_in_log;
use super::newest::Conditions;
use super::time_range::{CLOCK_SET_FROM, TimeRange};
use crate::alarm::AlarmState;
use patrold_engine::novelty::NoveltyKind;
use rusqlite::types::Value;
use rusqlite::{Connection, params_from_iter};

/// Which alarms to list; `None`: any. What is asked of the thing holds of one novelty of the visit that raised the alarm.
#[derive(Debug, Clone, Default)]
pub struct AlarmFilter {
    /// Last seen at or after.
    pub since: Option<jiff::Timestamp>,
    /// Raised at or before.
    pub until: Option<jiff::Timestamp>,
    /// Name of the waypoint.
    pub waypoint: Option<String>,
    /// State.
    pub state: Option<AlarmState>,
    /// What the thing is like.
    pub thing: ThingFilter,
    /// Only lower numbers: the log is read in pages by it.
    pub before: Option<i64>,
    /// The newest N.
    pub limit: Option<u32>,
}

/// What a thing is like; `None`: anything.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ThingFilter {
    /// Appeared or disappeared.
    pub kind: Option<NoveltyKind>,
    /// Class of its shape.
    pub class: Option<String>,
    /// Least longest side of its shape, metres.
    pub min_size_m: Option<f64>,
    /// Greatest longest side of its shape, metres.
    pub max_size_m: Option<f64>,
    /// Where it is: near one of these.
    pub near: Option<NearFilter>,
}

/// Near one of some places.
#[derive(Debug, Clone, PartialEq)]
pub struct NearFilter {
    /// The places; near none where there is none.
    pub places: Vec<FloorPlace>,
    /// How near, metres on the floor.
    pub within_m: f64,
}

/// A place on the floor, in the frame of a waypoint's references.
#[derive(Debug, Clone, PartialEq)]
pub struct FloorPlace {
    /// Name of the waypoint.
    pub waypoint: String,
    /// Forward, metres.
    pub x_m: f64,
    /// To the left, metres.
    pub y_m: f64,
}

impl AlarmFilter {
    /// Numbers of the alarms that match, newest first.
    ///
    /// # Errors
    /// A waypoint name that the log does not know, or the database fails.
    pub(super) fn matching_ids(&self, db: &Connection) -> Result<Vec<i64>, StoreError> {
        if let Some(name) = &self.waypoint {
            check_in_log(db, name)?;
        }
        let conditions = self.conditions();
        let condition = conditions.to_where();
        let limit = self.limit.map_or(-1, i64::from);
        let sql = format!("SELECT a.id FROM alarm a {condition} ORDER BY a.id DESC LIMIT {limit}");
        let mut query = db.prepare_cached(&sql)?;
        let ids = query.query_map(params_from_iter(conditions.values()), |row| row.get(0))?;
        Ok(ids.collect::<Result<_, _>>()?)
    }

    fn conditions(&self) -> Conditions {
        let mut all = Conditions::default();
        all.require_some("a.id < ?", self.before);
        all.require_some(
            "a.waypoint_id IN (SELECT id FROM waypoint WHERE name = ?)",
            self.waypoint.clone(),
        );
        all.require_some("a.state = ?", self.state.map(|s| s.as_str().to_owned()));
        let [since, until] = TimeRange {
            since: self.since,
            until: self.until,
        }
        .bounds();
        // Where one of the stamps comes from a clock that was not set, it is unknown when that was.
        let unset =
            format!("a.raised_at < '{CLOCK_SET_FROM}' OR a.last_seen_at < '{CLOCK_SET_FROM}'");
        if self.since.is_some() {
            all.require(format!("(a.last_seen_at >= ? OR {unset})"), [since.into()]);
        }
        if self.until.is_some() {
            all.require(format!("(a.raised_at <= ? OR {unset})"), [until.into()]);
        }
        self.thing.add_to(&mut all);
        all
    }
}

impl ThingFilter {
    fn add_to(&self, all: &mut Conditions) {
        let mut thing = Conditions::default();
        thing.require("n.visit_id = a.first_visit_id", []);
        thing.require_some("n.kind = ?", self.kind.map(|kind| kind.as_str().to_owned()));
        if let Some(near) = &self.near {
            near.add_to(&mut thing);
        }
        let needs_shape =
            self.class.is_some() || self.min_size_m.is_some() || self.max_size_m.is_some();
        thing.require_some("s.class = ?", self.class.clone());
        let longest_side = "max(s.size_x_m, s.size_y_m, s.size_z_m)";
        thing.require_some(&format!("{longest_side} >= ?"), self.min_size_m);
        thing.require_some(&format!("{longest_side} <= ?"), self.max_size_m);
        if thing.values().is_empty() && self.near.is_none() {
            return;
        }
        let shape = if needs_shape {
            "JOIN shape s ON s.novelty_id = n.id"
        } else {
            ""
        };
        let condition = thing.to_where();
        all.require(
            format!("EXISTS (SELECT 1 FROM novelty n {shape} {condition})"),
            thing.values().to_vec(),
        );
    }
}

impl NearFilter {
    fn add_to(&self, thing: &mut Conditions) {
        let place = "a.waypoint_id IN (SELECT id FROM waypoint WHERE name = ?) \
                     AND (n.x_m - ?) * (n.x_m - ?) + (n.y_m - ?) * (n.y_m - ?) <= ?";
        let any = vec![place; self.places.len()].join(" OR ");
        let values = self.places.iter().flat_map(|at| {
            let square = self.within_m * self.within_m;
            let [x, y] = [at.x_m, at.y_m].map(Value::from);
            [
                at.waypoint.clone().into(),
                x.clone(),
                x,
                y.clone(),
                y,
                square.into(),
            ]
        });
        let any = if any.is_empty() {
            "FALSE".to_owned()
        } else {
            format!("({any})")
        };
        thing.require(any, values);
    }
}
