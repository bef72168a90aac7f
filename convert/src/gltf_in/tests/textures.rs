//! Texture transforms, and textures that are made of others.

use aam::document::{Document, Flagged};
use aam::meaning::Materials;
use glam::{Vec2, Vec3};

use super::super::model::UvTransform;
use super::*;

/// A textured triangle; the base colour texture has these members besides its index.
fn textured(picture: &[u8], info: Value) -> Builder {
    let mut file = Builder::triangle();
    let uvs = file.vec2(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
    let texture = file.texture(picture, "paint");
    let mut info = info;
    info["index"] = json!(texture);
    file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": info, "metallicFactor": 0.0 } }));
    file.set("/meshes/0/primitives/0/material", json!(0));
    file
}

/// Where a glTF coordinate is looked up after the import: by the document's own meaning, back in glTF's space.
fn looked_up(document: &Document, uv: [f32; 2]) -> Vec2 {
    let materials = Materials::of(document);
    let layer = materials.leaves()[0].layers[0].as_ref().expect("a layer").transform;
    let moved = layer * Vec3::new(uv[0], 1.0 - uv[1], 1.0);
    Vec2::new(moved.x, 1.0 - moved.y)
}

fn transform(offset: [f32; 2], rotation: f32, scale: [f32; 2]) -> Value {
    json!({ "extensions": { "KHR_texture_transform": { "offset": offset, "rotation": rotation, "scale": scale } } })
}

#[test]
fn the_worked_example_of_the_extension() {
    // KHR_texture_transform: offset [0, 1], a quarter turn, scale ½ show the lower left quarter of the image.
    let file = textured(&png(1, 1, |_, _| [255; 4]), transform([0.0, 1.0], std::f32::consts::FRAC_PI_2, [0.5, 0.5]));
    let document = file.import().document;
    for (corner, wanted) in [([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [0.0, 0.5]), ([0.0, 1.0], [0.5, 1.0])] {
        assert_near(looked_up(&document, corner).to_array(), wanted, 1e-6);
    }
    // And offset [0, 1], scale [1, -1] count from the bottom.
    let file = textured(&png(1, 1, |_, _| [255; 4]), transform([0.0, 1.0], 0.0, [1.0, -1.0]));
    assert_near(looked_up(&file.import().document, [0.25, 0.25]).to_array(), [0.25, 0.75], 1e-6);
}

#[test]
fn transforms_against_the_closed_form() {
    for (offset, angle, scale) in [
        ([0.3, -0.7], 0.0_f32, [1.0, 1.0]),
        ([0.0, 0.0], 0.4, [1.0, 1.0]),
        ([0.0, 0.0], 0.0, [3.0, 0.5]),
        ([-1.25, 2.5], -2.1, [4.0, -0.25]),
        ([10.0, -20.0], 3.0, [0.01, 30.0]),
    ] {
        let document = textured(&png(1, 1, |_, _| [255; 4]), transform(offset, angle, scale)).import().document;
        for uv in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.3, 0.8], [-2.0, 5.0]] {
            let (s, c) = angle.sin_cos();
            let [x, y] = [uv[0] * scale[0], uv[1] * scale[1]];
            let wanted = [c * x + s * y + offset[0], -s * x + c * y + offset[1]];
            assert_near(looked_up(&document, uv).to_array(), wanted, 1e-4);
        }
    }
}

#[test]
fn a_transform_without_inverse_goes_into_the_coordinates() {
    let asset = textured(&png(1, 1, |_, _| [255; 4]), transform([0.25, 0.5], 0.0, [0.0, 2.0])).import();
    let faces = object(&asset, "node 0").faces.as_ref().expect("faces");
    let uvs = faces.tex_indices[0].map(|at| faces.tex_coords[at as usize]);
    assert_eq!(uvs, [[0.25, 0.5], [0.25, 0.5], [0.25, -1.5]]);
    assert_near(looked_up(&asset.document, [0.7, 0.2]).to_array(), [0.7, 0.2], 1e-6);
    assert!(reported(&asset, Outcome::Changed, "diffuse"));
}

