//! Real files, against figures from trimesh 4 and assimp 5.2 (`assimp info`).

use super::*;

#[test]
fn print_everything() {
    for file in [
        "Duck.glb",
        "CesiumMilkTruck.glb",
        "BoxTextured.glb",
        "AlphaBlendModeTest.glb",
        "FlightHelmet/FlightHelmet.gltf",
        "Fox.glb",
        "CornellBox.glb",
    ] {
        let Some(path) = corpus(file) else { return };
        let start = std::time::Instant::now();
        let asset = super::super::import(&path, &ImportOptions::default(), &Silent).unwrap();
        println!("==== {file} {:?}", start.elapsed());
        for change in &asset.report.changes {
            println!("{:?} {} | {} | {} | {:?}", change.outcome, change.subject, change.property, change.note, change.size);
        }
        for material in &asset.document.materials {
            println!("{material:?}");
        }
        for object in asset.document.objects() {
            println!("{} {} par {} mat {} v {} t {:?}", object.id, object.name, object.parent, object.material, object.vertices.len(), object.faces.as_ref().map(|f| (f.triangles.len(), f.tex_coords.len(), f.normals.as_ref().map(Vec::len))));
        }
        println!("{:?} {:?} {:?}", asset.textures.keys(), asset.lights, asset.cameras);
    }
}
