//! Whole OBJ files, in and out.

use std::path::{Path, PathBuf};

use aam::document::{Flagged, Layer, MaterialBody, Object, SingleMaterial};
use aam::meaning::{Bounds, SmoothingRule, object_normals};
use glam::Vec3;

use crate::{
    Asset, ConvertError, ConvertOptions, ExportOptions, ImportOptions, Outcome, Silent, TextureFile, convert, export,
    import,
};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            std::fs::create_dir_all(folder.path(name).parent().unwrap()).unwrap();
            std::fs::write(folder.path(name), text).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn picture(&self, name: &str, width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(pixel(x, y))).save(self.path(name)).unwrap();
    }

    fn read(&self, name: &str) -> Asset {
        import(&self.path(name), &ImportOptions::default(), &Silent).unwrap()
    }
}

fn read(text: &str) -> Asset {
    Folder::new(&[("model.obj", text)]).read("model.obj")
}

fn masks(object: &Object) -> Vec<i32> {
    object.faces.as_ref().unwrap().triangles.iter().map(|triangle| triangle.smoothing).collect()
}

fn singles(asset: &Asset) -> Vec<(String, &SingleMaterial)> {
    let mut found = Vec::new();
    crate::aam_file::for_each_single(&asset.document, |name, single| found.push((name.decoded(), single)));
    found
}

fn notes(asset: &Asset, outcome: Outcome) -> Vec<String> {
    let lines = asset.report.changes.iter().filter(|change| change.outcome == outcome);
    lines.map(|change| format!("{} {}: {}", change.subject, change.property, change.note)).collect()
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
const CUBE_FACES: &str = "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn axes_and_winding() {
    let text = format!("{CUBE}{CUBE_FACES}");
    for (up, expected) in
        [(None, [[0., -1., 0.], [1., 0., 1.]]), (Some(aam_scene::Up::Z), [[0., 0., 0.], [1., 1., 1.]])]
    {
        let folder = Folder::new(&[("a.obj", &text)]);
        let options = ImportOptions { up, ..ImportOptions::default() };
        let asset = import(&folder.path("a.obj"), &options, &Silent).unwrap();
        let object = &asset.document.objects()[0];
        let bounds = Bounds::of(object.vertices.iter().copied().map(Vec3::from)).unwrap();
        assert_eq!([bounds.min.to_array(), bounds.max.to_array()], expected);
        // Outwards stays outwards.
        for (corners, triangle) in
            object_normals(object, SmoothingRule::Masks).iter().zip(&object.faces.as_ref().unwrap().triangles)
        {
            let at = Vec3::from(object.vertices[triangle.vertices[0] as usize]);
            assert!(corners[0].dot(at - bounds.center()) > 0.0);
        }
    }
}

