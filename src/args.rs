//! Parsers of option values. Each error says what would have been accepted.

use std::ffi::OsStr;
use std::path::PathBuf;

use aam::check::{self, CODES, CodePattern};
use aam::nearest;
use aam_scene::{ShadowFilter, ShadowSettings};
use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Command};
use glam::Vec3;

use crate::shadows;

/// The largest side of a picture in pixels.
pub(crate) const MAX_SIDE: u32 = 16_384;

/// A picture's width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// `1280x720`.
pub(crate) fn size(text: &str) -> Result<Size, String> {
    let wanted = || format!("expected WIDTHxHEIGHT in pixels, each from 1 to {MAX_SIDE}, such as 1280x720");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(wanted)?;
    let side = |text: &str| match text.trim().parse::<u32>() {
        Ok(value) if (1..=MAX_SIDE).contains(&value) => Ok(value),
        _ => Err(wanted()),
    };
    Ok(Size { width: side(width)?, height: side(height)? })
}

/// `pcf`, `csm-evsm4`: a shadow technique.
pub(crate) fn shadow_technique(text: &str) -> Result<aam_scene::ShadowTechnique, String> {
    text.trim().parse()
}

/// `1,-2,0.5`: three finite numbers.
pub(crate) fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map(|word| word.trim().parse::<f32>().ok().filter(|value| value.is_finite()))
        .collect::<Option<_>>()
        .unwrap_or_default();
    match numbers[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err("expected three numbers X,Y,Z such as 1,-2,0.5".into()),
    }
}

/// What is behind the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Background {
    Transparent,
    Color(Vec3),
}

/// `transparent`, a name, `#rgb`, `#rrggbb`, or three numbers from 0 to 1; sRGB-encoded.
pub(crate) fn background(text: &str) -> Result<Background, String> {
    let names = [
        ("black", 0x0),
        ("white", 0xff_ffff),
        ("grey", 0x80_8080),
        ("gray", 0x80_8080),
        ("red", 0xff_0000),
        ("green", 0x00_8000),
        ("blue", 0x00_00ff),
    ];
    let hex = |value: u32| {
        let channel = |shift: u32| ((value >> shift) & 0xff) as f32 / 255.0;
        Background::Color(Vec3::new(channel(16), channel(8), channel(0)))
    };
    let lower = text.to_ascii_lowercase();
    if lower == "transparent" || lower == "none" {
        return Ok(Background::Transparent);
    }
    if let Some((_, value)) = names.iter().find(|(name, _)| *name == lower) {
        return Ok(hex(*value));
    }
    if let Some(digits) = lower.strip_prefix('#')
        && digits.bytes().all(|byte| byte.is_ascii_hexdigit())
        && let Ok(value) = u32::from_str_radix(digits, 16)
    {
        match digits.len() {
            6 => return Ok(hex(value)),
            3 => {
                let double = |shift: u32| ((value >> shift) & 0xf) * 0x11;
                return Ok(hex((double(8) << 16) | (double(4) << 8) | double(0)));
            }
            _ => {}
        }
    }
    match vector(text) {
        Ok(color) if color.min_element() >= 0.0 && color.max_element() <= 1.0 => Ok(Background::Color(color)),
        _ => {
            let near = nearest(lower.as_bytes(), names.iter().map(|(name, _)| *name).chain(["transparent", "none"]));
            let hint = near.map(|name| format!("; did you mean {name}?")).unwrap_or_default();
            Err(format!(
                "expected transparent, black, white, grey, red, green, blue, #rrggbb, or R,G,B with numbers from 0 to 1{hint}"
            ))
        }
    }
}

