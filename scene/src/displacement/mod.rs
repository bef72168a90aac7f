//! Displacement mapping: base triangles are tessellated, and their points moved along the normal by the heights of a map
//! (VR3Lib §2.2.2, §4.6; what a picture shows is defined in `docs/techniques/shading.md` §11).
//!
//! A [`Plan`] says which points there are and which triangles join them; a [`Surface`] says where a point goes. Both engines
//! draw the same plans: the renderer works out the points on the GPU, the reference tracer takes [`displaced`], a scene whose
//! meshes are displaced already.

mod adaptive;
mod base;
mod detail;
mod height;
mod plan;
mod surface;

use std::borrow::Cow;
use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec2};
use thiserror::Error;

pub use adaptive::Viewer;
pub use base::{Base, classes};
pub use detail::Detail;
pub use height::HeightMap;
pub use plan::{Place, Plan, Point};
pub use surface::Surface;

use crate::{Aabb, Displacement, Image, Layer, Material, Mesh, NormalSpace, Scene, Subset, View};

/// The finest cut of an edge: above it the factor is clamped, and a warning says so.
pub const MAX_TESSELLATION: u32 = 1024;

/// The most triangles that displacement may make in a picture, each mesh counted once: they take some 100 bytes each.
pub const MAX_TRIANGLES: u64 = 1 << 23;

/// The smallest pixel error of adaptive tessellation; below it counts as this.
pub const MIN_PIXEL_ERROR: f32 = 0.01;

/// The largest bias and scale, in object units; beyond it they are clamped.
pub const MAX_DISTANCE: f32 = 1e9;

/// How displacement maps are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum DisplacementMode {
    /// Not at all: the base mesh is drawn.
    Off,
    /// Each edge is cut into as many parts as the mesh's tessellation factor says, as in the source.
    #[default]
    Uniform,
    /// Each edge is halved as often as the picture needs, and the tessellation factor is not looked at.
    Adaptive {
        /// The most that a point of the surface moves, in pixels, when the tessellation changes; it is never farther than
        /// half of that from the displaced surface. At least [`MIN_PIXEL_ERROR`].
        pixel_error: f32,
    },
    /// By relief (parallax) mapping: the base mesh is drawn, and each fragment looks for the surface along the ray of sight.
    /// Outlines stay those of the base mesh. Only the renderer offers it.
    Parallax,
}

impl DisplacementMode {
    /// Adaptive with a pixel error of 1.
    pub const ADAPTIVE: Self = Self::Adaptive { pixel_error: 1.0 };
}

/// Why a displaced mesh cannot be drawn.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum DisplacementError {
    /// Geometry was asked for.
    #[error("parallax mapping makes no geometry, and the reference draws nothing else: use uniform, adaptive or off")]
    Parallax,
    /// It would take too much memory.
    #[error(
        "displacing mesh {mesh:?} with a tessellation factor of {factor} makes {triangles} triangles, and a picture can \
         have {limit} displaced ones: use a smaller factor, or draw it without displacement",
        limit = MAX_TRIANGLES
    )]
    TooManyTriangles {
        /// The mesh's name.
        mesh: String,
        /// Its tessellation factor.
        factor: u32,
        /// What would come of it.
        triangles: u64,
    },
}

/// What displaces a subset of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Displaced<'a> {
    /// The map's image.
    pub image: &'a Arc<Image>,
    /// The map's texture matrix; the identity if it is not finite.
    pub transform: Mat3,
    /// Texture coordinates of the map.
    pub uvs: &'a [Vec2],
    /// Factor, bias and scale, all in range.
    pub parameters: Displacement,
    /// No normal map says what the normals are, so that they are those of the displaced surface.
    pub recompute_normals: bool,
}

/// Factor, bias and scale in range; `None` if nothing moves.
fn usable(written: &Displacement) -> Option<Displacement> {
    let number = |value: f32| if value.is_finite() { value.clamp(-MAX_DISTANCE, MAX_DISTANCE) } else { 0.0 };
    let (bias, scale) = (number(written.bias), number(written.scale));
    let tessellation = written.tessellation.clamp(1, MAX_TESSELLATION);
    (bias != 0.0 || scale != 0.0).then_some(Displacement { tessellation, bias, scale })
}

/// What displaces a subset; `None` where nothing does: the mesh has no parameters or moves by 0 everywhere, or the material
/// has no map that is whole, or the mesh no coordinates for it.
pub fn of_subset<'a>(scene: &'a Scene, mesh: &'a Mesh, subset: &Subset) -> Option<Displaced<'a>> {
    let parameters = usable(mesh.displacement.as_ref()?)?;
    let material = scene.materials.get(subset.material.index())?;
    let map = drawn(scene, mesh, material, Layer::Displacement)?;
    let normal_map = drawn(scene, mesh, material, Layer::Normal).is_some_and(|_| {
        let tangents = mesh.tangents.as_ref().is_some_and(|tangents| tangents.len() == mesh.positions.len());
        let space = material.layers[Layer::Normal as usize].map(|layer| layer.normal_space);
        (space == Some(NormalSpace::Object) || tangents) && drawn(scene, mesh, material, Layer::LightMap).is_none()
    });
    let matrix = material.layers[Layer::Displacement as usize]?.transform;
    Some(Displaced {
        image: map.0,
        transform: if matrix.is_finite() { matrix } else { Mat3::IDENTITY },
        uvs: map.1,
        parameters,
        recompute_normals: !normal_map,
    })
}

