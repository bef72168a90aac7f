//! Where a source's setting can be trusted, and why not elsewhere.

use aam_scene::{
    Aabb, CasterFaces, DepthMetric, Members, Mesh, PcfKernel, Scene, ShadowFilter, ShadowLayout, ShadowSource, View,
};

use super::fit::{MapView, Placement, Surroundings, place};
use super::uniform::light_size;

/// What is to be said about a source's setting in a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ShadowLimit {
    /// It draws, with a fault.
    Degrades(String),
    /// It casts no shadow.
    Refuses(String),
}

impl ShadowLimit {
    /// The reason, a sentence without a full stop.
    pub fn reason(&self) -> &str {
        match self {
            Self::Degrades(reason) | Self::Refuses(reason) => reason,
        }
    }
}

/// Where the setting of the source at a position in [`aam_scene::Shadows::sources`] does not hold, as seen in a view.
/// Empty where it does.
pub fn shadow_limits(scene: &Scene, view: &View, source: usize) -> Vec<ShadowLimit> {
    let Some(shadows) = &scene.shadows else { return Vec::new() };
    let Some(source) = shadows.sources.get(source) else { return Vec::new() };
    if let Err(reason) = source.settings.check() {
        return vec![ShadowLimit::Refuses(reason)];
    }
    let all = boxes(scene, &shadows.casters.of(&scene.nodes), &shadows.receivers.of(&scene.nodes));
    let around = Surroundings { lights: &scene.lights, up: scene.up, view, boxes: &all };
    let placement = match place(source, &around) {
        Ok(placement) => placement,
        Err(reason) => return vec![ShadowLimit::Refuses(reason)],
    };
    let mut found = Vec::new();
    let case = Case { scene, view, source, placement: &placement, all: &all };
    if source.settings.technique.filter == ShadowFilter::Volume {
        found.push("edges are hard; with MSAA, pixels on outlines take the shadow of what is in their middle".into());
        if scene.materials.iter().any(|material| material.alpha_cutoff.is_some()) {
            found.push("parts that an alpha cutoff removes cast shadows".into());
        }
        return found.into_iter().map(ShadowLimit::Degrades).collect();
    }
    case.volume(&mut found);
    case.resolution(&mut found);
    case.comparisons(&mut found);
    case.moments(&mut found);
    case.casters(&mut found);
    found.into_iter().map(ShadowLimit::Degrades).collect()
}

/// World boxes of what is visible and casts or receives.
fn boxes(scene: &Scene, casts: &[bool], receives: &[bool]) -> Vec<Aabb> {
    let (world, visible) = (scene.world_transforms(), scene.visibility());
    let taking_part = |index: &usize| visible[*index] && (casts[*index] || receives[*index]);
    let aabb = |index: usize| {
        let mesh = scene.meshes.get(scene.nodes[index].mesh?.index())?;
        Some(mesh.bounds.transformed(&world[index]))
    };
    (0..scene.nodes.len()).filter(taking_part).filter_map(aabb).collect()
}

struct Case<'a> {
    scene: &'a Scene,
    view: &'a View,
    source: &'a ShadowSource,
    placement: &'a Placement,
    all: &'a [Aabb],
}

