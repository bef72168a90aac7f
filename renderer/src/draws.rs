//! From a scene to what is drawn: instances of meshes, and for each of their subsets the shader variant and material.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use aam_scene::{DisplacementMode, Image, Layer, Material, Mesh, NormalSpace, Scene, Subset, TextureLayer, View};
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, DMat3, Mat3, Vec3};

use crate::displacement::{DisplacementTable, Needs, Relief, SurfaceKey};
use crate::environment::EnvironmentTerms;
use crate::materials::{GpuMaterial, MaterialSlot, MaterialTable, opacity};
use crate::meshes::{MeshTable, Stream, ensure_stream};
use crate::mips::Meaning;
use crate::pipelines::{Constants, PassFormat, PipelineKey, Pipelines, Slot, surface_slots};
use crate::shader::{AlphaMode, ColorSource, NormalSource, Program, Surface, Variant};
use crate::shadows::ShadowSet;
use crate::textures::{TextureKey, TextureTable};
use crate::upload::Uploader;
use crate::{RenderError, Show};

/// A node's matrices: `NodeInput` in `shaders/node.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Instance {
    /// Rows of node to world.
    pub rows: [[f32; 4]; 3],
    /// Columns of its inverse transpose, up to a positive factor.
    pub normals: [[f32; 3]; 3],
    /// 1 if shadows fall on it.
    pub receives: f32,
}

impl Instance {
    pub(crate) fn new(world: &Affine3A) -> Self {
        let rows = [0, 1, 2].map(|row| {
            [world.matrix3.x_axis[row], world.matrix3.y_axis[row], world.matrix3.z_axis[row], world.translation[row]]
        });
        Self {
            rows,
            normals: normal_matrix(world).to_cols_array_2d().map(|column| column.map(|c| c as f32)),
            receives: 1.0,
        }
    }
}

impl Instance {
    /// From its coordinates to the world's.
    fn world(&self) -> Affine3A {
        let row = |row: usize| Vec3::from_slice(&self.rows[row][..3]);
        let translation = Vec3::from_array(self.rows.map(|row| row[3]));
        Affine3A::from_mat3_translation(Mat3::from_cols(row(0), row(1), row(2)).transpose(), translation)
    }
}

/// The inverse transpose up to a positive factor, which exists even if the matrix flattens: its cofactors.
fn normal_matrix(world: &Affine3A) -> DMat3 {
    let [x, y, z] = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis].map(|axis| axis.as_dvec3());
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let largest = cofactors.to_cols_array().into_iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    let sign = if is_mirrored(world) { -1.0 } else { 1.0 };
    if largest > 0.0 && largest.is_finite() { cofactors * (sign / largest) } else { DMat3::IDENTITY }
}

fn is_mirrored(world: &Affine3A) -> bool {
    let [x, y, z] = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis].map(|axis| axis.as_dvec3());
    x.cross(y).dot(z) < 0.0
}

/// A run of triangles of one mesh, one or more instances of it, one material.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    pub variant: Variant,
    pub mirrored: bool,
    pub material: MaterialSlot,
    /// Texture coordinates for the variant's first and second texture.
    uv_layers: [u8; 2],
    pub mesh: usize,
    pub subset: u32,
    /// The displaced surface that is drawn instead of the subset's own triangles.
    pub displaced: Option<SurfaceKey>,
    /// Of the mesh itself, displaced or not.
    pub indices: Range<u32>,
    pub instances: Range<u32>,
}

impl Batch {
    /// The pipeline that draws it.
    pub(crate) fn pipeline(&self, pass: PassFormat, constants: Constants) -> PipelineKey {
        PipelineKey {
            mirrored: self.mirrored,
            constants: constants.read_by(&self.variant),
            ..PipelineKey::new(Program::Surface(self.variant), pass)
        }
    }

    /// The layer of its first texture coordinates.
    pub(crate) fn base_layer(&self) -> u8 {
        self.uv_layers[0]
    }

    /// Its vertex streams in the order of the pipeline's buffers.
    pub(crate) fn streams(&self) -> impl Iterator<Item = Stream> + use<> {
        streams(&self.variant, self.uv_layers)
    }
}

fn streams(variant: &Variant, [base, second]: [u8; 2]) -> impl Iterator<Item = Stream> + use<> {
    surface_slots(variant).map(move |slot| match slot {
        Slot::Position => Stream::Position,
        Slot::Normal => Stream::Normal,
        Slot::Tangent => Stream::Tangent,
        Slot::Color => Stream::Color,
        Slot::BaseUv => Stream::Uv(base),
        Slot::SecondUv => Stream::Uv(second),
        Slot::ReliefUv => Stream::Uv(Layer::Displacement as u8),
    })
}

