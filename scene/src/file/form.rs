//! The scene file as TOML: every key known, every value checked, errors with their place.

use std::path::{Path, PathBuf};

use aam::Position;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::environment::{self, EnvironmentForm};
use super::shadow_form::{self, ShadowForm, ShadowsForm};
use super::{AssetEntry, BackgroundEntry, NodeEntry, SceneFile, SceneSyntaxError};
use crate::{Camera, Falloff, Light, LightKind, LightShape, Projection, Shading, ToneMap, Up};

const HEADER: &str = "# A scene of the aam toolkit. Lengths are metres, angles degrees, colours sRGB from 0 to 1.\n\n";

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneForm {
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<Up>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shading: Option<Shading>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exposure: Option<Spanned<f32>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tone_map: Option<ToneMap>,
    #[serde(skip_serializing_if = "Option::is_none")]
    active_camera: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    background: Option<Spanned<BackgroundForm>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    environment: Option<Spanned<EnvironmentForm>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    asset: Vec<Spanned<AssetForm>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    light: Option<Vec<Spanned<LightForm>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shadows: Option<Spanned<ShadowsForm>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    shadow: Vec<Spanned<ShadowForm>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    camera: Vec<Spanned<CameraForm>>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BackgroundForm {
    #[serde(skip_serializing_if = "Option::is_none")]
    transparent: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    color: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    environment: Option<bool>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct AssetForm {
    path: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    visible: Option<bool>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    node: Vec<Spanned<NodeForm>>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NodeForm {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    occurrence: Option<usize>,
    visible: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindForm {
    Point,
    Directional,
    Spot,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LightForm {
    #[serde(default, skip_serializing_if = "String::is_empty")]
    name: String,
    kind: KindForm,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    inner: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    outer: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    falloff: Option<Falloff>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ambient: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diffuse: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    specular: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<ShapeForm>,
}

#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeKindForm {
    Disc,
    Rectangle,
    Sphere,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShapeForm {
    form: ShapeKindForm,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    width: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<f32>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraForm {
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(super) name: String,
    position: [f32; 3],
    target: [f32; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fov_y: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) near: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) far: Option<f32>,
}

// ---- reading ----------------------------------------------------------------------------------------------------

pub(super) fn parse(text: &str) -> Result<SceneFile, SceneSyntaxError> {
    let at =
        |offset: usize, message: String| SceneSyntaxError { position: Position::of(text.as_bytes(), offset), message };
    let form: SceneForm = toml::from_str(text)
        .map_err(|error| at(error.span().map_or(0, |span| span.start), error.message().to_owned()))?;
    let up = form.up.unwrap_or_default();
    Ok(SceneFile {
        up: form.up,
        shading: form.shading,
        exposure: form.exposure.map(|stops| check(stops, &at, "exposure", environment::exposure)).transpose()?,
        tone_map: form.tone_map,
        active_camera: form.active_camera,
        background: form.background.map(|form| check(form, &at, "background", background)).transpose()?,
        environment: form.environment.map(|form| check(form, &at, "environment", environment::entry)).transpose()?,
        assets: checked(form.asset, &at, "asset", |asset| asset_entry(asset, &at))?,
        lights: form.light.map(|lights| checked(lights, &at, "light", |light| Ok(self::light(light)?))).transpose()?,
        shadows: shadow_form::read(form.shadows, form.shadow, up, &at)?,
        cameras: checked(form.camera, &at, "camera", |form| Ok(camera(form, up)?))?,
    })
}

/// What is wrong with an entry: a sentence about one of its keys, or an error that has its place already.
pub(super) enum Fault {
    Key(String),
    Placed(SceneSyntaxError),
}

impl From<String> for Fault {
    fn from(message: String) -> Self {
        Self::Key(message)
    }
}

pub(super) type At<'a> = dyn Fn(usize, String) -> SceneSyntaxError + 'a;

pub(super) fn check<F, V, E: Into<Fault>>(
    form: Spanned<F>,
    at: &At<'_>,
    what: &str,
    value: impl FnOnce(F) -> Result<V, E>,
) -> Result<V, SceneSyntaxError> {
    let start = form.span().start;
    value(form.into_inner()).map_err(|fault| match fault.into() {
        Fault::Key(message) => at(start, format!("in [{what}]: {message}")),
        Fault::Placed(error) => error,
    })
}

pub(super) fn checked<F, V>(
    forms: Vec<Spanned<F>>,
    at: &At<'_>,
    what: &str,
    value: impl Fn(F) -> Result<V, Fault>,
) -> Result<Vec<V>, SceneSyntaxError> {
    forms.into_iter().map(|form| check(form, at, &format!("[{what}]"), &value)).collect()
}

fn background(form: BackgroundForm) -> Result<BackgroundEntry, String> {
    let BackgroundForm { transparent, color, picture, environment } = form;
    match (transparent.unwrap_or(false), color, picture, environment.unwrap_or(false)) {
        (true, None, None, false) => Ok(BackgroundEntry::Transparent),
        (false, Some(color), None, false) => Ok(BackgroundEntry::Color(color_of("color", color)?)),
        (false, None, Some(picture), false) => Ok(BackgroundEntry::Picture(path_of("picture", &picture)?)),
        (false, None, None, true) => Ok(BackgroundEntry::Environment),
        _ => {
            Err("exactly one of `color`, `picture`, `transparent = true` and `environment = true` is needed".to_owned())
        }
    }
}

fn asset_entry(form: AssetForm, at: &At<'_>) -> Result<AssetEntry, Fault> {
    let AssetForm { path, name, position, rotation, scale, visible, node } = form;
    let node_entry = |NodeForm { name, occurrence, visible }: NodeForm| match occurrence {
        Some(0) => Err(Fault::Key("`occurrence` counts from 1".to_owned())),
        _ => Ok(NodeEntry { name, occurrence: occurrence.unwrap_or(1), visible }),
    };
    Ok(AssetEntry {
        path: path_of("path", &path)?,
        name,
        position: vector("position", position, Vec3::ZERO)?,
        rotation: vector("rotation", rotation, Vec3::ZERO)?,
        scale: vector("scale", scale, Vec3::ONE)?,
        visible: visible.unwrap_or(true),
        nodes: checked(node, at, "asset.node", node_entry).map_err(Fault::Placed)?,
    })
}

fn light(form: LightForm) -> Result<Light, String> {
    let LightForm { name, kind, position, direction, inner, outer, falloff, ambient, diffuse, specular, shape } = form;
    let word = match kind {
        KindForm::Point => "point",
        KindForm::Directional => "directional",
        KindForm::Spot => "spot",
    };
    let unused = |key: &str, given: bool| {
        if given { Err(format!("a {word} light has no `{key}`")) } else { Ok(()) }
    };
    let needed = |key: &str| format!("a {word} light needs a `{key}`");
    let place = || finite("position", position.ok_or_else(|| needed("position"))?);
    let heading = || {
        let direction = finite("direction", direction.ok_or_else(|| needed("direction"))?)?;
        if direction == Vec3::ZERO { Err("`direction` must not be zero".to_owned()) } else { Ok(direction) }
    };
    let falloff_or_none = falloff.unwrap_or_default();
    let kind = match kind {
        KindForm::Point => {
            unused("direction", direction.is_some())?;
            unused("inner", inner.is_some())?;
            unused("outer", outer.is_some())?;
            LightKind::Point { position: place()?, falloff: falloff_or_none }
        }
        KindForm::Directional => {
            unused("position", position.is_some())?;
            unused("inner", inner.is_some())?;
            unused("outer", outer.is_some())?;
            unused("falloff", falloff.is_some())?;
            LightKind::Directional { direction: heading()? }
        }
        KindForm::Spot => {
            let outer = outer.ok_or_else(|| needed("outer"))?;
            let inner = inner.unwrap_or(outer);
            if !(outer > 0.0 && outer <= 180.0) {
                return Err("`outer` must be above 0 and at most 180 degrees".to_owned());
            }
            if !(inner >= 0.0 && inner <= outer) {
                return Err("`inner` must be at least 0 and at most `outer`".to_owned());
            }
            LightKind::Spot {
                position: place()?,
                direction: heading()?,
                inner: inner.to_radians() as f32,
                outer: outer.to_radians() as f32,
                falloff: falloff_or_none,
            }
        }
    };
    Ok(Light {
        name,
        kind,
        ambient: color_of("ambient", ambient.unwrap_or([0.0; 3]))?,
        diffuse: color_of("diffuse", diffuse.unwrap_or([1.0; 3]))?,
        specular: color_of("specular", specular.unwrap_or([1.0; 3]))?,
        shape: shape.map(light_shape).transpose()?,
    })
}

fn light_shape(form: ShapeForm) -> Result<LightShape, String> {
    let length = |key: &str, value: Option<f32>| match value {
        Some(value) if value.is_finite() && value > 0.0 => Ok(value),
        Some(_) => Err(format!("`shape.{key}` must be above 0")),
        None => Err(format!("`shape.{key}` is needed")),
    };
    match form {
        ShapeForm { form: ShapeKindForm::Disc, radius, width: None, height: None } => {
            Ok(LightShape::Disc { radius: length("radius", radius)? })
        }
        ShapeForm { form: ShapeKindForm::Sphere, radius, width: None, height: None } => {
            Ok(LightShape::Sphere { radius: length("radius", radius)? })
        }
        ShapeForm { form: ShapeKindForm::Rectangle, radius: None, width, height } => {
            Ok(LightShape::Rectangle { width: length("width", width)?, height: length("height", height)? })
        }
        ShapeForm { form: ShapeKindForm::Rectangle, .. } => {
            Err("a rectangle has `width` and `height`, no `radius`".to_owned())
        }
        ShapeForm { .. } => Err("a disc or sphere has a `radius`, no `width` and `height`".to_owned()),
    }
}

pub(super) fn camera(form: CameraForm, scene_up: Up) -> Result<Camera, String> {
    let CameraForm { name, position, target, up, fov_y, height, near, far } = form;
    let (position, target) = (finite("position", position)?, finite("target", target)?);
    let distance = position.distance(target);
    if distance == 0.0 || !distance.is_finite() {
        return Err("`position` and `target` must be different points".to_owned());
    }
    let up = up.map_or(Ok(scene_up.axis()), |up| finite("up", up))?;
    if up == Vec3::ZERO {
        return Err("`up` must not be zero".to_owned());
    }
    let projection = match (fov_y, height) {
        (Some(fov_y), None) if fov_y > 0.0 && fov_y < 180.0 => {
            Projection::Perspective { fov_y: fov_y.to_radians() as f32 }
        }
        (Some(_), None) => return Err("`fov_y` must be between 0 and 180 degrees".to_owned()),
        (None, Some(height)) if height > 0.0 && height.is_finite() => Projection::Orthographic { height },
        (None, Some(_)) => return Err("`height` must be above 0".to_owned()),
        _ => return Err("either `fov_y` or `height` is needed".to_owned()),
    };
    let near = near.unwrap_or(0.01 * distance);
    let far = far.unwrap_or((100.0 * distance).max(2.0 * near));
    if !(near > 0.0 && far > near && far.is_finite()) {
        return Err("`near` must be above 0 and `far` above `near`".to_owned());
    }
    Ok(Camera { name, position, target, up, projection, near, far })
}

fn finite(key: &str, values: [f32; 3]) -> Result<Vec3, String> {
    let vector = Vec3::from(values);
    if vector.is_finite() { Ok(vector) } else { Err(format!("`{key}` must be finite numbers")) }
}

fn vector(key: &str, values: Option<[f32; 3]>, otherwise: Vec3) -> Result<Vec3, String> {
    values.map_or(Ok(otherwise), |values| finite(key, values))
}

fn color_of(key: &str, values: [f32; 3]) -> Result<Vec3, String> {
    let color = finite(key, values)?;
    if color.min_element() < 0.0 { Err(format!("`{key}` must not be negative")) } else { Ok(color) }
}

pub(super) fn path_of(key: &str, text: &str) -> Result<PathBuf, String> {
    let text = text.trim();
    if text.is_empty() || text.contains('\0') { Err(format!("`{key}` names no file")) } else { Ok(text.into()) }
}

// ---- writing ----------------------------------------------------------------------------------------------------

pub(super) fn to_text(file: &SceneFile) -> Result<String, String> {
    let (shadows, shadow) = file.shadows.as_ref().map_or((None, Vec::new()), shadow_form::write);
    let form = SceneForm {
        up: file.up,
        shading: file.shading,
        exposure: file.exposure.map(unplaced),
        tone_map: file.tone_map,
        active_camera: file.active_camera.clone(),
        background: file.background.as_ref().map(background_form).transpose()?.map(unplaced),
        environment: file.environment.as_ref().map(environment::form).transpose()?.map(unplaced),
        asset: file.assets.iter().map(|asset| Ok(unplaced(asset_form(asset)?))).collect::<Result<_, String>>()?,
        light: file.lights.as_ref().map(|lights| lights.iter().map(light_form).map(unplaced).collect()),
        shadows: shadows.map(unplaced),
        shadow: shadow.into_iter().map(unplaced).collect(),
        camera: file.cameras.iter().map(camera_form).map(unplaced).collect(),
    };
    let text = HEADER.to_owned() + &toml::to_string(&form).map_err(|error| error.to_string())?;
    // What cannot be read back (numbers that are not finite, for instance) is not written.
    parse(&text).map_err(|error| error.message)?;
    Ok(text)
}

pub(super) fn unplaced<F>(form: F) -> Spanned<F> {
    Spanned::new(0..0, form)
}

fn background_form(entry: &BackgroundEntry) -> Result<BackgroundForm, String> {
    Ok(match entry {
        BackgroundEntry::Transparent => BackgroundForm { transparent: Some(true), ..BackgroundForm::default() },
        BackgroundEntry::Color(color) => BackgroundForm { color: Some(color.to_array()), ..BackgroundForm::default() },
        BackgroundEntry::Picture(path) => {
            BackgroundForm { picture: Some(path_text(path)?), ..BackgroundForm::default() }
        }
        BackgroundEntry::Environment => BackgroundForm { environment: Some(true), ..BackgroundForm::default() },
    })
}

pub(super) fn path_text(path: &Path) -> Result<String, String> {
    let text = path.to_str().ok_or_else(|| format!("the path {} is not Unicode", path.display()))?;
    Ok(if cfg!(windows) { text.replace('\\', "/") } else { text.to_owned() })
}

fn asset_form(asset: &AssetEntry) -> Result<AssetForm, String> {
    let unless = |value: Vec3, usual: Vec3| (value != usual).then(|| value.to_array());
    let node = |node: &NodeEntry| {
        let occurrence = (node.occurrence != 1).then_some(node.occurrence);
        unplaced(NodeForm { name: node.name.clone(), occurrence, visible: node.visible })
    };
    Ok(AssetForm {
        path: path_text(&asset.path)?,
        name: asset.name.clone(),
        position: unless(asset.position, Vec3::ZERO),
        rotation: unless(asset.rotation, Vec3::ZERO),
        scale: unless(asset.scale, Vec3::ONE),
        visible: (!asset.visible).then_some(false),
        node: asset.nodes.iter().map(node).collect(),
    })
}

fn light_form(light: &Light) -> LightForm {
    let mut form = LightForm {
        name: light.name.clone(),
        kind: KindForm::Point,
        position: None,
        direction: None,
        inner: None,
        outer: None,
        falloff: None,
        ambient: Some(light.ambient.to_array()),
        diffuse: Some(light.diffuse.to_array()),
        specular: Some(light.specular.to_array()),
        shape: light.shape.map(|shape| match shape {
            LightShape::Disc { radius } => shape_form(ShapeKindForm::Disc, Some(radius), None),
            LightShape::Rectangle { width, height } => {
                shape_form(ShapeKindForm::Rectangle, None, Some([width, height]))
            }
            LightShape::Sphere { radius } => shape_form(ShapeKindForm::Sphere, Some(radius), None),
        }),
    };
    match light.kind {
        LightKind::Point { position, falloff } => {
            form.position = Some(position.to_array());
            form.falloff = Some(falloff);
        }
        LightKind::Directional { direction } => {
            form.kind = KindForm::Directional;
            form.direction = Some(direction.to_array());
        }
        LightKind::Spot { position, direction, inner, outer, falloff } => {
            form.kind = KindForm::Spot;
            form.position = Some(position.to_array());
            form.direction = Some(direction.to_array());
            form.inner = Some(degrees(inner));
            form.outer = Some(degrees(outer));
            form.falloff = Some(falloff);
        }
    }
    form
}

fn shape_form(form: ShapeKindForm, radius: Option<f32>, size: Option<[f32; 2]>) -> ShapeForm {
    ShapeForm { form, radius, width: size.map(|size| size[0]), height: size.map(|size| size[1]) }
}

pub(super) fn camera_form(camera: &Camera) -> CameraForm {
    let (fov_y, height) = match camera.projection {
        Projection::Perspective { fov_y } => (Some(degrees(fov_y)), None),
        Projection::Orthographic { height } => (None, Some(height)),
    };
    CameraForm {
        name: camera.name.clone(),
        position: camera.position.to_array(),
        target: camera.target.to_array(),
        up: Some(camera.up.to_array()),
        fov_y,
        height,
        near: Some(camera.near),
        far: Some(camera.far),
    }
}

/// An angle in degrees, with as few digits as give the same radians back.
fn degrees(radians: f32) -> f64 {
    let exact = f64::from(radians).to_degrees();
    (0..12)
        .filter_map(|digits| format!("{exact:.digits$}").parse::<f64>().ok())
        .find(|degrees| degrees.to_radians() as f32 == radians)
        .unwrap_or(exact)
}
