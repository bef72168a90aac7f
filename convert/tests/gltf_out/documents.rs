//! Documents made in code, one for each thing that the exporter does.

use aam::Document;
use aam::document::*;

/// A single material.
pub(crate) fn single(name: &str, edit: impl FnOnce(&mut SingleMaterial)) -> Material {
    let mut single = SingleMaterial {
        class: "Standard".into(),
        ambient: [0.6, 0.5, 0.4],
        diffuse: [0.6, 0.5, 0.4],
        specular: [0.5; 3],
        shininess: 0.25,
        layers: [Flagged::No, Flagged::No, Flagged::Omitted, Flagged::Omitted],
        ..SingleMaterial::default()
    };
    edit(&mut single);
    Material { number: 0, name: name.into(), body: MaterialBody::Single(Box::new(single)), unknown: Vec::new() }
}

/// A material whose parts are chosen by group.
pub(crate) fn multi(name: &str, subs: Vec<Material>) -> Material {
    let subs = subs.into_iter().enumerate().map(|(number, sub)| Material { number: number as i32, ..sub }).collect();
    Material { number: 0, name: name.into(), body: MaterialBody::Multi(subs), unknown: Vec::new() }
}

/// Puts a texture into a layer.
pub(crate) fn texture(single: &mut SingleMaterial, layer: Layer, file: &str, edit: impl FnOnce(&mut Texture)) {
    let mut texture = Texture::new(file);
    edit(&mut texture);
    single.layers[layer as usize] = Flagged::Yes(Box::new(texture));
}

const SIDES: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// A box of given half sizes around a point: two triangles a side, every side flat. Each side has a cell of its own in a
/// 3 × 2 atlas, written once for each of `layers` layers.
pub(crate) fn block(id: i32, name: &str, center: [f32; 3], half: [f32; 3], layers: u8) -> Object {
    let corner = |at: u32, axis: usize| {
        let sign = if at >> axis & 1 == 0 { -1.0 } else { 1.0 };
        center[axis] + sign * half[axis]
    };
    let vertices = (0..8).map(|at| [corner(at, 0), corner(at, 1), corner(at, 2)]).collect();
    let mut faces = Faces { tex_counts: TexCounts::Uniform(layers), ..Faces::default() };
    for (side, [a, b, c, d]) in SIDES.into_iter().enumerate() {
        let (u, v) = ((side % 3) as f32 / 3.0, (side / 3) as f32 / 2.0);
        let first = faces.tex_coords.len() as u32;
        let (w, h) = (0.3, 0.45);
        faces.tex_coords.extend([[u, v], [u + w, v], [u + w, v + h], [u, v + h]]);
        for (vertices, at) in [([a, b, c], [0, 1, 2]), ([a, c, d], [0, 2, 3])] {
            faces.triangles.push(Triangle { vertices, smoothing: 1 << side });
            for _ in 0..layers {
                faces.tex_indices.push(at.map(|at| first + at));
            }
        }
    }
    faces.groups = vec![Group { id: 0, triangles: 12 }];
    Object { id, name: name.into(), parent: -1, material: 0, vertices, faces: Some(faces), ..Object::default() }
}

/// A ball of rings and sectors, one smoothing group, without texture coordinates.
pub(crate) fn ball(id: i32, name: &str, radius: f32) -> Object {
    const RINGS: u32 = 6;
    const SECTORS: u32 = 8;
    let mut vertices = vec![[0.0, 0.0, radius], [0.0, 0.0, -radius]];
    for ring in 1..RINGS {
        for sector in 0..SECTORS {
            let (polar, turn) =
                (ring as f32 * std::f32::consts::PI / RINGS as f32, sector as f32 * std::f32::consts::FRAC_PI_4);
            vertices.push([radius * polar.sin() * turn.cos(), radius * polar.sin() * turn.sin(), radius * polar.cos()]);
        }
    }
    let at = |ring: u32, sector: u32| match ring {
        0 => 0,
        RINGS => 1,
        _ => 2 + (ring - 1) * SECTORS + sector % SECTORS,
    };
    let mut faces = Faces::default();
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let (a, b) = (at(ring, sector), at(ring, sector + 1));
            let (c, d) = (at(ring + 1, sector), at(ring + 1, sector + 1));
            if ring + 1 < RINGS {
                faces.triangles.push(Triangle { vertices: [a, c, d], smoothing: 1 });
            }
            if ring > 0 {
                let d = if ring + 1 < RINGS { d } else { 1 };
                faces.triangles.push(Triangle { vertices: [a, d, b], smoothing: 1 });
            }
        }
    }
    faces.groups = vec![Group { id: 0, triangles: faces.triangles.len() }];
    Object { id, name: name.into(), parent: -1, material: 0, vertices, faces: Some(faces), ..Object::default() }
}

