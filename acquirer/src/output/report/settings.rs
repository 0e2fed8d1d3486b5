//! The effective settings, one line each.

use super::{
    body::Section,
    html::{escaped, table},
};
use crate::output::Summary;

pub(super) fn section(summary: &Summary) -> Option<Section<'static>> {
    let mut rows = Vec::new();
    flatten("", &summary.settings, &mut rows);
    (!rows.is_empty()).then(|| Section {
        id: "settings",
        title: "Settings",
        body: table(&["Setting", "Value"], &rows).into(),
    })
}

fn flatten(path: &str, value: &serde_json::Value, rows: &mut Vec<Vec<String>>) {
    match value {
        serde_json::Value::Null => {}
        serde_json::Value::Object(entries) => {
            for (key, value) in entries {
                let path = if path.is_empty() {
                    key.clone()
                } else {
                    format!("{path}.{key}")
                };
                flatten(&path, value, rows);
            }
        }
        serde_json::Value::String(text) => rows.push(vec![escaped(path), escaped(text)]),
        other => rows.push(vec![escaped(path), escaped(&other.to_string())]),
    }
}
