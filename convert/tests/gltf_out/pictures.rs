//! Textures: copied, re-encoded, baked.

use aam::document::{Layer, NormalSpace};
use aam_convert::{Outcome, TextureFile};

use crate::content::{Glb, glb};
use crate::documents::*;
use crate::{asset, export_to, png};

fn image_bytes(file: &Glb, index: usize) -> image::RgbaImage {
    let image = file.document.images().nth(index).unwrap();
    let gltf::image::Source::View { view, .. } = image.source() else { panic!("embedded") };
    let bytes = &file.blob[view.offset()..view.offset() + view.length()];
    image::load_from_memory(bytes).unwrap().into_rgba8()
}

fn textured(layers: &[(Layer, &str)], edit: impl FnOnce(&mut aam::document::SingleMaterial)) -> aam::Document {
    let material = single("m", |single| {
        for (layer, file) in layers {
            texture(single, *layer, file, |_| {});
        }
        edit(single);
    });
    document(vec![material], vec![block(0, "box", [0.0; 3], [1.0; 3], layers.len() as u8)])
}

#[test]
fn files_that_gltf_knows_are_copied_and_others_become_png() {
    let picture = image::RgbaImage::from_fn(4, 2, |x, y| image::Rgba([60 * x as u8, 100 * y as u8, 7, 255]));
    let mut bmp = std::io::Cursor::new(Vec::new());
    image::DynamicImage::from(picture.clone()).into_rgb8().write_to(&mut bmp, image::ImageFormat::Bmp).unwrap();
    let document = textured(&[(Layer::Diffuse, "maps\\wood.BMP")], |_| {});
    let folder = tempfile::tempdir().unwrap();
    let textures = asset(document, &[("maps\\wood.BMP", bmp.into_inner())]);
    let (path, report) = export_to(folder.path(), "m.gltf", &textures).unwrap();
    let written = image::open(folder.path().join("maps/wood.png")).unwrap().into_rgba8();
    assert_eq!(written, picture);
    assert!(
        report.changes.iter().any(|change| change.subject.contains("wood.BMP") && change.outcome == Outcome::Changed)
    );
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(json["images"][0]["uri"], "maps/wood.png");
    assert_eq!(json["buffers"][0]["uri"], "m.bin");

    let bytes = png(4, 4, |x, _| [0, 50 * x as u8, 0, 255]);
    let document = textured(&[(Layer::Diffuse, "TEXTURE PARQUET.png")], |_| {});
    let source = tempfile::tempdir().unwrap();
    std::fs::write(source.path().join("x.png"), &bytes).unwrap();
    let mut textures = asset(document, &[]);
    textures.textures.insert("TEXTURE PARQUET.png".into(), TextureFile::OnDisk(source.path().join("x.png")));
    let (path, _) = export_to(folder.path(), "n.gltf", &textures).unwrap();
    assert_eq!(std::fs::read(folder.path().join("TEXTURE PARQUET.png")).unwrap(), bytes, "byte for byte");
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(json["images"][0]["uri"], "TEXTURE%20PARQUET.png");
}

#[test]
fn names_that_lead_out_of_the_folder_are_written_in_it() {
    let bytes = png(2, 2, |_, _| [9; 4]);
    let document = textured(&[(Layer::Diffuse, "..\\..\\secret.png")], |_| {});
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    export_to(&inner, "m.gltf", &asset(document, &[("..\\..\\secret.png", bytes)])).unwrap();
    assert!(inner.join("secret.png").exists() && !folder.path().join("secret.png").exists());
}

#[test]
fn holes_in_a_texture_blend_and_cutoffs_mask() {
    let holes = png(2, 2, |x, _| [255, 255, 255, if x == 0 { 0 } else { 255 }]);
    let textures = asset(textured(&[(Layer::Diffuse, "leaf.png")], |_| {}), &[("leaf.png", holes.clone())]);
    let material = glb(&textures).0.document.materials().next().unwrap().alpha_mode();
    assert_eq!(material, gltf::material::AlphaMode::Blend);
    let cut = textured(&[(Layer::Diffuse, "leaf.png")], |single| single.alpha_cutoff = Some(0.3));
    let file = glb(&asset(cut, &[("leaf.png", holes)])).0;
    let material = file.document.materials().next().unwrap();
    assert_eq!(material.alpha_mode(), gltf::material::AlphaMode::Mask);
    assert_eq!(material.alpha_cutoff(), Some(0.3));
    let opaque = png(2, 2, |_, _| [255; 4]);
    let textures = asset(textured(&[(Layer::Diffuse, "leaf.png")], |_| {}), &[("leaf.png", opaque)]);
    let material = glb(&textures).0.document.materials().next().unwrap().alpha_mode();
    assert_eq!(material, gltf::material::AlphaMode::Opaque);
}

