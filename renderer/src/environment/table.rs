//! Environments on the GPU: for each map the parts that pictures asked for, for as long as it is looked at.

use std::sync::{Arc, Weak};

use aam_scene::{Environment, EnvironmentMap, MapLayout, Shading, SpecularFilter, Up};
use glam::Vec4;

use super::cube::Cube;
use super::{
    DiffuseLight, EnvironmentDetail, EnvironmentTerms, EnvironmentUniform, SMALLEST_LOBE_SIDE, first_exponent,
    harmonics, lookup,
};
use crate::materials::bind;
use crate::mips::half_encode;
use crate::pipelines::Pipelines;
use crate::upload::{DynamicBuffer, Uploader};
use crate::{Gpu, RenderError};

/// The largest face of the sky box.
const MAX_SKY: u32 = 2048;

/// The side of the cube that diffuse light is taken from.
const DIFFUSE_SOURCE: usize = 64;

/// Pictures that an unused part is kept for, so that pictures of different detail can alternate.
const KEEP: u64 = 32;

/// A part of an environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PartKey {
    Diffuse {
        side: u32,
    },
    Harmonics {
        bands: u32,
    },
    /// Levels of means over lobes, or over texels.
    Levels {
        side: u32,
        lobes: bool,
        count: u32,
    },
}

#[derive(Debug)]
enum Part {
    Texture { view: wgpu::TextureView, bytes: u64, levels: u32 },
    Coefficients([Vec4; harmonics::COEFFICIENTS]),
}

#[derive(Debug)]
struct Entry {
    map: Weak<EnvironmentMap>,
    decode: bool,
    key: PartKey,
    part: Part,
    last_used: u64,
}

/// What of an environment a picture shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    pub terms: EnvironmentTerms,
    pub sky: bool,
}

/// What the passes of a picture bind.
#[derive(Debug)]
pub(crate) struct Ready {
    /// For surfaces.
    pub group: Option<wgpu::BindGroup>,
    /// The sky box.
    pub sky: Option<wgpu::TextureView>,
}

/// The environments on the GPU.
#[derive(Debug)]
pub(crate) struct EnvironmentTable {
    entries: Vec<Entry>,
    uniform: DynamicBuffer,
    sampler: Option<wgpu::Sampler>,
    /// In the place of a part that is not used.
    nothing: Option<wgpu::TextureView>,
}

impl EnvironmentTable {
    pub(crate) const fn new() -> Self {
        Self {
            entries: Vec::new(),
            uniform: DynamicBuffer::new("environment", wgpu::BufferUsages::UNIFORM),
            sampler: None,
            nothing: None,
        }
    }

