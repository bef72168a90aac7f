//! From a scene file and the scenes of its assets to one scene, and back.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use aam::{Finding, Severity};
use glam::{Affine3A, Mat3, Quat, Vec3};

use super::{AssetEntry, BackgroundEntry, NodeEntry, SceneFile, ShadowsEntry};
use crate::materials::MaterialList;
use crate::mesh::Meshes;
use crate::{
    Animation, Background, Built, Camera, FolderTextures, Image, Light, LightKind, LightShape, Mesh, Node, NodeId,
    NodeMotion, Projection, Scene, Shading, Texture, TextureId, TextureSource, Up, load_texture,
};

impl SceneFile {
    /// One scene from those of the assets, one for each entry of [`SceneFile::assets`] in order. `scene_file` is where
    /// the scene file lies; a background picture is looked for in its folder.
    ///
    /// Each asset becomes a node without parent that holds its placement, followed by the asset's nodes. Textures,
    /// materials and meshes that several assets share are there once. The first asset that moves gives the frame rate.
    pub fn assemble(&self, assets: Vec<Scene>, scene_file: &Path) -> Built {
        let mut assembly = Assembly::default();
        let up = self.up.unwrap_or_default();
        let linear = assets.iter().any(|asset| asset.shading == Shading::Linear);
        for (entry, asset) in self.assets.iter().zip(assets) {
            assembly.add(entry, asset, up, self.lights.is_none());
        }
        let Assembly { mut scene, materials, meshes, mut warnings, .. } = assembly;
        scene.materials = materials.list;
        scene.meshes = meshes.list;
        scene.up = up;
        scene.shading = self.shading.unwrap_or(if linear { Shading::Linear } else { Shading::Source });
        if let Some(lights) = &self.lights {
            scene.lights.clone_from(lights);
        }
        let named = |name: &str| self.cameras.iter().any(|camera| !name.is_empty() && camera.name == name);
        scene.cameras.retain(|camera| !named(&camera.name));
        scene.cameras.splice(0..0, self.cameras.iter().cloned());
        scene.exposure = self.exposure.unwrap_or_default();
        scene.tone_map = self.tone_map.unwrap_or_default();
        match self.environment.as_ref().map(|entry| entry.load(scene_file)) {
            None => {}
            Some(Ok(environment)) => {
                let notes = environment.map.notes().iter();
                warnings.extend(notes.map(|note| warning("scene/environment", "environment".into(), note.clone())));
                scene.environment = Some(environment);
            }
            Some(Err(reason)) => warnings.push(warning(
                "scene/environment",
                "environment".into(),
                format!("{reason}; the scene is lit by its lights"),
            )),
        }
        match &self.background {
            None if scene.environment.is_some() => scene.background = Background::Environment,
            None => {}
            Some(BackgroundEntry::Environment) => scene.background = Background::Environment,
            Some(BackgroundEntry::Transparent) => scene.background = Background::Transparent,
            Some(BackgroundEntry::Color(color)) => scene.background = Background::Color(*color),
            Some(BackgroundEntry::Picture(path)) => match picture(scene_file, path) {
                Ok(image) => scene.background = Background::Picture(Arc::new(image)),
                Err(reason) => warnings.push(warning(
                    "scene/background",
                    format!("picture \"{}\"", path.display()),
                    format!("{reason}; the default colour is used"),
                )),
            },
        }
        if let Some(name) = &self.active_camera
            && self.active(&scene).is_none()
        {
            warnings.push(warning("scene/camera", format!("camera \"{name}\""), "there is none of this name".into()));
        }
        scene.shadows = self.shadows.as_ref().map(|shadows| shadows.resolve(&scene, &mut warnings));
        if let Some(animation) = &mut scene.animation {
            for motion in &mut animation.nodes {
                // A shorter animation stands still at its end.
                if let Some(&last) = motion.locals.last() {
                    motion.locals.resize(animation.frame_count, last);
                }
            }
        }
        Built { scene, warnings }
    }