impl Case<'_> {
    fn first(&self) -> &MapView {
        &self.placement.views[0]
    }

    fn range(&self) -> f64 {
        self.first().far - self.first().near
    }

    /// The width of a texel where the scene is.
    fn texel(&self, map: &MapView) -> f64 {
        let middle = self.all.iter().fold(Aabb::EMPTY, |sum, aabb| sum.union(aabb)).center().as_dvec3();
        let depth = -map.view.transform_point3(middle).z;
        if self.placement.perspective { map.texel * depth.max(map.near) } else { map.texel }
    }

    fn volume(&self, found: &mut Vec<String>) {
        let filter = self.source.settings.technique.filter;
        if self.source.volume.is_none() || self.source.settings.technique.layout != ShadowLayout::One {
            return;
        }
        let shadows = self.scene.shadows.as_ref();
        found.extend(shadows.and_then(|shadows| shadows.cut_casters(self.scene, self.source)));
        if filter.has_moments() && self.placement.perspective && self.source.settings.metric != DepthMetric::Planar {
            let reach = self.all.iter().flat_map(corners).map(|corner| corner.distance(self.placement.origin));
            if reach.fold(0.0, f64::max) > self.first().far {
                found.push(
                    "surfaces farther than `far` from the source are lit, also in the corners of its volume".into(),
                );
            }
        }
    }

    fn resolution(&self, found: &mut Vec<String>) {
        let settings = &self.source.settings;
        let camera = &self.view.camera;
        let middle = self.all.iter().fold(Aabb::EMPTY, |sum, aabb| sum.union(aabb)).center();
        let distance = camera.position.distance(middle).max(camera.near);
        let across = match camera.projection {
            aam_scene::Projection::Perspective { fov_y } => 2.0 * distance * (0.5 * fov_y).tan(),
            aam_scene::Projection::Orthographic { height } => height,
        };
        let pixel = f64::from(across) / f64::from(self.view.height.max(1));
        let texel = self.texel(self.first());
        if settings.technique.filter == ShadowFilter::Hard && texel > pixel {
            found.push(format!(
                "a texel is {:.1} pixels wide in the middle of the scene: edges are stairs",
                texel / pixel
            ));
        }
        if settings.technique.layout == ShadowLayout::Cascades
            && settings.technique.filter != ShadowFilter::Hard
            && let Some(last) = self.placement.views.last().filter(|last| last.radius < 0.5)
        {
            found.push(format!(
                "the kernel of the first cascade is {:.2} texels in the last: penumbras are wider there",
                last.radius
            ));
        }
    }

    fn comparisons(&self, found: &mut Vec<String>) {
        let settings = &self.source.settings;
        let filter = settings.technique.filter;
        if !filter.compares() {
            return;
        }
        let biased = settings.bias > 0.0 || settings.normal_offset > 0.0;
        if settings.slope_bias < 1.0 && settings.faces != CasterFaces::Back {
            let angle = if biased {
                // (w/√2) tan θ ≤ bias.
                let bound = f64::from(settings.bias) / (self.texel(self.first()) * self.kernel_reach());
                format!("steeper than {:.0} degrees", bound.atan().to_degrees())
            } else {
                "at any angle".into()
            };
            found.push(format!("lit surfaces {angle} to the light darken themselves: slope_bias is below 1"));
        }
        if settings.bias > 0.0 {
            found.push(format!(
                "casters nearer than {} m along the light to what they shade lose their shadow",
                settings.bias
            ));
        }
        if settings.bits < 24 {
            let step = self.range() / (2.0_f64.powi(settings.bits as i32) - 1.0);
            if step > 0.1 * self.texel(self.first()) {
                found.push(format!("a step of depth is {step:.2e} m, of which biases have to make up for one"));
            }
        }
        if filter == ShadowFilter::Pcf && settings.kernel == PcfKernel::Box && settings.radius > 1 {
            found.push(format!("penumbras show {} bands", 2 * settings.radius + 2));
        }
        if filter == ShadowFilter::Pcss {
            let light = self.source.light.and_then(|light| self.scene.lights.get(light));
            if light_size(settings, light) == 0.0 {
                found.push("the light has no size, so that all penumbras are a texel wide".into());
            }
            found.push("blockers at several depths count as one at their mean depth".into());
        }
    }

    /// Half the diagonal of the kernel in texels.
    fn kernel_reach(&self) -> f64 {
        let radius =
            if self.source.settings.technique.filter == ShadowFilter::Hard { 0.0 } else { self.first().radius };
        2.0_f64.sqrt() * (radius + 0.5)
    }

    fn moments(&self, found: &mut Vec<String>) {
        let settings = &self.source.settings;
        let filter = settings.technique.filter;
        let (k, v) = (f64::from(settings.exponent), f64::from(settings.min_variance));
        let leak = |share: f64, filter: &str| {
            format!("casters nearer than {:.3} m to what they shade leak light: {filter}", share * self.range())
        };
        match filter {
            ShadowFilter::Esm => {
                found.push(leak(
                    3.0 / k,
                    &format!("over 5 % within 3/exponent of the range of depths, e^(−{k}·s) at a distance s"),
                ));
            }
            ShadowFilter::Vsm => {
                found.push(leak(v.sqrt(), "half at √min_variance"));
                found.push("where one shadow lies over another, up to (R/(R+2))² of the light leaks, R the ratio of the distances".into());
            }
            ShadowFilter::Evsm2 | ShadowFilter::Evsm4 => {
                found.push(leak(v.sqrt(), "half at √min_variance"));
                found.push(format!(
                    "receivers within {:.3} m under another show the upper one's penumbra",
                    2.0 / k * self.range()
                ));
                // The square of the negative warp at depth 1.
                if filter == ShadowFilter::Evsm4 && !settings.centred && v * k * k * (-2.0 * k).exp() < 1.2e-38 {
                    found.push("near the end of the volume the smallest variance is below the smallest float: min_variance does nothing there".into());
                }
            }
            ShadowFilter::Msm => found.push(leak(v.sqrt(), "half at √min_variance")),
            _ => {}
        }
        if settings.bleed_reduction > 0.0 && filter.has_moments() {
            found.push(format!("penumbras lose their darkest {:.0} %: shadows grow", 100.0 * settings.bleed_reduction));
        }
        let eroded = matches!(filter, ShadowFilter::Vsm | ShadowFilter::Esm | ShadowFilter::Evsm2);
        let partial = self.scene.shadows.as_ref().is_some_and(|shadows| shadows.casters != Members::All);
        if eroded && partial {
            found.push("shadows on receivers that do not cast are eroded by the kernel's radius".into());
        }
    }

    fn casters(&self, found: &mut Vec<String>) {
        let culls = self.scene.shadows.as_ref().is_some_and(|shadows| shadows.culling.back_faces);
        let needs_closed = self.source.settings.faces == CasterFaces::Back || culls;
        if needs_closed {
            let open: Vec<&str> =
                self.scene.meshes.iter().filter(|mesh| !is_closed(mesh)).map(|mesh| mesh.name.as_str()).collect();
            if !open.is_empty() {
                let more = if open.len() > 3 { format!(" and {} more", open.len() - 3) } else { String::new() };
                found.push(format!(
                    "meshes that are not closed cast wrong shadows: {}{more}",
                    open[..open.len().min(3)].join(", ")
                ));
            }
        }
        if self.scene.materials.iter().any(|material| material.opacity < 1.0) {
            found.push("surfaces that blend cast a full shadow where they cover at least half, else none".into());
        }
    }
}

fn corners(aabb: &Aabb) -> impl Iterator<Item = glam::DVec3> + use<> {
    let (low, high) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    (0..8).map(move |corner| {
        let pick = |bit: usize| if corner >> bit & 1 == 0 { low[bit] } else { high[bit] };
        glam::DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// Whether every edge, between positions that are equal, belongs to two triangles that run along it in opposite
/// directions.
pub(crate) fn is_closed(mesh: &Mesh) -> bool {
    let mut sums = std::collections::HashMap::new();
    let key = |index: u32| {
        mesh.positions.get(index as usize).map(|position| position.to_array().map(|c| (c + 0.0).to_bits()))
    };
    for triangle in mesh.indices.chunks_exact(3) {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (Some(a), Some(b)) = (key(triangle[a]), key(triangle[b])) else { return false };
            if a != b {
                let (edge, way) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
                *sums.entry(edge).or_insert(0) += way;
            }
        }
    }
    sums.values().all(|sum| *sum == 0)
}