#[test]
fn objects_groups_and_materials() {
    let asset = read(&format!(
        "{CUBE}g one\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 5 6 7\ng two\nf 5 7 8\ng one\nf 2 3 6\n"
    ));
    let objects = asset.document.objects();
    assert_eq!(objects.iter().map(|object| object.name.decoded()).collect::<Vec<_>>(), ["one", "two"]);
    let groups = |index: usize| -> Vec<(i32, usize)> {
        let faces = objects[index].faces.as_ref().unwrap();
        faces.groups.iter().map(|group| (group.id, group.triangles)).collect()
    };
    assert_eq!(groups(0), [(0, 3), (1, 1)]);
    assert_eq!(groups(1), [(1, 1)]);
    let MaterialBody::Multi(subs) = &asset.document.materials[objects[0].material as usize].body else {
        panic!("one object with two materials has a Multi");
    };
    assert_eq!(subs.iter().map(|sub| sub.name.decoded()).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(asset.document.materials[objects[1].material as usize].name, "a");

    // `o` rules where there is one.
    let asset = read(&format!("{CUBE}o x\ng one\nf 1 2 3\ng two\nf 1 3 4\no y\nf 5 6 7\n"));
    let names: Vec<String> = asset.document.objects().iter().map(|object| object.name.decoded()).collect();
    assert_eq!(names, ["x", "y"]);
    assert!(notes(&asset, Outcome::Lost).iter().any(|note| note.contains("groups")));
    assert_eq!(read(&format!("{CUBE}{CUBE_FACES}")).document.objects()[0].name, "model");
}

#[test]
fn smoothing_groups_become_masks() {
    let faces = "s 1\nf 1 4 3 2\ns off\nf 5 6 7 8\ns 3\nf 1 2 6 5\ns 1\nf 3 4 8 7\n";
    assert_eq!(masks(&read(&format!("{CUBE}{faces}")).document.objects()[0]), [1, 1, 0, 0, 4, 4, 1, 1]);
    // Numbers above 32 take bits in order of use.
    let large = faces.replace("s 3", "s 700");
    assert_eq!(masks(&read(&format!("{CUBE}{large}")).document.objects()[0]), [1, 1, 0, 0, 2, 2, 1, 1]);
    assert_eq!(masks(&read(&format!("{CUBE}{CUBE_FACES}")).document.objects()[0]), [0; 12]);
}

#[test]
fn more_smoothing_groups_than_bits() {
    // 100 separate roofs, each smooth in itself, in a row where each touches the next.
    let mut text = String::new();
    for x in 0..101 {
        text += &format!("v {x} 0 0\nv {x} 1 {}\nv {x} 2 0\n", 0.5 + 0.1 * (x % 3) as f32);
    }
    for x in 0..100 {
        let a = 3 * x + 1;
        let (b, c) = (a + 3, a + 1);
        text += &format!("s {}\nf {a} {b} {} {c}\nf {c} {} {} {}\n", x + 1, b + 1, b + 1, b + 2, a + 2);
    }
    let asset = read(&text);
    let object = &asset.document.objects()[0];
    assert_eq!(object.faces.as_ref().unwrap().normals, None, "{:?}", asset.report);
    let numbers: Vec<aam::document::Triangle> = object
        .faces
        .as_ref()
        .unwrap()
        .triangles
        .iter()
        .enumerate()
        .map(|(index, triangle)| aam::document::Triangle { smoothing: index as i32 / 4 + 1, ..*triangle })
        .collect();
    let wanted = aam::meaning::corner_normals(&object.vertices, &numbers, SmoothingRule::Numbers);
    for (wanted, given) in wanted.iter().zip(object_normals(object, SmoothingRule::Masks)) {
        for (wanted, given) in wanted.iter().zip(given) {
            assert!(wanted.distance(given) < 1e-5, "{wanted} {given}");
        }
    }
}

#[test]
fn smoothing_across_objects_keeps_its_normals() {
    let roof = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nv 1 2 0\nv 0 2 0\n";
    let asset = read(&format!("{roof}o a\ns 1\nf 1 2 3 4\no b\nf 4 3 5 6\n"));
    let normals = |asset: &Asset, index: usize| object_normals(&asset.document.objects()[index], SmoothingRule::Masks);
    let one = read(&format!("{roof}s 1\nf 1 2 3 4\nf 4 3 5 6\n"));
    let found = [normals(&asset, 0), normals(&asset, 1)].concat();
    for (a, b) in normals(&one, 0).iter().flatten().zip(found.iter().flatten()) {
        assert!(a.distance(*b) < 1e-6, "{a} {b}");
    }
}

#[test]
fn authored_normals_decide() {
    // Smooth normals without `s`.
    let smooth = "vn -1 -1 -1\nvn 1 -1 -1\nvn 1 1 -1\nvn -1 1 -1\nvn -1 -1 1\nvn 1 -1 1\nvn 1 1 1\nvn -1 1 1\n";
    let with = |faces: &str| {
        let corner = |word: &str| {
            if word.len() == 1 && word != "f" && word != "s" { format!("{word}//{word}") } else { word.into() }
        };
        faces.lines().map(|line| line.split(' ').map(corner).collect::<Vec<_>>().join(" ") + "\n").collect::<String>()
    };
    let asset = read(&format!("{CUBE}{smooth}{}", with(CUBE_FACES)));
    let object = &asset.document.objects()[0];
    let normals = object_normals(object, SmoothingRule::Masks);
    for (triangle, corners) in object.faces.as_ref().unwrap().triangles.iter().zip(&normals) {
        for (vertex, normal) in triangle.vertices.iter().zip(corners) {
            let outwards = Vec3::from(object.vertices[*vertex as usize]) - Vec3::new(0.5, -0.5, 0.5);
            assert!(normal.distance(outwards.normalize()) < 1e-5);
        }
    }
    // The quads' diagonals make the unweighted mean miss the corner's direction, so these are explicit.
    assert!(object.faces.as_ref().unwrap().normals.is_some());
    assert!(notes(&asset, Outcome::Changed).iter().any(|note| note.contains("explicit normals")));

    // Flat normals, written by a program that repeats vertices for each: welded, no groups, nothing explicit.
    let mut text = String::new();
    for (face, normal) in CUBE_FACES.lines().zip(["0 0 -1", "0 0 1", "0 -1 0", "1 0 0", "0 1 0", "-1 0 0"]) {
        text += &format!("vn {normal}\n");
        for word in face.split(' ').skip(1) {
            text += &format!("{}\n", CUBE.lines().nth(word.parse::<usize>().unwrap() - 1).unwrap());
        }
        text += "f -4//-1 -3//-1 -2//-1 -1//-1\n";
    }
    let asset = read(&text);
    let object = &asset.document.objects()[0];
    assert_eq!((object.vertices.len(), masks(object)), (8, vec![0; 12]));
    assert_eq!(object.faces.as_ref().unwrap().normals, None);
}

#[test]
fn normals_that_agree_with_the_groups_leave_them() {
    let asset = read(&format!("{CUBE}vn 0 0 -1\nvn 0 0 1\ns 5\nf 1//1 4//1 3//1 2//1\ns 6\nf 5//2 6//2 7//2 8//2\n"));
    assert_eq!(masks(&asset.document.objects()[0]), [16, 16, 32, 32]);
    // And win where they do not.
    let asset = read(&format!("{CUBE}vn 0 0 -1\nvn 0 -1 0\ns 5\nf 1//1 4//1 3//1 2//1\nf 1//2 2//2 6//2 5//2\n"));
    assert_eq!(masks(&asset.document.objects()[0]), [0; 4]);
}

#[test]
fn polygons_points_lines_colours() {
    let asset = read(
        "v 0 0 0 1 0 0\nv 4 0 0 0 1 0\nv 4 4 0 0 0 1\nv 2 1 0 1 1 1\nv 0 4 0 0 0 0\nf 1 2 3 4 5\np 1\nl 1 2 3\nf 1 2\n",
    );
    let object = &asset.document.objects()[0];
    let faces = object.faces.as_ref().unwrap();
    let at = |index: u32| Vec3::from(object.vertices[index as usize]);
    let area: f32 = faces
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.vertices.map(at);
            0.5 * (b - a).cross(c - a).dot(Vec3::NEG_Y)
        })
        .sum();
    assert_eq!((faces.triangles.len(), area), (3, 10.0));
    assert_eq!(object.colors.as_ref().unwrap()[..3], [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]);
    let lost = notes(&asset, Outcome::Lost);
    assert!(lost.iter().any(|note| note.contains("`l`")) && lost.iter().any(|note| note.contains("`p`")), "{lost:?}");
}