/// A document of one frame.
pub(crate) fn document(materials: Vec<Material>, objects: Vec<Object>) -> Document {
    Document {
        header: Some(Header::Mesh),
        materials,
        geometry: Geometry {
            smoothing_groups: true,
            frames: vec![Frame { objects, ..Frame::default() }],
            ..Geometry::default()
        },
        ..Document::default()
    }
}

/// Two blocks and a ball, one below the other, and an object without triangles.
pub(crate) fn hierarchy() -> Document {
    let mut child = ball(7, "Kugel", 0.5);
    child.parent = 3;
    child.user_properties = Some("weight = 3".into());
    let mut empty = Object { id: 9, name: "helper".into(), parent: 7, material: -1, ..Object::default() };
    empty.faces = Some(Faces::default());
    let mut plain = block(4, "no material", [3.0, 0.0, 0.0], [0.5; 3], 0);
    plain.material = -1;
    let root = block(3, "root block", [0.0, 1.0, 2.0], [1.0, 2.0, 3.0], 0);
    document(
        vec![single("matt", |single| single.shininess = 0.0), single("glossy", |_| {})],
        vec![empty, child, root, plain],
    )
}

/// A character: an arm of three parts, one mirrored, one scaled, moved by keys of several kinds.
pub(crate) fn character() -> Document {
    let node = |position: [f32; 3]| Some(NodeTransform { position, ..NodeTransform::default() });
    let mut upper = block(0, "upper", [0.0, 0.0, 1.0], [0.2, 0.2, 1.0], 0);
    upper.node = node([0.0, 0.0, 0.5]);
    let sample = |frame: f32, angle: f32| RotationSample { frame, axis: [0.0, 1.0, 0.0], angle };
    upper.keys =
        Flagged::Yes(vec![Track::RotationSampled((0..=10).map(|at| sample(at as f32, 0.1 * at as f32)).collect())]);
    let mut lower = block(1, "lower", [0.0, 0.0, 0.75], [0.15, 0.15, 0.75], 0);
    lower.parent = 0;
    lower.node = Some(NodeTransform { position: [0.0, 0.1, 2.0], scale: [1.0, 2.0, 0.5], ..NodeTransform::default() });
    let position = |frame: f32, z: f32| PositionSample { frame, position: [0.0, 0.1, z] };
    lower.keys =
        Flagged::Yes(vec![Track::PositionSampled(vec![position(0.0, 2.0), position(5.0, 2.5), position(10.0, 2.0)])]);
    let mut hand = block(2, "hand", [0.1, 0.2, 0.3], [0.1, 0.2, 0.3], 0);
    hand.parent = 1;
    let turned = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    hand.node =
        Some(NodeTransform { mirrored: true, rotation: turned, position: [0.0, 0.0, 1.5], ..NodeTransform::default() });
    hand.keys = Flagged::No;
    let mut document = document(vec![single("skin", |_| {})], vec![upper, lower, hand]);
    document.header = Some(Header::Character);
    document.geometry.animation = AnimationMode::Keyframe;
    document.geometry.frames_per_second = Some(25.0);
    document
}