/// `500000`, `64k`, `512M`, `4G`, with binary multiples, as in `dd` and `head`; not 0.
pub(crate) fn amount(text: &str) -> Result<u64, String> {
    let wanted = || "expected a whole number from 1 such as 500000, 64K, 512M or 4G (K is 1024)".to_owned();
    let trimmed = text.trim().trim_end_matches(['b', 'B']);
    let digits = trimmed.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let shift = match trimmed[digits.len()..].to_ascii_lowercase().as_str() {
        "" => 0,
        "k" | "ki" => 10,
        "m" | "mi" => 20,
        "g" | "gi" => 30,
        "t" | "ti" => 40,
        _ => return Err(wanted()),
    };
    let value: u64 = digits.trim().parse().map_err(|_| wanted())?;
    value.checked_mul(1 << shift).filter(|amount| *amount > 0).ok_or_else(wanted)
}

/// A code of `aam check`, or a group of codes. Its possible values are for completions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CodeParser;

impl TypedValueParser for CodeParser {
    type Value = CodePattern;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<CodePattern, clap::Error> {
        let pattern = StringValueParser::new().try_map(|text| text.parse::<CodePattern>());
        pattern.parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let codes = CODES.iter().map(|info| info.code);
        Some(Box::new(check::groups().into_iter().chain(codes).map(PossibleValue::new)))
    }
}

/// What of the scene is drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ShowArg {
    Lit,
    Normals,
    /// What a source lets through, by its name; without one the first.
    Shadow(Option<String>),
    /// The map of a source.
    Depth(Option<String>),
}

/// `lit`, `normals`, `shadow:lamp`, `depth`.
pub(crate) fn show(text: &str) -> Result<ShowArg, String> {
    let (what, name) = match text.split_once(':') {
        Some((what, name)) => (what, Some(name.to_owned()).filter(|name| !name.is_empty())),
        None => (text, None),
    };
    match (what, name) {
        ("lit", None) => Ok(ShowArg::Lit),
        ("normals", None) => Ok(ShowArg::Normals),
        ("shadow", name) => Ok(ShowArg::Shadow(name)),
        ("depth", name) => Ok(ShowArg::Depth(name)),
        _ => {
            let near = nearest(what.as_bytes(), ["lit", "normals", "shadow", "depth"]);
            let hint = near.map(|name| format!("; did you mean {name}?")).unwrap_or_default();
            Err(format!("expected lit, normals, shadow, shadow:NAME, depth or depth:NAME{hint}"))
        }
    }
}

/// Which shadows are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ShadowChoice {
    /// Those of the file, or of every light.
    Usual,
    /// None.
    None,
    /// Of lights as points, traced.
    Point,
    /// Of lights as large as they are, traced.
    Area,
    /// Of every light, in this way.
    Technique(ShadowSettings),
}

impl ShadowChoice {
    /// Words beside the techniques.
    const WORDS: [(&'static str, Self); 4] =
        [("usual", Self::Usual), ("none", Self::None), ("point", Self::Point), ("area", Self::Area)];
}

/// `pcf`, `evsm4:resolution=512,radius=5`, `area`; `help` prints what there is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadowParser;

impl TypedValueParser for ShadowParser {
    type Value = ShadowChoice;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<ShadowChoice, clap::Error> {
        if value == "help" {
            return Err(clap::Error::raw(ErrorKind::DisplayHelp, shadows::help()).with_cmd(command));
        }
        let parser = StringValueParser::new().try_map(|text| {
            if let Some((_, choice)) = ShadowChoice::WORDS.iter().find(|(word, _)| *word == text) {
                return Ok(*choice);
            }
            text.parse().map(ShadowChoice::Technique).map_err(|reason: String| {
                format!("{reason}; beside techniques of the GPU there are none, usual, and point and area, which the reference engine traces. `aam render --shadows=help` explains them")
            })
        });
        parser.parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let words = ShadowChoice::WORDS.into_iter().map(|(word, _)| word);
        Some(Box::new(ShadowFilter::WORDS.iter().copied().chain(words).chain(["help"]).map(PossibleValue::new)))
    }
}

/// A number from `low` to `high`.
fn between(text: &str, low: f32, high: f32, what: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(value) if value >= low && value <= high => Ok(value),
        _ => Err(format!("expected {what}")),
    }
}

/// A finite number.
pub(crate) fn number(text: &str) -> Result<f32, String> {
    between(text, f32::MIN, f32::MAX, "a number")
}

/// Exposure in stops.
pub(crate) fn exposure(text: &str) -> Result<f32, String> {
    let most = aam_scene::MAX_EXPOSURE;
    between(text, -most, most, &format!("stops, from -{most} to {most}"))
}

/// A finite number not below 0.
pub(crate) fn not_negative(text: &str) -> Result<f32, String> {
    between(text, 0.0, f32::MAX, "a number not below 0")
}

/// A finite number above 0.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    between(text, f32::MIN_POSITIVE, f32::MAX, "a number above 0")
}

