//! The shading equation of `docs/techniques/shading.md`.

use std::cell::Cell;

use aam_scene::{Shading, SpecularFilter};
use glam::{Vec2, Vec3, Vec4};

use crate::bvh::Ray;
use crate::camera::CameraRay;
use crate::colour;
use crate::geometry::{Geometry, Hit};
use crate::light::{Incident, Lamp};
use crate::options::LightSize;
use crate::sampling::Points;
use crate::sky::Sky;
use crate::surface::{Map, Surface};
use crate::texture::Texture;

/// Everything that shading looks at.
#[derive(Debug)]
pub(crate) struct Shader<'a> {
    pub(crate) geometry: &'a Geometry<'a>,
    pub(crate) textures: &'a [Texture],
    pub(crate) lamps: &'a [Lamp],
    pub(crate) sky: Option<&'a Sky>,
    pub(crate) environment_samples: u32,
    pub(crate) shading: Shading,
    pub(crate) shadows: Option<LightSize>,
    pub(crate) light_samples: u32,
    pub(crate) bounces: u32,
    pub(crate) environment: Vec3,
}

/// Rays traced so far, apart from those of the camera.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub(crate) shadow_rays: Cell<u64>,
    pub(crate) bounce_rays: Cell<u64>,
}

pub(crate) fn count(rays: &Cell<u64>) {
    rays.set(rays.get() + 1);
}

/// One camera ray's share of random numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample<'a> {
    /// Those of the pixel.
    pub(crate) points: Points,
    /// Which of the pixel's camera rays.
    pub(crate) index: u32,
    pub(crate) counts: &'a Counts,
}

/// What a pair of random numbers decides, at each surface that a path meets.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    Direction,
    Choice,
    Transparency(u32),
    Light(usize),
    /// Of the environment's diffuse or specular light, chosen by the light or by the surface.
    Environment {
        specular: bool,
        by_light: bool,
    },
}

impl Sample<'_> {
    /// Point number `of_many.0` of `of_many.1` that this camera ray has for a purpose.
    fn one_of(&self, of_many: (u32, u32), depth: u32, purpose: Purpose) -> Vec2 {
        let pair = match purpose {
            Purpose::Direction => 0,
            Purpose::Choice => 1,
            Purpose::Light(light) => 2 + light as u32,
            Purpose::Environment { specular, by_light } => 96 + 2 * u32::from(specular) + u32::from(by_light),
            Purpose::Transparency(layer) => 128 + layer % 128,
        };
        self.points.point(self.index * of_many.1 + of_many.0, 256 * depth + pair)
    }

    pub(crate) fn point(&self, depth: u32, purpose: Purpose) -> Vec2 {
        self.one_of((0, 1), depth, purpose)
    }
}

/// How far shadow rays start above their triangle, as a share of its largest coordinate: some 30 times the rounding
/// error of a point on it.
const LIFT: f32 = 32.0 * f32::EPSILON;

/// A point to be lit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    point: Vec3,
    /// Shading normal, unit, on the seen side.
    pub(crate) normal: Vec3,
    /// Unit vector towards the viewer.
    pub(crate) view: Vec3,
    /// Off the surface, on the seen side.
    pub(crate) lift: Vec3,
}

impl Spot {
    /// Where rays from it start.
    pub(crate) fn origin(&self) -> Vec3 {
        self.point + self.lift
    }
}

/// What a ray met.
#[derive(Debug)]
pub(crate) struct Vertex<'a> {
    pub(crate) surface: &'a Surface<'a>,
    pub(crate) texel: Vec3,
    pub(crate) alpha: f32,
    /// What the surface gives back whatever the light, before the texel.
    own: Vec3,
    pub(crate) spot: Spot,
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

