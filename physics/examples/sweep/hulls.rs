//! What `aam tune --physics FILE --max-error 0.0001 --json` found, as rows.

use std::path::Path;

use serde_json::Value;

use crate::Row;

/// The rows of a report: for each object whose hulls matter, its errors, jitter and cost against the number of hulls.
pub(crate) fn rows(path: &Path) -> Result<Vec<Row>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let report: Value = serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut rows = Vec::new();
    for object in report["objects"].as_array().into_iter().flatten() {
        let tried = object["tried"].as_array().map_or(&[][..], Vec::as_slice);
        // A convex object has one hull.
        if tried.len() < 2 {
            continue;
        }
        let name = object["name"].as_str().unwrap_or("object").replace(',', " ");
        let number = |value: &Value| value.as_f64().unwrap_or(f64::INFINITY);
        for one in tried {
            let errors = &one["errors"];
            for (sweep, value) in [
                ("hulls-path", 100.0 * number(&errors["path"])),
                ("hulls-rest", 100.0 * number(&errors["rest"])),
                ("hulls-jitter", 100.0 * number(&errors["jitter"])),
                ("hulls-cost", 1e6 * number(&errors["step_seconds"])),
            ] {
                rows.push(Row { sweep: sweep.into(), variant: name.clone(), x: number(&one["hulls"]), y: value });
            }
        }
    }
    Ok(rows)
}
