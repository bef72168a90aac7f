//! Checks of bodies and their collision shapes.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec3;

use super::{Findings, Part, counted};
use crate::Document;
use crate::document::{Body, BodyMode, Convex, Primitive};

/// How far a vertex of a convex piece may lie outside one of its planes, as a fraction of the piece's diagonal.
const CONVEXITY: f64 = 1e-4;
/// Vertices of a piece that GPU solvers take.
const FEW_VERTICES: usize = 64;
/// Vertices of a piece that common engines take.
const MOST_VERTICES: usize = 255;

pub(super) fn check(document: &Document, findings: &mut Findings) {
    let Some(physics) = &document.physics else { return };
    let objects: BTreeMap<i32, _> = document.objects().iter().rev().map(|object| (object.id, object)).collect();
    let mut seen = BTreeSet::new();
    for (index, body) in physics.bodies.iter().enumerate() {
        let part = Part::Body(index);
        let subject = format!("body {} {:?}", body.object, body.name);
        if !seen.insert(body.object) {
            findings.add(part, &subject, "physics/duplicate-body", "its object has a body already");
        }
        match objects.get(&body.object) {
            None => findings.add(part, &subject, "physics/no-object", format!("there is no object {}", body.object)),
            Some(object) => {
                if object.name != body.name {
                    let message = format!("object {} is called {:?}", object.id, object.name);
                    findings.add(part, &subject, "physics/name", message);
                }
                let empty = object.faces.as_ref().is_none_or(|faces| faces.triangles.is_empty());
                if body.mode == BodyMode::Static && empty {
                    findings.add(part, &subject, "physics/static-empty", "its object has no triangles");
                }
            }
        }
        check_body(part, &subject, body, findings);
    }
}

fn check_body(part: Part, subject: &str, body: &Body, findings: &mut Findings) {
    for (tag, friction) in [("SF", body.static_friction), ("DF", body.dynamic_friction)] {
        if !(friction >= 0.0 && friction.is_finite()) {
            findings.add(part, subject, "physics/friction", format!("{tag} is {friction}, not a number of 0 or more"));
        }
    }
    if !(0.0..=1.0).contains(&body.restitution) {
        findings.add(part, subject, "physics/restitution", format!("Re is {}, not from 0 to 1", body.restitution));
    }
    let shapes = body.pieces.as_ref().map_or(0, Vec::len) + body.primitives.as_ref().map_or(0, Vec::len);
    match (body.mode, body.mass) {
        (BodyMode::Dynamic, None) => findings.add(part, subject, "physics/mass", "`Ma:` is missing"),
        (BodyMode::Dynamic, Some(mass)) if !(mass > 0.0 && mass.is_finite()) => {
            findings.add(part, subject, "physics/mass", format!("Ma is {mass}, not above 0"));
        }
        (BodyMode::Static | BodyMode::Kinematic, Some(mass)) => {
            let message = format!("Ma is {mass}, but forces do not move this body");
            findings.add(part, subject, "physics/unused-mass", message);
        }
        _ => {}
    }
    match body.mode {
        BodyMode::Static if shapes > 0 => {
            let message = format!("it has {} of its own, but is static", counted(shapes, "shape"));
            findings.add(part, subject, "physics/static-pieces", message);
        }
        BodyMode::Kinematic | BodyMode::Dynamic if shapes == 0 => {
            findings.add(part, subject, "physics/no-shape", "it has nothing to collide with");
        }
        _ => {}
    }
    for (index, primitive) in body.primitives.iter().flatten().enumerate() {
        if let Some(message) = wrong_primitive(primitive) {
            findings.add(part, format!("{subject}, primitive {index}"), "physics/primitive", message);
        }
    }
    for piece in body.pieces.iter().flatten() {
        check_piece(part, &format!("{subject}, piece {}", piece.number), piece, findings);
    }
}

fn wrong_primitive(primitive: &Primitive) -> Option<String> {
    let sizes: &[f32] = match primitive {
        Primitive::Box { orientation, half, .. } => {
            let length = orientation.iter().map(|value| value * value).sum::<f32>().sqrt();
            if !((length - 1.0).abs() <= 1e-3) {
                return Some(format!("the quaternion {orientation:?} has length {length}"));
            }
            half
        }
        Primitive::Sphere { radius, .. } | Primitive::Capsule { radius, .. } => std::slice::from_ref(radius),
    };
    let bad = sizes.iter().find(|size| !(**size > 0.0 && size.is_finite()))?;
    Some(format!("a size is {bad}, not above 0"))
}

fn check_piece(part: Part, subject: &str, piece: &Convex, findings: &mut Findings) {
    let count = piece.vertices.len();
    if count > MOST_VERTICES {
        let message = format!("it has {count} vertices, more than {MOST_VERTICES}");
        findings.add(part, subject, "physics/too-many-vertices", message);
        // Convexity takes vertices times triangles; the piece has to be made again in any case.
        return;
    }
    if count > FEW_VERTICES {
        let message = format!("it has {count} vertices, more than {FEW_VERTICES}");
        findings.add(part, subject, "physics/piece-vertices", message);
    }
    if let Some(open) = open_edges(piece) {
        let message = format!("{} without a partner in the other direction", counted(open, "edge"));
        findings.add(part, subject, "physics/open-piece", message);
        return;
    }
    match worst_violation(piece) {
        None => findings.add(part, subject, "physics/flat-piece", "it encloses no volume"),
        Some((worst, diagonal)) if !(worst <= CONVEXITY * diagonal) => {
            let message = format!(
                "a vertex lies {worst:.3e} outside a face, {:.3e} of the diagonal where {CONVEXITY:.0e} is allowed",
                worst / diagonal
            );
            findings.add(part, subject, "physics/not-convex", message);
        }
        Some(_) => {}
    }
}

/// How many directed edges lack their opposite; `None` when the surface is closed.
fn open_edges(piece: &Convex) -> Option<usize> {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for &[a, b, c] in &piece.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from, to)).or_default() += 1;
            *edges.entry((to, from)).or_default() -= 1;
        }
    }
    let open = edges.values().filter(|balance| **balance > 0).count();
    (open > 0 || piece.triangles.is_empty()).then_some(open)
}

/// How far a vertex lies outside a face at worst, and the diagonal; `None` when there is no volume.
fn worst_violation(piece: &Convex) -> Option<(f64, f64)> {
    let points: Vec<DVec3> = piece.vertices.iter().map(|&[x, y, z]| DVec3::new(x.into(), y.into(), z.into())).collect();
    let low = points.iter().copied().reduce(DVec3::min)?;
    let high = points.iter().copied().reduce(DVec3::max)?;
    let diagonal = (high - low).length();
    let corner = |index: u32| points[index as usize] - low;
    let volume: f64 = piece.triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum();
    if !(volume.abs() > 1e-12 * diagonal.powi(3)) {
        return None;
    }
    let mut worst = f64::NEG_INFINITY;
    for &[a, b, c] in &piece.triangles {
        let (a, b, c) = (points[a as usize], points[b as usize], points[c as usize]);
        let normal = (b - a).cross(c - a);
        let length = normal.length();
        if length <= 1e-14 * diagonal * diagonal {
            continue;
        }
        for &point in &points {
            worst = worst.max((point - a).dot(normal) / length);
        }
    }
    Some((worst, diagonal))
}
