//! The schema of `summary.json`: what it says of a summary, and which keys it knows.
//!
//! The words of JSON Schema that it uses are a few; one that it does not is a panic here, so that none is passed over. A test
//! of the Python package holds this reading against the package `jsonschema`.

use serde_json::Value;
use std::path::Path;

/// The folder of the schema and of the page that tells what its keys mean.
pub fn reference() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference")
}

pub struct Schema {
    root: Value,
}

impl Schema {
    pub fn read() -> Self {
        let text = std::fs::read_to_string(reference().join("summary.schema.json")).unwrap();
        Self {
            root: serde_json::from_str(&text).unwrap(),
        }
    }

    /// What is wrong with a summary, with the place of each fault.
    pub fn faults(&self, summary: &Value) -> Vec<String> {
        let mut faults = Vec::new();
        self.check(&self.root, summary, "", &mut faults);
        faults
    }

    /// The keys of all objects: the name of the definition, "summary" of the whole, and the key.
    pub fn keys(&self) -> Vec<(&str, &str)> {
        let definitions = self.root["$defs"].as_object().unwrap();
        let definitions = definitions.iter().map(|(name, own)| (name.as_str(), own));
        let all = [("summary", &self.root)].into_iter().chain(definitions);
        let keys = all.flat_map(|(name, own)| {
            let properties = own["properties"].as_object().into_iter().flatten();
            properties.map(move |(key, _)| (name, key.as_str()))
        });
        keys.collect()
    }

    fn check(&self, rule: &Value, value: &Value, place: &str, faults: &mut Vec<String>) {
        for (word, own) in rule.as_object().unwrap() {
            let holds = match word.as_str() {
                "$schema" | "title" | "description" | "$defs" | "properties" => true,
                "$ref" => {
                    let name = own.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                    self.check(&self.root["$defs"][name], value, place, faults);
                    true
                }
                "type" => match own {
                    Value::Array(kinds) => kinds.iter().any(|kind| is(value, kind)),
                    kind => is(value, kind),
                },
                "const" => value == own,
                "enum" => own.as_array().unwrap().contains(value),
                "minimum" => value.as_f64().is_none_or(|v| v >= own.as_f64().unwrap()),
                "minItems" => size(value).is_none_or(|n| n >= own.as_u64().unwrap()),
                "maxItems" => size(value).is_none_or(|n| n <= own.as_u64().unwrap()),
                "items" => {
                    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                        self.check(own, item, &format!("{place}/{index}"), faults);
                    }
                    true
                }
                "anyOf" => own.as_array().unwrap().iter().any(|rule| {
                    let mut of_one = Vec::new();
                    self.check(rule, value, place, &mut of_one);
                    of_one.is_empty()
                }),
                "required" => has_all(value, own),
                "dependentRequired" => {
                    let rules = own.as_object().unwrap().iter();
                    let mut there = rules.filter(|(key, _)| value.get(key).is_some());
                    there.all(|(_, others)| has_all(value, others))
                }
                "additionalProperties" => {
                    for (key, entry) in value.as_object().into_iter().flatten() {
                        let place = format!("{place}/{key}");
                        match (rule.get("properties").and_then(|p| p.get(key)), own) {
                            (Some(rule), _) => self.check(rule, entry, &place, faults),
                            (None, Value::Bool(false)) => {
                                faults.push(format!("{place}: unknown key"));
                            }
                            (None, rule) => self.check(rule, entry, &place, faults),
                        }
                    }
                    true
                }
                other => panic!("the word `{other}` of JSON Schema is not read"),
            };
            if !holds {
                faults.push(format!("{place}: {word} {own}, found {value}"));
            }
        }
    }
}

fn is(value: &Value, kind: &Value) -> bool {
    match kind.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        other => panic!("the type `{other}` is not read"),
    }
}

fn size(value: &Value) -> Option<u64> {
    value.as_array().map(|list| list.len() as u64)
}

fn has_all(value: &Value, keys: &Value) -> bool {
    let keys = keys.as_array().unwrap().iter();
    let mut keys = keys.map(|key| key.as_str().unwrap());
    value.is_object() && keys.all(|key| value.get(key).is_some())
}