/// Image and coordinates of a layer that can be drawn.
fn drawn<'a>(
    scene: &'a Scene,
    mesh: &'a Mesh,
    material: &Material,
    layer: Layer,
) -> Option<(&'a Arc<Image>, &'a [Vec2])> {
    let used = material.layers[layer as usize]?;
    let uvs = mesh.uvs[layer as usize].as_deref().filter(|uvs| uvs.len() == mesh.positions.len())?;
    let image = scene.textures.get(used.texture.index())?.image.as_ref().ok()?;
    HeightMap::new(image).map(|_| (image, uvs))
}

/// What there is to say about a mesh's displacement parameters; nothing if they are drawn as they are.
pub fn warnings(mesh: &Mesh) -> Vec<String> {
    let Some(written) = &mesh.displacement else { return Vec::new() };
    let mut warnings = Vec::new();
    if written.tessellation > MAX_TESSELLATION {
        warnings.push(format!(
            "mesh {:?} has a tessellation factor of {}; it is drawn with {MAX_TESSELLATION}, the largest",
            mesh.name, written.tessellation
        ));
    }
    for (name, value) in [("bias", written.bias), ("scale", written.scale)] {
        if !value.is_finite() {
            warnings.push(format!("mesh {:?} has a displacement {name} of {value}; it is drawn with 0", mesh.name));
        } else if value.abs() > MAX_DISTANCE {
            warnings.push(format!(
                "mesh {:?} has a displacement {name} of {value}; it is drawn with {MAX_DISTANCE:e}",
                mesh.name
            ));
        }
    }
    warnings
}

/// What there is to say where adaptive tessellation had to multiply its pixel error.
pub fn coarser_warning(mesh: &Mesh, factor: f32) -> Option<String> {
    (factor > 1.0).then(|| {
        format!(
            "mesh {:?} is tessellated with {factor} times the pixel error asked for, so that a picture has at most \
             {MAX_TRIANGLES} displaced triangles",
            mesh.name
        )
    })
}

/// The farthest that displacement moves any point of a mesh; 0 if it moves none.
pub fn reach(mesh: &Mesh) -> f32 {
    let usable = mesh.displacement.as_ref().and_then(usable);
    usable.map_or(0.0, |parameters| parameters.bias.abs().max((parameters.bias + parameters.scale).abs()))
}

/// The box around a mesh, wherever its displacement map moves it.
pub fn bounds(mesh: &Mesh) -> Aabb {
    let reach = reach(mesh);
    if reach == 0.0 || mesh.bounds.is_empty() {
        return mesh.bounds;
    }
    Aabb { min: mesh.bounds.min - reach, max: mesh.bounds.max + reach }
}

/// A scene with its meshes displaced as a view shows them, at the view's frame, and what there is to say about it. Meshes that
/// nothing displaces are shared with the scene.
///
/// # Errors
/// A mesh would have too many triangles.
pub fn displaced<'a>(
    scene: &'a Scene,
    view: &View,
    mode: DisplacementMode,
) -> Result<(Cow<'a, Scene>, Vec<String>), DisplacementError> {
    let mut said = Vec::new();
    let mut made: Option<Scene> = None;
    if mode == DisplacementMode::Parallax {
        return Err(DisplacementError::Parallax);
    }
    if mode == DisplacementMode::Off {
        return Ok((Cow::Borrowed(scene), said));
    }
    let visible = scene.visibility();
    let frame = view.frame as usize;
    let world = scene.world_transforms_at(frame);
    let mut placed: Vec<Vec<Affine3A>> = vec![Vec::new(); scene.meshes.len()];
    for (index, node) in scene.nodes.iter().enumerate().filter(|(index, _)| visible[*index]) {
        if let Some(placed) = node.mesh.and_then(|mesh| placed.get_mut(mesh.index())) {
            placed.push(world[index]);
        }
    }
    let mut allowed = MAX_TRIANGLES;
    for (index, mesh) in scene.meshes.iter().enumerate().filter(|(index, _)| !placed[*index].is_empty()) {
        if mesh.subsets.iter().all(|subset| of_subset(scene, mesh, subset).is_none()) {
            continue;
        }
        said.extend(warnings(mesh));
        let fineness = match mode {
            DisplacementMode::Adaptive { pixel_error } => Some(Viewer::new(view, &placed[index], pixel_error)),
            _ => None,
        };
        let displaced = displaced_mesh(scene, mesh, frame, fineness.as_ref(), &mut allowed, &mut said)?;
        made.get_or_insert_with(|| scene.clone()).meshes[index] = Arc::new(displaced);
    }
    Ok((made.map_or(Cow::Borrowed(scene), Cow::Owned), said))
}

