//! Makes a document out of arbitrary bytes: every byte string gives a document that can be written.

use aam::Text;
use aam::document::{
    AnimationMode, Body, BodyMode, Convex, Displacement, Document, Encoding, Faces, Flagged, Frame, Geometry, Group,
    Header, Layer, Material, MaterialBody, NodeTransform, NormalSpace, Object, Physics, PositionBezier, PositionSample,
    Primitive, RotationBezier, RotationEuler, RotationSample, RotationTcb, ScaleBezier, ScaleSample, Shading,
    SingleMaterial, Skin, TexCounts, Texture, Track, Triangle, Unknown,
};

/// Reads choices from bytes; past their end every choice is 0.
pub(crate) struct Choices<'a>(pub(crate) &'a [u8]);

impl Choices<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    fn below(&mut self, limit: usize) -> usize {
        usize::from(self.byte()) % limit.max(1)
    }

    /// Any finite f32, subnormals and -0 among them.
    fn real(&mut self) -> f32 {
        let bits = u32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()]);
        let value = f32::from_bits(bits);
        if value.is_finite() { value } else { f32::from_bits(bits & 0x807f_ffff) }
    }

    fn reals<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.real())
    }

    fn integer(&mut self) -> i32 {
        match self.byte() {
            0 => i32::MIN,
            1 => i32::MAX,
            byte => i32::from(byte) - 3,
        }
    }

    /// Text without line ends or blanks at its ends, Latin-1 bytes among it.
    fn text(&mut self) -> Text {
        let length = self.below(8);
        let bytes: Vec<u8> = (0..length)
            .map(|_| match self.byte() {
                b'\n' | b'\r' => b'?',
                byte => byte,
            })
            .collect();
        let blank = |byte: &u8| matches!(byte, b' ' | b'\t');
        let start = bytes.iter().position(|byte| !blank(byte)).unwrap_or(bytes.len());
        let end = bytes.iter().rposition(|byte| !blank(byte)).map_or(start, |last| last + 1);
        Text::from(&bytes[start..end])
    }

    fn word(&mut self) -> Text {
        let words = ["PYRAMIDAL", "BLINN", "PHONG", "METAL", "NONE"];
        words[self.below(words.len())].into()
    }

    fn list<T>(&mut self, limit: usize, mut make: impl FnMut(&mut Self) -> T) -> Vec<T> {
        let length = self.below(limit);
        (0..length).map(|_| make(self)).collect()
    }

    fn maybe<T>(&mut self, make: impl FnOnce(&mut Self) -> T) -> Option<T> {
        self.flag().then(|| make(self))
    }

    fn flagged<T>(&mut self, make: impl FnOnce(&mut Self) -> T) -> Flagged<T> {
        match self.below(3) {
            0 => Flagged::Omitted,
            1 => Flagged::No,
            _ => Flagged::Yes(make(self)),
        }
    }

    fn unknown(&mut self, before: &[&'static str]) -> Vec<Unknown> {
        if self.byte() < 200 {
            return Vec::new();
        }
        let tag = before[self.below(before.len())];
        let mut lines = vec!["Later: 1 2 x"];
        if self.flag() {
            lines.extend(["{", "Inner: Y", "}"]);
        }
        vec![Unknown { before: Some((tag, 0)), text: Text::from(lines.join("\n")) }]
    }

    pub(crate) fn document(&mut self) -> Document {
        let header =
            [None, Some(Header::Mesh), Some(Header::MeshMultiframe), Some(Header::Character), Some(Header::Avatar)];
        let materials: Vec<Material> = self.list(4, |c| c.material(0));
        let geometry = self.geometry();
        Document {
            encoding: if self.flag() { Encoding::Binary } else { Encoding::Ascii },
            header: header[self.below(header.len())],
            preamble: Vec::new(),
            materials_unknown: Vec::new(),
            materials,
            physics: self.maybe(|c| c.physics()),
            geometry,
        }
    }

    fn material(&mut self, depth: usize) -> Material {
        let body = if depth < 3 && self.byte() > 180 {
            MaterialBody::Multi(self.list(4, |c| c.material(depth + 1)))
        } else {
            MaterialBody::Single(Box::new(self.single()))
        };
        Material { number: self.integer(), name: self.text(), body, unknown: self.unknown(&["Name:", "Class:"]) }
    }

    fn single(&mut self) -> SingleMaterial {
        let mut layers = [const { Flagged::Omitted }; 4];
        for layer in Layer::ALL {
            let choice = self.flagged(|c| Box::new(c.texture(layer)));
            let always = matches!(layer, Layer::Diffuse | Layer::LightMap);
            layers[layer as usize] = if always && choice == Flagged::Omitted { Flagged::No } else { choice };
        }
        let class = self.text();
        SingleMaterial {
            class: if class == "Multi" { "Standard".into() } else { class },
            ambient: self.reals(),
            diffuse: self.reals(),
            specular: self.reals(),
            transparency: self.real(),
            shininess: self.real(),
            emission: self.maybe(Self::reals),
            shading: self.maybe(|c| Shading { wire_size: c.real(), word: c.word() }),
            layers,
            alpha_cutoff: self.maybe(Self::real),
        }
    }

    fn texture(&mut self, layer: Layer) -> Texture {
        Texture {
            file: self.text(),
            filter: self.word(),
            channel: self.maybe(Self::integer),
            intensity: self.real(),
            rotation: self.reals(),
            offset: self.reals(),
            tiling: self.reals(),
            normal_space: if layer == Layer::Normal {
                self.maybe(|c| if c.flag() { NormalSpace::Object } else { NormalSpace::Tangent })
            } else {
                None
            },
            unknown: self.unknown(&["FN:", "UA:", "VT:"]),
        }
    }

    fn geometry(&mut self) -> Geometry {
        let animation = [AnimationMode::None, AnimationMode::Full, AnimationMode::Keyframe][self.below(3)];
        let objects = self.list(4, Self::object);
        let mut frames = vec![Frame { number: 0, objects, unknown: self.unknown(&["Obj:", "Par:"]) }];
        if frames[0].objects.is_empty() {
            frames[0].unknown.clear();
        }
        if animation == AnimationMode::Full {
            for number in 1..=self.below(3) {
                let objects = frames[0].objects.clone();
                let objects = objects.into_iter().map(|object| self.later(object)).collect();
                frames.push(Frame { number: i32::try_from(number).unwrap_or(0), objects, unknown: Vec::new() });
            }
        }
        let animation_frames = match animation {
            AnimationMode::Keyframe => 1 + u32::from(self.byte()),
            _ => frames.len() as u32,
        };
        Geometry {
            smoothing_groups: self.flag(),
            animation,
            frames_per_second: self.maybe(Self::real),
            animation_frames,
            frames,
            unknown: self.unknown(&["NObj:", "NFrames:", "Frame:"]),
        }
    }

    fn later(&mut self, first: Object) -> Object {
        let normals = first.faces.as_ref().and_then(|faces| faces.normals.as_ref()).map(Vec::len);
        Object {
            id: first.id,
            name: first.name,
            parent: first.parent,
            material: first.material,
            user_properties: first.user_properties,
            vertices: first.vertices.iter().map(|_| self.reals()).collect(),
            frame_normals: normals.filter(|_| self.flag()).map(|count| (0..count).map(|_| self.reals()).collect()),
            ..Object::default()
        }
    }

    fn object(&mut self) -> Object {
        let vertices: Vec<[f32; 3]> = self.list(9, Self::reals);
        let faces = self.maybe(|c| c.faces(vertices.len()));
        Object {
            id: self.integer(),
            name: self.text(),
            parent: self.integer(),
            node: self.maybe(|c| NodeTransform {
                pivot_position: c.reals(),
                pivot_orientation: c.reals(),
                mirrored: c.flag(),
                rotation: [c.reals(), c.reals(), c.reals()],
                position: c.reals(),
                scale: c.reals(),
            }),
            material: self.integer(),
            user_properties: self.maybe(Self::text),
            displacement: self.maybe(|c| Displacement {
                tessellation: 1 + u32::from(c.byte()),
                bias: c.real(),
                scale: c.real(),
            }),
            skin: self.flagged(|c| c.skin(vertices.len())),
            colors: self.maybe(|c| vertices.iter().map(|_| c.reals()).collect()),
            faces,
            frame_normals: None,
            keys: self.flagged(|c| c.list(5, Self::track)),
            unknown: self.unknown(&["MatID:", "V_List:"]),
            vertices,
        }
    }

    fn skin(&mut self, vertices: usize) -> Skin {
        let mut skin = Skin::default();
        for _ in 0..vertices {
            let weights = self.list(4, |c| (c.integer(), c.real()));
            skin.rows.push((self.below(vertices) as u32, weights.len() as u32));
            skin.weights.extend(weights);
        }
        skin
    }

    fn indices(&mut self, limit: usize) -> [u32; 3] {
        std::array::from_fn(|_| self.below(limit) as u32)
    }

    fn faces(&mut self, vertices: usize) -> Faces {
        let tex_coords: Vec<[f32; 2]> = self.list(6, Self::reals);
        let normals: Option<Vec<[f32; 3]>> = self.maybe(|c| {
            let mut normals: Vec<[f32; 3]> = c.list(4, Self::reals);
            normals.push(c.reals());
            normals
        });
        let mut faces = Faces { tex_coords, normals, ..Faces::default() };
        let uniform = self.flag().then(|| self.below(5));
        let mut counts = Vec::new();
        for _ in 0..self.below(4) {
            let triangles = if vertices == 0 { 0 } else { self.below(4) };
            faces.groups.push(Group { id: self.integer(), triangles });
            for _ in 0..triangles {
                let smoothing = self.integer();
                faces.triangles.push(Triangle { vertices: self.indices(vertices), smoothing });
                if let Some(normals) = &faces.normals {
                    let count = normals.len();
                    faces.normal_indices.push(self.indices(count));
                }
                let layers = uniform.unwrap_or_else(|| self.below(5));
                let layers = if faces.tex_coords.is_empty() { 0 } else { layers };
                for _ in 0..layers {
                    let count = faces.tex_coords.len();
                    faces.tex_indices.push(self.indices(count));
                }
                counts.push(layers as u8);
            }
        }
        faces.tex_counts = match counts.first() {
            Some(&first) if counts.iter().all(|&count| count == first) => TexCounts::Uniform(first),
            Some(_) => TexCounts::Each(counts),
            None => TexCounts::default(),
        };
        faces
    }

    fn frame(&mut self) -> f32 {
        if self.flag() { f32::from(self.byte()) } else { self.real() }
    }

    fn track(&mut self) -> Track {
        match self.below(8) {
            0 => Track::PositionSampled(self.list(4, |c| PositionSample { frame: c.frame(), position: c.reals() })),
            1 => Track::RotationSampled(self.list(4, |c| RotationSample {
                frame: c.frame(),
                axis: c.reals(),
                angle: c.real(),
            })),
            2 => Track::ScaleSampled(self.list(4, |c| ScaleSample {
                frame: c.frame(),
                axes: c.reals(),
                scale: c.reals(),
            })),
            3 => Track::PositionBezier(self.list(4, |c| PositionBezier {
                frame: c.frame(),
                position: c.reals(),
                tangent_in: c.reals(),
                tangent_out: c.reals(),
                flag: c.integer(),
            })),
            4 => Track::RotationBezier(self.list(4, |c| RotationBezier {
                frame: c.frame(),
                euler: c.reals(),
                tangent_in: c.reals(),
                tangent_out: c.reals(),
                flag: c.integer(),
            })),
            5 => Track::ScaleBezier(self.list(4, |c| ScaleBezier {
                frame: c.frame(),
                scale: c.reals(),
                axes: c.reals(),
                tangent_in: c.reals(),
                tangent_out: c.reals(),
                flag: c.integer(),
            })),
            6 => Track::RotationTcb(self.list(4, |c| RotationTcb {
                frame: c.frame(),
                axis: c.reals(),
                angle: c.real(),
                tension: c.real(),
                continuity: c.real(),
                bias: c.real(),
                ease_in: c.real(),
                ease_out: c.real(),
            })),
            _ => Track::RotationEuler(self.list(4, |c| RotationEuler { frame: c.frame(), euler: c.reals() })),
        }
    }

    fn physics(&mut self) -> Physics {
        Physics { bodies: self.list(4, Self::body), unknown: self.unknown(&["NBody:"]) }
    }

    fn body(&mut self) -> Body {
        Body {
            object: self.integer(),
            name: self.text(),
            mode: [BodyMode::Static, BodyMode::Kinematic, BodyMode::Dynamic][self.below(3)],
            static_friction: self.real(),
            dynamic_friction: self.real(),
            restitution: self.real(),
            mass: self.maybe(Self::real),
            primitives: self.maybe(|c| {
                c.list(4, |c| match c.below(3) {
                    0 => Primitive::Box { center: c.reals(), orientation: c.reals(), half: c.reals() },
                    1 => Primitive::Sphere { center: c.reals(), radius: c.real() },
                    _ => Primitive::Capsule { a: c.reals(), b: c.reals(), radius: c.real() },
                })
            }),
            pieces: self.maybe(|c| {
                c.list(3, |c| {
                    let vertices: Vec<[f32; 3]> = c.list(6, Self::reals);
                    let count = vertices.len();
                    let triangles = if count == 0 { Vec::new() } else { c.list(5, |c| c.indices(count)) };
                    Convex { number: c.integer(), vertices, triangles }
                })
            }),
            unknown: self.unknown(&["Mode:", "Re:"]),
        }
    }
}
