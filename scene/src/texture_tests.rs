//! Tests of finding and decoding textures.

use image::{ExtendedColorType, ImageEncoder, codecs};

use super::*;

const RED_BLUE: [u8; 8] = [255, 0, 0, 255, 0, 0, 255, 128];

fn png(bytes: &[u8], width: u32, height: u32, color: ExtendedColorType) -> Vec<u8> {
    let mut file = Vec::new();
    codecs::png::PngEncoder::new(&mut file).write_image(bytes, width, height, color).unwrap();
    file
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let picture = png(&RED_BLUE, 2, 1, ExtendedColorType::Rgba8);
    fs::create_dir_all(folder.path().join("asset/Maps")).unwrap();
    for name in ["outside.png", "asset/Desert80.png", "asset/Maps/TEXTURE PARQUET.png", "asset/ümlaut.png"] {
        fs::write(folder.path().join(name), &picture).unwrap();
    }
    folder
}

fn path_of(found: Result<FoundTexture, String>) -> Result<String, String> {
    found.map(|found| match found.data {
        TextureData::OnDisk(path) => path.file_name().unwrap().to_str().unwrap().to_owned(),
        TextureData::InMemory(_) => panic!("a folder has files"),
    })
}

#[test]
fn names_are_found_however_they_are_spelled() {
    let folder = folder();
    let source = FolderTextures::new(folder.path().join("asset"));
    for (name, file) in [
        ("Desert80.png", "Desert80.png"),
        ("desert80.PNG", "Desert80.png"),
        (" ./Desert80.png ", "Desert80.png"),
        ("Meshes/desert80.png", "Desert80.png"),
        ("Meshes\\desert80.png", "Desert80.png"),
        ("C:\\maps\\DESERT80.png", "Desert80.png"),
        ("/home/me/Desert80.png", "Desert80.png"),
        ("..\\..\\Desert80.png", "Desert80.png"),
        ("Maps/TEXTURE PARQUET.png", "TEXTURE PARQUET.png"),
        ("maps\\texture parquet.PNG", "TEXTURE PARQUET.png"),
        ("ÜMLAUT.png", "ümlaut.png"),
    ] {
        assert_eq!(path_of(source.find(name)).as_deref(), Ok(file), "{name}");
    }
    let (a, b) = (source.find("Desert80.png").unwrap(), source.find("x/desert80.PNG").unwrap());
    assert_eq!(a.key, b.key, "one file however it is spelled");
}

#[test]
fn names_that_are_not_there_say_so() {
    let folder = folder();
    let source = FolderTextures::new(folder.path().join("asset"));
    for name in ["", " ", "/", "..", "a/..", "Maps", "nothing.png", "a\0b.png", "Maps/Desert80", "."] {
        assert!(source.find(name).is_err(), "{name:?}");
    }
    assert!(source.find("nothing.png").unwrap_err().contains("no such file"));
    let gone = FolderTextures::new(folder.path().join("gone"));
    assert!(gone.find("a.png").is_err());
}

