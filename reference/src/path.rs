//! Light that comes from other surfaces: `docs/techniques/shading.md`, section 10.

use glam::Vec3;

use crate::bvh::Ray;
use crate::extent::{cosine_direction, lobe_direction};
use crate::geometry::Hits;
use crate::shade::{Purpose, Sample, Shader, Spot, Vertex, count};

/// Reflections before paths that carry little may end by chance.
const CERTAIN: u32 = 4;

impl<'a> Shader<'a> {
    /// The light of other surfaces that a surface gives back, along one path of at most [`Shader::bounces`] reflections.
    pub(crate) fn bounced(&self, vertex: &Vertex<'a>, sample: &Sample<'_>) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut through = Vec3::ONE;
        let mut next = self.scatter(vertex, sample, 0);
        for depth in 1..=self.bounces {
            let Some((spot, direction, weight)) = next else { break };
            through *= weight;
            count(&sample.counts.bounce_rays);
            let Some(vertex) = self.meet(&spot, direction, sample, depth) else {
                return sum + through * self.sky.map_or(self.environment, |sky| sky.radiance(direction));
            };
            sum += through * self.outgoing(&vertex, sample, depth);
            if depth < self.bounces {
                next = self.scatter(&vertex, sample, depth);
            }
        }
        sum
    }

    /// A direction from which light is reflected to the viewer, and how much of it; `None` where that is nothing.
    fn scatter(&self, vertex: &Vertex<'_>, sample: &Sample<'_>, depth: u32) -> Option<(Spot, Vec3, Vec3)> {
        if !vertex.surface.is_lit() {
            return None;
        }
        let spot = vertex.spot;
        let diffuse = vertex.texel * vertex.surface.diffuse;
        let specular = if vertex.surface.is_glossy() { vertex.texel * vertex.surface.specular } else { Vec3::ZERO };
        // What would give back more light than it gets gives back all of it.
        let most = (diffuse + specular).max_element().max(1.0);
        let (diffuse, specular) = (diffuse / most, specular / most);
        let total = diffuse.element_sum() + specular.element_sum();
        if !(total > 0.0) {
            return None;
        }
        let choice = sample.point(depth, Purpose::Choice);
        let survival = if depth < CERTAIN { 1.0 } else { (diffuse + specular).max_element() };
        if choice.y >= survival {
            return None;
        }
        let at = sample.point(depth, Purpose::Direction);
        let share = diffuse.element_sum() / total;
        let (direction, weight) = if choice.x < share {
            (cosine_direction(spot.normal, at), diffuse / share)
        } else {
            let exponent = vertex.surface.exponent;
            let mirrored = 2.0 * spot.normal.dot(spot.view) * spot.normal - spot.view;
            let direction = lobe_direction(mirrored.try_normalize()?, exponent, at);
            // The lobe (n + 2)/2π cosⁿ times the cosine with the normal, over the density (n + 1)/2π cosⁿ.
            let cosine = spot.normal.dot(direction).max(0.0);
            (direction, specular * (cosine * (exponent + 2.0) / (exponent + 1.0) / (1.0 - share)))
        };
        (direction.dot(spot.lift) > 0.0).then_some((spot, direction, weight / survival))
    }

    /// The surface that a ray from a spot meets; a transparent one by the chance of its alpha.
    fn meet(&self, from: &Spot, direction: Vec3, sample: &Sample<'_>, depth: u32) -> Option<Vertex<'a>> {
        let ray = Ray::new(from.origin(), direction);
        let mut hits = Hits::new();
        let mut last = None;
        let mut layer = 0;
        loop {
            self.geometry.collect(&ray, (0.0, f32::INFINITY), last, &mut hits);
            for hit in hits.as_slice() {
                let Some(vertex) = self.vertex(direction, hit, [Vec3::ZERO; 2]) else { continue };
                if vertex.alpha >= 1.0 || sample.point(depth, Purpose::Transparency(layer)).x < vertex.alpha {
                    return Some(vertex);
                }
                layer += 1;
            }
            last = hits.as_slice().last().copied();
            if !hits.may_go_on() {
                return None;
            }
        }
    }
}
