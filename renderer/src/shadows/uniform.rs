//! Shadow sources as the shaders see them.

use aam_scene::{DepthMetric, Light, LightShape, ShadowFilter, ShadowSettings};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, Mat4, Vec3, Vec4};

use super::fit::{MapView, Placement};

/// Most maps of a source.
pub(crate) const MAX_VIEWS: usize = 6;

/// `ShadowView` in `shaders/shadow.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct GpuView {
    clip: Mat4,
    axis: Vec4,
    texel: f32,
    near: f32,
    far: f32,
    radius: f32,
}

/// `ShadowSource` in `shaders/shadow.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuSource {
    views: [GpuView; MAX_VIEWS],
    origin: Vec3,
    perspective: f32,
    intensity: f32,
    bias: f32,
    slope_bias: f32,
    max_bias: f32,
    normal_offset: f32,
    receiver_plane: f32,
    levels: f32,
    texels: f32,
    exponent: f32,
    shift: f32,
    min_variance: f32,
    bleed_reduction: f32,
    light_size: f32,
    samples: f32,
    radial: f32,
    view_count: f32,
    ends: Vec4,
    blend: f32,
    number: f32,
    padding: [f32; 2],
}

/// `CasterView` in `shaders/shadow_caster.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuCasterView {
    clip: Mat4,
    axis: Vec4,
    origin: Vec3,
    radial: f32,
    near: f32,
    far: f32,
    exponent: f32,
    shift: f32,
}

/// Numbers of a warp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Warp {
    pub exponent: f32,
    pub shift: f32,
}

impl Warp {
    pub(super) fn of(settings: &ShadowSettings) -> Self {
        // Subtracting a constant from depths multiplies all moments alike, which no bound notices.
        let centred = match settings.technique.filter {
            ShadowFilter::Esm => true,
            ShadowFilter::Evsm2 | ShadowFilter::Evsm4 => settings.centred,
            _ => false,
        };
        Self { exponent: settings.exponent, shift: if centred { 0.5 } else { 0.0 } }
    }
}

fn relative(matrix: DMat4, eye: DVec3) -> DMat4 {
    matrix * DMat4::from_translation(eye)
}

fn axis(view: &MapView, eye: DVec3) -> Vec4 {
    (-relative(view.view, eye).row(2)).as_vec4()
}

/// Moments are of distance, not of depth along the axis. From infinitely far away there is no distance.
fn is_radial(settings: &ShadowSettings, placement: &Placement) -> bool {
    placement.perspective && settings.metric != DepthMetric::Planar
}

impl GpuSource {
    /// Nothing is inside: everything is lit.
    pub(crate) fn nowhere(number: usize) -> Self {
        Self { texels: 1.0, number: number as f32, ..Self::zeroed() }
    }

    pub(crate) fn new(
        number: usize,
        settings: &ShadowSettings,
        placement: &Placement,
        light: Option<&Light>,
        eye: Vec3,
    ) -> Self {
        let eye = eye.as_dvec3();
        let mut views = [GpuView::zeroed(); MAX_VIEWS];
        for (gpu, view) in views.iter_mut().zip(&placement.views) {
            *gpu = GpuView {
                clip: relative(view.projection * view.view, eye).as_mat4(),
                axis: axis(view, eye),
                texel: view.texel as f32,
                near: view.near as f32,
                far: view.far as f32,
                radius: view.radius as f32,
            };
        }
        let origin = if placement.perspective { placement.origin - eye } else { placement.origin };
        let warp = Warp::of(settings);
        let mut ends = Vec4::ZERO;
        for (end, depth) in placement.ends.iter().enumerate() {
            ends[end] = *depth as f32;
        }
        let switch = |on: bool| f32::from(u8::from(on));
        Self {
            views,
            origin: origin.as_vec3(),
            perspective: switch(placement.perspective),
            intensity: settings.intensity,
            bias: settings.bias,
            slope_bias: settings.slope_bias,
            max_bias: settings.max_bias.min(f32::MAX),
            normal_offset: settings.normal_offset,
            receiver_plane: switch(settings.receiver_plane),
            levels: if settings.bits < 32 { (2.0_f64.powi(settings.bits as i32) - 1.0) as f32 } else { 0.0 },
            texels: settings.resolution as f32,
            exponent: warp.exponent,
            shift: warp.shift,
            min_variance: settings.min_variance,
            bleed_reduction: settings.bleed_reduction,
            light_size: light_size(settings, light),
            samples: settings.samples as f32,
            radial: switch(is_radial(settings, placement)),
            view_count: placement.views.len() as f32,
            ends,
            blend: settings.blend,
            number: number as f32,
            padding: [0.0; 2],
        }
    }
}

/// Diameter of a light in metres; of one at infinity, in metres at a distance of one.
pub(crate) fn light_size(settings: &ShadowSettings, light: Option<&Light>) -> f32 {
    if settings.light_size > 0.0 {
        return settings.light_size;
    }
    match light.and_then(|light| light.shape) {
        None => 0.0,
        Some(LightShape::Disc { radius } | LightShape::Sphere { radius }) => 2.0 * radius,
        // The disc of the same area.
        Some(LightShape::Rectangle { width, height }) => 2.0 * (width * height / std::f32::consts::PI).sqrt(),
    }
}

impl GpuCasterView {
    pub(crate) fn new(settings: &ShadowSettings, placement: &Placement, view: &MapView, eye: Vec3) -> Self {
        let eye = eye.as_dvec3();
        let warp = Warp::of(settings);
        Self {
            clip: relative(view.projection * view.view, eye).as_mat4(),
            axis: axis(view, eye),
            origin: (placement.origin - eye).as_vec3(),
            radial: f32::from(u8::from(is_radial(settings, placement))),
            near: view.near as f32,
            far: view.far as f32,
            exponent: warp.exponent,
            shift: warp.shift,
        }
    }
}

impl GpuCasterView {
    /// What the camera sees.
    pub(crate) fn of_camera(clip: Mat4) -> Self {
        Self { clip, ..Self::zeroed() }
    }

    /// `Source` in `shaders/shadow_extrude.wgsl`.
    pub(crate) fn of_volume(clip: Mat4, placement: &Placement, reach: f32, eye: Vec3) -> Self {
        let origin = if placement.perspective { placement.origin - eye.as_dvec3() } else { placement.origin };
        Self {
            clip,
            origin: origin.as_vec3(),
            radial: f32::from(u8::from(placement.perspective)),
            near: reach,
            ..Self::zeroed()
        }
    }
}

/// The moments of depth 1: those of a map that nothing was drawn into.
pub(crate) fn empty_moments(settings: &ShadowSettings) -> [f64; 4] {
    let Warp { exponent, shift } = Warp::of(settings);
    let warp = f64::from(exponent) * (1.0 - f64::from(shift));
    let (positive, negative) = (warp.exp(), (-warp).exp());
    match settings.technique.filter {
        ShadowFilter::Esm => [positive, 0.0, 0.0, 0.0],
        ShadowFilter::Evsm2 => [positive, positive * positive, 0.0, 0.0],
        ShadowFilter::Evsm4 => [-negative, negative * negative, positive, positive * positive],
        ShadowFilter::Vsm | ShadowFilter::Msm => [1.0; 4],
        ShadowFilter::Hard | ShadowFilter::Pcf | ShadowFilter::Pcss | ShadowFilter::Volume => [0.0; 4],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_those_of_the_shaders() {
        assert_eq!((size_of::<GpuView>(), size_of::<GpuSource>(), size_of::<GpuCasterView>()), (96, 688, 112));
    }
}
