//! Checks of objects and their triangles.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use glam::Vec3;

use super::{Findings, Part, counted, object_subject};
use crate::Document;
use crate::document::{Faces, Flagged, Layer, MaterialBody, Object, SingleMaterial};
use crate::meaning::{Bounds, Materials, face_normal};

/// Above this tessellation factor a triangle becomes more than 4096.
const LARGE_TESSELLATION: u32 = 64;
/// Positions should resolve at least this fraction of an object's size.
const RESOLUTION: f32 = 1e-4;

pub(super) fn check(document: &Document, findings: &mut Findings) {
    let objects = document.objects();
    let materials = Materials::of(document);
    let ids: BTreeMap<i32, usize> =
        objects.iter().enumerate().rev().map(|(index, object)| (object.id, index)).collect();
    let mut seen_ids = BTreeSet::new();
    let mut seen_names = BTreeSet::new();
    for (index, object) in objects.iter().enumerate() {
        let part = Part::Object { frame: 0, index };
        let subject = object_subject(object);
        if !seen_ids.insert(object.id) {
            findings.add(part, &subject, "object/duplicate-id", format!("another object has id {}", object.id));
        }
        if object.name.is_empty() {
            findings.add(part, &subject, "object/empty-name", "it has no name");
        } else if !seen_names.insert(&object.name) {
            findings.add(part, &subject, "object/duplicate-name", "another object has the same name");
        }
        if object.parent != -1 && !ids.contains_key(&object.parent) {
            findings.add(
                part,
                &subject,
                "object/missing-parent",
                format!("there is no object {} to be its parent", object.parent),
            );
        }
        check_material(document, part, &subject, object, findings);
        check_vertices(part, &subject, object, findings);
        check_skin(part, &subject, object, &ids, findings);
        match &object.faces {
            Some(faces) if !faces.triangles.is_empty() => {
                check_faces(part, &subject, object, faces, findings);
                check_layers(&materials, part, &subject, object, faces, findings);
            }
            _ => findings.add(part, &subject, "object/empty", "it has no triangles"),
        }
        check_displacement(document, part, &subject, object, findings);
        if !document.geometry.smoothing_groups
            && object.faces.iter().flat_map(|faces| &faces.triangles).any(|triangle| triangle.smoothing != 0)
        {
            let message = "its triangles have smoothing numbers, but `SmGEnabled` is missing";
            findings.add(part, &subject, "geometry/smoothing-ignored", message);
        }
    }
    check_cycles(objects, &ids, findings);
}

fn check_cycles(objects: &[Object], ids: &BTreeMap<i32, usize>, findings: &mut Findings) {
    // 0 unseen, 1 on the way up, 2 known to end at a root.
    let mut state = vec![0u8; objects.len()];
    for start in 0..objects.len() {
        let mut path = Vec::new();
        let mut at = start;
        loop {
            if state[at] == 1 {
                let part = Part::Object { frame: 0, index: at };
                let message = format!("object {} is its own ancestor", objects[at].id);
                findings.add(part, object_subject(&objects[at]), "object/parent-cycle", message);
            }
            if state[at] != 0 {
                break;
            }
            state[at] = 1;
            path.push(at);
            match ids.get(&objects[at].parent) {
                Some(&parent) if objects[at].parent != -1 => at = parent,
                _ => break,
            }
        }
        for index in path {
            state[index] = 2;
        }
    }
}

