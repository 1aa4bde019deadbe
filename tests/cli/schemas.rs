//! The schemas themselves.

use crate::harness::schema;

#[test]
fn every_schema_is_valid_and_named_after_its_file() {
    for (name, text) in schema::all() {
        assert!(jsonschema::meta::is_valid(&text), "{name}");
        let id = format!("https://patrold.invalid/schema/{name}.json");
        assert_eq!(text["$id"], serde_json::json!(id));
    }
}

#[test]
fn every_schema_refuses_unknown_keys() {
    fn find_open(at: &str, value: &serde_json::Value, found: &mut Vec<String>) {
        if let Some(object) = value.as_object() {
            if object.get("type") == Some(&"object".into())
                && !object.contains_key("additionalProperties")
            {
                found.push(at.to_owned());
            }
            for (key, inner) in object {
                find_open(&format!("{at}/{key}"), inner, found);
            }
        }
    }
    for (name, text) in schema::all() {
        // Mixture files of users may have other keys.
        if name != "mixture" {
            let mut found = Vec::new();
            find_open(&name, &text, &mut found);
            assert_eq!(found, [""; 0]);
        }
    }
}
