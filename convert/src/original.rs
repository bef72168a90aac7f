//! The original AAM format alone: this project's extensions taken out of a document.

use std::convert::Infallible;

use aam::Document;
use aam::document::{Flagged, Layer, Material, MaterialBody, SingleMaterial};
use aam::meaning::{Materials, SmoothingRule, object_normals};

use crate::{Report, uv_lines};

/// Takes out `TN`, `TD`, `AC`, `TF BI SC`, `N_List`, `FPS` and `PHYSICS`, and reports each that was there.
pub(crate) fn strip(document: &mut Document, report: &mut Report) {
    for_each_object(document, report, strip_normals);
    let materials = Materials::of(document);
    let mut displaced = 0;
    for frame in &mut document.geometry.frames {
        for object in &mut frame.objects {
            displaced += usize::from(object.displacement.take().is_some());
            let kept = uv_lines::rewrite(object, &materials, |triangle, lines| -> Result<(), Infallible> {
                let original = |at: &usize| triangle.layers.get(*at).is_none_or(|layer| *layer <= Layer::LightMap);
                // Without a material there may be lines all the same; the original format has two layers.
                let kept = (0..triangle.lines.len()).filter(original).take(2);
                lines.extend(kept.map(|at| triangle.lines[at]));
                Ok(())
            });
            match kept {
                Ok(()) => {}
                Err(never) => match never {},
            }
        }
    }
    if displaced > 0 {
        report.lost(
            "",
            "displacement",
            format!("TF, BI and SC of {displaced} objects are no part of the original format"),
        );
    }
    for material in &mut document.materials {
        strip_material(material, report);
    }
    if let Some(fps) = document.geometry.frames_per_second.take()
        && fps != 30.0
    {
        report.lost(
            "",
            "frame rate",
            format!("FPS is no part of the original format; {fps} frames a second become 30"),
        );
    }
    if let Some(physics) = document.physics.take() {
        report.lost(
            "",
            "physics",
            format!("PHYSICS with {} bodies is no part of the original format", physics.bodies.len()),
        );
    }
}

fn for_each_object(
    document: &mut Document,
    report: &mut Report,
    mut change: impl FnMut(&mut aam::document::Object, SmoothingRule, &mut Report),
) {
    let rule = SmoothingRule::of(document);
    for frame in &mut document.geometry.frames {
        for object in &mut frame.objects {
            change(object, rule, report);
        }
    }
}

fn strip_normals(object: &mut aam::document::Object, rule: SmoothingRule, report: &mut Report) {
    object.frame_normals = None;
    if object.faces.as_ref().is_none_or(|faces| faces.normals.is_none()) {
        return;
    }
    let explicit = object_normals(object, rule);
    if let Some(faces) = &mut object.faces {
        faces.normals = None;
        faces.normal_indices.clear();
    }
    let angles = explicit
        .as_flattened()
        .iter()
        .zip(object_normals(object, rule).as_flattened())
        .map(|(a, b)| 2.0 * (0.5 * (*a - *b).length()).min(1.0).asin().to_degrees())
        .collect::<Vec<_>>();
    let mean = angles.iter().map(|angle| f64::from(*angle)).sum::<f64>() / angles.len().max(1) as f64;
    let worst = angles.into_iter().fold(0.0, f32::max);
    report.changed(
        &format!("object \"{}\"", object.name),
        "normals",
        "explicit normals are no part of the original format; smoothing groups stand in",
        Some(format!("{mean:.2}° mean, {worst:.2}° worst")),
    );
}

fn strip_material(material: &mut Material, report: &mut Report) {
    let mut pending = vec![material];
    while let Some(material) = pending.pop() {
        match &mut material.body {
            MaterialBody::Multi(subs) => pending.extend(subs.iter_mut().rev()),
            MaterialBody::Single(single) => strip_single(&format!("material \"{}\"", material.name), single, report),
        }
    }
}

fn strip_single(subject: &str, single: &mut SingleMaterial, report: &mut Report) {
    for layer in [Layer::Normal, Layer::Displacement] {
        if let Flagged::Yes(texture) = std::mem::take(&mut single.layers[layer as usize]) {
            report.lost(
                subject,
                layer.name(),
                format!("{} {} is no part of the original format", layer.tag(), texture.file),
            );
        }
    }
    if let Some(cutoff) = single.alpha_cutoff.take() {
        report.lost(subject, "alpha cutoff", format!("AC: {cutoff} is no part of the original format"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use aam::document::*;

    #[test]
    fn nothing_of_the_extension_is_left() {
        let texture = |name: &str| Flagged::Yes(Box::new(Texture::new(name)));
        let single = SingleMaterial {
            layers: [texture("d.png"), Flagged::No, texture("n.png"), texture("h.png")],
            alpha_cutoff: Some(0.5),
            ..SingleMaterial::default()
        };
        let triangle = Triangle { vertices: [0, 1, 2], smoothing: 1 };
        let object = Object {
            material: 0,
            parent: -1,
            vertices: vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]],
            displacement: Some(Displacement { tessellation: 2, bias: 0.0, scale: 1.0 }),
            faces: Some(Faces {
                tex_coords: vec![[0.0; 2]; 6],
                normals: Some(vec![[0., 0., 1.], [0., 1., 0.]]),
                normal_indices: vec![[0, 0, 1]; 2],
                triangles: vec![triangle; 2],
                tex_indices: vec![[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 5], [0, 0, 0], [1, 1, 1]],
                tex_counts: TexCounts::Uniform(3),
                groups: vec![Group { id: 0, triangles: 2 }],
            }),
            ..Object::default()
        };
        let body = Body {
            object: 0,
            name: "".into(),
            mode: BodyMode::Static,
            static_friction: 0.5,
            dynamic_friction: 0.5,
            restitution: 0.0,
            mass: None,
            primitives: None,
            pieces: None,
            unknown: Vec::new(),
        };
        let mut document = Document {
            header: Some(Header::Mesh),
            materials: vec![Material {
                number: 0,
                name: "m".into(),
                body: MaterialBody::Single(Box::new(single)),
                unknown: Vec::new(),
            }],
            geometry: Geometry {
                smoothing_groups: true,
                frames_per_second: Some(25.0),
                frames: vec![Frame { objects: vec![object], ..Frame::default() }],
                ..Geometry::default()
            },
            physics: Some(Physics { bodies: vec![body], unknown: Vec::new() }),
            ..Document::default()
        };
        let mut report = Report::default();
        strip(&mut document, &mut report);
        let text = String::from_utf8(aam::write(&document, &aam::WriteOptions::default()).unwrap()).unwrap();
        for tag in ["TN:", "TD:", "AC:", "TF:", "N_List:", "NI:", "FPS:", "PHYSICS"] {
            assert!(!text.contains(tag), "{tag} in\n{text}");
        }
        let faces = document.objects()[0].faces.as_ref().unwrap();
        assert_eq!(faces.tex_indices, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(faces.tex_counts, TexCounts::Uniform(1));
        let properties: Vec<&str> = report.changes.iter().map(|change| change.property.as_str()).collect();
        assert_eq!(
            properties,
            ["normals", "displacement", "normal map", "displacement map", "alpha cutoff", "frame rate", "physics"]
        );
        assert_eq!(report.changes[0].size.as_deref(), Some("30.00° mean, 90.00° worst"));
    }
}