#[test]
fn materials_and_textures() {
    let folder = Folder::new(&[
        (
            "model.obj",
            "mtllib my mats/the lib.mtl\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
             usemtl wood floor\nf 1/1 2/2 3/3\nusemtl nowhere\nf 1/1 3/3 2/2\n",
        ),
        (
            "my mats/the lib.mtl",
            "newmtl wood floor\r\nKa 0.1 0.1 0.1\r\nKd 0.5 0.25 0.125\r\nKs 1 1 1\r\nNs 64\r\nKe 0 0 3\r\nd 0.75\r\nillum 2\r\n\
             map_Kd -s 2 4 1 -o 0.25 0 0 wood.png\r\nmap_d mask.png -x\r\nbump -bm 2 ..\\Height Map.PNG\r\n\
             disp -mm -0.5 2 tiles/height.png\r\nmap_Ks shine.png\r\nrefl sky.png\r\nTf 0 1 1\r\nnewmtl unused\r\n",
        ),
    ]);
    folder.picture("my mats/wood.png", 2, 2, |_, _| [200, 100, 50, 255]);
    folder.picture("height map.png", 4, 4, |x, _| [20 * x as u8, 20 * x as u8, 20 * x as u8, 255]);
    folder.picture("my mats/tiles/height.png", 2, 2, |_, _| [9, 9, 9, 255]);
    let asset = folder.read("model.obj");

    let all = singles(&asset);
    assert_eq!(all.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["wood floor", "nowhere"]);
    let wood = all[0].1;
    assert_eq!((wood.ambient, wood.diffuse, wood.specular), ([0.1; 3], [0.5, 0.25, 0.125], [1.0; 3]));
    assert_eq!((wood.shininess, wood.emission, wood.transparency), (0.5, Some([0.0, 0.0, 3.0]), 0.25));
    let layer = |layer: Layer| match &wood.layers[layer as usize] {
        Flagged::Yes(texture) => texture.as_ref(),
        _ => panic!("no {}", layer.name()),
    };
    assert_eq!(layer(Layer::Diffuse).file, "my mats/wood.png");
    // ½ + 2·(u − ½ − o) = 2·u + ¼ for all u.
    assert_eq!(layer(Layer::Diffuse).tiling, [2.0, 4.0]);
    assert_eq!(layer(Layer::Diffuse).offset, [-0.375, -0.375]);
    assert_eq!(layer(Layer::Normal).file, "height map_normal.png");
    assert_eq!(layer(Layer::Displacement).file, "my mats/tiles/height.png");
    let displacement = asset.document.objects()[0].displacement.unwrap();
    assert_eq!((displacement.bias, displacement.scale, displacement.tessellation), (-0.5, 2.0, 8));
    let files: Vec<&str> = asset.textures.keys().map(String::as_str).collect();
    assert_eq!(files, ["height map_normal.png", "my mats/tiles/height.png", "my mats/wood.png"]);
    assert!(matches!(asset.textures["height map_normal.png"], TextureFile::InMemory(_)));

    let lost = notes(&asset, Outcome::Lost).join("\n");
    for expected in
        ["none.mtl", "\"nowhere\"", "mask.png", "map_Ks", "refl", "Tf", "1 of the library are used by no face"]
    {
        assert!(lost.contains(expected), "{expected} is not in:\n{lost}");
    }
    // Three layers, three lines for the triangle of wood; none for the other.
    let faces = asset.document.objects()[0].faces.as_ref().unwrap();
    assert_eq!(faces.tex_indices, [[0, 1, 2]; 3]);
}