    /// Linear between texels and levels; faces join by themselves.
    pub(crate) fn sampler(&mut self, gpu: &Gpu) -> &wgpu::Sampler {
        self.sampler.get_or_insert_with(|| {
            gpu.device().create_sampler(&wgpu::SamplerDescriptor {
                label: Some("environment"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            })
        })
    }

    /// Makes sure that what is wanted is on the GPU.
    #[expect(clippy::too_many_arguments, reason = "all of it decides about what is bound")]
    pub(crate) fn ensure(
        &mut self,
        uploader: &mut Uploader<'_>,
        pipelines: &mut Pipelines,
        environment: &Environment,
        up: Up,
        shading: Shading,
        detail: &EnvironmentDetail,
        wanted: Wanted,
        picture: u64,
    ) -> Result<Ready, RenderError> {
        let decode = shading == Shading::Linear && !environment.map.is_linear();
        let find = |table: &mut Self, uploader: &mut Uploader<'_>, key| {
            table.part(uploader, &environment.map, decode, key, picture)
        };
        let natural = natural_side(&environment.map);
        let device_limit = uploader.gpu.device().limits().max_texture_dimension_2d;
        let side = natural.min(detail.specular_size).min(device_limit);
        let lobes = environment.filter_for(shading) == SpecularFilter::Phong;
        let specular = PartKey::Levels { side, lobes, count: level_count(side, lobes).min(detail.specular_levels) };
        let specular_part = if wanted.terms.specular > 0 { Some(find(self, uploader, specular)?) } else { None };
        let diffuse_part = match detail.diffuse {
            _ if wanted.terms.diffuse == 0 => None,
            DiffuseLight::Cube(side) => Some(find(self, uploader, PartKey::Diffuse { side })?),
            DiffuseLight::Harmonics(bands) => Some(find(self, uploader, PartKey::Harmonics { bands })?),
        };
        let sky_part = if wanted.sky {
            let sky_side = natural.min(MAX_SKY).min(device_limit);
            // The sharp level of the specular map will do where it is as fine.
            let shared = specular_part.filter(|_| sky_side == side);
            let own = PartKey::Levels { side: sky_side, lobes: false, count: level_count(sky_side, false) };
            Some(if let Some(shared) = shared { shared } else { find(self, uploader, own)? })
        } else {
            None
        };

        let view = |table: &Self, part: Option<usize>| match part.map(|index| &table.entries[index].part) {
            Some(Part::Texture { view, .. }) => Some(view.clone()),
            _ => None,
        };
        let sky = view(self, sky_part);
        if specular_part.is_none() && diffuse_part.is_none() {
            return Ok(Ready { group: None, sky });
        }
        let (specular_view, diffuse_view) = (view(self, specular_part), view(self, diffuse_part));
        let last_level = match specular_part.map(|index| &self.entries[index].part) {
            Some(Part::Texture { levels, .. }) => levels - 1,
            _ => 0,
        };
        let coefficients = match diffuse_part.map(|index| &self.entries[index].part) {
            Some(Part::Coefficients(coefficients)) => *coefficients,
            _ => [Vec4::ZERO; harmonics::COEFFICIENTS],
        };
        let matrix = lookup(environment, up);
        let uniform = EnvironmentUniform {
            lookup: [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.extend(0.0)),
            factor: environment.factor(),
            first_exponent: first_exponent(side),
            last_level: last_level as f32,
            padding: 0.0,
            harmonics: coefficients,
        };
        self.uniform.set(uploader, bytemuck::bytes_of(&uniform))?;
        let nothing = match &self.nothing {
            Some(nothing) => nothing.clone(),
            None => {
                let dark = Cube { side: 1, texels: vec![glam::Vec3::ZERO; 6] };
                let (view, _) = upload(uploader, "no environment", &[dark]);
                self.nothing.insert(view).clone()
            }
        };
        let sampler = self.sampler(uploader.gpu).clone();
        let group = self.uniform.get().map(|buffer| {
            let texture = |view: &Option<wgpu::TextureView>| view.clone().unwrap_or_else(|| nothing.clone());
            let (diffuse, specular) = (texture(&diffuse_view), texture(&specular_view));
            uploader.gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("environment"),
                layout: pipelines.environment_layout(uploader.gpu),
                entries: &[
                    bind(0, buffer.as_entire_binding()),
                    bind(1, wgpu::BindingResource::Sampler(&sampler)),
                    bind(2, wgpu::BindingResource::TextureView(&diffuse)),
                    bind(3, wgpu::BindingResource::TextureView(&specular)),
                ],
            })
        });
        Ok(Ready { group, sky })
    }

    /// The position of a part in the list; made if it is not there.
    fn part(
        &mut self,
        uploader: &mut Uploader<'_>,
        map: &Arc<EnvironmentMap>,
        decode: bool,
        key: PartKey,
        picture: u64,
    ) -> Result<usize, RenderError> {
        let address = Arc::as_ptr(map);
        let same = |entry: &Entry| Weak::as_ptr(&entry.map) == address && entry.decode == decode && entry.key == key;
        if let Some(index) = self.entries.iter().position(same) {
            self.entries[index].last_used = picture;
            return Ok(index);
        }
        let texture = |uploader: &mut Uploader<'_>, levels: &[Cube]| {
            let (view, bytes) = upload(uploader, "environment", levels);
            Part::Texture { view, bytes, levels: levels.len() as u32 }
        };
        let part = match key {
            PartKey::Diffuse { side } => {
                let source = Cube::new(map, decode, DIFFUSE_SOURCE.max(side as usize));
                texture(uploader, &[source.over_lobes(1.0, side as usize)])
            }
            PartKey::Harmonics { bands } => {
                Part::Coefficients(harmonics::reflected(&Cube::new(map, decode, DIFFUSE_SOURCE), bands))
            }
            PartKey::Levels { side, lobes, count } => {
                let levels = levels(Cube::new(map, decode, side as usize), lobes, count);
                texture(uploader, &levels)
            }
        };
        self.entries.push(Entry { map: Arc::downgrade(map), decode, key, part, last_used: picture });
        Ok(self.entries.len() - 1)
    }

    /// Frees what no picture looked at for some time, or whose map is gone.
    pub(crate) fn sweep(&mut self, picture: u64) {
        self.entries.retain(|entry| entry.map.strong_count() > 0 && entry.last_used + KEEP > picture);
    }

    pub(crate) fn bytes(&self) -> u64 {
        let bytes = |entry: &Entry| match entry.part {
            Part::Texture { bytes, .. } => bytes,
            Part::Coefficients(_) => size_of::<[Vec4; harmonics::COEFFICIENTS]>() as u64,
        };
        self.entries.iter().map(bytes).sum()
    }
}