impl<'a> Shader<'a> {
    /// What the camera sees at a hit; `None` where the fragment is cut off. `footprint` is the share of a pixel's side
    /// that the ray stands for.
    pub(crate) fn seen(&self, ray: &CameraRay, hit: &Hit, footprint: f32) -> Option<Vertex<'a>> {
        let [p0, p1, p2] = self.geometry.corners[hit.face as usize];
        let (e1, e2) = (p1 - p0, p2 - p0);
        let across = e1.cross(e2);
        let change = ray.footprint(hit.t, across).map(|step| {
            let step = step * (footprint / across.length_squared());
            let (v, w) = (across.dot(step.cross(e2)), across.dot(e1.cross(step)));
            Vec3::new(-v - w, v, w)
        });
        self.vertex(ray.direction, hit, change)
    }

    /// What a ray of this direction meets at a hit; `None` where the fragment is cut off. `change` is that of the corner
    /// weights over the area that the ray stands for.
    pub(crate) fn vertex(&self, direction: Vec3, hit: &Hit, change: [Vec3; 2]) -> Option<Vertex<'a>> {
        let face = self.geometry.faces[hit.face as usize];
        let instance = &self.geometry.instances[face.instance as usize];
        let surface = &self.geometry.surfaces[face.surface as usize];
        let place = self.place(hit, change);
        let texel = self.diffuse(surface, &place);
        let alpha = self.coverage(surface, texel.w)?;
        let texel = texel.truncate();
        let baked = surface.light_map.as_ref().map_or(Vec3::ZERO, |map| self.sample(map, &place).truncate());
        let own = surface.emission + surface.diffuse * baked;
        let [p0, p1, p2] = self.geometry.corners[hit.face as usize];
        let point = p0 * place.weights.x + p1 * place.weights.y + p2 * place.weights.z;
        let view = -direction.normalize_or_zero();
        let outside = (p1 - p0).cross(p2 - p0) * instance.winding;
        let normal = instance.normal_matrix * self.object_normal(surface, &instance.normals, &place);
        let normal = normal.normalize_or_zero();
        let side = if outside.dot(view) < 0.0 { -1.0 } else { 1.0 };
        let reach = [p0, p1, p2].map(|corner| corner.abs().max_element()).into_iter().fold(0.0, f32::max);
        let lift = outside.normalize_or_zero() * (side * reach * LIFT);
        let spot = Spot { point, normal: normal * side, view, lift };
        Some(Vertex { surface, texel, alpha, own, spot })
    }

    /// The light that a surface shines with or gives back at once: its own and that of lights, in the values that
    /// lighting computes on. `depth` counts the surfaces on the way from the camera.
    pub(crate) fn outgoing(&self, vertex: &Vertex<'_>, sample: &Sample<'_>, depth: u32) -> Vec3 {
        let lit = if vertex.surface.is_lit() { self.lit(vertex, sample, depth) } else { Vec3::ZERO };
        vertex.texel * (vertex.own + lit)
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

    /// The light of lights that a surface gives back to the viewer, before the texture.
    fn lit(&self, vertex: &Vertex<'_>, sample: &Sample<'_>, depth: u32) -> Vec3 {
        let Vertex { surface, spot, .. } = vertex;
        if let Some(sky) = self.sky.filter(|sky| sky.is_lighting()) {
            // Light that bounces finds the sky by itself.
            return if self.bounces == 0 { self.lit_by_sky(sky, surface, spot, sample) } else { Vec3::ZERO };
        }
        let mut sum = Vec3::ZERO;
        for (number, lamp) in self.lamps.iter().enumerate() {
            if self.bounces == 0 {
                sum += surface.ambient * lamp.ambient;
            }
            let term = |incident: Incident| self.term(surface, spot, lamp, &incident, sample.counts);
            if self.shadows == Some(LightSize::Area) && lamp.is_extended() {
                let many = if depth == 0 { self.light_samples } else { 1 };
                let points = (0..many).map(|one| sample.one_of((one, many), depth, Purpose::Light(number)));
                let terms: Vec3 = points.filter_map(|at| lamp.sample(spot.point, at)).map(term).sum();
                sum += terms / many as f32;
            } else {
                sum += lamp.at(spot.point).map_or(Vec3::ZERO, term);
            }
        }
        sum
    }

    /// The environment's light that a surface gives back to the viewer, before the texture.
    fn lit_by_sky(&self, sky: &Sky, surface: &Surface<'_>, spot: &Spot, sample: &Sample<'_>) -> Vec3 {
        let mean = |axis: Vec3, exponent: f32, specular: bool| {
            let many = self.environment_samples;
            sky.mean(axis, exponent, many, |by_light, index| {
                sample.one_of((index, many.div_ceil(2)), 0, Purpose::Environment { specular, by_light })
            })
        };
        let mut sum = Vec3::ZERO;
        if sky.diffuse && surface.diffuse != Vec3::ZERO {
            sum += surface.diffuse * mean(spot.normal, 1.0, false);
        }
        if sky.specular && surface.is_glossy() {
            let mirrored = (2.0 * spot.normal.dot(spot.view) * spot.normal - spot.view).normalize_or(spot.normal);
            let light = match sky.filter {
                SpecularFilter::Mirror => sky.radiance(mirrored),
                SpecularFilter::Phong => mean(mirrored, surface.exponent, true),
            };
            sum += surface.specular * light;
        }
        sum
    }

    /// Diffuse and specular light from one point.
    fn term(&self, surface: &Surface<'_>, spot: &Spot, lamp: &Lamp, incident: &Incident, counts: &Counts) -> Vec3 {
        let facing = spot.normal.dot(incident.towards);
        let mut term = surface.diffuse * lamp.diffuse * facing.clamp(0.0, 1.0);
        if surface.is_glossy() {
            let mirrored = 2.0 * facing * spot.normal - incident.towards;
            let highlight = spot.view.dot(mirrored).clamp(0.0, 1.0).powf(surface.exponent);
            term += surface.specular * lamp.specular * highlight;
        }
        term *= incident.strength;
        if self.shadows.is_some() && term != Vec3::ZERO {
            term *= self.unshadowed(spot, incident, counts);
        }
        term
    }

    /// The middle of a light as a spot sees it; `None` where it shines on the other side of the shading normal only, or
    /// not there at all.
    pub(crate) fn facing(&self, lamp: &Lamp, spot: &Spot) -> Option<Incident> {
        lamp.at(spot.point).filter(|incident| spot.normal.dot(incident.towards) > 0.0)
    }

    /// The share of a point of a light that reaches a spot.
    pub(crate) fn visible(&self, lamp: &Lamp, spot: &Spot, at: Vec2, counts: &Counts) -> f32 {
        lamp.sample(spot.point, at).map_or(0.0, |incident| self.unshadowed(spot, &incident, counts))
    }

    /// The share of light that reaches a spot. The ray starts on the seen side of the surface, so that a light behind the
    /// surface does not reach it.
    pub(crate) fn unshadowed(&self, spot: &Spot, incident: &Incident, counts: &Counts) -> f32 {
        count(&counts.shadow_rays);
        let far = incident.distance * (1.0 - 1e-6) - spot.lift.length();
        let mut light = 1.0;
        self.geometry.any(&Ray::new(spot.origin(), incident.towards), (0.0, far), |hit, opaque| {
            light *= if opaque { 0.0 } else { 1.0 - self.opacity(hit) };
            light > 0.0
        });
        light
    }
}