/// Pixels that adaptive tessellation may be off by.
pub(crate) fn pixel_error(text: &str) -> Result<f32, String> {
    between(text, aam_scene::displacement::MIN_PIXEL_ERROR, 1e4, "pixels, from 0.01 to 10000")
}

/// A number from 0 to 1.
pub(crate) fn fraction(text: &str) -> Result<f32, String> {
    between(text, 0.0, 1.0, "a number from 0 to 1")
}

/// An error in % of a diagonal, such as `2`, `0.5` or `2%`, as a part of it.
pub(crate) fn percent(text: &str) -> Result<f32, String> {
    let number = text.trim().trim_end_matches('%').trim_end();
    match number.parse::<f32>() {
        Ok(value) if value > 0.0 && value <= 100.0 => Ok(value / 100.0),
        _ => Err("expected a number above 0 and up to 100, in % of the diagonal, such as 2 or 0.5".into()),
    }
}

/// Frames a second.
pub(crate) fn frames_per_second(text: &str) -> Result<f32, String> {
    between(text, 0.01, 1000.0, "frames a second, from 0.01 to 1000")
}

/// Seconds of a step: a number, or a fraction such as `1/240`.
pub(crate) fn time_step(text: &str) -> Result<f32, String> {
    let wanted = || "expected seconds from 0.000001 to 1, such as 1/240 or 0.004".to_owned();
    let number = |text: &str| text.trim().parse::<f32>().map_err(|_| wanted());
    let value = match text.split_once('/') {
        Some((above, below)) => number(above)? / number(below)?,
        None => number(text)?,
    };
    if (1e-6..=1.0).contains(&value) { Ok(value) } else { Err(wanted()) }
}

/// An angle in degrees for normals.
pub(crate) fn tolerance(text: &str) -> Result<f32, String> {
    between(text, 0.0, 180.0, "degrees, from 0 to 180")
}

/// A field of view in degrees.
pub(crate) fn field_of_view(text: &str) -> Result<f32, String> {
    between(text, 0.1, 175.0, "degrees, from 0.1 to 175")
}

/// A texture file, for one material or for all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TextureFor {
    pub(crate) material: Option<String>,
    pub(crate) file: PathBuf,
}

