//! Names and pictures from an enemy: nothing outside the folder is read or written, and no picture costs more than its limit.

use std::path::Path;

use aam_convert::{ConvertOptions, ImportOptions, Outcome, Silent, convert, import};
use aam_scene::{FoundTexture, Image, Pixels, TextureData, load_texture};
use base64::Engine;

/// An AAM file whose one material names this texture.
fn with_texture(name: &[u8]) -> Vec<u8> {
    let head = b"MATERIALS\nMatCount: 1\nMat# 0\n{\nName: m\nClass: Standard\nAm: 1 1 1\nDi: 1 1 1\nSp: 0 0 0\nTr: 0\nSh: 0\nTx: Y\n{\nFN: ";
    let tail = b"\nFi: PYRAMIDAL\nIn: 1\nUA: 0\nVA: 0\nWA: 0\nUO: 0\nVO: 0\nUT: 1\nVT: 1\n}\nTS: N\n}\nENDMATERIALS\nGEOMETRY\nNObj: 0\n\
        NFrames: 0\nAnimation_mode: None\nENDGEOMETRY\n";
    [head.as_slice(), name, tail].concat()
}

/// Every file below a folder.
fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(current) = pending.pop() {
        for entry in std::fs::read_dir(current).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.is_symlink() {
                pending.push(path);
            } else {
                found.push(path.strip_prefix(folder).unwrap().to_string_lossy().into_owned());
            }
        }
    }
    found.sort();
    found
}

/// A folder with a secret, and in it the folder of the asset.
fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(place.path().join("a/asset")).unwrap();
    image::RgbImage::new(2, 2).save(place.path().join("secret.png")).unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink(place.path().join("secret.png"), place.path().join("a/asset/link.png")).unwrap();
        symlink(place.path(), place.path().join("a/asset/up")).unwrap();
        symlink("/dev/zero", place.path().join("a/asset/zero.png")).unwrap();
    }
    place
}

#[test]
fn a_texture_name_reads_and_writes_nothing_outside() {
    let place = place();
    let absolute = place.path().join("secret.png").display().to_string();
    let names: [&[u8]; 22] = [
        b"../../secret.png",
        b"..\\..\\secret.png",
        b"a/../../../secret.png",
        absolute.as_bytes(),
        b"//server/share/secret.png",
        b"\\\\server\\share\\secret.png",
        b"\\\\?\\C:\\secret.png",
        b"C:\\secret.png",
        b"C:secret.png",
        b"file:///etc/passwd",
        b"https://example.com/secret.png",
        b"/dev/zero",
        b"/proc/self/mem",
        b"CON",
        b"NUL.png",
        b"COM1",
        b"link.png",
        b"up/secret.png",
        b"zero.png",
        b"sec\0ret.png",
        b"\xff\xfe\xc3(.png",
        b"..",
    ];
    for name in names {
        let shown = String::from_utf8_lossy(name).into_owned();
        let asset = place.path().join("a/asset");
        std::fs::write(asset.join("m.aam"), with_texture(name)).unwrap();
        let out = place.path().join("a/out");
        std::fs::create_dir(&out).unwrap();
        let before = files(place.path());
        let done = convert(&asset.join("m.aam"), Some(&out.join("m.aam")), &ConvertOptions::default(), &Silent);
        let done = done.unwrap_or_else(|error| panic!("{shown}: {error}"));
        let lost =
            done.report.changes.iter().any(|change| change.outcome == Outcome::Lost && change.property == "texture");
        assert!(lost, "{shown}: {:?}", done.report.changes);
        let mut after = files(place.path());
        after.retain(|file| !before.contains(file));
        assert_eq!(after, ["a/out/m.aam"], "{shown}");
        // The name itself is kept byte for byte.
        let bytes = std::fs::read(out.join("m.aam")).unwrap();
        assert!(bytes.windows(name.len() + 5).any(|window| window == [b"FN: ", name, b"\n"].concat()), "{shown}");
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn a_library_and_its_maps_read_nothing_outside() {
    let place = place();
    let asset = place.path().join("a/asset");
    std::fs::write(place.path().join("secret.mtl"), "newmtl stolen\nKd 1 0 0\n").unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl stolen\nf 1 2 3\n";
    for library in ["../../secret.mtl", "up/secret.mtl", "/dev/zero", "zero.png"] {
        std::fs::write(asset.join("m.obj"), format!("mtllib {library}\n{triangle}")).unwrap();
        let read = import(&asset.join("m.obj"), &ImportOptions::default(), &Silent).unwrap();
        assert!(read.report.changes.iter().any(|change| change.property == "material library"), "{library}");
    }
    for map in ["../../secret.png", "up/secret.png", "link.png", "zero.png", "//server/share/secret.png"] {
        std::fs::write(asset.join("m.mtl"), format!("newmtl stolen\nmap_Kd {map}\nbump {map}\n")).unwrap();
        std::fs::write(asset.join("m.obj"), format!("mtllib m.mtl\n{triangle}")).unwrap();
        let read = import(&asset.join("m.obj"), &ImportOptions::default(), &Silent).unwrap();
        assert!(read.textures.is_empty(), "{map}: {:?}", read.textures);
    }
}

fn picture(bytes: &[u8], name: &str) -> Result<Image, String> {
    let limits = aam::Limits { texture_pixels: 1 << 20, ..aam::Limits::default() };
    load_texture(&FoundTexture { key: name.into(), data: TextureData::InMemory(bytes.into()) }, &limits)
}

/// A PNG of this size, whose data is so many zeros, all of them right.
fn png(width: u32, height: u32, color: png::ColorType, depth: png::BitDepth) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette(vec![255, 0, 0]);
    }
    let row = (width as usize * color.samples() * depth as usize).div_ceil(8);
    encoder.write_header().unwrap().write_image_data(&vec![0; row * height as usize]).unwrap();
    bytes
}