#[test]
fn opacity_textures_join_the_diffuse_one() {
    let mtl = "newmtl a\nmap_Kd c.png\nmap_d a.png\nnewmtl b\nmap_Kd c.png\nmap_d c.png\n";
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\n";
    let folder = Folder::new(&[("m.obj", obj), ("m.mtl", mtl)]);
    folder.picture("c.png", 2, 1, |x, _| [x as u8 * 100, 10, 20, 255]);
    folder.picture("a.png", 2, 1, |x, _| [[0, 0, 0, 255], [255, 255, 255, 255]][x as usize]);
    let asset = folder.read("m.obj");
    let files: Vec<String> =
        singles(&asset).iter().map(|(_, single)| single.layers[0].as_ref().unwrap().file.decoded()).collect();
    assert_eq!(files, ["c_alpha.png", "c.png"]);
    let TextureFile::InMemory(bytes) = &asset.textures["c_alpha.png"] else { panic!() };
    let made = image::load_from_memory(bytes).unwrap().to_rgba8().into_raw();
    assert_eq!(made, [0, 10, 20, 0, 100, 10, 20, 255]);
}

#[test]
fn a_normal_map_under_bump_is_used_as_one() {
    let folder = Folder::new(&[
        ("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"),
        ("m.mtl", "newmtl a\nmap_Bump -bm 0.5 n.png\n"),
    ]);
    folder.picture("n.png", 8, 8, |x, _| if x % 2 == 0 { [128, 128, 255, 255] } else { [150, 120, 250, 255] });
    let asset = folder.read("m.obj");
    let Flagged::Yes(texture) = &singles(&asset)[0].1.layers[Layer::Normal as usize] else { panic!() };
    assert_eq!((texture.file.decoded().as_str(), texture.intensity), ("n.png", 0.5));
}