/// A mesh that is drawn, and where its instances are.
#[derive(Clone, Debug)]
pub(crate) struct DrawnMesh {
    pub mesh: usize,
    /// Its animation frame.
    pub frame: usize,
    /// Instances that do not mirror, then those that do.
    pub instances: Range<u32>,
    first_mirrored: u32,
}

/// Everything that is drawn of a scene.
#[derive(Debug, Default)]
pub(crate) struct DrawList {
    pub instances: Vec<Instance>,
    /// The node of each instance.
    pub nodes: Vec<u32>,
    pub meshes: Vec<DrawnMesh>,
    /// Displaced surfaces and the mesh that each is of.
    pub displaced: Vec<(usize, SurfaceKey)>,
    /// Ordered by pipeline.
    pub opaque: Vec<Batch>,
    /// In scene order.
    pub blended: Vec<Batch>,
    /// Not to be seen in this picture, but seen by shadow sources.
    pub unseen: Vec<Batch>,
}

/// What decides about shaders beside the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mode {
    pub show: Show,
    /// Sources that darken lit surfaces, or one of which is shown.
    pub shadows: ShadowSet,
    pub linear: bool,
    /// Some light has a direction.
    pub lit: bool,
    /// An environment lights instead.
    pub environment: Option<EnvironmentTerms>,
    /// Some light weakens with distance.
    pub falloff: bool,
    /// Sum of the lights' ambient colours.
    pub ambient_light: Vec3,
    pub anisotropy: u16,
    /// Animation frame.
    pub animation_frame: usize,
    pub displacement: DisplacementMode,
    /// Edges are drawn over the picture.
    pub wireframe: bool,
    /// Number of the picture, for the age of resources.
    pub picture: u64,
}

/// The tables that resources are found in or put into.
#[derive(Debug)]
pub(crate) struct Tables<'a> {
    pub meshes: &'a mut MeshTable,
    pub textures: &'a mut TextureTable,
    pub materials: &'a mut MaterialTable,
    pub displacements: &'a mut DisplacementTable,
    pub pipelines: &'a mut Pipelines,
}

/// What of a mesh decides about shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct MeshTraits {
    uvs: [bool; 4],
    tangents: bool,
    colors: bool,
    translucent_colors: bool,
}

/// How a subset is drawn.
#[derive(Clone, Copy, Debug)]
struct Look {
    variant: Variant,
    uv_layers: [u8; 2],
    slot: MaterialSlot,
}