fn check_material(document: &Document, part: Part, subject: &str, object: &Object, findings: &mut Findings) {
    let Ok(index) = usize::try_from(object.material) else {
        if object.material != -1 {
            findings.add(
                part,
                subject,
                "object/material-missing",
                format!("MatID is {}, neither -1 nor a material", object.material),
            );
        }
        return;
    };
    let Some(material) = document.materials.get(index) else {
        let message = format!("MatID is {index}, and the file has {}", counted(document.materials.len(), "material"));
        findings.add(part, subject, "object/material-missing", message);
        return;
    };
    if let (MaterialBody::Multi(subs), Some(faces)) = (&material.body, &object.faces) {
        let numbers: BTreeSet<i32> = subs.iter().map(|sub| sub.number).collect();
        let wrong: BTreeSet<i32> = faces
            .groups
            .iter()
            .filter(|group| group.triangles > 0)
            .map(|group| group.id)
            .filter(|id| !numbers.contains(id))
            .collect();
        if !wrong.is_empty() {
            let named: Vec<String> = wrong.iter().take(5).map(i32::to_string).collect();
            let more = if wrong.len() > named.len() { " …" } else { "" };
            let message = format!("`NEWGROUP:` {}{more} is no sub-material of {:?}", named.join(", "), material.name);
            findings.add(part, subject, "geometry/group", message);
        }
    }
}

fn check_vertices(part: Part, subject: &str, object: &Object, findings: &mut Findings) {
    if let Some(colors) = &object.colors {
        let outside = colors.iter().filter(|rgb| rgb.iter().any(|value| !(0.0..=1.0).contains(value))).count();
        if outside > 0 {
            let message = format!("{} outside [0, 1]", counted(outside, "vertex colour"));
            findings.add(part, subject, "geometry/vertex-color-range", message);
        }
    }
    if let Some(bounds) = Bounds::of(object.vertices.iter().map(|&vertex| Vec3::from(vertex))) {
        let size = (bounds.max - bounds.min).max_element();
        let reach = bounds.max.abs().max(bounds.min.abs()).max_element();
        if size > 0.0 && reach * f32::EPSILON > size * RESOLUTION {
            let message = format!("it is {size} in size and reaches {reach} from the origin");
            findings.add(part, subject, "geometry/far-from-origin", message);
        }
    }
}

fn check_skin(part: Part, subject: &str, object: &Object, ids: &BTreeMap<i32, usize>, findings: &mut Findings) {
    let Flagged::Yes(skin) = &object.skin else { return };
    let missing: BTreeSet<i32> =
        skin.weights.iter().map(|&(bone, _)| bone).filter(|bone| !ids.contains_key(bone)).collect();
    if let Some(bone) = missing.first() {
        let message = format!("bone {bone} is no object ({} in all)", counted(missing.len(), "such bone"));
        findings.add(part, subject, "geometry/skin-bone", message);
    }
    let mut weights = skin.weights.iter();
    let bad = skin
        .rows
        .iter()
        .filter(|&&(_, count)| {
            let (mut sum, mut negative) = (0.0, false);
            for &(_, weight) in weights.by_ref().take(count as usize) {
                sum += weight;
                negative |= weight < 0.0;
            }
            count > 0 && (negative || (sum - 1.0f32).abs() > 1e-3)
        })
        .count();
    if bad > 0 {
        let message = format!("{} whose weights are negative or do not sum to 1", counted(bad, "row"));
        findings.add(part, subject, "geometry/skin-weights", message);
    }
}

