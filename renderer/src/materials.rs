//! Materials on the GPU: parameters and textures in one bind group, shared by all that are equal.

use std::collections::HashMap;

use aam_scene::{Material, TextureLayer};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec3, Vec4};

use crate::displacement::{DisplaceParameters, Relief};
use crate::lights::color;
use crate::mips::srgb_decode;
use crate::pipelines::{MapSet, Pipelines};
use crate::textures::{TextureKey, TextureTable};
use crate::upload::Uploader;
use crate::{Gpu, RenderError};

/// `Material` in `shaders/material.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuMaterial {
    constant: Vec3,
    opacity: f32,
    pub diffuse: Vec3,
    exponent: f32,
    pub specular: Vec3,
    alpha_cutoff: f32,
    base_u: Vec4,
    base_v: Vec4,
    second_u: Vec3,
    normal_intensity: f32,
    second_v: Vec4,
}

impl GpuMaterial {
    /// The parameters of a material, decoded if lighting is linear, and of the layers it is drawn with. `ambient_light`
    /// is the sum of the lights' ambient colours.
    pub(crate) fn new(
        material: &Material,
        linear: bool,
        ambient_light: Vec3,
        base: Option<&TextureLayer>,
        second: Option<&TextureLayer>,
    ) -> Self {
        let decode = |stored: Vec3| {
            let stored = color(stored);
            if linear { Vec3::from_array(stored.to_array().map(srgb_decode)) } else { stored }
        };
        let exponent = exponent(material);
        let [base_u, base_v] = top_down(base.map_or(Mat3::IDENTITY, |layer| layer.transform));
        let [second_u, second_v] = top_down(second.map_or(Mat3::IDENTITY, |layer| layer.transform));
        Self {
            constant: decode(material.emission) + decode(material.ambient) * ambient_light,
            opacity: opacity(material),
            diffuse: decode(material.diffuse),
            exponent,
            specular: if exponent > 0.0 { decode(material.specular) } else { Vec3::ZERO },
            alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
            base_u: base_u.extend(0.0),
            base_v: base_v.extend(0.0),
            second_u,
            normal_intensity: second.map_or(1.0, |layer| layer.intensity),
            second_v: second_v.extend(0.0),
        }
    }
}

/// A material's opacity, made to lie in [0, 1].
pub(crate) fn opacity(material: &Material) -> f32 {
    if material.opacity.is_nan() { 1.0 } else { material.opacity.clamp(0.0, 1.0) }
}

fn exponent(material: &Material) -> f32 {
    if material.exponent.is_finite() { material.exponent.max(0.0) } else { 0.0 }
}

/// The two rows of a texture matrix, followed by v → 1 − v.
fn top_down(matrix: Mat3) -> [Vec3; 2] {
    let matrix = if matrix.is_finite() { matrix } else { Mat3::IDENTITY };
    [matrix.row(0), Vec3::Z - matrix.row(1)]
}

/// Identifies a material by everything that its bind group holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Key {
    parameters: [u32; size_of::<GpuMaterial>() / 4],
    base: Option<TextureKey>,
    second: Option<TextureKey>,
    anisotropy: u16,
    /// The map of a relief and its parameters.
    relief: Option<(u64, [u32; size_of::<DisplaceParameters>() / 4])>,
}

/// A place in the material table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MaterialSlot(usize);

#[derive(Debug)]
struct Entry {
    slot: MaterialSlot,
    last_used: u64,
}

/// Materials a uniform buffer.
const PAGE: usize = 64;

/// Frames that an unused material is kept for.
const KEEP: u64 = 60;

/// The materials on the GPU.
#[derive(Debug, Default)]
pub(crate) struct MaterialTable {
    entries: HashMap<Key, Entry>,
    bind_groups: Vec<Option<wgpu::BindGroup>>,
    free: Vec<usize>,
    pages: Vec<wgpu::Buffer>,
    samplers: HashMap<u16, wgpu::Sampler>,
}