#[test]
fn a_light_map_is_multiplied_into_an_unlit_picture() {
    // The diffuse texture repeats four times where the light map lies once.
    let mut document = textured(&[(Layer::Diffuse, "d.png"), (Layer::LightMap, "l.png")], |_| {});
    let aam::document::MaterialBody::Single(single) = &mut document.materials[0].body else { panic!() };
    texture(single, Layer::Diffuse, "d.png", |texture| {
        texture.tiling = [4.0, 4.0];
    });
    let diffuse = png(2, 2, |x, y| if (x + y) % 2 == 0 { [200, 100, 50, 255] } else { [100, 100, 100, 255] });
    let light = png(8, 8, |x, _| [if x < 4 { 255 } else { 128 }, 255, 255, 255]);
    let (file, report) = glb(&asset(document, &[("d.png", diffuse), ("l.png", light)]));
    let material = file.document.materials().next().unwrap();
    assert!(material.unlit());
    let base = material.pbr_metallic_roughness();
    let factor = base.base_color_factor();
    assert!((factor[0] - aam_convert::phong::decode_srgb(0.6)).abs() < 1e-6, "the diffuse colour stays a factor");
    let baked = image_bytes(&file, base.base_color_texture().unwrap().texture().source().index());
    assert_eq!(baked.dimensions(), (8, 8));
    // A texel of the diffuse texture is one of the light map; (1 − 4·½ + 4·…) leaves its rows in step.
    let row: Vec<u8> = (0..8).map(|x| baked.get_pixel(x, 3).0[0]).collect();
    let mut left: Vec<u8> = row[1..3].to_vec();
    left.sort_unstable();
    assert_eq!(left, [100, 200]);
    let mut right: Vec<u8> = row[5..7].to_vec();
    right.sort_unstable();
    assert_eq!(right, [50, 100], "half as light");
    assert!(report.changes.iter().any(|change| change.property == "light map" && change.outcome == Outcome::Changed));
    let kept = &file.json["materials"][0]["extras"]["AAM"]["textures"];
    assert!(kept["Tx"]["index"].is_u64() && kept["TS"]["index"].is_u64(), "{kept}");
}

#[test]
fn a_light_map_with_coordinates_of_its_own_is_baked_in_them() {
    let mut document = textured(&[(Layer::Diffuse, "d.png"), (Layer::LightMap, "l.png")], |_| {});
    // The diffuse texture has u and v exchanged.
    let faces = document.geometry.frames[0].objects[0].faces.as_mut().unwrap();
    let count = faces.tex_coords.len() as u32;
    let swapped: Vec<[f32; 2]> = faces.tex_coords.iter().map(|[u, v]| [*v, *u]).collect();
    faces.tex_coords.extend(swapped);
    for (line, indices) in faces.tex_indices.iter_mut().enumerate() {
        if line % 2 == 0 {
            *indices = indices.map(|index| index + count);
        }
    }
    let diffuse = png(64, 64, |x, _| [4 * x as u8, 0, 0, 255]);
    let light = png(64, 64, |_, _| [255, 255, 255, 255]);
    let (file, _) = glb(&asset(document.clone(), &[("d.png", diffuse), ("l.png", light.clone())]));
    let material = file.document.materials().next().unwrap();
    let info = material.pbr_metallic_roughness().base_color_texture().unwrap();
    assert_eq!(info.tex_coord(), 1, "in the light map's coordinates");
    let baked = image_bytes(&file, info.texture().source().index());
    // At (u, v) of the light map lies (v, u) of the diffuse texture, whose red is its u.
    for (x, y) in [(3_u32, 60_u32), (10, 40), (50, 20)] {
        let v = 1.0 - (y as f32 + 0.5) / 64.0;
        let expected = 4.0 * (64.0 * v - 0.5);
        let got = f32::from(baked.get_pixel(x, y).0[0]);
        assert!((got - expected).abs() <= 4.0, "{x} {y}: {got} for {expected}");
    }

    // All sides on one spot of the light map, but not of the diffuse texture: no picture shows that.
    let faces = document.geometry.frames[0].objects[0].faces.as_mut().unwrap();
    for (line, indices) in faces.tex_indices.iter_mut().enumerate() {
        if line % 2 == 1 {
            *indices = if line % 4 == 1 { [0, 1, 2] } else { [0, 2, 3] };
        }
    }
    let diffuse = png(64, 64, |x, y| [4 * x as u8, 4 * y as u8, 0, 255]);
    let (file, report) = glb(&asset(document, &[("d.png", diffuse), ("l.png", light)]));
    assert!(report.changes.iter().any(|change| change.property == "light map" && change.outcome == Outcome::Lost));
    let material = file.document.materials().next().unwrap();
    assert_eq!(material.pbr_metallic_roughness().base_color_texture().unwrap().tex_coord(), 0);
}

