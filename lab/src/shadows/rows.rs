//! A chart as comma-separated values and as JSON, one row for each setting and truth.

use aam_scene::ShadowParameter;
use serde_json::{Map, Value, json};

use super::{Judged, Run, ShadowChart, Truth};

/// Columns before the parameters.
const FIRST: [&str; 5] = ["scene", "light", "technique", "settings", "truth"];

/// Columns after the parameters.
const LAST: [&str; 27] = [
    "gpu_ms",
    "gpu_ms_q1",
    "gpu_ms_q3",
    "frames",
    "map_ms",
    "blur_ms",
    "lookup_ms",
    "bytes",
    "rmse",
    "noise",
    "signed_mean",
    "leaked",
    "lost",
    "penumbras",
    "penumbras_missed",
    "penumbra_width",
    "penumbra_signed",
    "penumbra_absolute",
    "flip_mean",
    "flip_p95",
    "flicker",
    "flicker_camera",
    "flicker_light",
    "flicker_caster",
    "limits",
    "adapter",
    "size",
];

/// The names of the columns of [`csv`]; each parameter of any technique has one, empty where a technique lacks it.
pub fn columns() -> Vec<&'static str> {
    let parameters = ShadowParameter::ALL.iter().map(|parameter| parameter.key);
    FIRST.into_iter().chain(parameters).chain(LAST).collect()
}

/// The rows as comma-separated values below the names of the [`columns`]. Numbers that were not measured are empty.
pub fn csv(chart: &ShadowChart) -> String {
    let mut lines = vec![columns().join(",")];
    for row in rows(chart) {
        let field = |column: &&str| match row.get(*column) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => quoted(text),
            Some(value) => value.to_string(),
        };
        lines.push(columns().iter().map(field).collect::<Vec<_>>().join(","));
    }
    lines.join("\n") + "\n"
}

/// The chart as `docs/chart-shadows.schema.json` says.
pub fn json(chart: &ShadowChart) -> Value {
    let truths = chart.truths.iter().zip(&chart.exact).map(|(truth, (visibility, penumbra))| {
        let [dark, penumbra_pixels, lit] = truth.counts();
        json!({
            "truth": truth.kind.word(),
            "pixels": { "dark": dark, "penumbra": penumbra_pixels, "lit": lit },
            "noise": digits(visibility.noise),
            "exact_point": {
                "rmse": digits(visibility.rmse),
                "signed_mean": digits(visibility.signed_mean),
                "penumbra_absolute": digits(penumbra.absolute_mean),
            },
        })
    });
    let left = chart.left.iter().map(|left| json!({ "settings": left.settings, "reason": left.reason }));
    json!({
        "scene": chart.scene,
        "light": chart.light,
        "width": chart.size[0],
        "height": chart.size[1],
        "adapter": chart.adapter,
        "frames": chart.frames,
        "light_samples": chart.rays.light_samples,
        "picture_samples": chart.rays.picture_samples,
        "seconds": digits(chart.elapsed.as_secs_f64()),
        "exact_point_flicker": chart.exact_flicker.and_then(|flicker| flicker.most()).map(digits),
        "truths": truths.collect::<Vec<_>>(),
        "runs": rows(chart),
        "left": left.collect::<Vec<_>>(),
    })
}

fn rows(chart: &ShadowChart) -> Vec<Map<String, Value>> {
    let of_run = |run: &Run| {
        chart.truths.iter().zip(&run.judged).map(|(truth, judged)| row(chart, run, truth, judged)).collect::<Vec<_>>()
    };
    chart.runs.iter().flat_map(of_run).collect()
}

fn row(chart: &ShadowChart, run: &Run, truth: &Truth, judged: &Judged) -> Map<String, Value> {
    let mut row = Map::new();
    let mut put = |key: &str, value: Value| {
        row.insert(key.to_owned(), value);
    };
    put("scene", json!(chart.scene));
    put("light", json!(chart.light));
    put("technique", json!(run.technique()));
    put("settings", json!(run.label()));
    put("truth", json!(truth.kind.word()));
    for parameter in run.settings.iter().flat_map(|settings| settings.parameters()) {
        let text = run.settings.map(|settings| parameter.get(&settings)).unwrap_or_default();
        let number = text.parse::<f64>().ok().and_then(|value| serde_json::Number::from_f64(value).map(|_| value));
        let value = match (number, text.parse::<u64>(), text.as_str()) {
            (_, Ok(whole), _) => json!(whole),
            (Some(number), ..) => json!(number),
            (None, _, "true") => json!(true),
            (None, _, "false") => json!(false),
            // Infinity, which JSON does not have, and words.
            _ => json!(text),
        };
        put(parameter.key, value);
    }
    let times = &run.times;
    put("gpu_ms", digits(times.gpu_ms));
    put("gpu_ms_q1", digits(times.quartiles[0]));
    put("gpu_ms_q3", digits(times.quartiles[1]));
    put("frames", json!(times.frames));
    put("map_ms", digits(times.map_ms));
    put("blur_ms", digits(times.blur_ms));
    put("lookup_ms", digits(times.lookup_ms));
    put("bytes", json!(run.bytes));
    let (visibility, penumbra) = (&judged.visibility, &judged.penumbra);
    put("rmse", digits(visibility.rmse));
    put("noise", digits(visibility.noise));
    put("signed_mean", digits(visibility.signed_mean));
    put("leaked", digits(visibility.leaked));
    put("lost", digits(visibility.lost));
    put("penumbras", json!(penumbra.count));
    put("penumbras_missed", json!(penumbra.missed));
    put("penumbra_width", digits(penumbra.width));
    put("penumbra_signed", digits(penumbra.signed_mean));
    put("penumbra_absolute", digits(penumbra.absolute_mean));
    put("flip_mean", judged.flip.map_or(Value::Null, |flip| digits(flip.0)));
    put("flip_p95", judged.flip.map_or(Value::Null, |flip| digits(flip.1)));
    let flicker = run.flicker.unwrap_or_default();
    for (key, value) in [
        ("flicker", flicker.most()),
        ("flicker_camera", flicker.camera),
        ("flicker_light", flicker.light),
        ("flicker_caster", flicker.caster),
    ] {
        put(key, value.map_or(Value::Null, digits));
    }
    put("limits", json!(run.limits.text()));
    put("adapter", json!(chart.adapter));
    put("size", json!(format!("{}x{}", chart.size[0], chart.size[1])));
    row
}

/// A number with no more digits than were measured.
fn digits(value: f64) -> Value {
    let places = 1e5;
    json!((value * places).round() / places)
}

fn quoted(text: &str) -> String {
    let text = text.replace(['\r', '\n'], " ");
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}
