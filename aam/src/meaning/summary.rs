//! A document in numbers.

use std::collections::BTreeMap;

use glam::Vec3;
use serde::Serialize;

use crate::Document;
use crate::document::{AnimationMode, BodyMode, Encoding, Object, Track};
use crate::meaning::{Bounds, Hierarchy, Lookup, Materials, frame_range, frames_per_second, world_transforms};

/// A document in numbers, for `aam info`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// `ascii` or `binary`.
    pub encoding: &'static str,
    /// The header word, if there is one.
    pub header: Option<&'static str>,
    /// `None`, `Full` or `Keyframe`.
    pub animation: &'static str,
    /// How many frames it has: those in the file for `Full`, those from the first to the last key else, at least 1.
    pub frames: usize,
    /// Frames a second.
    pub frames_per_second: f32,
    /// From the first to the last frame, in seconds; 0 if nothing moves.
    pub duration: f32,
    /// Vertices of all objects in frame 0.
    pub vertices: usize,
    /// Triangles of all objects.
    pub triangles: usize,
    /// The box around everything in frame 0, in world coordinates.
    pub bounds: Option<Bounds>,
    /// The objects of frame 0, in file order.
    pub objects: Vec<ObjectSummary>,
    /// The single materials, Multi ones flattened, and the default material last if any triangle has it.
    pub materials: Vec<MaterialSummary>,
    /// The texture files that materials name, each once, in order of first use.
    pub textures: Vec<TextureSummary>,
    /// How many physics bodies: static, kinematic, dynamic.
    pub bodies: [usize; 3],
    /// How many convex pieces and primitives all bodies have.
    pub collision_shapes: usize,
}

/// An object in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectSummary {
    /// The id.
    pub id: i32,
    /// The name.
    pub name: String,
    /// The position of its parent in [`Summary::objects`].
    pub parent: Option<usize>,
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// The box in the object's own coordinates.
    pub bounds: Option<Bounds>,
    /// How many keys.
    pub keys: usize,
    /// Whether it has explicit normals.
    pub explicit_normals: bool,
    /// Whether it has vertex colours.
    pub vertex_colors: bool,
    /// Whether it has displacement parameters.
    pub displacement: bool,
}

/// A material in words.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialSummary {
    /// The name.
    pub name: String,
    /// Triangles that use it.
    pub triangles: usize,
    /// The Phong exponent.
    pub exponent: f32,
    /// 1 − transparency.
    pub opacity: f32,
    /// The texture file of each layer.
    pub layers: [Option<String>; 4],
}

/// A texture file that materials name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureSummary {
    /// The file as the document names it.
    pub file: String,
    /// How many material layers use it.
    pub uses: usize,
}

impl Summary {
    /// Counts a document.
    pub fn of(document: &Document) -> Self {
        let hierarchy = Hierarchy::of(document.objects());
        let range = frame_range(document);
        let (first, length) = range.map_or((0.0, 0.0), |(first, last)| (first, last - first));
        let fps = frames_per_second(document);
        let materials = Materials::of(document);
        let objects = object_summaries(document, &hierarchy);
        let world = world_transforms(document, &hierarchy, first);
        let boxes = objects.iter().zip(&world).filter_map(|(object, world)| object.bounds?.transformed(world));
        let bodies = document.physics.as_ref().map_or(&[][..], |physics| &physics.bodies);
        let of_mode = |mode| bodies.iter().filter(|body| body.mode == mode).count();
        Self {
            encoding: match document.encoding {
                Encoding::Ascii => "ascii",
                Encoding::Binary => "binary",
            },
            header: document.header.map(|header| header.word()),
            animation: document.geometry.animation.word(),
            frames: match document.geometry.animation {
                AnimationMode::Full => document.geometry.frames.len(),
                AnimationMode::None | AnimationMode::Keyframe => length as usize + 1,
            },
            frames_per_second: fps,
            duration: length / fps,
            vertices: objects.iter().map(|object| object.vertices).sum(),
            triangles: objects.iter().map(|object| object.triangles).sum(),
            bounds: boxes.reduce(Bounds::union),
            materials: material_summaries(document, &materials),
            textures: texture_summaries(&materials),
            objects,
            bodies: [BodyMode::Static, BodyMode::Kinematic, BodyMode::Dynamic].map(of_mode),
            collision_shapes: bodies
                .iter()
                .map(|body| body.pieces.as_ref().map_or(0, Vec::len) + body.primitives.as_ref().map_or(0, Vec::len))
                .sum(),
        }
    }
}

