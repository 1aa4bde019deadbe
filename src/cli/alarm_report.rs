//! Alarms as table, text, JSON and CSV.

use super::local_time::local_time;
use super::output::printable;
use super::table;
use crate::alarm::GuardPosition;
use crate::config::Settings;
use crate::store::{AlarmRow, SightingRow};
use comfy_table::Table;
use patrold_engine::report::NoveltyRecord;
use serde_json::{Value, json};

/// A thing so near to the line ahead is straight ahead, degrees.
const AHEAD_DEG: f64 = 7.5;
/// A thing so near to the floor stands on it, metres: the lowest beams pass some centimetres over it.
const ON_FLOOR_M: f64 = 0.1;

/// One row per alarm, as it was last seen.
pub(super) fn alarm_table(alarms: &[AlarmRow]) -> Table {
    let mut rows = table::table(&[
        "id",
        "raised",
        "waypoint",
        "state",
        "last seen",
        "score",
        "what, where (m), shape",
    ]);
    for alarm in alarms {
        let novelties: Vec<String> = current(alarm).iter().map(novelty_text).collect();
        let unobserved = alarm.unobserved_since.as_ref();
        let unobserved =
            unobserved.map(|at| format!("place not seen since {}", local_time(at, false)));
        rows.add_row([
            alarm.id.to_string(),
            local_time(&alarm.raised_at, alarm.clock_unset),
            alarm.waypoint.clone(),
            alarm.state.clone(),
            local_time(&alarm.last_seen_at, alarm.clock_unset),
            table::distance_text(alarm.score, 4, alarm.ground.as_deref()),
            [novelties, unobserved.into_iter().collect()]
                .concat()
                .join("\n"),
        ]);
    }
    rows
}

/// The thing as it was last seen.
pub(super) fn current(alarm: &AlarmRow) -> &[NoveltyRecord] {
    let last = alarm.last_sighting.as_ref();
    last.map_or(&alarm.novelties, |last| &last.novelties)
}

/// A novelty in one line.
pub(super) fn novelty_text(novelty: &NoveltyRecord) -> String {
    let moved = if novelty.moved_from.is_some() {
        " (moved)"
    } else {
        ""
    };
    let shape = match &novelty.shape {
        Some(shape) => {
            let [a, b, c] = shape.size;
            format!("{} {a:.2} x {b:.2} x {c:.2}", shape.class)
        }
        None => "too few points for a shape".to_owned(),
    };
    format!(
        "{}{moved} at {}: {shape}",
        novelty.kind,
        table::format_point(novelty.centre)
    )
}

/// All about one alarm. `floor_m` is the height of the floor in its frame.
pub(super) fn alarm_text(alarm: &AlarmRow, settings: &Settings, floor_m: Option<f64>) -> String {
    let time = |stamp: &str| local_time(stamp, alarm.clock_unset);
    let distance = |x| table::distance_text(x, 6, alarm.ground.as_deref());
    let mut lines = vec![
        format!("alarm {} at {}: {}", alarm.id, alarm.waypoint, alarm.state),
        format!(
            "  raised {}, last seen {}, {} visit(s)",
            time(&alarm.raised_at),
            time(&alarm.last_seen_at),
            alarm.visits
        ),
        format!(
            "  d_GMM {}, U_th {}: {}",
            distance(alarm.d_gmm),
            distance(alarm.u_th),
            alarm.reason
        ),
        format!(
            "  its own part of d_GMM {}; positions in the frame of reference {}",
            distance(alarm.score),
            alarm.frame
        ),
    ];
    if let Some(at) = &alarm.unobserved_since {
        lines.push(format!(
            "  its place could not be seen since {}: it may be there or not",
            local_time(at, false)
        ));
    }
    for (at, by) in alarm.acknowledged_at.iter().zip(&alarm.acknowledged_by) {
        lines.push(format!("  acknowledged {} by {by}", local_time(at, false)));
    }
    if let Some(answer) = &alarm.answer {
        lines.push(format!("  answer: {}", answer.replace('_', " ")));
    }
    for note in alarm.note.iter().flat_map(|note| note.lines()) {
        lines.push(format!("  note: {note}"));
    }
    for (at, because) in alarm.cleared_at.iter().zip(&alarm.cleared_because) {
        lines.push(format!("  cleared {}: {because}", local_time(at, false)));
    }
    for sighting in alarm.sightings.iter().flatten() {
        if sighting.relation != "seen" {
            lines.push(format!(
                "  {} {}",
                local_time(&sighting.at, false),
                sighting_text(sighting)
            ));
        }
    }
    for novelty in current(alarm) {
        lines.push(format!(
            "  {}, {} points",
            novelty_text(novelty),
            novelty.points
        ));
        let on_map = map_centre(alarm, novelty, settings)
            .map(|p| format!("; on the map at {}", table::format_point(p)));
        let position = position_text(&GuardPosition::new(novelty, floor_m));
        lines.push(format!("    {position}{}", on_map.unwrap_or_default()));
    }
    lines.join("\n")
}