#[test]
fn object_space_normals_become_tangent_space_ones() {
    let wanted = glam::Vec3::new(0.3, -0.4, 0.866).normalize();
    let color = (0.5 * wanted + 0.5).to_array().map(|value| (255.0 * value).round() as u8);
    let map = png(96, 64, |_, _| [color[0], color[1], color[2], 255]);
    let document = textured(&[(Layer::Normal, "n.png")], |_| {});
    let (file, report) = glb(&asset(document, &[("n.png", map.clone())]));
    assert!(report.changes.iter().any(|change| change.property == "normal map" && change.outcome == Outcome::Changed));
    let material = file.document.materials().next().unwrap();
    let baked = image_bytes(&file, material.normal_texture().unwrap().texture().source().index());
    let primitive = file.node("box").mesh().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&file.blob));
    let normals: Vec<glam::Vec3> = reader.read_normals().unwrap().map(glam::Vec3::from).collect();
    let tangents: Vec<glam::Vec4> = reader.read_tangents().unwrap().map(glam::Vec4::from).collect();
    let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    // glTF's own equation in the middle of each triangle gives the object-space normal back.
    let expected = glam::Vec3::new(wanted.x, wanted.z, -wanted.y);
    for corners in indices.chunks_exact(3) {
        let at = corners.iter().map(|&c| glam::Vec2::from(uvs[c as usize])).sum::<glam::Vec2>() / 3.0;
        let texel = baked.get_pixel((at.x * 96.0) as u32, (at.y * 64.0) as u32).0;
        let local = glam::Vec3::new(texel[0].into(), texel[1].into(), texel[2].into()) / 255.0 * 2.0 - 1.0;
        let (n, t) = (normals[corners[0] as usize], tangents[corners[0] as usize]);
        let got = (local.x * t.truncate() + local.y * t.w * n.cross(t.truncate()) + local.z * n).normalize();
        let degrees = got.angle_between(expected).to_degrees();
        assert!(degrees < 1.0, "{degrees}°: {got} for {expected}");
    }

    // All sides on one spot: each would need another picture.
    let mut document = textured(&[(Layer::Normal, "n.png")], |_| {});
    let faces = document.geometry.frames[0].objects[0].faces.as_mut().unwrap();
    for (line, indices) in faces.tex_indices.iter_mut().enumerate() {
        *indices = if line % 2 == 0 { [0, 1, 2] } else { [0, 2, 3] };
    }
    let (file, report) = glb(&asset(document, &[("n.png", map)]));
    assert!(report.changes.iter().any(|change| change.property == "normal map" && change.outcome == Outcome::Lost));
    assert!(file.document.materials().next().unwrap().normal_texture().is_none());
}

#[test]
fn tangent_space_maps_keep_picture_and_strength() {
    let map = png(4, 4, |_, _| [128, 128, 255, 255]);
    let document = textured(&[], |single| {
        texture(single, Layer::Normal, "n.png", |texture| {
            texture.normal_space = Some(NormalSpace::Tangent);
            texture.intensity = 0.75;
            texture.tiling = [2.0, 3.0];
        });
    });
    let mut document = document;
    document.geometry.frames[0].objects[0] = block(0, "box", [0.0; 3], [1.0; 3], 1);
    let (file, _) = glb(&asset(document, &[("n.png", map)]));
    let material = file.document.materials().next().unwrap();
    assert_eq!(material.normal_texture().unwrap().scale(), 0.75);
    let transform = &file.json["materials"][0]["normalTexture"]["extensions"]["KHR_texture_transform"];
    assert_eq!(transform["scale"], serde_json::json!([2.0, 3.0]));
}
