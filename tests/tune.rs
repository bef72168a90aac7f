//! `aam tune` as a user meets it.

mod common;

use common::Folder;

const CUBE: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn a_convex_object_needs_one_hull_and_the_file_gets_it() {
    let folder = Folder::new();
    folder.write("cube.obj", CUBE);
    let said = folder.aam(&["tune", "--physics", "cube.obj", "--drops", "3", "-o", "cube.aam"]).succeeds();
    said.says("1 hull is enough").says("closed surface");
    folder.aam(&["check", "cube.aam", "--only", "physics"]).succeeds();
    folder.aam(&["simulate", "cube.aam", "--time", "0.2"]).succeeds().says("1 dynamic");
    let json = folder.aam(&["tune", "--physics", "cube.aam", "--drops", "3", "--json"]).succeeds().json();
    let object = &json["objects"][0];
    assert_eq!((object["hulls"].as_u64(), object["enough"].as_bool()), (Some(1), Some(true)));
    assert!(object["tried"][0]["errors"]["rest"].as_f64().expect("an error") < 0.01);
}

#[test]
fn what_cannot_be_tuned_is_said() {
    let folder = Folder::new();
    folder.write("cube.obj", CUBE);
    folder.aam(&["tune", "--physics", "nothing.obj"]).fails(2).says("nothing.obj");
    folder.aam(&["tune", "--physics", "cube.obj", "-o", "cube.obj"]).fails(2).says("replace its input");
    folder.aam(&["tune", "--physics", "cube.obj", "--max-error", "7"]).fails(2).says("--max-error");
    folder.write("plate.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.aam(&["tune", "--physics", "plate.obj"]).fails(2).says("flat");
}