fn sighting_text(sighting: &SightingRow) -> String {
    let by = sighting.distance_m.filter(|_| sighting.relation == "moved");
    let by = by.map(|m| format!(" by {m:.2} m")).unwrap_or_default();
    format!("{}{by} (visit {})", sighting.relation, sighting.visit_id)
}

/// Where to look and for what, in a guard's words.
fn position_text(at: &GuardPosition) -> String {
    let degrees = at.bearing_deg.abs();
    let side = if at.bearing_deg > 0.0 {
        "left"
    } else {
        "right"
    };
    let bearing = if degrees < AHEAD_DEG {
        "straight ahead".to_owned()
    } else if degrees > 180.0 - AHEAD_DEG {
        "straight behind".to_owned()
    } else {
        format!("{degrees:.0} deg to the {side}")
    };
    let floor = match at.above_floor_m {
        Some(height) if height.abs() <= ON_FLOOR_M => "on the floor, ".to_owned(),
        Some(height) if height > 0.0 => format!("{height:.2} m over the floor, "),
        Some(height) => format!("{:.2} m below the floor, ", -height),
        None => String::new(),
    };
    format!(
        "{:.1} m from the waypoint, {bearing}; {floor}{:.2} m high, {:.2} m wide, {:.2} m deep",
        at.distance_m, at.height_m, at.width_m, at.depth_m
    )
}

/// Centre of a novelty on the site's map, where `map_pose` of the waypoint is configured. Heights are unchanged.
fn map_centre(alarm: &AlarmRow, novelty: &NoveltyRecord, settings: &Settings) -> Option<[f64; 3]> {
    let [x, y, yaw_rad] = settings.waypoints.get(&alarm.waypoint)?.map_pose?;
    let [cx, cy, cz] = novelty.centre;
    let (sin, cos) = yaw_rad.sin_cos();
    Some([x + cos * cx - sin * cy, y + sin * cx + cos * cy, cz])
}

/// An alarm as JSON, with `map_centre` of each novelty where `map_pose` is configured.
pub(super) fn alarm_json(alarm: &AlarmRow, settings: &Settings) -> Value {
    with_places(alarm, |novelty, record| {
        if let Some(centre) = map_centre(alarm, novelty, settings) {
            record.insert("map_centre".to_owned(), json!(centre));
        }
    })
}

/// The same, with `position` of each novelty. `floor_m` is the height of the floor in the alarm's frame.
pub(super) fn alarm_json_for_guard(
    alarm: &AlarmRow,
    settings: &Settings,
    floor_m: Option<f64>,
) -> Value {
    with_places(alarm, |novelty, record| {
        if let Some(centre) = map_centre(alarm, novelty, settings) {
            record.insert("map_centre".to_owned(), json!(centre));
        }
        let position = GuardPosition::new(novelty, floor_m);
        record.insert("position".to_owned(), json!(position));
    })
}

fn with_places(
    alarm: &AlarmRow,
    add: impl Fn(&NoveltyRecord, &mut serde_json::Map<String, Value>),
) -> Value {
    let mut value = json!(alarm);
    for (place, novelties) in [
        ("/novelties", &alarm.novelties[..]),
        ("/last_sighting/novelties", current(alarm)),
    ] {
        let records = value.pointer_mut(place).and_then(Value::as_array_mut);
        for (novelty, record) in novelties.iter().zip(records.into_iter().flatten()) {
            if let Value::Object(record) = record {
                add(novelty, record);
            }
        }
    }
    value
}

