//! Which alarms to list, and the SQL that selects their numbers.

use crate::alarm::AlarmState;
use crate::store::error::StoreError;
use crate::store::lookup::check_in_log;
use crate::store::newest::Conditions;
use crate::store::time_range::{CLOCK_SET_FROM, TimeRange};
use patrold_engine::novelty::NoveltyKind;
use rusqlite::{Connection, params_from_iter};
use std::collections::HashMap;

/// Which alarms to list; `None`: any. What is asked of the thing holds of it as it was last seen.
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
        let mut conditions = self.conditions();
        if let Some(near) = &self.thing.near {
            return self.ids_near(db, near, conditions);
        }
        let (joins, mut thing) = self.thing.seen_last();
        if !thing.values().is_empty() {
            let its_own =
                "g.alarm_id = a.id AND g.visit_id = n.visit_id AND g.position = n.position";
            thing.require(its_own, []);
            let condition = thing.to_where();
            let one_thing =
                format!("EXISTS (SELECT 1 FROM {joins} CROSS JOIN sighting g {condition})");
            conditions.require(one_thing, thing.values().to_vec());
        }
        let condition = conditions.to_where();
        let limit = self.limit.map_or(-1, i64::from);
        let sql = format!("SELECT a.id FROM alarm a {condition} ORDER BY a.id DESC LIMIT {limit}");
        let mut query = db.prepare_cached(&sql)?;
        let ids = query.query_map(params_from_iter(conditions.values()), |row| row.get(0))?;
        Ok(ids.collect::<Result<_, _>>()?)
    }

    /// Walks through the things that last visits saw, the newest alarm first, until enough of the alarms' own are near.
    fn ids_near(
        &self,
        db: &Connection,
        near: &NearFilter,
        mut conditions: Conditions,
    ) -> Result<Vec<i64>, StoreError> {
        let places = near.places_by_waypoint(db)?;
        let (joins, thing) = self.thing.seen_last();
        conditions.extend(&thing);
        near.require_bounds(&mut conditions);
        let condition = conditions.to_where();
        let sql = format!(
            "SELECT a.id, a.waypoint_id, n.x_m, n.y_m, n.visit_id, n.position FROM alarm a CROSS JOIN {joins} {condition}
             ORDER BY a.id DESC"
        );
        let mut query = db.prepare_cached(&sql)?;
        let mut is_its_own = db.prepare_cached(
            "SELECT EXISTS (SELECT 1 FROM sighting WHERE alarm_id = ?1 AND visit_id = ?2 AND position = ?3)",
        )?;
        let mut rows = query.query(params_from_iter(conditions.values()))?;
        let mut ids = Vec::new();
        while let Some(row) = rows.next()? {
            if self.limit.is_some_and(|limit| ids.len() >= limit as usize) {
                break;
            }
            let (id, waypoint): (i64, i64) = (row.get(0)?, row.get(1)?);
            let at: [Option<f64>; 2] = [row.get(2)?, row.get(3)?];
            let is_near = |place: &[f64; 2]| match at {
                [Some(x), Some(y)] => (x - place[0]).hypot(y - place[1]) <= near.within_m,
                _ => false,
            };
            let places = places.get(&waypoint);
            // Several things of one alarm follow each other.
            if ids.last() == Some(&id) || !places.is_some_and(|places| places.iter().any(is_near)) {
                continue;
            }
            let (visit, position): (i64, i64) = (row.get(4)?, row.get(5)?);
            if is_its_own.query_row([id, visit, position], |row| row.get(0))? {
                ids.push(id);
            }
        }
        Ok(ids)
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
        all
    }
}

impl ThingFilter {
    /// The tables of one thing that the last visit of an alarm `a` saw, and what it is like; whether it is the alarm's own is
    /// asked last. The indices hold all that is asked, without the records.
    fn seen_last(&self) -> (String, Conditions) {
        let mut thing = Conditions::default();
        thing.require("n.visit_id = a.last_visit_id", []);
        thing.require_some("n.kind = ?", self.kind.map(|kind| kind.as_str().to_owned()));
        thing.require_some("s.class = ?", self.class.clone());
        let longest_side = "max(s.size_x_m, s.size_y_m, s.size_z_m)";
        thing.require_some(&format!("{longest_side} >= ?"), self.min_size_m);
        thing.require_some(&format!("{longest_side} <= ?"), self.max_size_m);
        let mut joins = "novelty n INDEXED BY novelty_by_place".to_owned();
        if self.class.is_some() || self.min_size_m.is_some() || self.max_size_m.is_some() {
            joins
                .push_str(" CROSS JOIN shape s INDEXED BY shape_by_novelty ON s.novelty_id = n.id");
        }
        (joins, thing)
    }
}

impl NearFilter {
    /// Within a rectangle around all places: most of what is far is left out before its row is given.
    fn require_bounds(&self, conditions: &mut Conditions) {
        let xs = self.places.iter().map(|place| place.x_m);
        let ys = self.places.iter().map(|place| place.y_m);
        let around = |along: &[f64]| {
            let from = along.iter().copied().fold(f64::INFINITY, f64::min);
            let to = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            [(from - self.within_m).into(), (to + self.within_m).into()]
        };
        conditions.require("n.x_m BETWEEN ? AND ?", around(&xs.collect::<Vec<_>>()));
        conditions.require("n.y_m BETWEEN ? AND ?", around(&ys.collect::<Vec<_>>()));
    }

    /// Places by the id of their waypoint; a name that was forgotten and taught again is several.
    fn places_by_waypoint(
        &self,
        db: &Connection,
    ) -> Result<HashMap<i64, Vec<[f64; 2]>>, StoreError> {
        let mut query = db.prepare_cached("SELECT id FROM waypoint WHERE name = ?1")?;
        let mut places: HashMap<i64, Vec<[f64; 2]>> = HashMap::new();
        for place in &self.places {
            for id in query.query_map([&place.waypoint], |row| row.get(0))? {
                places.entry(id?).or_default().push([place.x_m, place.y_m]);
            }
        }
        Ok(places)
    }
}
