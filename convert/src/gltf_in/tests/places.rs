//! Where files and data come from: containers, data URIs, external files, and what must not be reached.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::*;

const POSITIONS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

fn bytes() -> Vec<u8> {
    POSITIONS.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// A triangle whose buffer has this URI.
fn with_uri(uri: &str) -> Builder {
    let mut file = Builder::triangle();
    file.set("/buffers", json!([{ "byteLength": 36, "uri": uri }]));
    file.bin.clear();
    file
}

fn import_at(folder: &Path, file: &Builder, options: &ImportOptions) -> Result<Asset, ConvertError> {
    let path = folder.join("model.gltf");
    fs::write(&path, file.json.to_string()).expect("written");
    crate::import(&path, options, &Silent)
}

fn triangles(asset: &Asset) -> usize {
    asset.document.objects().iter().filter_map(|object| object.faces.as_ref()).map(|f| f.triangles.len()).sum()
}

#[test]
fn embedded_buffers() {
    let encoded = STANDARD.encode(bytes());
    for uri in [
        format!("data:application/octet-stream;base64,{encoded}"),
        format!("data:application/gltf-buffer;base64,{}", encoded.trim_end_matches('=')),
        format!("data:;BASE64,{}", encoded.replace('+', "%2B").replace('/', "%2F")),
        format!("data:application/octet-stream,{}", bytes().iter().map(|b| format!("%{b:02X}")).collect::<String>()),
    ] {
        let asset = import_bytes(with_uri(&uri).json.to_string().as_bytes(), "model.gltf", &ImportOptions::default());
        assert_eq!(triangles(&asset.unwrap_or_else(|error| panic!("{uri}: {error}"))), 1);
    }
}

#[test]
fn external_buffers_with_odd_names() {
    let folder = TempDir::new().expect("a folder");
    fs::create_dir(folder.path().join("sub dir")).expect("a folder");
    for (name, uri) in [
        ("plain.bin", "plain.bin"),
        ("with blank.bin", "with%20blank.bin"),
        ("with blank.bin", "with blank.bin"),
        ("100%.bin", "100%.bin"),
        ("a%20b.bin", "a%20b.bin"),
        ("ümlaut.bin", "%C3%BCmlaut.bin"),
        ("sub dir/data.bin", "sub%20dir/data.bin"),
        ("sub dir/data.bin", "sub dir\\data.bin"),
        ("sub dir/data.bin", "./sub dir/../sub dir/data.bin"),
    ] {
        fs::write(folder.path().join(name), bytes()).expect("written");
        let asset = import_at(folder.path(), &with_uri(uri), &ImportOptions::default());
        assert_eq!(triangles(&asset.unwrap_or_else(|error| panic!("{uri}: {error}"))), 1);
    }
}

#[test]
fn files_outside_the_folder_are_refused() {
    let outer = TempDir::new().expect("a folder");
    let folder = outer.path().join("inner");
    fs::create_dir(&folder).expect("a folder");
    let secret = outer.path().join("secret.bin");
    fs::write(&secret, bytes()).expect("written");
    let absolute = secret.display().to_string();
    let mut uris =
        vec!["../secret.bin", "..\\secret.bin", "a/../../secret.bin", "%2E%2E/secret.bin", absolute.as_str()];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, folder.join("link.bin")).expect("a link");
        uris.push("link.bin");
    }
    for uri in uris {
        let error = import_at(&folder, &with_uri(uri), &ImportOptions::default()).expect_err(uri).to_string();
        assert!(error.contains("/buffers/0/uri") && error.contains("--allow-outside"), "{error}");
        let trusting = ImportOptions { allow_outside: true, ..ImportOptions::default() };
        let asset = import_at(&folder, &with_uri(uri), &trusting).unwrap_or_else(|error| panic!("{uri}: {error}"));
        assert_eq!(triangles(&asset), 1, "{uri}");
    }
}

