//! The environment of a scene file: as TOML, as part of a scene, and back.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::EnvironmentEntry;
use super::form::{path_of, path_text};
use crate::{
    Environment, EnvironmentPictures, FolderTextures, MAX_EXPOSURE, Scene, SpecularFilter, TextureSource,
    load_environment,
};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentForm {
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diffuse: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    specular: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    filter: Option<SpecularFilter>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    intensity: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    faces: Option<FacesForm>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FacesForm {
    right: String,
    left: String,
    up: String,
    down: String,
    front: String,
    back: String,
}

pub(super) fn exposure(stops: f32) -> Result<f32, String> {
    if stops.abs() <= MAX_EXPOSURE {
        Ok(stops)
    } else {
        Err(format!("`exposure` must be from −{MAX_EXPOSURE} to {MAX_EXPOSURE} stops"))
    }
}

pub(super) fn entry(form: EnvironmentForm) -> Result<EnvironmentEntry, String> {
    let EnvironmentForm { picture, faces, diffuse, specular, filter, rotation, intensity } = form;
    let pictures = match (picture, faces) {
        (Some(picture), None) => EnvironmentPictures::One(path_of("picture", &picture)?),
        (None, Some(FacesForm { right, left, up, down, front, back })) => EnvironmentPictures::Faces(Box::new([
            path_of("faces.right", &right)?,
            path_of("faces.left", &left)?,
            path_of("faces.up", &up)?,
            path_of("faces.down", &down)?,
            path_of("faces.front", &front)?,
            path_of("faces.back", &back)?,
        ])),
        _ => return Err("either `picture` or `faces` is needed".to_owned()),
    };
    let (rotation, intensity) = (rotation.unwrap_or(0.0), intensity.unwrap_or(1.0));
    if !rotation.is_finite() {
        return Err("`rotation` must be a finite number".to_owned());
    }
    if !(intensity >= 0.0 && intensity.is_finite()) {
        return Err("`intensity` must be a finite number not below 0".to_owned());
    }
    let (diffuse, specular) = (diffuse.unwrap_or(true), specular.unwrap_or(true));
    Ok(EnvironmentEntry { pictures, diffuse, specular, filter, rotation, intensity })
}

pub(super) fn form(entry: &EnvironmentEntry) -> Result<EnvironmentForm, String> {
    let (picture, faces) = match &entry.pictures {
        EnvironmentPictures::One(path) => (Some(path_text(path)?), None),
        EnvironmentPictures::Faces(paths) => {
            let [right, left, up, down, front, back] = &**paths;
            let faces = FacesForm {
                right: path_text(right)?,
                left: path_text(left)?,
                up: path_text(up)?,
                down: path_text(down)?,
                front: path_text(front)?,
                back: path_text(back)?,
            };
            (None, Some(faces))
        }
    };
    Ok(EnvironmentForm {
        picture,
        faces,
        diffuse: Some(entry.diffuse),
        specular: Some(entry.specular),
        filter: entry.filter,
        rotation: (entry.rotation != 0.0).then_some(entry.rotation),
        intensity: (entry.intensity != 1.0).then_some(entry.intensity),
    })
}

impl EnvironmentEntry {
    /// All of a picture's light, as it comes.
    pub fn new(pictures: EnvironmentPictures<PathBuf>) -> Self {
        Self { pictures, diffuse: true, specular: true, filter: None, rotation: 0.0, intensity: 1.0 }
    }

    /// The environment, its pictures read from the folder of the scene file.
    pub(super) fn load(&self, scene_file: &Path) -> Result<Environment, String> {
        let source = FolderTextures::beside(scene_file);
        let found = self.pictures.try_map(|path| {
            let name = path.to_str().ok_or("the name of a picture is not Unicode")?;
            source.find(name).map_err(|reason| format!("\"{}\": {reason}", path.display()))
        })?;
        Ok(Environment {
            map: Arc::new(load_environment(&found, &source.limits())?),
            diffuse: self.diffuse,
            specular: self.specular,
            filter: self.filter,
            rotation: self.rotation.to_radians(),
            intensity: self.intensity,
        })
    }

    /// Takes over what was changed in an environment; what is the same in both stays as the file has it.
    pub(super) fn record(&mut self, before: &Scene, after: &Scene) {
        let (Some(before), Some(after)) = (&before.environment, &after.environment) else { return };
        (self.diffuse, self.specular) = (after.diffuse, after.specular);
        self.filter = after.filter;
        if after.rotation != before.rotation {
            self.rotation = after.rotation.to_degrees();
        }
        self.intensity = after.intensity;
    }
}