/// Finds out what a scene draws and puts it on the GPU.
pub(crate) fn prepare(
    scene: &Scene,
    view: &View,
    mode: &Mode,
    tables: &mut Tables<'_>,
    uploader: &mut Uploader<'_>,
    warnings: &mut Vec<String>,
) -> Result<DrawList, RenderError> {
    let mut list = place(scene, mode.animation_frame)?;
    let mut looks: HashMap<(u32, MeshTraits, [u32; 2]), Option<Look>> = HashMap::new();
    tables.displacements.begin();
    for drawn in list.meshes.clone() {
        let mesh = &scene.meshes[drawn.mesh];
        let placed = &list.instances[drawn.instances.start as usize..drawn.instances.end as usize];
        let world: Vec<Affine3A> = match mode.displacement {
            DisplacementMode::Adaptive { .. } => placed.iter().map(Instance::world).collect(),
            _ => Vec::new(),
        };
        let gpu_mesh = tables.meshes.ensure(uploader, mesh, drawn.frame)?;
        let traits = MeshTraits {
            uvs: [0, 1, 2, 3].map(|layer: usize| mesh.uvs[layer].is_some()),
            tangents: mesh.tangents.is_some(),
            colors: mesh.colors.is_some(),
            translucent_colors: gpu_mesh.translucent_colors,
        };
        for (number, subset) in (0..).zip(&mesh.subsets) {
            let indices = triangles(subset);
            if indices.is_empty() {
                continue;
            }
            // A relief is the mesh's too.
            let relief = mesh.displacement.filter(|_| mode.displacement == DisplacementMode::Parallax);
            let relief = relief.map_or([0; 2], |relief| [relief.bias.to_bits(), relief.scale.to_bits()]);
            let key = (subset.material.0, traits, relief);
            let look = match looks.get(&key) {
                Some(look) => *look,
                None => {
                    let material = scene.materials.get(subset.material.index()).ok_or_else(|| RenderError::Mesh {
                        mesh: mesh.name.clone(),
                        reason: format!(
                            "subset {number} refers to material {} of {}",
                            subset.material.0,
                            scene.materials.len()
                        ),
                    })?;
                    let relief = match mode.displacement {
                        DisplacementMode::Parallax => {
                            tables.displacements.relief(uploader, scene, mesh, subset, warnings)?
                        }
                        _ => None,
                    };
                    let look = resolve(scene, material, traits, relief.as_ref(), mode, tables, uploader, warnings)?;
                    looks.insert(key, look);
                    look
                }
            };
            let Some(Look { variant, uv_layers, slot }) = look else { continue };
            let gpu_mesh = tables.meshes.ensure(uploader, mesh, drawn.frame)?;
            let needs =
                Needs { frame: drawn.frame, sorted: variant.alpha.blend, edges: mode.wireframe, picture: mode.picture };
            let displaced = tables.displacements.ensure(
                uploader,
                scene,
                mesh,
                gpu_mesh,
                number,
                (mode.displacement, view, &world),
                streams(&variant, uv_layers),
                needs,
                warnings,
            )?;
            if let Some(key) = displaced {
                list.displaced.push((drawn.mesh, key));
            }
            // Shadow maps are drawn of the base mesh.
            if displaced.is_none() || !mode.shadows.is_empty() {
                for stream in streams(&variant, uv_layers) {
                    ensure_stream(uploader, gpu_mesh, mesh, stream)?;
                }
            }
            let halves = [
                (false, drawn.instances.start..drawn.first_mirrored),
                (true, drawn.first_mirrored..drawn.instances.end),
            ];
            for (mirrored, instances) in halves.into_iter().filter(|(_, instances)| !instances.is_empty()) {
                let batches = match mode.show {
                    Show::Shadow(_) if variant.alpha.blend => &mut list.unseen,
                    Show::ShadowMap(_) => &mut list.unseen,
                    _ if variant.alpha.blend => &mut list.blended,
                    _ => &mut list.opaque,
                };
                batches.push(Batch {
                    variant,
                    mirrored,
                    material: slot,
                    uv_layers,
                    mesh: drawn.mesh,
                    subset: number,
                    displaced,
                    indices: indices.clone(),
                    instances,
                });
            }
        }
    }
    // By the pipelines' own order, so that equal scenes give equal pictures whatever was drawn before.
    list.opaque.sort_by_key(|batch| (batch.variant, batch.mirrored));
    Ok(list)
}

/// Whether any surface is lit by an environment.
pub(crate) fn is_lit_by_environment(list: &DrawList) -> bool {
    let lit = |batch: &Batch| matches!(batch.variant.surface, Surface::Environment { .. });
    list.opaque.iter().chain(&list.blended).any(lit)
}

fn triangles(subset: &Subset) -> Range<u32> {
    subset.first_index..subset.first_index + subset.index_count / 3 * 3
}

/// World matrices of the visible nodes, grouped by mesh.
/// Where everything visible stands at a frame of the animation.
pub(crate) fn place(scene: &Scene, frame: usize) -> Result<DrawList, RenderError> {
    let mut locals: Vec<Affine3A> = scene.nodes.iter().map(|node| node.local).collect();
    for motion in scene.animation.iter().flat_map(|animation| &animation.nodes) {
        let last = motion.locals.len().saturating_sub(1);
        if let (Some(local), Some(moved)) = (locals.get_mut(motion.node.index()), motion.locals.get(frame.min(last))) {
            *local = *moved;
        }
    }
    let visible = scene.visibility();
    let mut world: Vec<Affine3A> = Vec::with_capacity(locals.len());
    let mut by_mesh: Vec<[Vec<u32>; 2]> = vec![Default::default(); scene.meshes.len()];
    for (index, node) in scene.nodes.iter().enumerate() {
        let parent = node.parent.and_then(|id| world.get(id.index()));
        let matrix = parent.map_or(locals[index], |parent| *parent * locals[index]);
        world.push(matrix);
        let Some(mesh) = node.mesh.filter(|_| visible[index] && matrix.is_finite()) else { continue };
        let group = by_mesh.get_mut(mesh.index()).ok_or_else(|| RenderError::Scene {
            reason: format!("node {:?} refers to mesh {} of {}", node.name, mesh.0, scene.meshes.len()),
        })?;
        group[usize::from(is_mirrored(&matrix))].push(index as u32);
    }
    let mut list = DrawList::default();
    for (mesh, [plain, mirrored]) in by_mesh.iter().enumerate() {
        let data = &scene.meshes[mesh];
        if plain.len() + mirrored.len() == 0 || data.indices.len() < 3 || data.subsets.is_empty() {
            continue;
        }
        let start = list.nodes.len() as u32;
        list.nodes.extend(plain.iter().chain(mirrored));
        list.meshes.push(DrawnMesh {
            mesh,
            frame: frame.min(data.frames.len()),
            instances: start..list.nodes.len() as u32,
            first_mirrored: start + plain.len() as u32,
        });
    }
    list.instances = list.nodes.iter().map(|&node| Instance::new(&world[node as usize])).collect();
    Ok(list)
}