    /// The camera that an assembled scene is to be looked at through first, if the file names one.
    pub fn active<'a>(&self, scene: &'a Scene) -> Option<&'a Camera> {
        let name = self.active_camera.as_ref()?;
        scene.cameras.iter().find(|camera| camera.name == *name)
    }

    /// Takes over what was changed in an assembled scene: hidden nodes, lights, environment, shadows, shading, exposure,
    /// tone mapping, background colour. `before` is the scene as it was assembled; what is the same in both stays as the
    /// file has it. `camera` is kept as the named view `view`, which becomes active.
    pub fn record(&mut self, before: &Scene, after: &Scene, camera: &Camera) {
        let view = Camera { name: "view".to_owned(), ..camera.clone() };
        match self.cameras.iter_mut().find(|camera| camera.name == view.name) {
            Some(old) => *old = view,
            None => self.cameras.push(view),
        }
        self.active_camera = Some("view".to_owned());
        if after.lights != before.lights {
            self.lights = Some(after.lights.clone());
        }
        // Shadows find their lights by name or number, which may have changed.
        if after.shadows != before.shadows || after.lights != before.lights {
            self.shadows = ShadowsEntry::of(after);
        }
        if after.shading != before.shading {
            self.shading = Some(after.shading);
        }
        if after.exposure != before.exposure {
            self.exposure = Some(after.exposure);
        }
        if after.tone_map != before.tone_map {
            self.tone_map = Some(after.tone_map);
        }
        if let Some(environment) = &mut self.environment {
            environment.record(before, after);
        }
        match &after.background {
            same if *same == before.background => {}
            Background::Transparent => self.background = Some(BackgroundEntry::Transparent),
            Background::Color(color) => self.background = Some(BackgroundEntry::Color(*color)),
            // A picture from elsewhere has no path that could be written.
            Background::Picture(_) => {}
            Background::Environment => self.background = Some(BackgroundEntry::Environment),
        }
        let roots: Vec<usize> = (0..after.nodes.len()).filter(|&node| after.nodes[node].parent.is_none()).collect();
        let ends = roots.iter().skip(1).copied().chain([after.nodes.len()]);
        for ((entry, &root), end) in self.assets.iter_mut().zip(&roots).zip(ends) {
            entry.visible = after.nodes[root].visible;
            entry.nodes = hidden(&after.nodes[root + 1..end]);
        }
    }
}

fn hidden(nodes: &[Node]) -> Vec<NodeEntry> {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    let mut entries = Vec::new();
    for node in nodes {
        let occurrence = seen.entry(&node.name).or_default();
        *occurrence += 1;
        if !node.visible {
            entries.push(NodeEntry { name: node.name.clone(), occurrence: *occurrence, visible: false });
        }
    }
    entries
}

fn picture(scene_file: &Path, path: &Path) -> Result<Image, String> {
    let source = FolderTextures::beside(scene_file);
    let name = path.to_str().ok_or("the name is not Unicode")?;
    load_texture(&source.find(name)?, &source.limits())
}

pub(super) fn warning(code: &'static str, subject: String, message: String) -> Finding {
    Finding { code, severity: Severity::Warning, position: None, subject, message }
}

/// What makes two textures the same.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum TextureKey {
    File(PathBuf),
    /// Where the pixels lie in memory.
    Pixels(usize),
    Missing(String, String),
}

#[derive(Default)]
struct Assembly {
    scene: Scene,
    materials: MaterialList,
    meshes: Meshes,
    textures: BTreeMap<TextureKey, TextureId>,
    warnings: Vec<Finding>,
}

impl Assembly {
    fn add(&mut self, entry: &AssetEntry, asset: Scene, up: Up, with_lights: bool) {
        let placement = entry.placement() * turned(asset.up, up);
        let textures: Vec<TextureId> = asset.textures.into_iter().map(|texture| self.texture(texture)).collect();
        let materials: Vec<_> = asset
            .materials
            .into_iter()
            .map(|mut material| {
                for layer in material.layers.iter_mut().flatten() {
                    layer.texture = textures.get(layer.texture.index()).copied().unwrap_or(layer.texture);
                }
                self.materials.share(material)
            })
            .collect();
        let meshes: Vec<_> = asset
            .meshes
            .into_iter()
            .map(|mesh| {
                let renamed = |old: crate::MaterialId| materials.get(old.index()).copied().unwrap_or(old);
                if mesh.subsets.iter().all(|subset| renamed(subset.material) == subset.material) {
                    return self.meshes.share(mesh);
                }
                let mut mesh = Mesh::clone(&mesh);
                for subset in &mut mesh.subsets {
                    subset.material = renamed(subset.material);
                }
                self.meshes.share(Arc::new(mesh))
            })
            .collect();

        let root = self.scene.nodes.len();
        self.scene.nodes.push(Node {
            name: entry.display_name(),
            parent: None,
            local: placement,
            mesh: None,
            visible: entry.visible,
        });
        let shifted = |id: NodeId| NodeId((root + 1 + id.index()) as u32);
        self.scene.nodes.extend(asset.nodes.into_iter().map(|node| Node {
            parent: Some(node.parent.map_or(NodeId(root as u32), shifted)),
            mesh: node.mesh.and_then(|mesh| meshes.get(mesh.index()).copied()),
            ..node
        }));
        self.override_nodes(entry, root + 1);
        if with_lights {
            self.scene.lights.extend(asset.lights.into_iter().map(|light| placed_light(light, &placement)));
        }
        self.scene.cameras.extend(asset.cameras.into_iter().map(|camera| placed_camera(camera, &placement)));
        if let Some(animation) = asset.animation {
            self.animate(entry, animation, shifted);
        }
    }