#[test]
fn names_do_not_leave_the_folder_unless_allowed() {
    let folder = folder();
    let outside = folder.path().join("outside.png");
    let mut source = FolderTextures::new(folder.path().join("asset"));
    let names =
        ["../outside.png".to_owned(), "Maps/../../outside.png".to_owned(), outside.to_str().unwrap().to_owned()];
    for name in &names {
        assert!(source.find(name).unwrap_err().contains("leads out"), "{name}");
    }
    for name in ["//server/share/outside.png", "\\\\server\\share\\outside.png", "file:///outside.png"] {
        assert!(source.find(name).is_err(), "{name}");
    }
    source.allow_outside = true;
    for name in &names {
        assert_eq!(path_of(source.find(name)).as_deref(), Ok("outside.png"), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn links_and_pipes_are_no_way_out() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    let asset = folder.path().join("asset");
    symlink(folder.path().join("outside.png"), asset.join("link.png")).unwrap();
    symlink(folder.path(), asset.join("up")).unwrap();
    symlink(asset.join("Desert80.png"), asset.join("inner.png")).unwrap();
    symlink("/dev/zero", asset.join("zero.png")).unwrap();
    let mut source = FolderTextures::new(&asset);
    for name in ["link.png", "LINK.PNG", "up/outside.png", "zero.png"] {
        assert!(source.find(name).unwrap_err().contains("leads out"), "{name}");
    }
    assert_eq!(path_of(source.find("inner.png")).as_deref(), Ok("Desert80.png"));
    source.allow_outside = true;
    assert_eq!(path_of(source.find("link.png")).as_deref(), Ok("outside.png"));
    assert!(source.find("zero.png").is_err(), "not a file");
}

fn decoded(bytes: &[u8], name: &str) -> Image {
    decode(bytes, Path::new(name), &pixels(1 << 20)).unwrap()
}

#[test]
fn every_kind_of_pixel_is_decoded_top_row_first() {
    let rgba = decoded(&png(&RED_BLUE, 1, 2, ExtendedColorType::Rgba8), "a.png");
    assert_eq!((rgba.width, rgba.height), (1, 2));
    assert_eq!(rgba.pixels, Pixels::Rgba8(RED_BLUE.to_vec()));
    // The content decides, not the extension.
    assert_eq!(decoded(&png(&RED_BLUE, 1, 2, ExtendedColorType::Rgba8), "a.jpg").pixels, rgba.pixels);
    let grey = decoded(&png(&[0, 200], 2, 1, ExtendedColorType::L8), "a.png");
    assert_eq!(grey.pixels, Pixels::Rgba8(vec![0, 0, 0, 255, 200, 200, 200, 255]));
    let words: Vec<u8> = [1_u16, 2, 65535].into_iter().flat_map(u16::to_ne_bytes).collect();
    let deep = decoded(&png(&words, 1, 1, ExtendedColorType::Rgb16), "a.png");
    assert_eq!(deep.pixels, Pixels::Rgba16(vec![1, 2, 65535, 65535]));
    let deep = decoded(&png(&words[2..4], 1, 1, ExtendedColorType::L16), "a.png");
    assert_eq!(deep.pixels, Pixels::Rgba16(vec![2, 2, 2, 65535]));
    let mut tga = Vec::new();
    codecs::tga::TgaEncoder::new(&mut tga).write_image(&RED_BLUE, 2, 1, ExtendedColorType::Rgba8).unwrap();
    assert_eq!(decoded(&tga, "a.TGA").pixels, rgba.pixels, "a format without a signature");
    let mut hdr = Vec::new();
    let radiance = [image::Rgb([4.0_f32, 0.5, 0.0])];
    codecs::hdr::HdrEncoder::new(&mut hdr).encode(&radiance, 1, 1).unwrap();
    let Pixels::RgbF32(values) = decoded(&hdr, "a.hdr").pixels else { panic!("radiance is floating point") };
    assert!((values[0] - 4.0).abs() < 0.05 && (values[1] - 0.5).abs() < 0.05 && values[2] == 0.0);
}

#[test]
fn palettes_are_looked_up() {
    let mut bytes = Vec::new();
    {
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(vec![9, 8, 7, 1, 2, 3]);
        encoder.set_trns(vec![255, 10]);
        encoder.write_header().unwrap().write_image_data(&[1, 0]).unwrap();
    }
    assert_eq!(decoded(&bytes, "a.png").pixels, Pixels::Rgba8(vec![1, 2, 3, 10, 9, 8, 7, 255]));
}

fn pixels(texture_pixels: u64) -> Limits {
    Limits { texture_pixels, ..Limits::default() }
}

#[test]
fn limits_hold_before_memory_is_used() {
    let picture = png(&[7; 64 * 64], 64, 64, ExtendedColorType::L8);
    assert!(decode(&picture, Path::new("a.png"), &pixels(64 * 64)).is_ok());
    let refusal = decode(&picture, Path::new("a.png"), &pixels(64 * 64 - 1)).unwrap_err();
    assert!(
        refusal.contains("64 × 64 = 4096 pixels are more than the limit of 4095; raise it with --max-texture-pixels"),
        "{refusal}"
    );
    // A header that promises 65535 × 65535 pixels and holds none.
    let mut bomb = picture.clone();
    bomb[16..24].copy_from_slice(&[0, 0, 255, 255, 0, 0, 255, 255]);
    assert!(decode(&bomb, Path::new("a.png"), &Limits::default()).is_err());
    let found = FoundTexture { key: "a.png".into(), data: TextureData::InMemory(picture.into()) };
    let limits = Limits { file_size: 10, ..Limits::default() };
    assert!(load_texture(&found, &limits).unwrap_err().contains("limit of 10"));
}

#[test]
fn rubbish_is_an_error() {
    for bytes in [&b""[..], b"hello", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff\xe0", b"BM", b"#?RADIANCE\n"] {
        assert!(decode(bytes, Path::new("a.bin"), &pixels(1 << 20)).is_err());
        assert!(decode(bytes, Path::new("a.png"), &pixels(1 << 20)).is_err());
        assert!(decode(bytes, Path::new("a.tga"), &pixels(1 << 20)).is_err());
    }
}
