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
        let Some(near) = &self.thing.near else {
            return self.read_ids(db, &conditions);
        };
        // One walk along the alarms of each place's waypoint.
        let mut ids = Vec::new();
        for place in &near.places {
            let mut at_place = conditions.clone();
            place.add_to(near.within_m, &self.thing, &mut at_place);
            ids.extend(self.read_ids(db, &at_place)?);
        }
        ids.sort_unstable_by(|a, b| b.cmp(a));
        ids.dedup();
        ids.truncate(self.limit.map_or(usize::MAX, |limit| limit as usize));
        Ok(ids)
    }

    fn read_ids(&self, db: &Connection, conditions: &Conditions) -> Result<Vec<i64>, StoreError> {
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
        if self.thing.near.is_none() {
            self.thing.add_to(Conditions::default(), &mut all);
        }
        all
    }
}

impl ThingFilter {
    /// One novelty has all of it, and what `thing` asks of it.
    fn add_to(&self, mut thing: Conditions, all: &mut Conditions) {
        thing.require_some("n.kind = ?", self.kind.map(|kind| kind.as_str().to_owned()));
        let needs_shape =
            self.class.is_some() || self.min_size_m.is_some() || self.max_size_m.is_some();
        thing.require_some("s.class = ?", self.class.clone());
        let longest_side = "max(s.size_x_m, s.size_y_m, s.size_z_m)";
        thing.require_some(&format!("{longest_side} >= ?"), self.min_size_m);
        thing.require_some(&format!("{longest_side} <= ?"), self.max_size_m);
        if thing.values().is_empty() {
            return;
        }
        let shape = if needs_shape {
            "JOIN shape s ON s.novelty_id = n.id"
        } else {
            ""
        };
        thing.require("n.visit_id = a.first_visit_id", []);
        let condition = thing.to_where();
        all.require(
            format!("EXISTS (SELECT 1 FROM novelty n {shape} {condition})"),
            thing.values().to_vec(),
        );
    }
}

impl FloorPlace {
    /// At its waypoint, a thing that is as `filter` says and near.
    fn add_to(&self, within_m: f64, filter: &ThingFilter, all: &mut Conditions) {
        all.require(
            "a.waypoint_id IN (SELECT id FROM waypoint WHERE name = ?)",
            [self.waypoint.clone().into()],
        );
        let mut near = Conditions::default();
        let [x, y] = [self.x_m, self.y_m].map(Value::from);
        near.require(
            "(n.x_m - ?) * (n.x_m - ?) + (n.y_m - ?) * (n.y_m - ?) <= ?",
            [x.clone(), x, y.clone(), y, (within_m * within_m).into()],
        );
        filter.add_to(near, all);
    }
}
