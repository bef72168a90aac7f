//! The shading equation of `docs/techniques/shading.md`.

use std::cell::Cell;

use aam_scene::Shading;
use glam::{Vec2, Vec3, Vec4};

use crate::bvh::Ray;
use crate::camera::CameraRay;
use crate::colour;
use crate::geometry::{Geometry, Hit};
use crate::light::{Incident, Lamp};
use crate::surface::{Map, Surface};
use crate::texture::Texture;

/// Everything that shading looks at.
#[derive(Debug)]
pub(crate) struct Shader<'a> {
    pub(crate) geometry: &'a Geometry<'a>,
    pub(crate) textures: &'a [Texture],
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) shading: Shading,
    pub(crate) shadows: bool,
}

/// How far shadow rays start above their triangle, as a share of its largest coordinate: some 30 times the rounding
/// error of a point on it.
const LIFT: f32 = 32.0 * f32::EPSILON;

/// A point to be lit.
struct Spot {
    point: Vec3,
    /// Shading normal, unit, on the seen side.
    normal: Vec3,
    /// Unit vector towards the viewer.
    view: Vec3,
    /// Off the surface, on the seen side.
    lift: Vec3,
}

/// A hit's place on its mesh.
struct Place {
    corners: [u32; 3],
    /// Weights of the three corners, and their change for one sample to the right and one down.
    weights: Vec3,
    change: [Vec3; 2],
}

impl Place {
    fn mix<T>(&self, of: impl Fn(u32) -> T) -> T
    where
        T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
    {
        let [a, b, c] = self.corners;
        of(a) * self.weights.x + of(b) * self.weights.y + of(c) * self.weights.z
    }
}