fn check_faces(part: Part, subject: &str, object: &Object, faces: &Faces, findings: &mut Findings) {
    let corner = |index: u32| Vec3::from(object.vertices[index as usize]);
    let mut used = vec![false; object.vertices.len()];
    let mut seen = HashSet::with_capacity(faces.triangles.len());
    let (mut degenerate, mut duplicate) = (0, 0);
    for triangle in &faces.triangles {
        let [a, b, c] = triangle.vertices;
        for index in [a, b, c] {
            used[index as usize] = true;
        }
        if a == b || b == c || c == a || face_normal(corner(a), corner(b), corner(c)).is_none() {
            degenerate += 1;
        }
        let rotation = if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        };
        duplicate += usize::from(!seen.insert(rotation));
    }
    let unused = used.iter().filter(|used| !**used).count();
    let counts = [
        (degenerate, "geometry/degenerate-triangle", "triangle", "without area"),
        (duplicate, "geometry/duplicate-triangle", "triangle", "that repeat another"),
        (unused, "geometry/unused-vertex", "vertex", "that no triangle uses"),
    ];
    for (count, code, one, what) in counts {
        if count > 0 {
            let noun = if one == "vertex" && count > 1 { format!("{count} vertices") } else { counted(count, one) };
            findings.add(part, subject, code, format!("{noun} {what}"));
        }
    }
    if let Some(normals) = &faces.normals {
        let lengths = || normals.iter().map(|&normal| Vec3::from(normal).length());
        let zero = lengths().filter(|&length| length == 0.0).count();
        let off = lengths().filter(|&length| length > 0.0 && (length - 1.0).abs() > 1e-3).count();
        if zero > 0 {
            findings.add(
                part,
                subject,
                "geometry/zero-normal",
                format!("{} of N_List of length 0", counted(zero, "normal")),
            );
        }
        if off > 0 {
            findings.add(
                part,
                subject,
                "geometry/normal-length",
                format!("{} of N_List not of length 1", counted(off, "normal")),
            );
        }
    }
}

/// A triangle has one `TI:` for each layer of its material.
fn check_layers(
    materials: &Materials,
    part: Part,
    subject: &str,
    object: &Object,
    faces: &Faces,
    findings: &mut Findings,
) {
    let mut triangle = 0;
    let mut wrong = 0;
    let mut example = (0, 0);
    for group in &faces.groups {
        let Some(leaf) = materials.lookup(object.material, group.id).leaf() else {
            triangle += group.triangles;
            continue;
        };
        let expected = materials.leaves()[leaf].layers.iter().flatten().count();
        for _ in 0..group.triangles {
            let found = faces.tex_counts.of(triangle);
            if found != expected {
                wrong += 1;
                example = (found, expected);
            }
            triangle += 1;
        }
    }
    if wrong > 0 {
        let (found, expected) = example;
        let message = format!(
            "{} with {found} `TI:` where the material has {}",
            counted(wrong, "triangle"),
            counted(expected, "layer")
        );
        findings.add(part, subject, "geometry/layer-count", message);
    }
}

fn check_displacement(document: &Document, part: Part, subject: &str, object: &Object, findings: &mut Findings) {
    let map =
        usize::try_from(object.material).ok().and_then(|index| document.materials.get(index)).is_some_and(|material| {
            any_single(&material.body, &|single| single.layers[Layer::Displacement as usize].as_ref().is_some())
        });
    let Some(displacement) = &object.displacement else {
        if map && object.faces.as_ref().is_some_and(|faces| !faces.triangles.is_empty()) {
            let message = "its material has a displacement map, but the object has no `TF BI SC`";
            findings.add(part, subject, "geometry/map-without-displacement", message);
        }
        return;
    };
    if !map {
        let message = "it has `TF BI SC`, but its material has no displacement map";
        findings.add(part, subject, "geometry/displacement-without-map", message);
    }
    if displacement.tessellation > LARGE_TESSELLATION {
        let message = format!("TF is {}, above {LARGE_TESSELLATION}", displacement.tessellation);
        findings.add(part, subject, "geometry/large-tessellation", message);
    }
    let mut groups = object.faces.iter().flat_map(|faces| &faces.triangles).map(|triangle| triangle.smoothing);
    if let Some(first) = groups.next()
        && groups.any(|group| group != first)
    {
        let message = "it is displaced and has more than one smoothing group";
        findings.add(part, subject, "geometry/displaced-hard-edges", message);
    }
}

fn any_single(body: &MaterialBody, test: &impl Fn(&SingleMaterial) -> bool) -> bool {
    match body {
        MaterialBody::Single(single) => test(single),
        MaterialBody::Multi(subs) => subs.iter().any(|sub| any_single(&sub.body, test)),
    }
}
