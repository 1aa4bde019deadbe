//! The configuration as a JSON Schema, for editors and for programs that write it.

use super::keys::{ConfigKey, KEYS};
use super::value::ValueKind;
use super::waypoint_keys::WAYPOINT_KEYS;
use serde_json::{Map, Value, json};

const USB_NAME: &str = "usb:[0-9A-Fa-f]{4}:[0-9A-Fa-f]{4}(:.+)?";

/// Host and port, from 1 to 65535.
const TCP_NAME: &str =
    "tcp:.+:([1-9][0-9]{0,3}|[1-5][0-9]{4}|6[0-4][0-9]{3}|65[0-4][0-9]{2}|655[0-2][0-9]|6553[0-5])";

/// Text of `docs/schema/config.json`.
pub fn json_schema() -> String {
    let mut sections: Vec<(&str, Vec<&ConfigKey>)> = Vec::new();
    for key in KEYS {
        let (section, _) = key.name.split_once('.').unwrap_or(("", key.name));
        match sections.last_mut() {
            Some((last, keys)) if *last == section => keys.push(key),
            _ => sections.push((section, vec![key])),
        }
    }
    let mut properties: Map<String, Value> = sections
        .into_iter()
        .map(|(section, keys)| (section.to_owned(), table(&keys)))
        .collect();
    let waypoint = table(&WAYPOINT_KEYS.iter().collect::<Vec<_>>());
    let waypoints = json!({
        "type": "object",
        "description": "Waypoints that differ, by name.",
        "additionalProperties": waypoint,
    });
    properties.insert("waypoint".to_owned(), waypoints);
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "https://patrold.invalid/schema/config.json",
        "title": "patrold.toml, and each file of patrold.d",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
    });
    format!("{schema:#}\n")
}

fn table(keys: &[&ConfigKey]) -> Value {
    let properties: Map<String, Value> = keys
        .iter()
        .map(|key| {
            let name = key.name.split_once('.').map_or(key.name, |(_, name)| name);
            (name.to_owned(), property(key))
        })
        .collect();
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

fn property(key: &ConfigKey) -> Value {
    let mut property = accepted(key.kind);
    let unit = if key.unit.is_empty() {
        String::new()
    } else {
        format!(" [{}]", key.unit)
    };
    property["description"] = json!(format!("{}{unit}", key.description));
    property["default"] = key
        .default_value()
        .map_or(Value::Null, |value| value.to_json());
    property
}

fn accepted(kind: ValueKind) -> Value {
    match kind {
        ValueKind::Float(low, high) => number("number", json!(low), json!(high)),
        ValueKind::Integer(low, high) => number("integer", json!(low), json!(high)),
        ValueKind::Text => json!({ "type": "string", "minLength": 1 }),
        ValueKind::Port => json!({
            "type": "string",
            "pattern": format!("^(?!usb:|tcp:).+$|^{USB_NAME}$|^{TCP_NAME}$"),
        }),
        ValueKind::OneOf(words) => json!({ "enum": words }),
        ValueKind::Sign => json!({ "enum": [1, -1] }),
        ValueKind::Flag => json!({ "type": "boolean" }),
        ValueKind::Floats(min, max, low, high) => json!({
            "type": "array",
            "items": number("number", json!(low), json!(high)),
            "minItems": min,
            "maxItems": max,
        }),
    }
}

fn number(kind: &str, low: Value, high: Value) -> Value {
    json!({ "type": kind, "minimum": low, "maximum": high })
}

#[cfg(test)]
mod tests {
    use super::json_schema;
    use crate::config::keys::KEYS;
    use crate::config::waypoint_keys::WAYPOINT_KEYS;
    use serde_json::{Value, json};
    use toml::de::DeValue;

    #[test]
    fn the_shipped_schema_is_this_text() {
        let shipped = patrold_test_support::workspace_root().join("docs/schema/config.json");
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::write(&shipped, json_schema()).expect("written");
        }
        let text = std::fs::read_to_string(shipped).expect("docs/schema/config.json");
        assert_eq!(
            text,
            json_schema(),
            "UPDATE_EXPECT=1 cargo test rewrites it"
        );
    }

    // JSON Schema takes 5.0 as a whole number, TOML does not: no such value here.
    #[test]
    fn a_value_is_valid_where_its_key_accepts_it() {
        let schema: Value = serde_json::from_str(&json_schema()).expect("JSON");
        let validator = jsonschema::validator_for(&schema).expect("a schema");
        let values = [
            "1",
            "-1",
            "0",
            "0.25",
            "-0.3",
            "7",
            "20000.5",
            "1234567.5",
            "9600",
            "true",
            "\"\"",
            "\"any\"",
            "\"step\"",
            "\"info\"",
            "\"usb:15d1:0000\"",
            "\"usb:0403:6001:A1B2\"",
            "\"usb:nothing\"",
            "\"usb:15d:0000\"",
            "\"usb:15d1:0000:\"",
            "\"tcp:\"",
            "\"tcp:10.0.0.2:10940\"",
            "\"tcp:host:65535\"",
            "\"tcp:host:65536\"",
            "\"tcp:host:0\"",
            "\"tcp:host\"",
            "\"/dev/ttyS0\"",
            "[]",
            "[0.0]",
            "[0, 0, 0]",
            "[1, 2, 1e7]",
            "[\"a\"]",
        ];
        let waypoint_keys = WAYPOINT_KEYS.iter();
        let of_waypoint =
            waypoint_keys.map(|key| (format!("waypoint.hall.{}", key.name), key.kind));
        let of_section = KEYS.iter().map(|key| (key.name.to_owned(), key.kind));
        let mut seen = [0; 2];
        for (name, kind) in of_section.chain(of_waypoint) {
            for value in values {
                let accepted = kind
                    .parse(DeValue::parse(value).expect("TOML").get_ref())
                    .is_ok();
                let number: toml::Table = format!("v = {value}").parse().expect("TOML");
                let mut file = serde_json::to_value(&number["v"]).expect("JSON");
                for part in name.rsplit('.') {
                    file = json!({ part: file });
                }
                assert_eq!(validator.is_valid(&file), accepted, "{name} = {value}");
                seen[usize::from(accepted)] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
        for file in [json!({}), json!({"waypoint": {"hall": {}}})] {
            assert!(validator.is_valid(&file));
        }
        for file in [
            json!({"sweeps": {}}),
            json!({"ptu": {"prot": "x"}}),
            json!({"waypoint": {"hall": {"u_th": 1}}}),
        ] {
            assert!(!validator.is_valid(&file), "{file}");
        }
    }
}
