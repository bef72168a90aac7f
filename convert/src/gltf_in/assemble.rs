//! The document: objects from nodes and surfaces, in world coordinates, with local transforms, or frame by frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use aam::Text;
use aam::document::{AnimationMode, Document, Faces, Flagged, Frame, Geometry, Header, Object, Triangle};
use glam::{DAffine3, DVec3};

use crate::smoothing::Recovered;
use crate::{Asset, ImportOptions, Progress};

use super::character::{self, Places};
use super::clip::Clip;
use super::fault::{Checked, Fault};
use super::graph::Graph;
use super::log::Log;
use super::model::Model;
use super::names::Names;
use super::normals::{self, MovingNormals};
use super::palette::Palette;
use super::pose::{Placement, check_bones};
use super::stage::{Form, Moment};
use super::surface::{Surface, wound};

/// Everything that a document is made of.
pub(super) struct Assembly<'a> {
    pub model: &'a Model,
    pub graph: &'a Graph,
    pub surfaces: &'a [Option<Surface>],
    pub palette: Palette,
    /// The inverse bind matrices of each skin.
    pub inverse_binds: Vec<Vec<DAffine3>>,
    pub clip: Option<&'a Clip>,
    pub frames: usize,
    pub form: Form,
    pub options: &'a ImportOptions,
}

/// One object of the document.
#[derive(Debug)]
struct Plan {
    node: usize,
    /// The mesh that it shows.
    mesh: Option<usize>,
    /// The position of its parent among the plans.
    parent: Option<usize>,
    name: String,
    /// Whether its vertices are world coordinates even where others' are local.
    world: bool,
}

/// The places of the joints of each skin at a moment.
type Bones = BTreeMap<usize, Arc<[DAffine3]>>;

/// What explicit normals cost, over all objects.
#[derive(Debug, Default)]
struct NormalCosts {
    corners: usize,
    off: usize,
    objects: usize,
    bytes: u64,
    worst: f32,
}

impl NormalCosts {
    fn add(&mut self, found: &Recovered) {
        self.corners += found.corners;
        self.off += found.corners_off;
        self.worst = self.worst.max(found.worst_degrees);
        self.objects += usize::from(found.explicit.is_some());
        self.bytes += found.explicit_bytes;
    }

    fn report(&self, tolerance: f32, log: &mut Log) {
        if self.corners == 0 {
            return;
        }
        if self.objects == 0 {
            let note = format!("smoothing groups give all {} authored normals back within {tolerance}°", self.corners);
            log.kept("", "normals", note);
            return;
        }
        let note = format!(
            "smoothing groups miss {} of {} authored normals by more than {tolerance}° (at worst {:.1}°), so {} objects carry explicit normals",
            self.off, self.corners, self.worst, self.objects
        );
        log.changed("", "normals", note, Some(format!("{} bytes of text", self.bytes)));
    }
}