#[test]
fn the_extension_may_name_another_set() {
    let mut file = textured(&png(1, 1, |_, _| [255; 4]), json!({}));
    let uvs = file.vec2(&[[0.5, 0.5]; 3]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_3", json!(uvs));
    let info = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions";
    file.set(info, json!({ "KHR_texture_transform": { "texCoord": 3 } }));
    let asset = file.import();
    assert_eq!(object(&asset, "node 0").faces.as_ref().expect("faces").tex_coords, [[0.5, 0.5]]);
}

#[test]
fn applying_is_the_closed_form_too() {
    let transform = UvTransform { offset: [0.5, -1.0], rotation: 1.0, scale: [2.0, 3.0] };
    let (s, c) = 1.0_f32.sin_cos();
    let wanted = [c * 2.0 * 0.1 + s * 3.0 * 0.2 + 0.5, -s * 2.0 * 0.1 + c * 3.0 * 0.2 - 1.0];
    assert_near(transform.apply([0.1, 0.2]), wanted, 1e-6);
}

#[test]
fn a_picture_is_used_as_it_is() {
    let picture = png(2, 1, |x, _| [x as u8 * 200, 50, 25, 255]);
    let asset = textured(&picture, json!({})).import();
    let [(name, file)] = asset.textures.iter().collect::<Vec<_>>()[..] else { panic!("one texture") };
    assert_eq!(name, "model_paint.png");
    match file {
        crate::TextureFile::InMemory(bytes) => assert_eq!(**bytes, *picture),
        crate::TextureFile::OnDisk(_) => panic!("the picture is in the file"),
    }
}

#[test]
fn an_opaque_material_loses_its_pictures_alpha() {
    let picture = png(2, 1, |x, _| [10, 20, 30, if x == 0 { 0 } else { 255 }]);
    let mut file = textured(&picture, json!({}));
    let asset = file.import();
    let layer = single(&asset, 0).layers[0].as_ref().expect("a layer").file.decoded();
    assert_eq!(layer, "model_paint_opaque.png");
    assert!(decoded(&asset, &layer).pixels().all(|pixel| pixel.0 == [10, 20, 30, 255]));
    for mode in ["BLEND", "MASK"] {
        file.set("/materials/0/alphaMode", json!(mode));
        let asset = file.import();
        let layer = single(&asset, 0).layers[0].as_ref().expect("a layer").file.decoded();
        assert_eq!(decoded(&asset, &layer).get_pixel(0, 0).0, [10, 20, 30, 0], "{mode}");
    }
}

/// A texture of one grey, decoded to linear.
fn linear(value: u8) -> f32 {
    crate::phong::decode_srgb(f32::from(value) / 255.0)
}

#[test]
fn occlusion_is_multiplied_in_linear_light() {
    let base = png(2, 2, |x, y| [200, 100, (x + 2 * y) as u8 * 60, 255]);
    let mut file = textured(&base, json!({}));
    let occlusion = file.texture(&png(2, 2, |x, _| [if x == 0 { 255 } else { 128 }, 0, 0, 255]), "ao");
    file.set("/materials/0/occlusionTexture", json!({ "index": occlusion, "strength": 0.5 }));
    let asset = file.import();
    let layer = single(&asset, 0).layers[0].as_ref().expect("a layer").file.decoded();
    assert_eq!(layer, "model_paint_occluded.png");
    let baked = decoded(&asset, &layer);
    assert_eq!(baked.get_pixel(0, 1).0, [200, 100, 120, 255], "where occlusion is 1 nothing changes");
    let left = 1.0 + 0.5 * (128.0 / 255.0 - 1.0);
    let pixel = baked.get_pixel(1, 0).0;
    for (found, stored) in pixel.iter().zip([200, 100, 60]) {
        let wanted = crate::phong::encode_srgb(linear(stored) * left) * 255.0;
        assert!((f32::from(*found) - wanted).abs() <= 0.5001, "{found} {wanted}");
    }
    assert!(reported(&asset, Outcome::Changed, "occlusion texture"));
}

#[test]
fn occlusion_of_another_size_is_resampled() {
    let mut file = textured(&png(1, 1, |_, _| [255; 4]), json!({}));
    let occlusion = file.texture(&png(4, 2, |x, y| [(x * 16 + y * 64) as u8, 9, 9, 255]), "ao");
    file.set("/materials/0/occlusionTexture", json!({ "index": occlusion }));
    let asset = file.import();
    let baked = decoded(&asset, "model_paint_occluded.png");
    assert_eq!(baked.dimensions(), (4, 2));
    let wanted = crate::phong::encode_srgb((3.0 * 16.0 + 64.0) / 255.0) * 255.0;
    assert_eq!(f32::from(baked.get_pixel(3, 1).0[0]), wanted.round());
}

#[test]
fn occlusion_without_base_texture_becomes_one() {
    let mut file = Builder::triangle();
    let uvs = file.vec2(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(uvs));
    let occlusion = file.texture(&png(1, 1, |_, _| [64, 0, 0, 255]), "ao");
    file.push("materials", json!({ "occlusionTexture": { "index": occlusion, "texCoord": 1 } }));
    file.set("/meshes/0/primitives/0/material", json!(0));
    let asset = file.import();
    let wanted = (crate::phong::encode_srgb(64.0 / 255.0) * 255.0).round() as u8;
    assert_eq!(decoded(&asset, "model_ao_occluded.png").get_pixel(0, 0).0, [wanted, wanted, wanted, 255]);
}

#[test]
fn occlusion_with_other_coordinates_is_lost() {
    let mut file = textured(&png(1, 1, |_, _| [255; 4]), json!({}));
    let occlusion = file.texture(&png(1, 1, |_, _| [128, 0, 0, 255]), "ao");
    let uvs = file.vec2(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(uvs));
    file.set("/materials/0/occlusionTexture", json!({ "index": occlusion, "texCoord": 1 }));
    let asset = file.import();
    assert_eq!(asset.textures.len(), 1);
    assert!(notes(&asset, "occlusion texture").contains("49.8 % darker"), "{}", notes(&asset, "occlusion texture"));
}

#[test]
fn names_are_the_assets_own_and_never_clash() {
    let mut file = textured(&png(1, 1, |_, _| [255, 0, 0, 255]), json!({}));
    let second = file.texture(&png(1, 1, |_, _| [0, 255, 0, 255]), "Paint");
    let third = file.texture(&png(1, 1, |_, _| [0, 0, 255, 255]), "../../etc/pass wd.png");
    let mut attributes = file.json["meshes"][0]["primitives"][0].clone();
    for (material, texture) in [(1, second), (2, third)] {
        file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
        attributes["material"] = json!(material);
        file.json["meshes"][0]["primitives"].as_array_mut().expect("primitives").push(attributes.clone());
    }
    let names: Vec<String> = file.import().textures.into_keys().collect();
    assert_eq!(names, ["model_Paint.001.png", "model__._.__etc_pass wd.png", "model_paint.png"]);
}

#[test]
fn two_materials_share_a_picture() {
    let mut file = textured(&png(1, 1, |_, _| [255; 4]), json!({}));
    let copy = file.json["materials"][0].clone();
    file.push("materials", copy);
    let asset = file.import();
    assert_eq!(asset.textures.len(), 1);
    assert!(matches!(single(&asset, 1).layers[0], Flagged::Yes(_)), "an unused material is kept");
}

#[test]
fn a_picture_that_is_embedded_twice_is_written_once() {
    let picture = png(2, 2, |x, _| [x as u8, 2, 3, 255]);
    let mut file = textured(&picture, json!({}));
    let again = file.texture(&picture, "again");
    file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": again } } }));
    assert_eq!(file.import().textures.into_keys().collect::<Vec<_>>(), ["model_paint.png"]);
}

#[test]
fn clamping_is_reported_where_it_matters() {
    let mut file = textured(&png(1, 1, |_, _| [255; 4]), json!({}));
    file.push("samplers", json!({ "wrapS": 33071, "magFilter": 9728 }));
    file.set("/textures/0/sampler", json!(0));
    let asset = file.import();
    assert!(!reported(&asset, Outcome::Lost, "texture wrapping"), "the coordinates stay in the picture");
    assert!(reported(&asset, Outcome::Lost, "texture filter"));
    file.set(
        "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions",
        transform([0.0, 0.0], 0.0, [2.0, 2.0])["extensions"].clone(),
    );
    assert!(reported(&file.import(), Outcome::Lost, "texture wrapping"));
}

#[test]
fn undecodable_pictures_are_used_unseen() {
    // The signature is right and the rest is not: nothing can be baked from it.
    let mut file = textured(b"\x89PNG\r\n\x1a\nbroken", json!({}));
    file.set("/materials/0/occlusionTexture", json!({ "index": 0 }));
    let asset = file.import();
    assert_eq!(single(&asset, 0).layers[0].as_ref().expect("a layer").file, *"model_paint.png");
    assert!(reported(&asset, Outcome::Lost, "picture"));
}

#[test]
fn pictures_beyond_the_limit_are_not_decoded() {
    let file = textured(&png(64, 64, |_, _| [1, 2, 3, 4]), json!({}));
    let asset = file.import_with(&limited(Limits { texture_pixels: 1000, ..Limits::DEFAULT }));
    assert!(notes(&asset, "picture").contains("64 × 64"), "{}", notes(&asset, "picture"));
}

#[test]
fn webp_is_taken_where_there_is_nothing_else() {
    let mut webp = Vec::new();
    image::DynamicImage::new_rgb8(2, 2)
        .write_to(&mut std::io::Cursor::new(&mut webp), image::ImageFormat::WebP)
        .expect("encoded");
    let mut file = textured(&webp, json!({}));
    file.set("/textures/0", json!({ "extensions": { "EXT_texture_webp": { "source": 0 } } }));
    file.set("/extensionsRequired", json!(["EXT_texture_webp"]));
    assert_eq!(single(&file.import(), 0).layers[0].as_ref().expect("a layer").file, *"model_paint.webp");
    file.push("images", json!({ "bufferView": 1 }));
    file.set("/textures/0/source", json!(0));
    file.import();
}