/// A mesh at a frame, displaced.
fn displaced_mesh(
    scene: &Scene,
    mesh: &Mesh,
    frame: usize,
    viewer: Option<&Viewer>,
    allowed: &mut u64,
    said: &mut Vec<String>,
) -> Result<Mesh, DisplacementError> {
    let positions = mesh.positions_at(frame);
    let normals = mesh.normals_at(frame);
    let classes = classes(mesh);
    let mut out = Mesh {
        name: mesh.name.clone(),
        tangents: mesh.tangents.as_ref().map(|_| Vec::new()),
        colors: mesh.colors.as_ref().map(|_| Vec::new()),
        uvs: [0, 1, 2, 3].map(|layer: usize| mesh.uvs[layer].as_ref().map(|_| Vec::new())),
        ..Mesh::default()
    };
    for subset in &mesh.subsets {
        let first_index = out.indices.len() as u32;
        let first_vertex = out.positions.len() as u32;
        let displaced = of_subset(scene, mesh, subset)
            .and_then(|displaced| Some((displaced, HeightMap::new(displaced.image)?)))
            .filter(|_| positions.len() == mesh.positions.len() && normals.len() == mesh.positions.len());
        if let Some((displaced, heights)) = displaced {
            let base = Base::new(mesh, subset, &classes);
            let Displacement { tessellation, bias, scale } = displaced.parameters;
            let surface = Surface {
                positions,
                normals: &normals,
                uvs: displaced.uvs,
                heights: &heights,
                transform: displaced.transform,
                bias,
                scale,
            };
            let plan = match viewer {
                None => Plan::uniform(&base, tessellation, &mesh.name, *allowed)?,
                Some(viewer) => {
                    let detail = Detail::new(&heights);
                    let (plan, coarser) = Plan::adaptive(&base, &surface, &detail, viewer, &mesh.name, *allowed)?;
                    said.extend(coarser_warning(mesh, coarser));
                    plan
                }
            };
            *allowed -= (plan.triangle_count() as u64).min(*allowed);
            let (moved, turned) = surface.vertices(&plan, displaced.recompute_normals);
            out.positions.extend(moved);
            out.normals.extend(turned);
            let each = |out: &mut Mesh, point: &Point| {
                extend(&mut out.tangents, &mesh.tangents, point);
                extend(&mut out.colors, &mesh.colors, point);
                for (out, uvs) in out.uvs.iter_mut().zip(&mesh.uvs) {
                    extend(out, uvs, point);
                }
            };
            plan.points.iter().for_each(|point| each(&mut out, point));
            out.indices.extend(plan.indices.iter().map(|point| first_vertex + point));
        } else {
            let begin = (subset.first_index as usize).min(mesh.indices.len());
            let end = begin.saturating_add(subset.index_count as usize).min(mesh.indices.len());
            let mut places = vec![u32::MAX; mesh.positions.len()];
            for &vertex in &mesh.indices[begin..end] {
                let index = vertex as usize;
                let place = match places.get(index) {
                    Some(&u32::MAX) if index < positions.len() => {
                        places[index] = out.positions.len() as u32;
                        out.positions.push(positions[index]);
                        out.normals.push(normals[index]);
                        copy(&mut out.tangents, &mesh.tangents, index);
                        copy(&mut out.colors, &mesh.colors, index);
                        for (out, uvs) in out.uvs.iter_mut().zip(&mesh.uvs) {
                            copy(out, uvs, index);
                        }
                        places[index]
                    }
                    Some(&place) => place,
                    None => u32::MAX,
                };
                out.indices.push(place);
            }
        }
        let index_count = out.indices.len() as u32 - first_index;
        out.subsets.push(Subset { first_index, index_count, material: subset.material });
    }
    out.bounds = Aabb::of(out.positions.iter().copied());
    Ok(out)
}

fn extend<T>(out: &mut Option<Vec<T>>, from: &Option<Vec<T>>, point: &Point)
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T> + Copy + Default,
{
    if let (Some(out), Some(from)) = (out, from) {
        let there = point.place.corners.iter().all(|corner| (*corner as usize) < from.len());
        out.push(if there { point.mix(from) } else { T::default() });
    }
}

fn copy<T: Copy + Default>(out: &mut Option<Vec<T>>, from: &Option<Vec<T>>, index: usize) {
    if let (Some(out), Some(from)) = (out, from) {
        out.push(from.get(index).copied().unwrap_or_default());
    }
}

#[cfg(test)]
mod tests;