/// `[MATERIAL=]FILE`. A name with `=` that is a file is a file.
pub(crate) fn texture_for(text: &str) -> Result<TextureFor, String> {
    let whole = || TextureFor { material: None, file: text.into() };
    match text.split_once('=') {
        Some((material, file)) if !std::path::Path::new(text).is_file() => {
            if material.is_empty() || file.is_empty() {
                return Err("expected FILE or MATERIAL=FILE".into());
            }
            Ok(TextureFor { material: Some(material.into()), file: file.into() })
        }
        _ if text.is_empty() => Err("expected FILE or MATERIAL=FILE".into()),
        _ => Ok(whole()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_bounded() {
        assert_eq!(size("1280x720"), Ok(Size { width: 1280, height: 720 }));
        for wrong in ["", "1280", "0x5", "5x0", "-1x5", "99999x99999", "1e3x5", "5x", "4294967297x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn vectors_are_three_finite_numbers() {
        assert_eq!(vector("1,-2, .5"), Ok(Vec3::new(1.0, -2.0, 0.5)));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,nan", "1,2,inf", "1,2,x"] {
            assert!(vector(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn colours_have_names_hex_and_numbers() {
        let color = |r, g, b| Ok(Background::Color(Vec3::new(r, g, b)));
        assert_eq!(background("Transparent"), Ok(Background::Transparent));
        assert_eq!(background("white"), color(1.0, 1.0, 1.0));
        assert_eq!(background("#ff0000"), color(1.0, 0.0, 0.0));
        assert_eq!(background("#0f0"), color(0.0, 1.0, 0.0));
        assert_eq!(background("0,0.5,1"), color(0.0, 0.5, 1.0));
        for wrong in ["", "#12", "#12345g", "#+12345", "2,0,0", "-1,0,0", "mauve-ish"] {
            assert!(background(wrong).is_err(), "{wrong}");
        }
        assert!(background("wihte").is_err_and(|error| error.ends_with("did you mean white?")));
    }

    #[test]
    fn amounts_take_units() {
        assert_eq!(amount("500000"), Ok(500_000));
        assert_eq!(amount("64K"), Ok(65_536));
        assert_eq!(amount("4GiB"), Ok(4 << 30));
        for wrong in ["", "0", "0G", "K", "-1", "4X", "99999999999999999999", "999999999T"] {
            assert!(amount(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_stay_in_their_range() {
        assert_eq!(number("-1.5"), Ok(-1.5));
        assert!(number("nan").is_err() && number("inf").is_err() && number("1e99").is_err());
        assert!(positive("0").is_err() && not_negative("0").is_ok() && not_negative("-0.1").is_err());
        assert!(exposure("-1.5").is_ok() && exposure("33").is_err() && exposure("nan").is_err());
        assert!(fraction("1.1").is_err() && field_of_view("180").is_err() && frames_per_second("0").is_err());
    }

    #[test]
    fn steps_are_seconds_or_fractions() {
        assert_eq!((time_step("1/240"), time_step("0.5")), (Ok(1.0 / 240.0), Ok(0.5)));
        for wrong in ["", "0", "1/0", "-1", "2", "1/2/3", "nan", "1e-9", "/"] {
            assert!(time_step(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_shown_may_name_a_source() {
        assert_eq!((show("lit"), show("depth")), (Ok(ShowArg::Lit), Ok(ShowArg::Depth(None))));
        assert_eq!(show("shadow:a:b"), Ok(ShowArg::Shadow(Some("a:b".into()))));
        assert!(show("lit:a").is_err() && show("dept").is_err_and(|error| error.ends_with("did you mean depth?")));
    }

    #[test]
    fn shadows_are_words_or_techniques() {
        let parse = |text: &str| ShadowParser.parse_ref(&Command::new("aam"), None, OsStr::new(text));
        assert_eq!(parse("none").ok(), Some(ShadowChoice::None));
        let settings = "evsm4:radius=5".parse().expect("settings");
        assert_eq!(parse("evsm4:radius=5").ok(), Some(ShadowChoice::Technique(settings)));
        assert!(parse("soft").is_err_and(|error| error.to_string().contains("there are hard, pcf")));
        assert!(parse("help").is_err_and(|error| error.exit_code() == 0 && error.to_string().contains("evsm4")));
    }

    #[test]
    fn textures_may_name_a_material() {
        let of = |material: &str, file: &str| Ok(TextureFor { material: Some(material.into()), file: file.into() });
        assert_eq!(texture_for("Wall=lm.png"), of("Wall", "lm.png"));
        assert_eq!(texture_for("lm.png"), Ok(TextureFor { material: None, file: "lm.png".into() }));
        assert!(texture_for("=lm.png").is_err() && texture_for("Wall=").is_err() && texture_for("").is_err());
    }
}