/// Four frames of a ball that is pulled long and sheared, beside a block that stays.
pub(crate) fn multiframe() -> Document {
    let still = block(1, "still", [2.0, 0.0, 0.0], [0.5; 3], 0);
    let mut document = document(vec![single("rubber", |_| {})], vec![ball(0, "ball", 1.0), still.clone()]);
    document.header = Some(Header::MeshMultiframe);
    document.geometry.animation = AnimationMode::Full;
    document.geometry.frames_per_second = Some(10.0);
    for number in 1..4_u8 {
        let t = f32::from(number) / 3.0;
        let mut moved = ball(0, "ball", 1.0);
        for [x, _, z] in &mut moved.vertices {
            *z *= 1.0 + t;
            *x += 0.5 * t * *z;
        }
        let objects = [moved, still.clone()].map(|object| Object { faces: None, ..object }).to_vec();
        let frame = Frame { number: number.into(), objects, unknown: Vec::new() };
        document.geometry.frames.push(frame);
    }
    document
}

/// One block of two materials, with vertex colours and explicit normals.
pub(crate) fn several_materials() -> Document {
    let mut object = block(0, "two", [0.0; 3], [1.0; 3], 0);
    let colors = (0..8).map(|at| [at as f32 / 7.0, 1.0 - at as f32 / 7.0, 0.25]).collect();
    object.colors = Some(colors);
    if let Some(faces) = &mut object.faces {
        faces.groups =
            vec![Group { id: 1, triangles: 8 }, Group { id: 0, triangles: 2 }, Group { id: 46, triangles: 2 }];
        let up = 0.5_f32.sqrt();
        faces.normals = Some(vec![[0.0, up, up], [1.0, 0.0, 0.0]]);
        faces.normal_indices = (0..12).map(|triangle| [triangle % 2; 3]).collect();
    }
    let glass = single("glass", |single| {
        single.transparency = 0.7;
        single.specular = [0.9; 3];
        single.shininess = 1.0;
    });
    let lamp = single("lamp", |single| single.emission = Some([1.5, 0.8, 0.0]));
    document(vec![multi("both", vec![glass, lamp])], vec![object])
}

/// Bodies of every mode with every shape.
pub(crate) fn physics() -> Document {
    let mut document = document(
        vec![single("stone", |_| {})],
        vec![
            block(10, "floor", [0.0, 0.0, -1.0], [5.0, 5.0, 0.5], 0),
            block(11, "crate", [0.0; 3], [0.5, 0.25, 0.75], 0),
            ball(12, "ball", 0.5),
        ],
    );
    let body = |object: i32, name: &str, mode: BodyMode| Body {
        object,
        name: name.into(),
        mode,
        static_friction: 0.6,
        dynamic_friction: 0.5,
        restitution: 0.25,
        mass: None,
        primitives: None,
        pieces: None,
        unknown: Vec::new(),
    };
    let piece = block(0, "", [0.0; 3], [0.5, 0.25, 0.75], 0);
    let triangles =
        piece.faces.as_ref().map_or_else(Vec::new, |faces| faces.triangles.iter().map(|t| t.vertices).collect());
    let floor = body(10, "floor", BodyMode::Static);
    let mut dynamic = body(11, "crate", BodyMode::Dynamic);
    dynamic.mass = Some(4.5);
    dynamic.pieces = Some(vec![Convex { number: 0, vertices: piece.vertices, triangles }]);
    let mut kinematic = body(12, "ball", BodyMode::Kinematic);
    kinematic.restitution = 0.75;
    let half = 0.5_f32.sqrt();
    kinematic.primitives = Some(vec![
        Primitive::Sphere { center: [0.0, 0.0, 0.25], radius: 0.5 },
        // Turned by a right angle about AAM's Z.
        Primitive::Box { center: [1.0, 2.0, 3.0], orientation: [0.0, 0.0, half, half], half: [0.1, 0.2, 0.3] },
        Primitive::Capsule { a: [0.0, 0.0, -1.0], b: [0.0, 0.0, 1.0], radius: 0.2 },
    ]);
    document.physics = Some(Physics { bodies: vec![floor, dynamic, kinematic], unknown: Vec::new() });
    document
}
