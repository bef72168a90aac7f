//! One light of a scene and its shadow, to measure on.

use aam_scene::{Light, Scene, ShadowSettings, ShadowSource, Shadows, View};
use glam::Vec3;

/// A scene in which one light has a shadow, and how it is looked at.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Name for reports.
    pub name: String,
    /// The scene. Its only shadow source is that of the light. Other lights give their ambient colour alone, so that
    /// both truth and technique show this light's shadow and nothing else.
    pub scene: Scene,
    /// How it is looked at.
    pub view: View,
    /// The position of the light in [`Scene::lights`].
    pub light: usize,
}

/// Why there is nothing to measure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SubjectError {
    /// The scene has no light.
    #[error("the scene has no light, so nothing casts a shadow; give it a [[light]] in a scene file")]
    NoLight,
    /// No light has this name.
    #[error("there is no light {wanted:?}; there are {}", there_are(.known))]
    Unknown {
        /// The name that was asked for.
        wanted: String,
        /// The names that there are.
        known: Vec<String>,
    },
    /// The light shines on nothing.
    #[error("the light {0:?} is black: it has neither diffuse nor specular colour, and so no shadow")]
    Black(String),
}

fn there_are(names: &[String]) -> String {
    names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ")
}

impl Subject {
    /// A scene's light by its name, or by its number from 1; without a name the first with a shape, else the first that
    /// shines. Who casts and receives, and the volume of the light's own source, stay as the scene has them.
    ///
    /// # Errors
    /// There is no such light, or it gives no light.
    pub fn new(name: String, scene: &Scene, view: View, light: Option<&str>) -> Result<Self, SubjectError> {
        let index = find(&scene.lights, light)?;
        let mut scene = scene.clone();
        for (_, other) in scene.lights.iter_mut().enumerate().filter(|(other, _)| *other != index) {
            (other.diffuse, other.specular) = (Vec3::ZERO, Vec3::ZERO);
        }
        let shadows = scene.shadows.take().unwrap_or_default();
        let own = shadows.sources.iter().find(|source| source.light == Some(index));
        let volume = own.and_then(|source| source.volume.clone());
        let source = ShadowSource { volume, ..ShadowSource::of_light(index, ShadowSettings::default()) };
        scene.shadows = Some(Shadows { sources: vec![source], ..shadows });
        Ok(Self { name, scene, view, light: index })
    }

    /// The light.
    pub fn light(&self) -> Option<&Light> {
        self.scene.lights.get(self.light)
    }

    /// The light's name, or its number from 1.
    pub fn light_name(&self) -> String {
        light_name(&self.scene.lights, self.light)
    }

    /// The scene without any shadow.
    pub fn unshadowed(&self) -> Scene {
        Scene { shadows: None, ..self.scene.clone() }
    }
}

/// A light's name, or its number from 1.
pub(super) fn light_name(lights: &[Light], index: usize) -> String {
    let name = lights.get(index).map_or("", |light| &light.name);
    if name.is_empty() { (index + 1).to_string() } else { name.to_owned() }
}

fn find(lights: &[Light], wanted: Option<&str>) -> Result<usize, SubjectError> {
    if lights.is_empty() {
        return Err(SubjectError::NoLight);
    }
    let shines = |light: &Light| light.diffuse.max(light.specular).max_element() > 0.0;
    let Some(wanted) = wanted else {
        let shaped = lights.iter().position(|light| shines(light) && light.shape.is_some());
        let first = shaped.or_else(|| lights.iter().position(shines));
        return first.ok_or_else(|| SubjectError::Black(light_name(lights, 0)));
    };
    let named = lights.iter().position(|light| light.name == wanted);
    let number = || wanted.parse::<usize>().ok()?.checked_sub(1).filter(|index| *index < lights.len());
    let index = named.or_else(number).ok_or_else(|| SubjectError::Unknown {
        wanted: wanted.to_owned(),
        known: (0..lights.len()).map(|index| light_name(lights, index)).collect(),
    })?;
    if shines(&lights[index]) { Ok(index) } else { Err(SubjectError::Black(light_name(lights, index))) }
}