    fn texture(&mut self, texture: Texture) -> TextureId {
        let key = match (&texture.path, &texture.image) {
            (Some(path), _) => TextureKey::File(path.clone()),
            (None, Ok(image)) => TextureKey::Pixels(Arc::as_ptr(image).addr()),
            (None, Err(reason)) => TextureKey::Missing(texture.name.clone(), reason.clone()),
        };
        let next = TextureId(self.scene.textures.len() as u32);
        let id = *self.textures.entry(key).or_insert(next);
        if id == next {
            self.scene.textures.push(texture);
        }
        id
    }

    fn override_nodes(&mut self, entry: &AssetEntry, first: usize) {
        let mut places: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (index, node) in self.scene.nodes[first..].iter().enumerate() {
            places.entry(&node.name).or_default().push(first + index);
        }
        let found: Vec<Option<usize>> = entry
            .nodes
            .iter()
            .map(|node| places.get(node.name.as_str())?.get(node.occurrence.checked_sub(1)?).copied())
            .collect();
        for (node, place) in entry.nodes.iter().zip(found) {
            match place {
                Some(place) => self.scene.nodes[place].visible = node.visible,
                None => self.warnings.push(warning(
                    "scene/node",
                    format!("asset \"{}\"", entry.display_name()),
                    format!("it has no node \"{}\" number {}; the entry is not used", node.name, node.occurrence),
                )),
            }
        }
    }

    fn animate(&mut self, entry: &AssetEntry, animation: Animation, shifted: impl Fn(NodeId) -> NodeId) {
        let whole = self.scene.animation.get_or_insert_with(|| Animation {
            frames_per_second: animation.frames_per_second,
            ..Animation::default()
        });
        if animation.frames_per_second != whole.frames_per_second {
            self.warnings.push(warning(
                "scene/frame-rate",
                format!("asset \"{}\"", entry.display_name()),
                format!(
                    "it is made for {} frames a second and plays at the {} of the first asset that moves",
                    animation.frames_per_second, whole.frames_per_second
                ),
            ));
        }
        whole.frame_count = whole.frame_count.max(animation.frame_count);
        whole.nodes.extend(
            animation.nodes.into_iter().map(|motion| NodeMotion { node: shifted(motion.node), locals: motion.locals }),
        );
    }
}

/// The turn from one up axis to the other: (x, y, z) with Y up is (x, −z, y) with Z up.
fn turned(from: Up, to: Up) -> Affine3A {
    let quarter = std::f32::consts::FRAC_PI_2;
    match (from, to) {
        (Up::Y, Up::Z) => Affine3A::from_quat(Quat::from_rotation_x(quarter)),
        (Up::Z, Up::Y) => Affine3A::from_quat(Quat::from_rotation_x(-quarter)),
        (Up::Y, Up::Y) | (Up::Z, Up::Z) => Affine3A::IDENTITY,
    }
}

/// The factor by which lengths grow, over all directions.
fn growth(placement: &Affine3A) -> f32 {
    Mat3::from(placement.matrix3).determinant().abs().cbrt()
}

fn placed_light(light: Light, placement: &Affine3A) -> Light {
    let point = |position: Vec3| placement.transform_point3(position);
    let heading = |direction: Vec3| placement.transform_vector3(direction);
    // The lengths of a light at infinity are angles.
    let size = if matches!(light.kind, LightKind::Directional { .. }) { 1.0 } else { growth(placement) };
    Light {
        kind: match light.kind {
            LightKind::Point { position, falloff } => LightKind::Point { position: point(position), falloff },
            LightKind::Directional { direction } => LightKind::Directional { direction: heading(direction) },
            LightKind::Spot { position, direction, inner, outer, falloff } => {
                LightKind::Spot { position: point(position), direction: heading(direction), inner, outer, falloff }
            }
        },
        shape: light.shape.map(|shape| match shape {
            LightShape::Disc { radius } => LightShape::Disc { radius: size * radius },
            LightShape::Rectangle { width, height } => {
                LightShape::Rectangle { width: size * width, height: size * height }
            }
            LightShape::Sphere { radius } => LightShape::Sphere { radius: size * radius },
        }),
        ..light
    }
}

fn placed_camera(camera: Camera, placement: &Affine3A) -> Camera {
    let size = growth(placement);
    Camera {
        position: placement.transform_point3(camera.position),
        target: placement.transform_point3(camera.target),
        up: placement.transform_vector3(camera.up),
        projection: match camera.projection {
            Projection::Perspective { fov_y } => Projection::Perspective { fov_y },
            Projection::Orthographic { height } => Projection::Orthographic { height: size * height },
        },
        near: size * camera.near,
        far: size * camera.far,
        ..camera
    }
}
