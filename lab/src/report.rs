//! Studies as text: comma-separated values that a chart can be drawn from again.

use crate::study::{Row, Study};

/// Column names, in order.
const COLUMNS: [&str; 11] = [
    "scene",
    "variant",
    "GPU ms",
    "GPU ms first quartile",
    "GPU ms third quartile",
    "FLIP mean",
    "FLIP 95 %",
    "FLIP 99 %",
    "RMSE",
    "over 24/255",
    "limits",
];

/// Why text is not a study.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct ReportError {
    /// Line number from 1.
    pub line: usize,
    /// What is wrong.
    pub problem: String,
}

/// A study as comma-separated values, after lines with `#` that say what was measured and on what.
pub fn to_csv(study: &Study) -> String {
    let Study { technique, title, machine, method, rows } = study;
    let mut lines: Vec<String> = [("technique", technique), ("title", title), ("machine", machine), ("method", method)]
        .map(|(key, value)| format!("# {key}: {}", value.replace(['\r', '\n'], " ")))
        .to_vec();
    lines.push(COLUMNS.join(","));
    lines.extend(rows.iter().map(|row| {
        let [low, high] = row.gpu_quartiles;
        let milliseconds = [row.gpu_ms, low, high].map(|ms| format!("{ms:.3}"));
        let errors =
            [row.flip_mean, row.flip_p95, row.flip_p99, row.rmse, row.over_24].map(|error| format!("{error:.5}"));
        let mut fields = vec![quoted(&row.scene), quoted(&row.variant)];
        fields.extend(milliseconds.into_iter().chain(errors));
        fields.push(quoted(&row.limits));
        fields.join(",")
    }));
    lines.join("\n") + "\n"
}

/// Reads what [`to_csv`] wrote.
///
/// # Errors
/// A line is not of that form.
pub fn from_csv(text: &str) -> Result<Study, ReportError> {
    let mut study = Study {
        technique: String::new(),
        title: String::new(),
        machine: String::new(),
        method: String::new(),
        rows: Vec::new(),
    };
    let mut names_seen = false;
    for (index, line) in text.lines().enumerate() {
        let fail = |problem: String| ReportError { line: index + 1, problem };
        if let Some(note) = line.strip_prefix("# ") {
            let (key, value) = note.split_once(": ").unwrap_or((note, ""));
            match key {
                "technique" => study.technique = value.into(),
                "title" => study.title = value.into(),
                "machine" => study.machine = value.into(),
                "method" => study.method = value.into(),
                _ => return Err(fail(format!("unknown note {key:?}"))),
            }
        } else if !names_seen {
            if line != COLUMNS.join(",") {
                return Err(fail(format!("expected the columns {}", COLUMNS.join(","))));
            }
            names_seen = true;
        } else {
            study.rows.push(row(&fields(line)).map_err(fail)?);
        }
    }
    Ok(study)
}

fn row(fields: &[String]) -> Result<Row, String> {
    let [scene, variant, numbers @ .., limits] = fields else { return Err("too few columns".into()) };
    let number = |text: &String| text.parse().map_err(|_| format!("{text:?} is not a number"));
    let numbers = numbers.iter().map(number).collect::<Result<Vec<f64>, _>>()?;
    let &[gpu_ms, low, high, flip_mean, flip_p95, flip_p99, rmse, over_24] = numbers.as_slice() else {
        return Err(format!("expected {} columns, found {}", COLUMNS.len(), fields.len()));
    };
    let (scene, variant, limits) = (scene.clone(), variant.clone(), limits.clone());
    Ok(Row { scene, variant, gpu_ms, gpu_quartiles: [low, high], flip_mean, flip_p95, flip_p99, rmse, over_24, limits })
}

fn quoted(text: &str) -> String {
    let text = text.replace(['\r', '\n'], " ");
    if text.contains([',', '"', '#']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// The fields of a line; a comma in quotes does not end one.
pub(crate) fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut inside = false;
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '"' if inside && characters.peek() == Some(&'"') => {
                characters.next();
                fields.last_mut().unwrap_or(&mut String::new()).push('"');
            }
            '"' => inside = !inside,
            ',' if !inside => fields.push(String::new()),
            _ => fields.last_mut().unwrap_or(&mut String::new()).push(character),
        }
    }
    fields
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn study() -> Study {
        let row = |scene: &str, variant: &str, gpu_ms: f64, flip_mean: f64| Row {
            scene: scene.into(),
            variant: variant.into(),
            gpu_ms,
            gpu_quartiles: [gpu_ms - 0.25, gpu_ms + 0.25],
            flip_mean,
            flip_p95: 2.0 * flip_mean,
            flip_p99: 3.0 * flip_mean,
            rmse: flip_mean,
            over_24: 0.01,
            limits: "degrades because it says \"no\", twice".into(),
        };
        Study {
            technique: "sample".into(),
            title: "A title: with a colon".into(),
            machine: "adapter (driver)".into(),
            method: "median of 3".into(),
            rows: vec![
                row("one", "a, cheap", 1.0, 0.125),
                row("one", "b", 2.0, 0.0625),
                row("one", "c, worse", 3.0, 0.09375),
                row("two", "b", 20.0, 0.25),
            ],
        }
    }

    #[test]
    fn text_reads_back_to_the_same_study() {
        assert_eq!(from_csv(&to_csv(&study())), Ok(study()));
    }

    #[test]
    fn text_of_another_form_is_refused_by_line() {
        let text = to_csv(&study());
        assert_eq!(from_csv("scene,variant\n").map_err(|error| error.line), Err(1));
        assert_eq!(from_csv(&text.replace("20.000", "fast")).map_err(|error| error.line), Err(9));
        assert_eq!(from_csv(&text.replace(",20.000", "")).map_err(|error| error.line), Err(9));
        assert_eq!(from_csv("# colour: red\n").map_err(|error| error.line), Err(1));
    }
}