impl MaterialTable {
    /// Makes sure that a material is on the GPU, with textures that are there already.
    #[expect(clippy::too_many_arguments, reason = "all of it goes into one bind group")]
    pub(crate) fn ensure(
        &mut self,
        uploader: &mut Uploader<'_>,
        pipelines: &mut Pipelines,
        textures: &TextureTable,
        parameters: &GpuMaterial,
        base: Option<TextureKey>,
        second: Option<TextureKey>,
        relief: Option<&Relief>,
        anisotropy: u16,
        frame: u64,
    ) -> Result<MaterialSlot, RenderError> {
        let key = Key {
            parameters: bytemuck::cast(*parameters),
            base,
            second,
            anisotropy,
            relief: relief.map(|relief| (relief.map, bytemuck::cast(relief.parameters))),
        };
        if let Some(entry) = self.entries.get_mut(&key) {
            entry.last_used = frame;
            return Ok(entry.slot);
        }
        let gpu = uploader.gpu;
        let limits = gpu.device().limits();
        let stride = size_of::<GpuMaterial>().next_multiple_of(limits.min_uniform_buffer_offset_alignment as usize);
        let slot = self.free.pop().unwrap_or(self.bind_groups.len());
        if slot == self.bind_groups.len() {
            self.bind_groups.push(None);
        }
        if slot / PAGE == self.pages.len() {
            let size = (PAGE * stride) as u64;
            self.pages.push(uploader.empty_buffer("materials", wgpu::BufferUsages::UNIFORM, size)?);
        }
        let (page, offset) = (&self.pages[slot / PAGE], (slot % PAGE * stride) as u64);
        uploader.write(page, offset, bytemuck::bytes_of(parameters));

        let sampler = self.samplers.entry(anisotropy).or_insert_with(|| sampler(gpu, anisotropy));
        let uniform = wgpu::BufferBinding {
            buffer: page,
            offset,
            size: std::num::NonZeroU64::new(size_of::<GpuMaterial>() as u64),
        };
        let mut entries = vec![bind(0, wgpu::BindingResource::Buffer(uniform))];
        let views = [base, second].map(|texture| texture.and_then(|texture| textures.view(texture)));
        if views.iter().any(Option::is_some) {
            entries.push(bind(1, wgpu::BindingResource::Sampler(sampler)));
        }
        for (binding, view) in (2..).zip(views) {
            entries.extend(view.map(|view| bind(binding, wgpu::BindingResource::TextureView(view))));
        }
        let relief_parameters = match relief {
            Some(relief) => {
                let bytes = bytemuck::bytes_of(&relief.parameters);
                Some(uploader.buffer("relief", wgpu::BufferUsages::UNIFORM, bytes)?)
            }
            None => None,
        };
        if let (Some(relief), Some(parameters)) = (relief, &relief_parameters) {
            entries.push(bind(4, parameters.as_entire_binding()));
            entries.push(bind(5, wgpu::BindingResource::TextureView(&relief.view)));
        }
        let maps = MapSet { base: views[0].is_some(), second: views[1].is_some(), relief: relief.is_some() };
        self.bind_groups[slot] = Some(gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("material"),
            layout: pipelines.material_layout(gpu, maps),
            entries: &entries,
        }));
        self.entries.insert(key, Entry { slot: MaterialSlot(slot), last_used: frame });
        Ok(MaterialSlot(slot))
    }

    /// The bind group of a material that was made sure of.
    pub(crate) fn bind_group(&self, slot: MaterialSlot) -> Option<&wgpu::BindGroup> {
        self.bind_groups.get(slot.0).and_then(Option::as_ref)
    }

    /// Frees materials that were not used for long, or whose textures are gone.
    pub(crate) fn sweep(&mut self, textures: &TextureTable, frame: u64) {
        let (bind_groups, free) = (&mut self.bind_groups, &mut self.free);
        let before = free.len();
        self.entries.retain(|key, entry| {
            let keep = entry.last_used + KEEP >= frame
                && [key.base, key.second].into_iter().flatten().all(|texture| textures.contains(texture));
            if !keep {
                bind_groups[entry.slot.0] = None;
                free.push(entry.slot.0);
            }
            keep
        });
        // The table has no order of its own.
        free[before..].sort_unstable();
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }
}

pub(crate) fn bind(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

/// Repeating, linear between texels and levels.
fn sampler(gpu: &Gpu, anisotropy: u16) -> wgpu::Sampler {
    gpu.device().create_sampler(&wgpu::SamplerDescriptor {
        label: Some("texture layers"),
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        anisotropy_clamp: anisotropy.clamp(1, 16),
        ..wgpu::SamplerDescriptor::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layout_is_that_of_the_shader() {
        assert_eq!(size_of::<GpuMaterial>(), 112);
    }

    #[test]
    fn the_texture_matrix_works_from_the_bottom_and_gives_rows_from_the_top() {
        let scale = Mat3::from_cols(Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0), Vec3::new(0.1, 0.2, 1.0));
        let [u, v] = top_down(scale);
        let at = Vec3::new(0.5, 0.25, 1.0);
        assert!((u.dot(at) - 1.1).abs() < 1e-6);
        assert!((v.dot(at) - (1.0 - 0.95)).abs() < 1e-6);
    }

    #[test]
    fn broken_numbers_do_not_reach_the_shader() {
        let material = Material {
            diffuse: Vec3::new(f32::NAN, -1.0, 0.5),
            specular: Vec3::ONE,
            exponent: f32::NAN,
            opacity: f32::NAN,
            ..Material::default()
        };
        let packed = GpuMaterial::new(&material, false, Vec3::ZERO, None, None);
        assert_eq!((packed.diffuse, packed.specular), (Vec3::new(0.0, 0.0, 0.5), Vec3::ZERO));
        assert_eq!((packed.exponent, packed.opacity), (0.0, 1.0));
    }
}
