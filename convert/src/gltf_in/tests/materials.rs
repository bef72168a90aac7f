//! What becomes of each material property.

use aam::document::{Flagged, NormalSpace};

use crate::phong::{self, MetallicRoughness, decode_srgb, encode_srgb, from_metallic_roughness};

use super::*;

/// A square over the whole picture with one material.
fn square(material: Value) -> Builder {
    let mut file = Builder::new();
    let position = file.vec3(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let uvs = file.vec2(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    let attributes = json!({ "POSITION": position, "TEXCOORD_0": uvs });
    file.push("meshes", json!({ "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file.push("materials", material);
    file
}

/// A picture of two halves, left and right.
fn halves(left: [u8; 4], right: [u8; 4]) -> Vec<u8> {
    png(16, 16, |x, _| if x < 8 { left } else { right })
}

#[test]
fn factors_go_through_the_phong_mapping() {
    let pbr = json!({ "baseColorFactor": [0.2, 0.5, 0.8, 1.0], "metallicFactor": 0.25, "roughnessFactor": 0.4 });
    let asset = square(json!({ "name": "m", "pbrMetallicRoughness": pbr })).import();
    let single = single(&asset, 0);
    let wanted = from_metallic_roughness(&MetallicRoughness {
        base_color: [0.2, 0.5, 0.8],
        metallic: 0.25,
        roughness: 0.4,
        ..MetallicRoughness::default()
    });
    assert_eq!((single.ambient, single.diffuse, single.specular), (wanted.ambient, wanted.diffuse, wanted.specular));
    assert_eq!(single.shininess, phong::shininess(wanted.exponent));
    assert_eq!(single.transparency, 0.0);
    assert_eq!(single.emission, None);
    assert_eq!(single.layers, [Flagged::No, Flagged::No, Flagged::Omitted, Flagged::Omitted]);
    assert_eq!(asset.document.materials[0].name, *"m");
}

#[test]
fn primitives_without_material_get_the_default_one() {
    let asset = Builder::triangle().import();
    assert_eq!(asset.document.materials[0].name, *"default");
    let wanted = from_metallic_roughness(&MetallicRoughness::default());
    assert_eq!(single(&asset, 0).diffuse, wanted.diffuse);
    assert!(single(&asset, 0).diffuse[0] > 0.3, "a rough metal is not black");
}

#[test]
fn emission_may_be_stronger_than_white() {
    let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 8.0 } });
    let asset = square(json!({ "emissiveFactor": [1.0, 0.5, 0.0], "extensions": strength })).import();
    let emission = single(&asset, 0).emission.expect("emission").map(decode_srgb);
    assert_near(emission, [8.0, 4.0, 0.0], 1e-4);
}

#[test]
fn alpha_modes() {
    let material = |mode: &str, alpha: f32, cutoff: f32| {
        let pbr = json!({ "baseColorFactor": [1.0, 1.0, 1.0, alpha] });
        let asset = square(json!({ "alphaMode": mode, "alphaCutoff": cutoff, "pbrMetallicRoughness": pbr })).import();
        (single(&asset, 0).transparency, single(&asset, 0).alpha_cutoff)
    };
    assert_eq!(material("OPAQUE", 0.5, 0.5), (0.0, None));
    assert_eq!(material("BLEND", 0.25, 0.5), (0.75, None));
    assert_eq!(material("MASK", 1.0, 0.3), (0.0, Some(0.3)));
    // The cutoff is compared with texel times factor; the document knows the texel alone.
    assert_eq!(material("MASK", 0.5, 0.25), (0.0, Some(0.5)));
    assert!(material("MASK", 0.0, 0.25).1.is_some_and(|cutoff| cutoff > 1.0));
}

#[test]
fn unlit_shines_by_itself() {
    let picture = png(1, 1, |_, _| [10, 20, 30, 255]);
    let pbr = json!({ "baseColorFactor": [1.0, 0.5, 0.25, 1.0], "baseColorTexture": { "index": 0 } });
    let mut file = square(json!({ "pbrMetallicRoughness": pbr, "extensions": { "KHR_materials_unlit": {} } }));
    file.texture(&picture, "flat");
    file.set("/materials/0/normalTexture", json!({ "index": 0 }));
    let asset = file.import();
    let single = single(&asset, 0);
    assert_near(single.emission.expect("emission"), [1.0, 0.5, 0.25].map(encode_srgb), 1e-6);
    assert_eq!((single.ambient, single.diffuse, single.specular), ([0.0; 3], [0.0; 3], [0.0; 3]));
    assert!(matches!(single.layers[0], Flagged::Yes(_)));
    assert_eq!(single.layers[2], Flagged::Omitted, "a normal map does nothing without light");
}

#[test]
fn normal_maps_are_in_tangent_space() {
    let mut file = square(json!({ "normalTexture": { "index": 0, "scale": 1.5 } }));
    file.texture(&png(1, 1, |_, _| [128, 128, 255, 255]), "bumps");
    let asset = file.import();
    let layer = single(&asset, 0).layers[2].as_ref().expect("a normal map");
    assert_eq!(layer.normal_space, Some(NormalSpace::Tangent));
    assert_eq!(layer.intensity, 1.5);
    assert_eq!(layer.file, *"model_bumps.png");
}

#[test]
fn metallic_and_roughness_are_averaged_over_the_surface() {
    // Left: rough 51/255 = 0.2, metal 0; right: rough 153/255 = 0.6, metal 1.
    let pbr = json!({ "metallicRoughnessTexture": { "index": 0 }, "roughnessFactor": 0.5 });
    let mut file = square(json!({ "pbrMetallicRoughness": pbr }));
    file.texture(&halves([7, 51, 0, 255], [9, 153, 255, 255]), "mr");
    let asset = file.import();
    let wanted =
        from_metallic_roughness(&MetallicRoughness { metallic: 0.5, roughness: 0.2, ..MetallicRoughness::default() });
    assert_near(single(&asset, 0).specular, wanted.specular, 0.01);
    assert_near(
        [single(&asset, 0).shininess],
        [phong::shininess(wanted.exponent)],
        0.01 * phong::shininess(wanted.exponent),
    );
    let line = notes(&asset, "metallic and roughness texture");
    assert!(line.contains("metallic 0.50 ± 0.50, roughness 0.20 ± 0.10"), "{line}");
    // Only the left half of the picture is used: only it counts.
    let uvs = file.vec2(&[[0.0, 0.0], [0.45, 0.0], [0.45, 1.0], [0.0, 1.0]]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
    let line = notes(&file.import(), "metallic and roughness texture");
    assert!(line.contains("metallic 0.00 ± 0.00, roughness 0.10 ± 0.00"), "{line}");
}

#[test]
fn specular_glossiness() {
    let extension = json!({
        "diffuseFactor": [0.5, 0.4, 0.3, 0.5], "specularFactor": [0.3, 0.2, 0.1], "glossinessFactor": 0.7,
    });
    let extensions = json!({ "KHR_materials_pbrSpecularGlossiness": extension });
    let mut file = square(json!({ "alphaMode": "BLEND", "extensions": extensions }));
    let asset = file.import();
    let wanted = from_metallic_roughness(&MetallicRoughness {
        base_color: [0.5, 0.4, 0.3],
        metallic: 0.0,
        roughness: 1.0 - 0.7,
        dielectric_f0: [0.3, 0.2, 0.1],
    });
    assert_eq!(single(&asset, 0).diffuse, wanted.diffuse);
    assert_near(single(&asset, 0).specular, wanted.specular, 1e-6);
    assert_eq!(single(&asset, 0).transparency, 0.5);

    file.texture(&halves([0, 0, 0, 255], [255, 255, 255, 0]), "sg");
    let info = "/materials/0/extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture";
    file.set(info, json!({ "index": 0 }));
    let line = notes(&file.import(), "metallic and roughness texture");
    assert!(line.contains("glossiness 0.35 ± 0.35"), "{line}");
}

#[test]
fn specular_and_ior_set_the_dielectric_reflectance() {
    let base = |extensions: Value| {
        let pbr = json!({ "metallicFactor": 0.0, "roughnessFactor": 0.4 });
        let asset = square(json!({ "pbrMetallicRoughness": pbr, "extensions": extensions })).import();
        single(&asset, 0).specular
    };
    let mapped = |f0: [f32; 3]| {
        from_metallic_roughness(&MetallicRoughness {
            metallic: 0.0,
            roughness: 0.4,
            dielectric_f0: f0,
            ..MetallicRoughness::default()
        })
        .specular
    };
    assert_near(base(json!({})), mapped([0.04; 3]), 1e-6);
    assert_near(base(json!({ "KHR_materials_ior": { "ior": 2.0 } })), mapped([1.0 / 9.0; 3]), 1e-6);
    assert_eq!(base(json!({ "KHR_materials_specular": { "specularFactor": 0.0 } })), [0.0; 3]);
    let specular = json!({ "specularFactor": 0.5, "specularColorFactor": [4.0, 1.0, 0.0] });
    assert_near(base(json!({ "KHR_materials_specular": specular })), mapped([0.08, 0.02, 0.0]), 1e-6);
}

#[test]
fn a_dark_texture_does_not_swallow_the_highlight() {
    // The texel multiplies the whole sum, highlights too; so the highlight is written stronger by 1 / texel.
    let pbr = json!({ "baseColorTexture": { "index": 0 }, "metallicFactor": 0.0, "roughnessFactor": 0.6 });
    let mut file = square(json!({ "pbrMetallicRoughness": pbr }));
    file.texture(&png(4, 4, |_, _| [128, 188, 188, 255]), "dark");
    let asset = file.import();
    let plain =
        from_metallic_roughness(&MetallicRoughness { metallic: 0.0, roughness: 0.6, ..MetallicRoughness::default() });
    for channel in 0..3 {
        let texel = decode_srgb(if channel == 0 { 128.0 } else { 188.0 } / 255.0);
        let shown = texel * decode_srgb(single(&asset, 0).specular[channel]);
        assert_near([shown], [decode_srgb(plain.specular[channel])], 2e-4);
    }
    // The base colour itself is not touched: diffuse is still all but white.
    assert!(single(&asset, 0).diffuse.iter().all(|value| *value > 0.98), "{:?}", single(&asset, 0).diffuse);
}

#[test]
fn a_metals_highlight_keeps_its_textures_tint() {
    let pbr = json!({ "baseColorTexture": { "index": 0 }, "metallicFactor": 1.0, "roughnessFactor": 0.4 });
    let mut file = square(json!({ "pbrMetallicRoughness": pbr }));
    file.texture(&png(4, 4, |_, _| [255, 188, 100, 255]), "gold");
    let plain = from_metallic_roughness(&MetallicRoughness { roughness: 0.4, ..MetallicRoughness::default() });
    assert_near(single(&file.import(), 0).specular, plain.specular, 1e-6);
}

#[test]
fn an_emissive_texture_becomes_the_nearest_constant() {
    // On a white base the nearest constant is the mean: half of the square emits 1, the other nothing.
    let mut file = square(json!({ "emissiveTexture": { "index": 0 }, "emissiveFactor": [1.0, 1.0, 0.5] }));
    file.texture(&halves([255, 0, 255, 255], [0, 0, 0, 255]), "glow");
    let asset = file.import();
    assert_near(single(&asset, 0).emission.expect("emission").map(decode_srgb), [0.5, 0.0, 0.25], 2e-3);
    // e = 1 and 0 against the constant ½: both are ½ off, against an RMS of √½.
    let line = notes(&asset, "emissive texture");
    assert!(line.contains("71 % RMS"), "{line}");
    assert_eq!(single(&asset, 0).layers[0], Flagged::No);
}

#[test]
fn an_emissive_texture_on_black_is_the_diffuse_layer() {
    let pbr = json!({ "baseColorFactor": [0.0, 0.0, 0.0, 1.0], "metallicFactor": 0.0 });
    let emissive =
        json!({ "emissiveTexture": { "index": 0 }, "emissiveFactor": [1.0, 1.0, 1.0], "pbrMetallicRoughness": pbr });
    let mut file = square(emissive);
    file.texture(&halves([255, 0, 255, 255], [0, 0, 0, 255]), "screen");
    let asset = file.import();
    assert_eq!(single(&asset, 0).layers[0].as_ref().expect("a layer").file, *"model_screen.png");
    assert_near(single(&asset, 0).emission.expect("emission"), [1.0; 3], 1e-6);
    assert!(single(&asset, 0).diffuse.iter().all(|value| *value < 0.3));
}

#[test]
fn what_has_no_counterpart_is_reported() {
    let material = json!({
        "name": "glass",
        "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1.0 }, "VENDOR_magic": {} },
        "extras": { "note": "keep" },
    });
    let mut file = square(material);
    file.set("/extensionsUsed", json!(["KHR_materials_transmission", "VENDOR_magic", "KHR_materials_variants"]));
    file.set("/extensionsRequired", json!(["KHR_materials_transmission"]));
    let asset = file.import();
    assert!(notes(&asset, "material extension").contains("KHR_materials_transmission"));
    assert!(notes(&asset, "extension").contains("VENDOR_magic"));
    assert!(reported(&asset, Outcome::Lost, "material variants"));
    assert!(notes(&asset, "extras").contains("keep"));
    assert!(reported(&asset, Outcome::Changed, "single-sided materials"));
}

#[test]
fn equal_material_names_are_told_apart() {
    let mut file = square(json!({ "name": "paint" }));
    file.push("materials", json!({ "name": "paint" }));
    file.push("materials", json!({}));
    let names: Vec<String> = file.import().document.materials.iter().map(|m| m.name.decoded()).collect();
    assert_eq!(names, ["paint", "paint.001", "material 2"]);
}