/// A layer that can be drawn: its texture has an image, and the mesh has texture coordinates for it.
fn layer<'a>(
    scene: &'a Scene,
    material: &'a Material,
    traits: MeshTraits,
    layer: Layer,
) -> Option<(&'a TextureLayer, &'a Arc<Image>, &'a str)> {
    let used = material.layers[layer as usize].as_ref().filter(|_| traits.uvs[layer as usize])?;
    let texture = scene.textures.get(used.texture.index())?;
    texture.image.as_ref().ok().map(|image| (used, image, texture.name.as_str()))
}

#[expect(clippy::too_many_arguments, reason = "a look follows from mesh, material and options")]
/// The variant and material of a subset; `None` if it is not to be seen.
fn resolve(
    scene: &Scene,
    material: &Material,
    traits: MeshTraits,
    relief: Option<&Relief>,
    mode: &Mode,
    tables: &mut Tables<'_>,
    uploader: &mut Uploader<'_>,
    warnings: &mut Vec<String>,
) -> Result<Option<Look>, RenderError> {
    let find = |which| layer(scene, material, traits, which);
    let color_meaning = if mode.linear { Meaning::Srgb } else { Meaning::Stored };
    let light_map = find(Layer::LightMap);
    let normal_map = find(Layer::Normal)
        .filter(|(used, ..)| light_map.is_none() && (used.normal_space == NormalSpace::Object || traits.tangents));
    let normal = match normal_map {
        None => NormalSource::Vertex,
        Some((used, ..)) if used.normal_space == NormalSpace::Object => NormalSource::ObjectMap,
        Some(_) => NormalSource::TangentMap,
    };
    let normal_texture = normal_map.map(|found| (found, Meaning::Vectors, Layer::Normal));

    let (variant, base, second) = match mode.show {
        Show::Lit | Show::Shadow(_) | Show::ShadowMap(_) => {
            let diffuse_map = find(Layer::Diffuse);
            let opacity = opacity(material);
            let test = material.alpha_cutoff.is_some();
            let translucent = (traits.translucent_colors && traits.colors)
                || diffuse_map.is_some_and(|(_, image, _)| tables.textures.is_translucent(image));
            let alpha = AlphaMode { test, blend: opacity < 1.0 || (!test && translucent) };
            if alpha.blend && opacity == 0.0 {
                return Ok(None);
            }
            let parameters = GpuMaterial::new(material, mode.linear, Vec3::ZERO, None, None);
            let specular = parameters.specular != Vec3::ZERO;
            let surface = if mode.show != Show::Lit {
                Surface::ShowShadow
            } else if light_map.is_some() {
                Surface::LightMapped
            } else if let Some(terms) = mode.environment {
                let specular = specular && terms.specular > 0;
                let reflects = specular || terms.diffuse > 0 && parameters.diffuse != Vec3::ZERO;
                if reflects { Surface::Environment { normal, specular } } else { Surface::Flat }
            } else if mode.lit && (specular || parameters.diffuse != Vec3::ZERO) {
                Surface::Lit { normal, specular, falloff: mode.falloff }
            } else {
                Surface::Flat
            };
            let color = match (traits.colors, mode.linear) {
                (false, _) => ColorSource::None,
                (true, false) => ColorSource::Stored,
                (true, true) => ColorSource::Decoded,
            };
            // What is shown of shadows has the surface's outline alone.
            let cut = mode.show == Show::Lit || alpha != AlphaMode::OPAQUE;
            let color = if cut { color } else { ColorSource::None };
            let diffuse_map = diffuse_map.filter(|_| cut);
            let shadows = match surface {
                Surface::Lit { .. } | Surface::ShowShadow => mode.shadows,
                _ => ShadowSet::NONE,
            };
            let plain = Variant { surface, diffuse_map: diffuse_map.is_some(), color, alpha, shadows, relief: false };
            let variant =
                Variant { relief: mode.show == Show::Lit && relief.is_some() && plain.shows_relief(), ..plain };
            let base = diffuse_map.map(|found| (found, color_meaning, Layer::Diffuse));
            let second = match surface {
                Surface::LightMapped => light_map.map(|found| (found, color_meaning, Layer::LightMap)),
                Surface::Lit { .. } | Surface::Environment { .. } => normal_texture,
                _ => None,
            };
            (variant, base, second)
        }
        Show::Layer(which) => match find(which) {
            Some(found) => (Variant::show(Surface::ShowTexture), Some((found, Meaning::Stored, which)), None),
            None => (Variant::show(Surface::ShowNothing), None, None),
        },
        Show::Normals => (Variant::show(Surface::ShowNormal(normal)), None, normal_texture),
        Show::Uvs(which) if traits.uvs[which as usize] => {
            let parameters =
                GpuMaterial::new(material, false, Vec3::ZERO, material.layers[which as usize].as_ref(), None);
            let slot = ensure_material(tables, uploader, &parameters, [None; 2], None, mode)?;
            let variant = Variant::show(Surface::ShowUv);
            return Ok(Some(Look { variant, uv_layers: [which as u8, 0], slot }));
        }
        Show::Uvs(_) => (Variant::show(Surface::ShowNothing), None, None),
    };

    let mut textures = [None; 2];
    for (texture, source) in textures.iter_mut().zip([&base, &second]) {
        if let Some(((_, image, name), meaning, _)) = source {
            let table = &mut *tables.textures;
            *texture = Some(table.ensure(uploader, image, name, *meaning, mode.picture, warnings)?);
        }
    }
    let used = |source: &Option<((&TextureLayer, _, _), _, Layer)>| source.as_ref().map(|((used, ..), ..)| **used);
    let ambient_light = if variant.surface == Surface::LightMapped { Vec3::ZERO } else { mode.ambient_light };
    let (base_layer, second_layer) = (used(&base), used(&second));
    let parameters = GpuMaterial::new(material, mode.linear, ambient_light, base_layer.as_ref(), second_layer.as_ref());
    let slot = ensure_material(tables, uploader, &parameters, textures, relief.filter(|_| variant.relief), mode)?;
    let uv_layers = [&base, &second].map(|source| source.as_ref().map_or(0, |(_, _, which)| *which as u8));
    Ok(Some(Look { variant, uv_layers, slot }))
}

