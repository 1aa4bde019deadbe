//! Options of `patrold alarms` that select alarms.

use super::failure::Failure;
use super::{time_arg, value_parsers};
use crate::alarm::AlarmState;
use crate::config::Settings;
use crate::store::{AlarmFilter, FloorPlace, NearFilter, ThingFilter};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use jiff::Timestamp;
use patrold_engine::novelty::NoveltyKind;

/// Words for a shape in the log.
const CLASSES: [&str; 8] = [
    "sphere",
    "cylinder",
    "plane",
    "box",
    "cone",
    "superquadric",
    "ambiguous",
    "composite",
];
/// How near is near where `--within` is not given, metres.
const NEAR_M: f64 = 1.0;

#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(super) struct AlarmFilterArgs {
    /// Only alarms whose change was last seen at or after this time: RFC 3339, a date or time (local), today, yesterday, or -3h (ago)
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = time_arg::parse_time)]
    since: Option<Timestamp>,
    /// Only alarms raised at or before this time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = time_arg::parse_time)]
    until: Option<Timestamp>,
    /// Only alarms of this waypoint
    #[arg(long, value_name = "NAME")]
    waypoint: Option<String>,
    /// Only alarms in this state: open, acknowledged or cleared
    #[arg(long)]
    state: Option<AlarmState>,
    /// Only things that appeared or disappeared
    #[arg(long, value_parser = kind())]
    kind: Option<NoveltyKind>,
    /// Only things of this shape
    #[arg(long, value_parser = PossibleValuesParser::new(CLASSES))]
    class: Option<String>,
    /// Only things whose longest side is at least M metres
    #[arg(long, value_name = "M", value_parser = value_parsers::parse_metres)]
    min_size: Option<f64>,
    /// Only things whose longest side is at most M metres
    #[arg(long, value_name = "M", value_parser = value_parsers::parse_metres)]
    max_size: Option<f64>,
    /// Only things near X,Y in the frame of the waypoint's references, metres; with --waypoint
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = value_parsers::parse_floor_point, conflicts_with = "map_near")]
    near: Option<[f64; 2]>,
    /// Only things near X,Y on the site's map, metres; at waypoints that have a map_pose
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = value_parsers::parse_floor_point)]
    map_near: Option<[f64; 2]>,
    /// How near --near and --map-near are, metres [default: 1]
    #[arg(long, value_name = "M", value_parser = value_parsers::parse_metres)]
    within: Option<f64>,
    /// Only the newest N alarms
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
}

fn kind() -> impl TypedValueParser<Value = NoveltyKind> {
    let all = [NoveltyKind::Appeared, NoveltyKind::Disappeared];
    PossibleValuesParser::new(all.map(NoveltyKind::as_str)).map(move |name| {
        let found = all.into_iter().find(|kind| kind.as_str() == name);
        found.unwrap_or(NoveltyKind::Appeared)
    })
}

impl AlarmFilterArgs {
    /// Whether only some alarms are asked for; a limit alone selects none.
    pub(super) fn selects(&self) -> bool {
        let without_limit = Self {
            limit: None,
            ..self.clone()
        };
        without_limit != Self::default()
    }

    /// # Errors
    /// A place without what it needs: a waypoint, or a waypoint with a pose on the map.
    pub(super) fn filter(&self, settings: &Settings) -> Result<AlarmFilter, Failure> {
        Ok(AlarmFilter {
            since: self.since,
            until: self.until,
            waypoint: self.waypoint.clone(),
            state: self.state,
            thing: ThingFilter {
                kind: self.kind,
                class: self.class.clone(),
                min_size_m: self.min_size,
                max_size_m: self.max_size,
                near: self.near_filter(settings)?,
            },
            before: None,
            limit: self.limit,
        })
    }

    fn near_filter(&self, settings: &Settings) -> Result<Option<NearFilter>, Failure> {
        let places = match (self.near, self.map_near, &self.waypoint) {
            (None, None, _) if self.within.is_some() => {
                let text = "--within belongs to --near or --map-near; give one".to_owned();
                return Err(Failure::Usage(text));
            }
            (None, None, _) => return Ok(None),
            (Some([x_m, y_m]), _, Some(waypoint)) => vec![FloorPlace {
                waypoint: waypoint.clone(),
                x_m,
                y_m,
            }],
            (Some(_), _, None) => {
                let text =
                    "--near is in the frame of a waypoint; give --waypoint too, or --map-near";
                return Err(Failure::Usage(text.to_owned()));
            }
            (None, Some(on_map), _) => places_on_map(settings, on_map),
        };
        if places.is_empty() {
            let text =
                "--map-near: no waypoint has a pose on the map; set map_pose in [waypoint.NAME]";
            return Err(Failure::Usage(text.to_owned()));
        }
        let within_m = self.within.unwrap_or(NEAR_M);
        Ok(Some(NearFilter { places, within_m }))
    }

    /// These filters; where one is not given, that of `outer`.
    pub(super) fn or(&self, outer: &Self) -> Self {
        Self {
            since: self.since.or(outer.since),
            until: self.until.or(outer.until),
            waypoint: self.waypoint.clone().or_else(|| outer.waypoint.clone()),
            state: self.state.or(outer.state),
            kind: self.kind.or(outer.kind),
            class: self.class.clone().or_else(|| outer.class.clone()),
            min_size: self.min_size.or(outer.min_size),
            max_size: self.max_size.or(outer.max_size),
            near: self.near.or(outer.near),
            map_near: self.map_near.or(outer.map_near),
            within: self.within.or(outer.within),
            limit: self.limit.or(outer.limit),
        }
    }
}

/// A place on the map in the frame of every waypoint that has a pose there.
fn places_on_map(settings: &Settings, [x, y]: [f64; 2]) -> Vec<FloorPlace> {
    let waypoints = settings.waypoints.iter();
    let placed = waypoints.filter_map(|(name, waypoint)| Some((name, waypoint.map_pose?)));
    let in_frame = |(name, [at_x, at_y, yaw_rad]): (&String, [f64; 3])| {
        let (sin, cos) = yaw_rad.sin_cos();
        let [dx, dy] = [x - at_x, y - at_y];
        FloorPlace {
            waypoint: name.clone(),
            x_m: cos * dx + sin * dy,
            y_m: cos * dy - sin * dx,
        }
    };
    placed.map(in_frame).collect()
}