impl Assembly<'_> {
    /// Makes the document, and gives the box around frame 0 in world coordinates.
    pub(super) fn document(
        mut self,
        moment: &mut Moment,
        asset: &mut Asset,
        log: &mut Log,
        progress: &dyn Progress,
    ) -> Checked<Option<[DVec3; 2]>> {
        let places = match self.form {
            Form::Character => Some(character::places(self.model, self.graph, moment, log)),
            Form::Static | Form::Full => None,
        };
        let plans = self.plans(log);
        let mut frame = self.first_frame(&plans, places.as_ref(), moment, log, progress)?;
        if let (Some(places), Some(clip)) = (&places, self.clip) {
            let driven = clip.moving(&places.rest);
            let keys = character::keys(self.graph, clip, places, &driven, self.frames, self.options.frames_per_second);
            for (object, plan) in frame.objects.iter_mut().zip(&plans) {
                let tracks = if plan.world { None } else { keys.get(&plan.node) };
                object.keys = tracks.map_or(Flagged::No, |tracks| Flagged::Yes(tracks.clone()));
            }
        }
        let bounds = bounds(&frame, &plans, places.as_ref(), moment);
        let mut document = Document { materials: std::mem::take(&mut self.palette.materials), ..Document::default() };
        document.header = Some(match self.form {
            Form::Static => Header::Mesh,
            Form::Character => Header::Character,
            Form::Full => Header::MeshMultiframe,
        });
        let animated = self.clip.is_some() && self.form != Form::Static;
        let rate = self.options.frames_per_second;
        document.geometry = Geometry {
            smoothing_groups: true,
            animation: match self.form {
                _ if !animated => AnimationMode::None,
                Form::Full => AnimationMode::Full,
                Form::Character | Form::Static => AnimationMode::Keyframe,
            },
            frames_per_second: (animated && rate != 30.0).then_some(rate),
            animation_frames: if animated { self.frames as u32 } else { 1 },
            frames: vec![frame],
            unknown: Vec::new(),
        };
        if self.form == Form::Full
            && let Some(clip) = self.clip
        {
            self.later_frames(&plans, clip, moment, &mut document, progress)?;
        }
        self.count(&document, log);
        asset.document = document;
        Ok(bounds)
    }

    fn count(&self, document: &Document, log: &mut Log) {
        let objects = document.objects();
        let triangles: usize =
            objects.iter().filter_map(|object| object.faces.as_ref()).map(|f| f.triangles.len()).sum();
        let vertices: usize = objects.iter().map(|object| object.vertices.len()).sum();
        let note = format!("{} objects, {triangles} triangles, {vertices} vertices", objects.len());
        log.kept("", "geometry", note);
        if let Some(clip) = self.clip.filter(|_| self.form != Form::Static) {
            let form = if self.form == Form::Full { "vertices frame by frame" } else { "keys" };
            let note = format!(
                "{:?} of {:.3} s as {form}, {} frames at {} a second",
                clip.name, clip.duration, self.frames, self.options.frames_per_second
            );
            log.changed("", "animation", note, None);
        }
    }

    /// The objects, parents before children.
    fn plans(&self, log: &mut Log) -> Vec<Plan> {
        let shown = |node: usize| {
            self.model.nodes[node].mesh.filter(|&mesh| self.surfaces.get(mesh).is_some_and(Option::is_some))
        };
        // In world coordinates an empty object means nothing but what hangs on it.
        let mut wanted = vec![self.form == Form::Character; self.model.nodes.len()];
        for &node in self.graph.scene.iter().rev() {
            wanted[node] |= shown(node).is_some();
            if let (true, Some(parent)) = (wanted[node], self.graph.parents[node]) {
                wanted[parent] = true;
            }
        }
        let mut names = Names::default();
        let mut plans: Vec<Plan> = Vec::new();
        let mut plan_of: Vec<Option<usize>> = vec![None; self.model.nodes.len()];
        let mut dropped = Vec::new();
        for &node in &self.graph.scene {
            let own = &self.model.nodes[node];
            let mesh = shown(node);
            let mesh_name = own.mesh.and_then(|mesh| self.model.meshes[mesh].name.as_deref());
            let name = own.name.as_deref().or(mesh_name).map_or_else(|| format!("node {node}"), str::to_owned);
            if !wanted[node] {
                dropped.push(name);
                continue;
            }
            // glTF ignores the place of a skinned mesh's own node; its children keep it.
            let skinned = self.form == Form::Character && own.skin.is_some() && mesh.is_some();
            let parent = self.graph.parents[node].and_then(|parent| plan_of[parent]);
            plan_of[node] = Some(plans.len());
            if skinned && own.children.is_empty() {
                plans.push(Plan { node, mesh, parent: None, name: names.unique(&name, ""), world: true });
                continue;
            }
            let own_mesh = mesh.filter(|_| !skinned);
            plans.push(Plan { node, mesh: own_mesh, parent, name: names.unique(&name, ""), world: false });
            if skinned {
                let name = names.unique(&format!("{name} skin"), "");
                plans.push(Plan { node, mesh, parent: None, name, world: true });
            }
        }
        if names.changed > 0 {
            let note = format!("{} names that stood more than once got a number", names.changed);
            log.changed("", "names", note, None);
        }
        if !dropped.is_empty() {
            let few: Vec<&str> = dropped.iter().take(5).map(String::as_str).collect();
            let more = if dropped.len() > few.len() { " …" } else { "" };
            let note = format!(
                "{} without geometry are not in the document: {}{more}; --hierarchy keeps them in files that are not multiframe",
                dropped.len(),
                few.join(", ")
            );
            log.lost("", "nodes", note);
        }
        plans
    }

    /// Where a node's surface stands. `bones` keeps what was worked out for a skin at this moment.
    fn placement(&self, plan: &Plan, places: Option<&Places>, moment: &Moment, bones: &mut Bones) -> Placement {
        match self.model.nodes[plan.node].skin {
            Some(skin) => Placement::Bones(Arc::clone(bones.entry(skin).or_insert_with(|| {
                let joints = self.model.skins[skin].joints.iter().zip(&self.inverse_binds[skin]);
                joints.map(|(&joint, inverse)| moment.worlds[joint] * *inverse).collect()
            }))),
            None => Placement::Rigid(match places {
                Some(places) => DAffine3::from_mat3(places.baked[plan.node]),
                None => moment.worlds[plan.node],
            }),
        }
    }

    fn first_frame(
        &self,
        plans: &[Plan],
        places: Option<&Places>,
        moment: &Moment,
        log: &mut Log,
        progress: &dyn Progress,
    ) -> Checked<Frame> {
        progress.stage("building objects", plans.len() as u64);
        let mut costs = NormalCosts::default();
        let mut known: Vec<Option<Recovered>> = vec![None; self.surfaces.len()];
        let mut frame = Frame::default();
        let mut bones = Bones::new();
        for (id, plan) in plans.iter().enumerate() {
            let mut object = Object {
                id: id as i32,
                name: Text::from(plan.name.as_str()),
                parent: plan.parent.map_or(-1, |parent| parent as i32),
                material: -1,
                faces: Some(Faces::default()),
                ..Object::default()
            };
            object.user_properties = self.extras(plan, log);
            if let Some(places) = places {
                object.node = Some(if plan.world { Default::default() } else { places.transform(plan.node) });
                object.keys = Flagged::No;
            }
            if let Some((mesh, surface)) = plan.mesh.and_then(|mesh| Some((mesh, self.surfaces[mesh].as_ref()?))) {
                if let Some(skin) = self.model.nodes[plan.node].skin {
                    let place = format!("{}/skin", self.model.nodes[plan.node].place);
                    check_bones(surface, self.model.skins[skin].joints.len(), &place)?;
                }
                let placement = self.placement(plan, places, moment, &mut bones);
                let weights = &moment.weights[plan.node];
                object.vertices = placement.vertices(surface, weights);
                self.check_range(plan, &object.vertices)?;
                let recovered = self.recover(surface, &placement, weights, &object.vertices, &mut known[mesh]);
                costs.add(&recovered);
                self.dress(&mut object, surface, &placement, weights, recovered);
            }
            frame.objects.push(object);
            progress.step(id as u64 + 1);
        }
        costs.report(self.options.normal_tolerance, log);
        Ok(frame)
    }

    /// The extras of a node or, where it has none, of the mesh that it shows.
    fn extras(&self, plan: &Plan, log: &mut Log) -> Option<Text> {
        let node = self.model.nodes[plan.node].extras.as_deref();
        let mesh = plan.mesh.and_then(|mesh| self.model.meshes[mesh].extras.as_deref());
        if let (Some(_), Some(mesh)) = (node, mesh) {
            let note = format!("the node has extras too, and UserProp holds one text: {}", shortened(mesh));
            log.lost(&format!("mesh of {:?}", plan.name), "extras", note);
        }
        node.or(mesh).map(Text::one_line)
    }

    /// Masks and explicit normals; found once for a surface that only stands elsewhere.
    fn recover(
        &self,
        surface: &Surface,
        placement: &Placement,
        weights: &[f32],
        vertices: &[[f32; 3]],
        known: &mut Option<Recovered>,
    ) -> Recovered {
        let tolerance = self.options.normal_tolerance;
        match placement {
            Placement::Rigid(place) if surface.targets.is_empty() && normals::keeps_angles(place) => {
                let own = Placement::Rigid(DAffine3::IDENTITY);
                let found = known.get_or_insert_with(|| {
                    let vertices = own.vertices(surface, weights);
                    normals::recover(surface, &own, weights, &vertices, tolerance)
                });
                normals::moved(found, place)
            }
            _ => normals::recover(surface, placement, weights, vertices, tolerance),
        }
    }

    /// Material, faces, colours and normals of an object that stands already.
    fn dress(
        &self,
        object: &mut Object,
        surface: &Surface,
        placement: &Placement,
        weights: &[f32],
        recovered: Recovered,
    ) {
        let mirrored = placement.mirrors();
        let (material, groups) = self.palette.ids(surface);
        object.material = material;
        object.colors = surface.colors.clone();
        let mut faces = surface.faces(mirrored, |slot| groups.get(&slot).copied().unwrap_or(material));
        let masks = recovered.masks.iter().copied().chain(std::iter::repeat(0));
        faces.triangles = surface
            .vertex_triangles()
            .zip(masks)
            .map(|(vertices, smoothing)| Triangle { vertices: wound(vertices, mirrored), smoothing })
            .collect();
        if let Some(mut explicit) = recovered.explicit {
            if self.form == Form::Full {
                let moving = MovingNormals::of(surface, mirrored);
                let normals = moving.at(surface, placement, weights, &object.vertices, mirrored);
                explicit = moving.explicit(normals);
            }
            faces.normals = Some(explicit.normals);
            faces.normal_indices = explicit.indices;
        }
        object.faces = Some(faces);
    }

    fn later_frames(
        &self,
        plans: &[Plan],
        clip: &Clip,
        moment: &mut Moment,
        document: &mut Document,
        progress: &dyn Progress,
    ) -> Checked<()> {
        progress.stage("sampling the animation", self.frames as u64);
        let first = document.geometry.frames.first().cloned().unwrap_or_default();
        let mut bones = Bones::new();
        let moving: Vec<Option<(bool, MovingNormals)>> = plans
            .iter()
            .zip(&first.objects)
            .map(|(plan, object)| {
                object.faces.as_ref()?.normals.as_ref()?;
                let surface = self.surfaces[plan.mesh?].as_ref()?;
                let mirrored = self.placement(plan, None, moment, &mut bones).mirrors();
                Some((mirrored, MovingNormals::of(surface, mirrored)))
            })
            .collect();
        for number in 1..self.frames {
            moment.go_to(number as f32 / self.options.frames_per_second, clip, self.graph);
            bones.clear();
            let mut frame = Frame { number: number as i32, ..Frame::default() };
            for ((plan, original), moving) in plans.iter().zip(&first.objects).zip(&moving) {
                let mut object = Object {
                    id: original.id,
                    name: original.name.clone(),
                    parent: original.parent,
                    material: original.material,
                    ..Object::default()
                };
                if let Some(surface) = plan.mesh.and_then(|mesh| self.surfaces[mesh].as_ref()) {
                    let placement = self.placement(plan, None, moment, &mut bones);
                    let weights = &moment.weights[plan.node];
                    object.vertices = placement.vertices(surface, weights);
                    self.check_range(plan, &object.vertices)?;
                    object.frame_normals = moving
                        .as_ref()
                        .map(|(mirrored, moving)| moving.at(surface, &placement, weights, &object.vertices, *mirrored));
                }
                frame.objects.push(object);
            }
            document.geometry.frames.push(frame);
            progress.step(number as u64 + 1);
        }
        Ok(())
    }

    /// Refuses vertices that no document can hold.
    fn check_range(&self, plan: &Plan, vertices: &[[f32; 3]]) -> Checked<()> {
        if vertices.as_flattened().iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        let place = &self.model.nodes[plan.node].place;
        Err(Fault::broken(place, "what is shown here has positions that do not fit 32 bits"))
    }
}

/// The start of a long text.
fn shortened(text: &str) -> String {
    text.chars().take(120).collect()
}

/// The box around everything in the world, in AAM's axes.
fn bounds(frame: &Frame, plans: &[Plan], places: Option<&Places>, moment: &Moment) -> Option<[DVec3; 2]> {
    let mut bounds: Option<[DVec3; 2]> = None;
    for (object, plan) in frame.objects.iter().zip(plans) {
        let world = places.filter(|_| !plan.world).map(|places| places.world(plan.node, moment));
        for vertex in &object.vertices {
            let point = DVec3::from(vertex.map(f64::from));
            let point = world.map_or(point, |world| world.transform_point3(point));
            if point.is_finite() {
                let [low, high] = bounds.unwrap_or([point; 2]);
                bounds = Some([low.min(point), high.max(point)]);
            }
        }
    }
    bounds
}