fn object_summaries(document: &Document, hierarchy: &Hierarchy) -> Vec<ObjectSummary> {
    let summary = |(object, parent): (&Object, &Option<usize>)| {
        let faces = object.faces.as_ref();
        ObjectSummary {
            id: object.id,
            name: object.name.decoded(),
            parent: *parent,
            vertices: object.vertices.len(),
            triangles: faces.map_or(0, |faces| faces.triangles.len()),
            bounds: Bounds::of(object.vertices.iter().copied().map(Vec3::from)),
            keys: object.keys.as_ref().map_or(0, |tracks| tracks.iter().map(Track::key_count).sum()),
            explicit_normals: faces.is_some_and(|faces| faces.normals.is_some()),
            vertex_colors: object.colors.is_some(),
            displacement: object.displacement.is_some(),
        }
    };
    document.objects().iter().zip(&hierarchy.parents).map(summary).collect()
}

fn material_summaries(document: &Document, materials: &Materials) -> Vec<MaterialSummary> {
    let mut triangles = vec![0; materials.leaves().len()];
    let mut without = 0;
    for object in document.objects() {
        for group in object.faces.iter().flat_map(|faces| &faces.groups) {
            match materials.lookup(object.material, group.id) {
                Lookup::Named(leaf) | Lookup::Substitute(leaf) => triangles[leaf] += group.triangles,
                Lookup::Default | Lookup::Missing => without += group.triangles,
            }
        }
    }
    let named = materials.leaves().iter().zip(triangles).map(|(leaf, triangles)| MaterialSummary {
        name: leaf.name.clone(),
        triangles,
        exponent: leaf.exponent,
        opacity: leaf.opacity,
        layers: leaf.layers.each_ref().map(|layer| layer.as_ref().map(|layer| layer.file.clone())),
    });
    let default = MaterialSummary {
        name: "(default)".to_owned(),
        triangles: without,
        exponent: 0.0,
        opacity: 1.0,
        layers: [const { None }; 4],
    };
    named.chain((without > 0).then_some(default)).collect()
}

fn texture_summaries(materials: &Materials) -> Vec<TextureSummary> {
    let mut textures: Vec<TextureSummary> = Vec::new();
    let mut place: BTreeMap<&str, usize> = BTreeMap::new();
    for layer in materials.leaves().iter().flat_map(|leaf| leaf.layers.iter().flatten()) {
        let index = *place.entry(&layer.file).or_insert_with(|| {
            textures.push(TextureSummary { file: layer.file.clone(), uses: 0 });
            textures.len() - 1
        });
        textures[index].uses += 1;
    }
    textures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{
        Flagged, Frame, Geometry, Group, Material, MaterialBody, NodeTransform, PositionSample, SingleMaterial, Texture,
    };

    #[test]
    fn a_character_is_counted_where_it_stands() {
        let mut single = SingleMaterial { shininess: 0.5, transparency: 0.25, ..SingleMaterial::default() };
        single.layers[0] = Flagged::Yes(Box::new(Texture::new("a.png")));
        single.layers[2] = Flagged::Yes(Box::new(Texture::new("a.png")));
        let body = MaterialBody::Single(Box::new(single));
        let material = Material { number: 0, name: "m".into(), body, unknown: Vec::new() };
        let faces = crate::document::Faces {
            triangles: vec![crate::document::Triangle { vertices: [0, 1, 2], smoothing: 1 }; 2],
            groups: vec![Group { id: 0, triangles: 2 }],
            ..Default::default()
        };
        let row = |frame, x| PositionSample { frame, position: [x, 0.0, 0.0] };
        let object = Object {
            id: 4,
            name: "o".into(),
            parent: -1,
            node: Some(NodeTransform::default()),
            vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 2.0]],
            faces: Some(faces),
            keys: Flagged::Yes(vec![Track::PositionSampled(vec![row(5.0, 10.0), row(35.0, 0.0)])]),
            ..Object::default()
        };
        let other = Object { id: 5, parent: 4, material: -1, ..object.clone() };
        let document = Document {
            materials: vec![material],
            geometry: Geometry {
                animation: AnimationMode::Keyframe,
                frames: vec![Frame { objects: vec![object, other], ..Frame::default() }],
                ..Geometry::default()
            },
            ..Document::default()
        };
        let summary = Summary::of(&document);
        assert_eq!((summary.vertices, summary.triangles, summary.frames), (6, 4, 31));
        assert_eq!(summary.duration, 1.0);
        assert_eq!(summary.objects[1].parent, Some(0));
        assert_eq!(summary.objects[0].keys, 2);
        let bounds = Bounds { min: Vec3::new(10.0, 0.0, 0.0), max: Vec3::new(21.0, 1.0, 2.0) };
        assert_eq!(summary.bounds, Some(bounds), "the child stands 10 further");
        assert_eq!(summary.textures, [TextureSummary { file: "a.png".into(), uses: 2 }]);
        let materials: Vec<_> = summary.materials.iter().map(|m| (m.name.as_str(), m.triangles, m.exponent)).collect();
        assert_eq!(materials, [("m", 2, 64.0), ("(default)", 2, 0.0)]);
    }

    #[test]
    fn nothing_is_counted_as_nothing() {
        let summary = Summary::of(&Document::default());
        assert_eq!((summary.frames, summary.duration, summary.bounds), (1, 0.0, None));
    }
}