#[test]
fn roughness_and_metallic_become_phong() {
    let mtl = "newmtl a\nKd 0.5 0.5 0.5\nPr 0.3\nPm 0\nnewmtl b\nKd 0.5 0.5 0.5\nPr 0.6\nmap_Pr r.png\n";
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\n";
    let folder = Folder::new(&[("m.obj", obj), ("m.mtl", mtl)]);
    folder.picture("r.png", 2, 1, |x, _| [[0, 0, 0, 255], [255, 0, 0, 255]][x as usize]);
    let asset = folder.read("m.obj");
    let shininess: Vec<f32> = singles(&asset).iter().map(|(_, single)| single.shininess).collect();
    // 0.6 times a mean of 0.5 is 0.3 as well.
    assert!(shininess[0] > 0.0);
    assert_eq!(shininess[0], shininess[1]);
    assert_ne!(singles(&asset)[0].1.specular, [0.0; 3]);
}

#[test]
fn illumination_models() {
    let mtl = "newmtl flat\nKd 1 0 0\nKs 1 1 1\nNs 9\nillum 0\nnewmtl matte\nKd 1 0 0\nKs 1 1 1\nNs 9\nillum 1\n\
        newmtl sharp\nKd 0 0 0\nKs 1 1 1\nNs 900\nillum 2\n";
    let obj =
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl flat\nf 1 2 3\nusemtl matte\nf 1 2 3\nusemtl sharp\nf 1 2 3\n";
    let asset = Folder::new(&[("m.obj", obj), ("m.mtl", mtl)]).read("m.obj");
    let all = singles(&asset);
    assert_eq!((all[0].1.emission, all[0].1.diffuse, all[0].1.specular), (Some([1., 0., 0.]), [0.0; 3], [0.0; 3]));
    assert_eq!((all[1].1.diffuse, all[1].1.specular, all[1].1.shininess), ([1., 0., 0.], [0.0; 3], 0.0));
    assert_eq!((all[2].1.shininess, all[2].1.ambient), (900.0, [0.0; 3]));
}