#[test]
fn a_buffer_that_nothing_needs_may_be_absent() {
    let mut file = Builder::triangle();
    file.set("/buffers", json!([{ "byteLength": 36 }, { "byteLength": 1_000_000_000_000_u64 }]));
    assert_eq!(triangles(&file.import()), 1);
}

#[test]
fn addresses_are_not_fetched() {
    for uri in ["https://example.com/a.bin", "file:///etc/passwd", "ftp://x/y"] {
        let error = with_uri(uri).try_import(&ImportOptions::default()).expect_err("no network");
        assert!(matches!(error, ConvertError::Unsupported { .. }), "{error}");
    }
}

#[test]
fn a_glb_may_be_called_gltf() {
    let glb = Builder::triangle().glb();
    assert_eq!(triangles(&import_bytes(&glb, "model.gltf", &ImportOptions::default()).expect("imported")), 1);
}

#[test]
fn a_byte_order_mark_and_bytes_after_the_end_do_no_harm() {
    let mut text = b"\xEF\xBB\xBF".to_vec();
    let uri = format!("data:;base64,{}", STANDARD.encode(bytes()));
    text.extend_from_slice(with_uri(&uri).json.to_string().as_bytes());
    assert_eq!(triangles(&import_bytes(&text, "model.gltf", &ImportOptions::default()).expect("imported")), 1);
    let mut glb = Builder::triangle().glb();
    glb.extend_from_slice(b"trailing");
    let asset = import_bytes(&glb, "model.glb", &ImportOptions::default()).expect("imported");
    assert!(notes(&asset, "GLB container").contains("8 bytes"));
}

#[test]
fn unknown_chunks_are_skipped() {
    let mut glb = Builder::triangle().glb();
    glb.extend_from_slice(&4_u32.to_le_bytes());
    glb.extend_from_slice(b"XTRAdata");
    let length = glb.len() as u32;
    glb[8..12].copy_from_slice(&length.to_le_bytes());
    let asset = import_bytes(&glb, "model.glb", &ImportOptions::default()).expect("imported");
    assert_eq!(triangles(&asset), 1);
}

#[test]
fn an_external_picture_keeps_its_name_and_place() {
    let folder = TempDir::new().expect("a folder");
    fs::create_dir(folder.path().join("maps")).expect("a folder");
    fs::write(folder.path().join("maps/bark 1.png"), png(2, 2, |_, _| [255; 4])).expect("written");
    let mut file = Builder::triangle();
    file.set("/buffers", json!([{ "byteLength": 36, "uri": "a.bin" }]));
    fs::write(folder.path().join("a.bin"), bytes()).expect("written");
    file.push("images", json!({ "uri": "maps/bark%201.png" }));
    file.push("textures", json!({ "source": 0 }));
    file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
    file.set("/meshes/0/primitives/0/material", json!(0));
    let asset = import_at(folder.path(), &file, &ImportOptions::default()).expect("imported");
    let layer = single(&asset, 0).layers[0].as_ref().expect("a layer");
    assert_eq!(layer.file, *"maps/bark 1.png");
    match &asset.textures["maps/bark 1.png"] {
        crate::TextureFile::OnDisk(path) => assert_eq!(path, &folder.path().join("maps/bark 1.png")),
        crate::TextureFile::InMemory(_) => panic!("the file itself is used"),
    }

    file.set("/images/0/uri", json!("maps/missing.png"));
    let asset = import_at(folder.path(), &file, &ImportOptions::default()).expect("imported");
    assert_eq!(single(&asset, 0).layers[0].as_ref().expect("a layer").file, *"maps/missing.png");
    assert!(reported(&asset, Outcome::Lost, "picture") && asset.textures.is_empty());

    file.set("/images/0/uri", json!("../missing.png"));
    let error = import_at(folder.path(), &file, &ImportOptions::default()).expect_err("outside").to_string();
    assert!(error.contains("/images/0/uri"), "{error}");
}
