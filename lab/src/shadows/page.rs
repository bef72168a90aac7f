//! A chart as one page that needs nothing else.

use std::io::Cursor;

use aam_scene::{Image, Pixels};
use base64::Engine;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};

use super::front::front_of;
use super::rows::json as rows_of;
use super::{Run, ShadowChart};
use crate::LabError;
use crate::metrics::CompareError;

const TEMPLATE: &str = include_str!("page.html");

/// Quality of pictures; differences are seen beside them, not in them.
const QUALITY: u8 = 88;

/// The chart as HTML: the plot, a table, and the pictures of the settings that someone may choose beside the truths'.
/// `command` is shown as what made it.
///
/// # Errors
/// A picture cannot be encoded.
pub fn page(chart: &ShadowChart, command: &str) -> Result<String, LabError> {
    let mut data = rows_of(chart);
    let shown = shown(chart);
    let pictures = chart.runs.iter().enumerate().filter(|(index, _)| shown.contains(index));
    let pictures = pictures
        .map(|(_, run)| Ok((run.label(), pair(chart, &run.picture, &run.visibility)?)))
        .collect::<Result<serde_json::Map<String, Value>, LabError>>()?;
    let truths = chart
        .truths
        .iter()
        .map(|truth| {
            let visibility = grey(chart, &truth.shares())?;
            let picture = truth.picture.as_ref().map(jpeg).transpose()?;
            let faces: Vec<f32> = truth.seen.iter().map(|seen| f32::from(u8::from(seen.is_some()))).collect();
            let faces = grey(chart, &faces)?;
            Ok((truth.kind.word().to_owned(), json!({ "picture": picture, "visibility": visibility, "faces": faces })))
        })
        .collect::<Result<serde_json::Map<String, Value>, LabError>>()?;
    if let Some(object) = data.as_object_mut() {
        object.insert("pictures".into(), Value::Object(pictures));
        object.insert("truth_pictures".into(), Value::Object(truths));
        object.insert("command".into(), json!(command));
    }
    // Nothing in a string can end the script.
    let data = data.to_string().replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029");
    let title = escaped(&format!("Shadows of {} in {}", chart.light, chart.scene));
    Ok(TEMPLATE.replace("{{title}}", &title).replace("{{data}}", &data))
}

/// The runs whose pictures are worth their bytes: those on a front of time or memory and any error, and of each
/// technique the most accurate and the one that costs the least.
fn shown(chart: &ShadowChart) -> Vec<usize> {
    let runs = &chart.runs;
    let mut shown = vec![0];
    for truth in 0..chart.truths.len() {
        let errors: [&dyn Fn(&Run) -> f64; 3] = [
            &|run| run.judged[truth].visibility.rmse,
            &|run| run.judged[truth].flip.map_or(f64::INFINITY, |flip| flip.0),
            &|run| run.judged[truth].penumbra.absolute_mean,
        ];
        for error in errors {
            shown.extend(front_of(runs.iter().map(|run| (run.times.gpu_ms, error(run)))));
        }
        shown.extend(front_of(runs.iter().map(|run| (run.bytes as f64, run.judged[truth].visibility.rmse))));
        let mut names: Vec<String> = runs.iter().map(Run::technique).collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            let own = || (0..runs.len()).filter(|&index| runs[index].technique() == name);
            let rmse = |index: &usize| runs[*index].judged[truth].visibility.rmse;
            shown.extend(own().min_by(|a, b| rmse(a).total_cmp(&rmse(b))));
            shown.extend(own().min_by(|a, b| runs[*a].times.gpu_ms.total_cmp(&runs[*b].times.gpu_ms)));
        }
    }
    shown.sort_unstable();
    shown.dedup();
    shown
}

fn pair(chart: &ShadowChart, picture: &Image, visibility: &[f32]) -> Result<Value, LabError> {
    Ok(json!({ "picture": jpeg(picture)?, "visibility": grey(chart, visibility)? }))
}

fn jpeg(picture: &Image) -> Result<String, LabError> {
    let Pixels::Rgba8(bytes) = &picture.pixels else { return Err(CompareError::Format.into()) };
    let colors: Vec<u8> = bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut encoded = Cursor::new(Vec::new());
    JpegEncoder::new_with_quality(&mut encoded, QUALITY)
        .write_image(&colors, picture.width, picture.height, ExtendedColorType::Rgb8)
        .map_err(|error| LabError::Embed(error.to_string()))?;
    Ok(url("jpeg", &encoded.into_inner()))
}

/// Numbers from 0 to 1 as a grey picture without loss.
fn grey(chart: &ShadowChart, values: &[f32]) -> Result<String, LabError> {
    let bytes: Vec<u8> = values.iter().map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
    let mut encoded = Vec::new();
    PngEncoder::new_with_quality(&mut encoded, CompressionType::Best, FilterType::Adaptive)
        .write_image(&bytes, chart.size[0], chart.size[1], ExtendedColorType::L8)
        .map_err(|error| LabError::Embed(error.to_string()))?;
    Ok(url("png", &encoded))
}

fn url(kind: &str, bytes: &[u8]) -> String {
    format!("data:image/{kind};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
