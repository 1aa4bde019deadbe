//! Validates JSON against the schemas of `docs/schema`.

use jsonschema::{Registry, Resource};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

fn folder() -> PathBuf {
    patrold_test_support::workspace_root().join("docs/schema")
}

/// Name and schema.
pub(crate) fn all() -> Vec<(String, Value)> {
    let entries = fs::read_dir(folder()).expect("docs/schema is there");
    let mut all: Vec<(String, Value)> = entries
        .map(|entry| entry.expect("an entry").path())
        .map(|path| {
            let text = fs::read_to_string(&path).expect("readable");
            let schema =
                serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            let name = path
                .file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            (name, schema)
        })
        .collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// Panics unless `value` is valid under the schema `name`.
pub(crate) fn check(name: &str, value: &Value) {
    let schemas = all();
    let (_, schema) = schemas
        .iter()
        .find(|(n, _)| n == name)
        .unwrap_or_else(|| panic!("docs/schema/{name}.json is missing"));
    let uri = |name: &str| format!("https://patrold.invalid/schema/{name}.json");
    let mut registry = Registry::new();
    for (other, text) in &schemas {
        registry = registry
            .add(uri(other), Resource::from_contents(text.clone()))
            .expect("a schema");
    }
    let registry = registry.prepare().expect("the schemas resolve");
    let validator = jsonschema::options()
        .with_registry(&registry)
        .build(schema)
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let errors: Vec<String> = validator
        .iter_errors(value)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    assert!(
        errors.is_empty(),
        "not valid under the schema {name}:\n{}\n{value}",
        errors.join("\n")
    );
}