#[test]
fn broken_files_say_where() {
    let folder =
        Folder::new(&[("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), ("b.obj", "\u{0}\u{1}PNG\n\u{2}x 3")]);
    let error = |name: &str| import(&folder.path(name), &ImportOptions::default(), &Silent).unwrap_err();
    let ConvertError::Broken { place, message, .. } = error("a.obj") else { panic!() };
    assert_eq!(place, "4:7");
    assert!(message.starts_with("index 4 is out of range"), "{message}");
    assert!(error("b.obj").to_string().contains("not an OBJ file"));
    assert!(matches!(error("none.obj"), ConvertError::File(_)));
}

/// Writes the asset as OBJ, reads that, and does so again.
fn round_trip(asset: &Asset) -> [(Asset, Vec<u8>); 2] {
    let mut trips = Vec::new();
    let mut current = asset.clone();
    for name in ["one", "two"] {
        let folder = Folder::new(&[]);
        let path = folder.path(&format!("{name}/model.obj"));
        export(&current, &path, &ExportOptions::default()).unwrap();
        current = import(&path, &ImportOptions::default(), &Silent).unwrap();
        // Textures outlive the folder.
        for file in current.textures.values_mut() {
            if let TextureFile::OnDisk(path) = file {
                *file = TextureFile::InMemory(std::fs::read(path).unwrap().into());
            }
        }
        trips.push((current.clone(), std::fs::read(&path).unwrap()));
    }
    trips.try_into().unwrap_or_else(|_| panic!("two trips"))
}

#[test]
fn there_and_back() {
    let mtl = "newmtl wood\nKa 0.1 0.2 0.3\nKd 0.5 0.25 0.125\nKs 1 1 1\nNs 64\nKe 0 0 3\nd 0.3\nillum 2\n\
        map_Kd -s 2 4 1 -o 0.2 0.7 0 wood.png\nnorm -bm 0.5 n.png\ndisp -mm -0.5 2 h.png\n\
        newmtl dull\nKd 1 0 0\nillum 1\nnewmtl lamp\nKd 1 1 0\nillum 0\n";
    let obj = format!(
        "mtllib m.mtl\n{CUBE}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\no box one\ns 3\nusemtl wood\nf 1/1 4/2 3/3 2/4\n\
         usemtl dull\nf 5 6 7 8\ns 1\nf 1 2 6 5\nusemtl lamp\ns off\nf 2 3 7 6\no two\nusemtl dull\nf 3 4 8 7\nf 4 1 5 8\n"
    );
    let folder = Folder::new(&[("m.obj", &obj), ("m.mtl", mtl)]);
    folder.picture("wood.png", 1, 1, |_, _| [1, 2, 3, 255]);
    folder.picture("n.png", 1, 1, |_, _| [128, 128, 255, 255]);
    folder.picture("h.png", 1, 1, |_, _| [7, 7, 7, 255]);
    let first = folder.read("m.obj");
    let [(second, text), (third, again)] = round_trip(&first);
    assert_eq!(first.document, second.document);
    assert_eq!(second.document, third.document);
    assert_eq!(text, again);
    assert_eq!(first.textures.keys().collect::<Vec<_>>(), second.textures.keys().collect::<Vec<_>>());
    assert_eq!(notes(&second, Outcome::Lost), Vec::<String>::new());
}

#[test]
fn masks_that_numbers_cannot_say_come_back_by_their_normals() {
    let mut first = read(&format!("{CUBE}s 1\n{CUBE_FACES}"));
    let object = &mut first.document.geometry.frames[0].objects[0];
    for (triangle, mask) in
        object.faces.as_mut().unwrap().triangles.iter_mut().zip([1, 1, 0, 0, 3, 3, 2, 2, 2, 2, 1, 1])
    {
        triangle.smoothing = mask;
    }
    let wanted = object_normals(&first.document.objects()[0], SmoothingRule::Masks);
    let [(second, _), _] = round_trip(&first);
    let object = &second.document.objects()[0];
    assert_eq!(object.faces.as_ref().unwrap().normals, None);
    for (wanted, given) in wanted.iter().flatten().zip(object_normals(object, SmoothingRule::Masks).iter().flatten()) {
        assert!(wanted.distance(*given) < 1e-5);
    }
}

#[test]
fn a_character_is_posed() {
    use aam::document::{Header, NodeTransform};
    let mut asset = read(&format!("{CUBE}{CUBE_FACES}"));
    asset.document.header = Some(Header::Character);
    let object = &mut asset.document.geometry.frames[0].objects[0];
    object.node = Some(NodeTransform { position: [10., 20., 30.], scale: [2., 2., -2.], ..NodeTransform::default() });
    let folder = Folder::new(&[]);
    let report = export(&asset, &folder.path("p.obj"), &ExportOptions::default()).unwrap();
    assert!(report.changes.iter().any(|change| change.property == "animation"));
    assert!(report.changes.iter().any(|change| change.property == "winding"));
    let back = folder.read("p.obj");
    let object = &back.document.objects()[0];
    let bounds = Bounds::of(object.vertices.iter().copied().map(Vec3::from)).unwrap();
    assert_eq!(bounds.min, Vec3::new(10., 18., 28.));
    assert_eq!(bounds.max, Vec3::new(12., 20., 30.));
    for (corners, triangle) in
        object_normals(object, SmoothingRule::Masks).iter().zip(&object.faces.as_ref().unwrap().triangles)
    {
        let at = Vec3::from(object.vertices[triangle.vertices[0] as usize]);
        assert!(corners[0].dot(at - bounds.center()) > 0.0, "a face is turned inside");
    }
}

fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("AAM_CORPUS").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: AAM_CORPUS is not set");
    }
    folder
}

/// Counts of the text, and bounds, area and volume by trimesh 5.2.
#[test]
fn corpus_models_against_another_tool() {
    let Some(folder) = corpus() else { return };
    type Row = (&'static str, usize, usize, [[f32; 3]; 2], f64, f64);
    let rows: [Row; 6] = [
        (
            "fandisk",
            6475,
            12946,
            [[0., 12.6055, -2.68026], [4.8279, 17.85, 0.]],
            60.669109234919674,
            20.243374882839458,
        ),
        (
            "rocker-arm",
            10044,
            20088,
            [[-0.151733, -0.257456, -0.5], [0.151733, 0.257456, 0.5]],
            1.2965518606981843,
            0.04251362358052909,
        ),
        (
            "spot",
            2930,
            5856,
            [[-0.471552, -0.736784, -0.668909], [0.471552, 0.953646, 1.049]],
            5.709518785165158,
            0.7182587880998647,
        ),
        (
            "stanford-bunny",
            34834,
            69451,
            [[-0.09469, 0.032987, -0.061874], [0.061009, 0.187321, 0.0588]],
            0.057128786060864294,
            0.0007595000885596169,
        ),
        (
            // Two of its 507 vertices lie on others.
            "suzanne",
            505,
            968,
            [[-3.86125, 0.267311, 3.25233], [-1.126875, 2.236061, 4.955455]],
            12.468539112387251,
            2.2160719890340776,
        ),
        ("teapot", 3644, 6320, [[-3., 0., -2.], [3.434, 3.15, 2.]], 52.6607934255059, 27.437841876032355),
    ];
    for (name, vertices, triangles, [low, high], area, volume) in rows {
        let options = ImportOptions { up: Some(aam_scene::Up::Z), ..ImportOptions::default() };
        let asset = import(&folder.join(format!("obj/{name}.obj")), &options, &Silent).unwrap();
        let [object] = asset.document.objects() else { panic!("{name}") };
        let faces = object.faces.as_ref().unwrap();
        assert_eq!((object.vertices.len(), faces.triangles.len()), (vertices, triangles), "{name}");
        let bounds = Bounds::of(object.vertices.iter().copied().map(Vec3::from)).unwrap();
        assert_eq!([bounds.min.to_array(), bounds.max.to_array()], [low, high], "{name}");
        let (mut found_area, mut found_volume) = (0.0, 0.0);
        for triangle in &faces.triangles {
            let [a, b, c] = triangle.vertices.map(|index| Vec3::from(object.vertices[index as usize]).as_dvec3());
            found_area += 0.5 * (b - a).cross(c - a).length();
            found_volume += a.dot(b.cross(c)) / 6.0;
        }
        // Quads may be cut along the other diagonal.
        let tolerance = if name == "suzanne" { 2e-2 } else { 1e-6 };
        assert!((found_area / area - 1.0).abs() < tolerance, "{name}: area {found_area} is not {area}");
        // An open surface has no volume of its own.
        if ["fandisk", "rocker-arm", "spot"].contains(&name) {
            assert!((found_volume / volume - 1.0).abs() < 1e-5, "{name}: volume {found_volume} is not {volume}");
        }
    }
}

#[test]
fn corpus_models_there_and_back() {
    let Some(folder) = corpus() else { return };
    for name in ["fandisk", "rocker-arm", "spot", "stanford-bunny", "suzanne", "teapot"] {
        let first = import(&folder.join(format!("obj/{name}.obj")), &ImportOptions::default(), &Silent).unwrap();
        let [(second, text), (third, again)] = round_trip(&first);
        let renamed = |asset: &Asset| {
            let mut document = asset.document.clone();
            document.geometry.frames[0].objects[0].name = "".into();
            document
        };
        assert!(renamed(&first) == renamed(&second), "{name} changed");
        assert!(second.document == third.document && text == again, "{name} changed on the second trip");
    }
}

#[test]
fn converting_a_file_takes_its_textures_along() {
    let folder = Folder::new(&[
        ("in/m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"),
        ("in/m.mtl", "newmtl a\nmap_Kd tex/c.png\n"),
    ]);
    folder.picture("in/tex/c.png", 1, 1, |_, _| [1, 2, 3, 255]);
    let names = |written: &[PathBuf], base: &Path| -> Vec<String> {
        written.iter().map(|path| path.strip_prefix(base).unwrap().display().to_string()).collect()
    };
    let options = ConvertOptions::default();
    let beside = convert(&folder.path("in/m.obj"), None, &options, &Silent).unwrap();
    assert_eq!(names(&beside.written, &folder.path("in")), ["m.aam"]);
    let away = convert(&folder.path("in/m.obj"), Some(&folder.path("out/n.aam")), &options, &Silent).unwrap();
    assert_eq!(names(&away.written, &folder.path("out")), ["tex/c.png", "n.aam"]);
    let obj = convert(&folder.path("out/n.aam"), Some(&folder.path("obj/n.obj")), &options, &Silent).unwrap();
    assert_eq!(names(&obj.written, &folder.path("obj")), ["n.mtl", "tex/c.png", "n.obj"]);
    let back = folder.read("obj/n.obj");
    assert_eq!(back.document, folder.read("in/m.obj").document);
    // Nothing is done twice, and what differs is not replaced unasked.
    assert_eq!(convert(&folder.path("in/m.obj"), None, &options, &Silent).unwrap().written, Vec::<PathBuf>::new());
    std::fs::write(folder.path("in/m.aam"), "mine").unwrap();
    let error = convert(&folder.path("in/m.obj"), None, &options, &Silent).unwrap_err().to_string();
    assert!(error.contains("m.aam: exists with other content"), "{error}");
    let error = convert(&folder.path("in/m.obj"), Some(&folder.path("in/m.obj")), &options, &Silent).unwrap_err();
    assert!(error.to_string().contains("this is the input"));
}

/// Every triangle of every AAM file of the corpus comes back from OBJ, with its normals.
#[test]
fn corpus_documents_come_back_from_obj() {
    let Some(folder) = corpus() else { return };
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder.join("aam")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let (mut files, mut triangles, mut inexact) = (0, 0, 0);
    for path in paths {
        let asset = import(&path, &ImportOptions::default(), &Silent).unwrap();
        let target = Folder::new(&[]);
        let report = export(&asset, &target.path("m.obj"), &ExportOptions::default()).unwrap();
        inexact += usize::from(report.changes.iter().any(|change| change.property == "smoothing groups"));
        let Ok(back) = import(&target.path("m.obj"), &ImportOptions::default(), &Silent) else {
            assert!(
                asset
                    .document
                    .objects()
                    .iter()
                    .all(|object| { object.faces.as_ref().is_none_or(|faces| faces.triangles.is_empty()) })
            );
            continue;
        };
        let posed = aam::meaning::world_transforms(
            &asset.document,
            &aam::meaning::Hierarchy::of(asset.document.objects()),
            0.0,
        );
        type Key = [[i64; 3]; 3];
        let collect = |document: &aam::Document, poses: Option<&[glam::Affine3A]>| {
            let rule = SmoothingRule::of(document);
            let mut found: std::collections::BTreeMap<Key, Vec<[Vec3; 3]>> = std::collections::BTreeMap::new();
            for (index, object) in document.objects().iter().enumerate() {
                let pose = poses.map_or(glam::Affine3A::IDENTITY, |poses| poses[index]);
                let normals = object_normals(object, rule);
                for (triangle, normals) in object.faces.iter().flat_map(|faces| &faces.triangles).zip(normals) {
                    let corners =
                        triangle.vertices.map(|at| pose.transform_point3(object.vertices[at as usize].into()));
                    if aam::meaning::face_normal(corners[0], corners[1], corners[2]).is_some() {
                        let key = corners.map(|corner| corner.to_array().map(|value| (value * 1e4).round() as i64));
                        let turned = normals.map(|normal| pose.transform_vector3(normal).normalize_or(normal));
                        found.entry(key).or_default().push(turned);
                    }
                }
            }
            found
        };
        let before = collect(&asset.document, Some(&posed));
        let after = collect(&back.document, None);
        assert!(before.keys().eq(after.keys()), "{}: triangles differ", path.display());
        for (key, wanted) in &before {
            let given = &after[key];
            assert_eq!(given.len(), wanted.len(), "{}", path.display());
            for wanted in wanted {
                let near = |given: &[Vec3; 3]| (0..3).all(|at| wanted[at].distance(given[at]) < 0.01);
                assert!(given.iter().any(near), "{}: {wanted:?} is not among {given:?}", path.display());
            }
            triangles += wanted.len();
        }
        files += 1;
    }
    println!("{files} files, {triangles} triangles; {inexact} with smoothing that numbers cannot say");
    assert!(files > 40);
}