impl Shader<'_> {
    /// Colour in the values that lighting computes on, clamped to `[0, 1]`, and alpha; `None` where the fragment is
    /// cut off. `footprint` is the share of a pixel's side that the ray stands for.
    pub(crate) fn shade(
        &self,
        ray: &CameraRay,
        hit: &Hit,
        footprint: f32,
        shadow_rays: &Cell<u64>,
    ) -> Option<(Vec3, f32)> {
        let face = self.geometry.faces[hit.face as usize];
        let instance = &self.geometry.instances[face.instance as usize];
        let surface = &self.geometry.surfaces[face.surface as usize];
        let [p0, p1, p2] = self.geometry.corners[hit.face as usize];
        let (e1, e2) = (p1 - p0, p2 - p0);
        let across = e1.cross(e2);
        let change = ray.footprint(hit.t, across).map(|step| {
            let step = step * (footprint / across.length_squared());
            let (v, w) = (across.dot(step.cross(e2)), across.dot(e1.cross(step)));
            Vec3::new(-v - w, v, w)
        });
        let place = self.place(hit, change);

        let texel = self.diffuse(surface, &place);
        let alpha = self.coverage(surface, texel.w)?;
        let color = match &surface.light_map {
            Some(map) => surface.emission + surface.diffuse * self.sample(map, &place).truncate(),
            None => {
                let point = p0 * place.weights.x + p1 * place.weights.y + p2 * place.weights.z;
                let view = -ray.direction.normalize_or_zero();
                let outside = across * instance.winding;
                let normal = instance.normal_matrix * self.object_normal(surface, &instance.normals, &place);
                let normal = normal.normalize_or_zero();
                let side = if outside.dot(view) < 0.0 { -1.0 } else { 1.0 };
                let reach = [p0, p1, p2].map(|corner| corner.abs().max_element()).into_iter().fold(0.0, f32::max);
                let lift = outside.normalize_or_zero() * (side * reach * LIFT);
                self.light(surface, &Spot { point, normal: normal * side, view, lift }, shadow_rays)
            }
        };
        Some((colour::saturate(texel.truncate() * color), alpha))
    }

    /// The share of light that a surface in the way takes.
    fn opacity(&self, hit: &Hit) -> f32 {
        let face = self.geometry.faces[hit.face as usize];
        let surface = &self.geometry.surfaces[face.surface as usize];
        let place = self.place(hit, [Vec3::ZERO; 2]);
        self.coverage(surface, self.diffuse(surface, &place).w).unwrap_or(0.0)
    }

    /// The alpha that a fragment blends with; `None` where it is cut off.
    fn coverage(&self, surface: &Surface<'_>, texel_alpha: f32) -> Option<f32> {
        let alpha = colour::saturate_one(texel_alpha * surface.opacity);
        match surface.alpha_cutoff {
            Some(cutoff) if alpha < cutoff => None,
            _ if surface.blends => Some(alpha),
            _ => Some(1.0),
        }
    }

    fn place(&self, hit: &Hit, change: [Vec3; 2]) -> Place {
        let face = self.geometry.faces[hit.face as usize];
        let mesh = self.geometry.instances[face.instance as usize].mesh;
        let first = face.first_index as usize;
        let [v, w] = hit.weights;
        Place {
            corners: [mesh.indices[first], mesh.indices[first + 1], mesh.indices[first + 2]],
            weights: Vec3::new(1.0 - v - w, v, w),
            change,
        }
    }

    /// T: diffuse texel times vertex colour.
    fn diffuse(&self, surface: &Surface<'_>, place: &Place) -> Vec4 {
        let texel = surface.diffuse_map.as_ref().map_or(Vec4::ONE, |map| self.sample(map, place));
        let Some(colors) = surface.colors else { return texel };
        texel
            * place.mix(|corner| {
                let color = Vec4::from_array(colors[corner as usize].to_array().map(colour::saturate_one));
                match self.shading {
                    Shading::Source => color,
                    Shading::Linear => colour::decode_rgb(color.truncate()).extend(color.w),
                }
            })
    }

    fn sample(&self, map: &Map<'_>, place: &Place) -> Vec4 {
        let at = |corner: u32| {
            let Vec2 { x, y } = map.uvs[corner as usize];
            Vec2::new(if x.is_finite() { x } else { 0.0 }, if y.is_finite() { y } else { 0.0 })
        };
        let [a, b, c] = place.corners.map(at);
        let mix = |weights: Vec3| a * weights.x + b * weights.y + c * weights.z;
        let uv = map.transform.transform_point2(mix(place.weights));
        let change = place.change.map(|change| map.transform.transform_vector2(mix(change)));
        self.textures[map.texture].sample(uv, change)
    }

    /// The shading normal in object space, of any length.
    fn object_normal(&self, surface: &Surface<'_>, normals: &[Vec3], place: &Place) -> Vec3 {
        let vertex_normal = || place.mix(|corner| normals[corner as usize]);
        let Some(map) = &surface.normal_map else { return vertex_normal() };
        let texel = 2.0 * self.sample(&map.map, place).truncate() - 1.0;
        let Some((tangents, intensity)) = map.tangent else { return texel };
        let normal = vertex_normal();
        let tangent = place.mix(|corner| tangents[corner as usize]);
        let bitangent = tangent.w * normal.cross(tangent.truncate());
        intensity * (texel.x * tangent.truncate() + texel.y * bitangent) + texel.z * normal
    }

    /// C, the light that the surface gives back to the viewer before the texture.
    fn light(&self, surface: &Surface<'_>, spot: &Spot, shadow_rays: &Cell<u64>) -> Vec3 {
        let Spot { point, normal, view, .. } = *spot;
        let glossy = surface.exponent > 0.0 && surface.specular != Vec3::ZERO;
        let mut sum = surface.emission;
        for lamp in &self.lamps {
            sum += surface.ambient * lamp.ambient;
            let Some(incident) = lamp.at(point) else { continue };
            let facing = normal.dot(incident.towards);
            let mirrored = 2.0 * facing * normal - incident.towards;
            let mut term = surface.diffuse * lamp.diffuse * facing.clamp(0.0, 1.0);
            if glossy {
                term += surface.specular * lamp.specular * view.dot(mirrored).clamp(0.0, 1.0).powf(surface.exponent);
            }
            if self.shadows && term != Vec3::ZERO {
                shadow_rays.set(shadow_rays.get() + 1);
                term *= self.unshadowed(spot, &incident);
            }
            sum += term * incident.strength;
        }
        sum
    }

    /// The share of a light that reaches a point. The ray starts on the seen side of the surface, so that a light behind
    /// the surface does not reach it.
    fn unshadowed(&self, spot: &Spot, incident: &Incident) -> f32 {
        let origin = spot.point + spot.lift;
        let far = incident.distance * (1.0 - 1e-6) - spot.lift.length();
        let mut light = 1.0;
        self.geometry.any(&Ray::new(origin, incident.towards), (0.0, far), |hit, opaque| {
            light *= if opaque { 0.0 } else { 1.0 - self.opacity(hit) };
            light > 0.0
        });
        light
    }
}