#[test]
fn a_picture_costs_no_more_than_its_limit() {
    // A real bomb: two kilobytes that unpack to 16 MB; and headers that promise what is not there.
    let bomb = png(4096, 4096, png::ColorType::Grayscale, png::BitDepth::Eight);
    assert!(bomb.len() < 100_000, "{}", bomb.len());
    let mut header = png(1, 1, png::ColorType::Rgba, png::BitDepth::Sixteen);
    header[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let gif =
        [b"GIF89a".as_slice(), &[0xff; 4], &[0, 0, 0, 0x2c, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 0, 2, 1, 0, 0, 0x3b]]
            .concat();
    let mut bmp = b"BM".to_vec();
    bmp.extend([0; 8]);
    bmp.extend(54_u32.to_le_bytes());
    bmp.extend([40_u32, 0x7fff_ffff, 0x7fff_ffff].iter().flat_map(|value| value.to_le_bytes()));
    bmp.extend([1, 0, 24, 0]);
    bmp.extend([0; 24]);
    let tga = [[0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0].as_slice(), &[0xff; 4], &[32, 0]].concat();
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n".to_vec();
    for (name, bytes) in
        [("a.png", bomb), ("b.png", header), ("c.gif", gif), ("d.bmp", bmp), ("e.tga", tga), ("f.hdr", hdr)]
    {
        let refusal = picture(&bytes, name).expect_err(name);
        assert!(!refusal.is_empty(), "{name}");
        println!("{name}: {refusal}");
    }
}

#[test]
fn a_picture_without_pixels_is_refused() {
    let mut none = png(1, 1, png::ColorType::Rgb, png::BitDepth::Eight);
    none[16..24].fill(0);
    assert!(picture(&none, "a.png").is_err());
    assert!(picture(&[[0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0].as_slice(), &[0; 4], &[32, 0]].concat(), "a.tga").is_err());
    assert!(picture(b"GIF89a\0\0\0\0\0\0\0;", "a.gif").is_err());
    assert!(picture(b"", "a.png").is_err());
}

/// Red, 8 × 8, with cyan, magenta, yellow and black as Adobe writes them.
const CMYK: &str = "/9j/7gAOQWRvYmUAZAAAAAAA/9sAQwAQCwwODAoQDg0OEhEQExgoGhgWFhgxIyUdKDozPTw5Mzg3QEhcTkBEV0U3OFBtUVdfYmdoZz5NcXlwZHhcZW\
    dj/8AAFAgACAAIBEMRAE0RAFkRAEsRAP/EAB8AAAEFAQEBAQEBAAAAAAAAAAABAgMEBQYHCAkKC//EALUQAAIBAwMCBAMFBQQEAAABfQECAwAEEQUSITFBBhNRYQcic\
    RQygZGhCCNCscEVUtHwJDNicoIJChYXGBkaJSYnKCkqNDU2Nzg5OkNERUZHSElKU1RVVldYWVpjZGVmZ2hpanN0dXZ3eHl6g4SFhoeIiYqSk5SVlpeYmZqio6Slpqeoqa\
    qys7S1tre4ubrCw8TFxsfIycrS09TV1tfY2drh4uPk5ebn6Onq8fLz9PX29/j5+v/aAA4EQwBNAFkASwAAPwD0CvP68/r0Cv/Z";

#[test]
fn pictures_of_every_kind_are_read_whatever_they_are_called() {
    let cmyk = base64::engine::general_purpose::STANDARD.decode(CMYK).unwrap();
    for name in ["a.jpg", "a.png", "a.tga", "a"] {
        let Pixels::Rgba8(pixels) = picture(&cmyk, name).unwrap_or_else(|error| panic!("{name}: {error}")).pixels
        else {
            panic!("eight bits")
        };
        assert!(pixels[0] > 240 && pixels[1] < 16 && pixels[2] < 16 && pixels[3] == 255, "{name}: {:?}", &pixels[..4]);
    }
    use png::{BitDepth, ColorType};
    for (color, depth) in [
        (ColorType::Indexed, BitDepth::One),
        (ColorType::Indexed, BitDepth::Eight),
        (ColorType::Grayscale, BitDepth::One),
        (ColorType::GrayscaleAlpha, BitDepth::Sixteen),
        (ColorType::Rgb, BitDepth::Sixteen),
        (ColorType::Rgba, BitDepth::Eight),
    ] {
        for name in ["a.png", "a.jpg", "a.gif", "a.bin"] {
            let image = picture(&png(3, 2, color, depth), name).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!((image.width, image.height), (3, 2), "{color:?} {depth:?} {name}");
        }
    }
}