fn ensure_material(
    tables: &mut Tables<'_>,
    uploader: &mut Uploader<'_>,
    parameters: &GpuMaterial,
    [base, second]: [Option<TextureKey>; 2],
    relief: Option<&Relief>,
    mode: &Mode,
) -> Result<MaterialSlot, RenderError> {
    let Tables { materials, pipelines, textures, .. } = tables;
    materials.ensure(uploader, pipelines, textures, parameters, base, second, relief, mode.anisotropy, mode.picture)
}

/// The mesh of a batch.
pub(crate) fn mesh_of<'a>(scene: &'a Scene, batch: &Batch) -> &'a Arc<Mesh> {
    &scene.meshes[batch.mesh]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn normals_follow_the_inverse_transpose_also_of_mirrors() {
        let rotation = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        for scale in [Vec3::new(2.0, 0.5, 3.0), Vec3::new(-1.0, 2.0, 0.1), Vec3::splat(1e-5)] {
            let world = Affine3A::from_scale_rotation_translation(scale, rotation, Vec3::ONE);
            let exact = Mat3::from(world.matrix3).inverse().transpose();
            let ours = Instance::new(&world).normals.map(Vec3::from_array);
            for n in [Vec3::X, Vec3::Y, Vec3::new(0.3, -0.5, 0.9)] {
                let mapped = n.x * ours[0] + n.y * ours[1] + n.z * ours[2];
                assert!(mapped.normalize().distance((exact * n).normalize()) < 1e-5, "{scale} {n}");
            }
        }
    }

    #[test]
    fn a_flattened_node_keeps_the_normal_of_its_plane() {
        let world = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
        let [_, _, z] = Instance::new(&world).normals;
        assert_eq!(z, [0.0, 0.0, 1.0]);
    }
}
