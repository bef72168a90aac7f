//! Checks of materials and their textures.

use std::collections::BTreeSet;

use super::{Findings, Part};
use crate::Document;
use crate::document::{Flagged, Layer, Material, MaterialBody, NormalSpace, SingleMaterial, Texture};

pub(super) fn check(document: &Document, findings: &mut Findings) {
    let used: BTreeSet<i32> = document.objects().iter().map(|object| object.material).collect();
    for (index, material) in document.materials.iter().enumerate() {
        let part = Part::Material(index);
        let subject = format!("material {index} {:?}", material.name);
        if material.number != i32::try_from(index).unwrap_or(-1) {
            let message = format!("it is number {index} in the file, but `Mat#` says {}", material.number);
            findings.add(part, &subject, "material/number", message);
        }
        if !used.contains(&i32::try_from(index).unwrap_or(-1)) {
            findings.add(part, &subject, "material/unused", "no object uses it");
        }
        check_material(part, &subject, material, findings);
    }
}

fn check_material(part: Part, subject: &str, material: &Material, findings: &mut Findings) {
    match &material.body {
        MaterialBody::Single(single) => check_single(part, subject, single, findings),
        MaterialBody::Multi(subs) => {
            if subs.is_empty() {
                findings.add(part, subject, "material/empty-multi", "it has no sub-materials");
            }
            let mut numbers = BTreeSet::new();
            for (index, sub) in subs.iter().enumerate() {
                let sub_subject = format!("{subject}, sub {} {:?}", sub.number, sub.name);
                if !numbers.insert(sub.number) {
                    let message = "another sub-material before it has the same number";
                    findings.add(part, &sub_subject, "material/duplicate-sub", message);
                } else if sub.number != i32::try_from(index).unwrap_or(-1) {
                    let message = format!("it is number {index} in its material");
                    findings.add(part, &sub_subject, "material/number", message);
                }
                check_material(part, &sub_subject, sub, findings);
            }
        }
    }
}

fn check_single(part: Part, subject: &str, single: &SingleMaterial, findings: &mut Findings) {
    let unit = |value: &f32| (0.0..=1.0).contains(value) || value.is_nan();
    for (tag, rgb) in [("Am", &single.ambient), ("Di", &single.diffuse), ("Sp", &single.specular)] {
        if !rgb.iter().all(unit) {
            findings.add(part, subject, "material/color-range", format!("{tag} is {rgb:?}, not all from 0 to 1"));
        }
    }
    if let Some(emission) = single.emission
        && emission.iter().any(|&value| value < 0.0)
    {
        findings.add(part, subject, "material/negative-emission", format!("SI is {emission:?}, not all 0 or more"));
    }
    if !unit(&single.transparency) {
        findings.add(
            part,
            subject,
            "material/transparency-range",
            format!("Tr is {}, not from 0 to 1", single.transparency),
        );
    }
    // Above 128 an exponent can only be written as itself.
    let plain_exponent = single.shininess > 128.0 && single.shininess.is_finite();
    if !(unit(&single.shininess) || plain_exponent) {
        let reading = if single.shininess > 1.0 { "taken as the exponent itself" } else { "taken as no highlight" };
        findings.add(part, subject, "material/shininess", format!("Sh is {}, {reading}", single.shininess));
    }
    if let Some(cutoff) = single.alpha_cutoff
        && !unit(&cutoff)
    {
        findings.add(part, subject, "material/alpha-cutoff-range", format!("AC is {cutoff}, not from 0 to 1"));
    }
    let has = |layer: Layer| single.layers[layer as usize].as_ref().is_some();
    if has(Layer::LightMap) && has(Layer::Normal) {
        let message = "it has TS and TN; the light map replaces lighting, so the normal map has no effect";
        findings.add(part, subject, "material/light-and-normal-map", message);
    }
    if has(Layer::Displacement) && !has(Layer::LightMap) && !has(Layer::Normal) {
        let message = "it has TD but neither TN nor TS";
        findings.add(part, subject, "material/displacement-without-shading-map", message);
    }
    for layer in Layer::ALL {
        if let Flagged::Yes(texture) = &single.layers[layer as usize] {
            check_texture(part, &format!("{subject}, {}", layer.name()), layer, texture, findings);
        }
    }
}

fn check_texture(part: Part, subject: &str, layer: Layer, texture: &Texture, findings: &mut Findings) {
    if texture.file.is_empty() {
        findings.add(part, subject, "texture/empty-name", "`FN:` is empty");
    } else if leaves_folder(texture.file.bytes()) {
        findings.add(
            part,
            subject,
            "texture/outside-folder",
            format!("{:?} leaves the document's folder", texture.file),
        );
    }
    if texture.tiling.contains(&0.0) {
        findings.add(
            part,
            subject,
            "texture/zero-tiling",
            format!("UT and VT are {:?}; 0 shows one line of texels", texture.tiling),
        );
    }
    if texture.rotation[0] != 0.0 || texture.rotation[1] != 0.0 {
        let message = format!("UA is {} and VA is {}, which turn nothing", texture.rotation[0], texture.rotation[1]);
        findings.add(part, subject, "texture/rotation-axes", message);
    }
    let applied = layer == Layer::Normal && texture.normal_space == Some(NormalSpace::Tangent);
    if texture.intensity != 1.0 && !applied {
        findings.add(
            part,
            subject,
            "texture/intensity",
            format!("In is {}, which is not applied here", texture.intensity),
        );
    }
}

/// Whether a path is absolute (on any system) or goes up.
fn leaves_folder(path: &[u8]) -> bool {
    let absolute = matches!(path, [b'/' | b'\\', ..] | [_, b':', ..]);
    absolute || path.split(|byte| matches!(byte, b'/' | b'\\')).any(|step| step == b"..")
}
