//! As much of JSON Schema (2020-12) as the schemas in `docs/` use. Any other keyword is refused, so that nothing in
//! them goes unchecked.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Map, Value};

/// Keywords that say nothing about values.
const ANNOTATIONS: [&str; 4] = ["$schema", "title", "description", "$defs"];

/// A schema, and which of its properties were met in the values so far.
pub(crate) struct Schema {
    root: Value,
    met: BTreeSet<(String, String)>,
}

impl Schema {
    /// A schema of `docs/`.
    pub(crate) fn of_docs(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name);
        let text = std::fs::read_to_string(path).expect("a schema");
        Self { root: serde_json::from_str(&text).expect("JSON"), met: BTreeSet::new() }
    }

    /// Fails, saying where, unless a value is as the schema says.
    #[track_caller]
    pub(crate) fn accepts(&mut self, value: &Value) {
        let root = self.root.clone();
        if let Err(problem) = self.validate("#", &root, value) {
            panic!("{problem}\nin {value:#}");
        }
    }

    /// Whether a value is refused.
    pub(crate) fn refuses(&mut self, value: &Value) -> bool {
        let root = self.root.clone();
        self.validate("#", &root, value).is_err()
    }

    /// Fails unless every property that the schema names was met.
    #[track_caller]
    pub(crate) fn is_used_up(&self) {
        let named = properties("#", &self.root);
        let unmet: Vec<_> = named.difference(&self.met).collect();
        assert!(unmet.is_empty(), "no output has {unmet:?}");
    }

    fn validate(&mut self, place: &str, schema: &Value, value: &Value) -> Result<(), String> {
        let schema = schema.as_object().expect("a schema is an object");
        for (keyword, rule) in schema {
            let held = match keyword.as_str() {
                name if ANNOTATIONS.contains(&name) => true,
                "properties" | "additionalProperties" => continue,
                "$ref" => {
                    let target = rule.as_str().expect("a reference");
                    let found = self.root.pointer(&target[1..]).expect("a definition").clone();
                    self.validate(target, &found, value)?;
                    true
                }
                "anyOf" => {
                    let choices = rule.as_array().expect("a list");
                    let results: Vec<_> = choices.iter().map(|choice| self.validate(place, choice, value)).collect();
                    if results.iter().all(Result::is_err) {
                        return results.into_iter().next().expect("a choice");
                    }
                    true
                }
                "type" => match rule {
                    Value::Array(types) => types.iter().any(|name| is_of(value, name)),
                    name => is_of(value, name),
                },
                "enum" => rule.as_array().expect("a list").contains(value),
                "minimum" => value.as_f64().is_none_or(|number| number >= rule.as_f64().expect("a number")),
                "minItems" => value.as_array().is_none_or(|list| list.len() as u64 >= rule.as_u64().expect("a count")),
                "maxItems" => value.as_array().is_none_or(|list| list.len() as u64 <= rule.as_u64().expect("a count")),
                "required" => {
                    let names = rule.as_array().expect("a list").iter().filter_map(Value::as_str);
                    value.as_object().is_none_or(|object| names.into_iter().all(|name| object.contains_key(name)))
                }
                "items" => {
                    for item in value.as_array().into_iter().flatten() {
                        self.validate(place, rule, item)?;
                    }
                    true
                }
                other => panic!("{place}: the keyword {other} is not known here"),
            };
            if !held {
                return Err(format!("{place}: {value} breaks {keyword} {rule}"));
            }
        }
        match value.as_object() {
            Some(members) => self.members(place, schema, members),
            None => Ok(()),
        }
    }

    fn members(
        &mut self,
        place: &str,
        schema: &Map<String, Value>,
        members: &Map<String, Value>,
    ) -> Result<(), String> {
        for (name, member) in members {
            match schema.get("properties").and_then(|properties| properties.get(name)) {
                Some(rule) => {
                    self.met.insert((place.to_owned(), name.clone()));
                    self.validate(place, rule, member).map_err(|problem| format!("{name}: {problem}"))?;
                }
                None if schema.get("additionalProperties") == Some(&Value::Bool(false)) => {
                    return Err(format!("{place}: the schema does not know {name}"));
                }
                None => {}
            }
        }
        Ok(())
    }
}

fn is_of(value: &Value, name: &Value) -> bool {
    match name.as_str().expect("the name of a type") {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("there is no type {other}"),
    }
}

/// The properties that a schema and its definitions name, each with its place.
fn properties(place: &str, schema: &Value) -> BTreeSet<(String, String)> {
    let names = |schema: &Value| schema.get("properties").and_then(Value::as_object).cloned().unwrap_or_default();
    let own = names(schema).into_iter().map(|(name, _)| (place.to_owned(), name));
    let defined = schema.get("$defs").and_then(Value::as_object).into_iter().flatten();
    own.chain(defined.flat_map(|(name, inner)| properties(&format!("{place}/$defs/{name}"), inner))).collect()
}