/// The side of a cube whose faces are about as fine as the map, a power of two.
fn natural_side(map: &EnvironmentMap) -> u32 {
    let side = match map.layout() {
        MapLayout::Panorama(image) => (image.width as f32 / std::f32::consts::PI) as u32,
        MapLayout::Cube(faces) => faces[0].width,
    };
    side.max(SMALLEST_LOBE_SIDE).next_power_of_two().min(MAX_SKY)
}

fn level_count(side: u32, lobes: bool) -> u32 {
    let smallest = if lobes { SMALLEST_LOBE_SIDE } else { 1 };
    (side / smallest).max(1).ilog2() + 1
}

/// The levels of a cube; those of lobes are each made from means over texels at least half as large as their own.
fn levels(base: Cube, lobes: bool, count: u32) -> Vec<Cube> {
    const FINEST_FOR_WIDE: usize = 32;
    let first = first_exponent(base.side as u32);
    let mut finer = vec![base];
    while finer.last().is_some_and(|cube| cube.side > 1) && (lobes || finer.len() < count as usize) {
        let next = finer.last().map(Cube::halved);
        finer.extend(next);
    }
    if !lobes {
        return finer;
    }
    let mut levels = vec![finer[0].clone()];
    for level in 1..count as usize {
        let side = finer[0].side >> level;
        let wanted = (2 * side).max(FINEST_FOR_WIDE.min(finer[0].side));
        let source = finer.iter().find(|cube| cube.side <= wanted).unwrap_or(&finer[0]);
        levels.push(source.over_lobes(first / 4.0_f32.powi(level as i32 - 1), side));
    }
    levels
}

fn upload(uploader: &mut Uploader<'_>, label: &str, levels: &[Cube]) -> (wgpu::TextureView, u64) {
    const BYTES_PER_TEXEL: u32 = 8;
    let side = levels[0].side as u32;
    let device = uploader.gpu.device();
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 6 },
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let before = uploader.bytes;
    let mut bytes = Vec::new();
    for (level, cube) in (0..).zip(levels) {
        bytes.clear();
        bytes.reserve(cube.texels.len() * BYTES_PER_TEXEL as usize);
        for texel in &cube.texels {
            for value in [texel.x, texel.y, texel.z, 1.0] {
                bytes.extend_from_slice(&half_encode(value).to_le_bytes());
            }
        }
        uploader.write_layers(&texture, level, (cube.side as u32, cube.side as u32, 6), BYTES_PER_TEXEL, &bytes);
    }
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::Cube),
        ..wgpu::TextureViewDescriptor::default()
    });
    (view, uploader.bytes - before)
}