/// Columns of [`alarm_csv`].
pub(super) const CSV_HEADER: &str = "id,waypoint,state,raised_at,last_seen_at,d_gmm,u_th,kind,x_m,y_m,z_m,class,\
                                     size_x_m,size_y_m,size_z_m,note,map_x_m,map_y_m,map_z_m";

/// One line per thing, as it was last seen.
pub(super) fn alarm_csv(alarm: &AlarmRow, settings: &Settings) -> Vec<String> {
    let line = |n: &NoveltyRecord| {
        let class = n.shape.as_ref().map_or("", |shape| &shape.class);
        let mut cells = vec![
            alarm.id.to_string(),
            quoted(&alarm.waypoint),
            alarm.state.clone(),
            alarm.raised_at.clone(),
            alarm.last_seen_at.clone(),
            number_cell(alarm.d_gmm),
            number_cell(alarm.u_th),
            n.kind.clone(),
        ];
        cells.extend(n.centre.map(|x| number_cell(Some(x))));
        cells.push(class.to_owned());
        cells.extend(xyz_cells(n.shape.as_ref().map(|shape| shape.size)));
        cells.push(quoted(alarm.note.as_deref().unwrap_or("")));
        cells.extend(xyz_cells(map_centre(alarm, n, settings)));
        cells.join(",")
    };
    current(alarm).iter().map(line).collect()
}

/// A cell of text. A spreadsheet takes one that begins with `= + - @` for a formula: an apostrophe goes before it.
fn quoted(text: &str) -> String {
    let text = printable(text);
    let formula = text.trim_start().starts_with(['=', '+', '-', '@', '\t']);
    let apostrophe = if formula { "'" } else { "" };
    format!("\"{apostrophe}{}\"", text.replace('"', "\"\""))
}

fn xyz_cells(values: Option<[f64; 3]>) -> [String; 3] {
    values.map_or([const { String::new() }; 3], |values| {
        values.map(|x| number_cell(Some(x)))
    })
}

/// Empty where there is no number.
fn number_cell(x: Option<f64>) -> String {
    x.filter(|x| x.is_finite())
        .map_or_else(String::new, |x| x.to_string())
}

#[cfg(test)]
mod tests {
    use super::{position_text, quoted};
    use crate::alarm::GuardPosition;

    #[test]
    fn a_cell_is_no_formula() {
        for (text, cell) in [
            ("=1+1", "\"'=1+1\""),
            ("+49 30", "\"'+49 30\""),
            ("-", "\"'-\""),
            ("@all", "\"'@all\""),
            (" =1", "\"' =1\""),
            ("a \"b\", c", "\"a \"\"b\"\", c\""),
            ("a-b=c", "\"a-b=c\""),
            ("\u{1b}[2J", "\"\\u001b[2J\""),
        ] {
            assert_eq!(quoted(text), cell);
        }
    }

    #[test]
    fn a_position_is_told_in_a_guards_words() {
        let text = |bearing_deg, above_floor_m| {
            position_text(&GuardPosition {
                distance_m: 3.24,
                bearing_deg,
                above_floor_m,
                height_m: 0.3,
                width_m: 0.6,
                depth_m: 0.4,
            })
        };
        let size = "0.30 m high, 0.60 m wide, 0.40 m deep";
        let from = "3.2 m from the waypoint";
        assert_eq!(
            text(40.0, Some(0.06)),
            format!("{from}, 40 deg to the left; on the floor, {size}")
        );
        assert_eq!(
            text(-90.4, Some(0.85)),
            format!("{from}, 90 deg to the right; 0.85 m over the floor, {size}")
        );
        assert_eq!(text(-3.0, None), format!("{from}, straight ahead; {size}"));
        assert_eq!(
            text(178.0, None),
            format!("{from}, straight behind; {size}")
        );
    }
}
