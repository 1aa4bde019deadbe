//! Alarms as table, text, JSON and CSV.

use super::failure::Failure;
use super::table;
use crate::config::Settings;
use crate::store::AlarmRow;
use patrold_engine::report::NoveltyRecord;
use serde_json::{Value, json};

/// One row per alarm, one line per novelty.
pub(super) fn alarm_table(alarms: &[AlarmRow]) -> String {
    let mut rows = table::table(&[
        "id",
        "raised",
        "waypoint",
        "state",
        "d_gmm",
        "what, where (m), shape",
    ]);
    for alarm in alarms {
        let novelties: Vec<String> = alarm.novelties.iter().map(novelty_text).collect();
        rows.add_row([
            alarm.id.to_string(),
            alarm.raised_at.clone(),
            alarm.waypoint.clone(),
            alarm.state.clone(),
            distance_text(alarm.d_gmm, 4, alarm),
            novelties.join("\n"),
        ]);
    }
    rows.to_string()
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

/// All about one alarm.
pub(super) fn alarm_text(alarm: &AlarmRow, settings: &Settings) -> String {
    let mut lines = vec![
        format!("alarm {} at {}: {}", alarm.id, alarm.waypoint, alarm.state),
        format!(
            "  raised {}, last seen {}, {} visit(s)",
            alarm.raised_at, alarm.last_seen_at, alarm.visits
        ),
        format!(
            "  d_GMM {}, U_th {}: {}",
            distance_text(alarm.d_gmm, 6, alarm),
            distance_text(alarm.u_th, 6, alarm),
            alarm.reason
        ),
        format!("  positions in the frame of reference {}", alarm.frame),
    ];
    for (at, by) in alarm.acknowledged_at.iter().zip(&alarm.acknowledged_by) {
        lines.push(format!("  acknowledged {at} by {by}"));
    }
    for note in alarm.note.iter().flat_map(|note| note.lines()) {
        lines.push(format!("  note: {note}"));
    }
    for (at, because) in alarm.cleared_at.iter().zip(&alarm.cleared_because) {
        lines.push(format!("  cleared {at}: {because}"));
    }
    for novelty in &alarm.novelties {
        let on_map = map_centre(alarm, novelty, settings)
            .map(|p| format!(", on the map at {}", table::format_point(p)));
        lines.push(format!(
            "  {}{}, {} points",
            novelty_text(novelty),
            on_map.unwrap_or_default(),
            novelty.points
        ));
    }
    lines.join("\n")
}

/// A distance with the unit of its ground distance; `fm` has none.
fn distance_text(x: Option<f64>, digits: usize, alarm: &AlarmRow) -> String {
    let unit = match alarm.ground.as_deref() {
        Some("w2" | "euclid") => " m",
        _ => "",
    };
    x.map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}{unit}"))
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
    let mut value = json!(alarm);
    if let Some(Value::Array(records)) = value.get_mut("novelties") {
        for (novelty, record) in alarm.novelties.iter().zip(records) {
            if let (Some(centre), Value::Object(record)) =
                (map_centre(alarm, novelty, settings), record)
            {
                record.insert("map_centre".to_owned(), json!(centre));
            }
        }
    }
    value
}

/// One JSON object per line.
pub(super) fn alarm_json_lines(
    alarms: &[AlarmRow],
    settings: &Settings,
) -> Result<String, Failure> {
    let line = |alarm| serde_json::to_string(&alarm_json(alarm, settings)).map(|line| line + "\n");
    let lines: Result<String, _> = alarms.iter().map(line).collect();
    lines.map_err(Failure::failed)
}

/// One line per novelty.
pub(super) fn alarm_csv(alarms: &[AlarmRow], settings: &Settings) -> String {
    let mut text = "id,waypoint,state,raised_at,last_seen_at,d_gmm,u_th,kind,x_m,y_m,z_m,class,\
                    size_x_m,size_y_m,size_z_m,note,map_x_m,map_y_m,map_z_m\n"
        .to_owned();
    for alarm in alarms {
        for n in &alarm.novelties {
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
            text.push_str(&cells.join(","));
            text.push('\n');
        }
    }
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
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
