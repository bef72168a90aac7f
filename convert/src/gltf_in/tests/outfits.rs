//! Lights and cameras.

use aam_scene::{Falloff, LightKind, Projection};
use glam::Vec3;

use super::*;

fn lit(light: Value, node: Value) -> Asset {
    let mut file = Builder::triangle();
    file.set("/extensions", json!({ "KHR_lights_punctual": { "lights": [light] } }));
    let mut node = node;
    node["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    file.push("nodes", node);
    file.import()
}

#[test]
fn a_point_light_of_pi_candela_is_white_at_one_metre() {
    let light = json!({ "type": "point", "color": [1.0, 0.5, 0.0], "intensity": std::f32::consts::PI, "range": 4.0 });
    let asset = lit(light, json!({ "name": "lamp", "translation": [1.0, 2.0, 3.0] }));
    let [light] = asset.lights.as_slice() else { panic!("one light") };
    assert_eq!(light.name, "lamp");
    assert_eq!(light.kind, LightKind::Point { position: Vec3::new(1.0, -3.0, 2.0), falloff: Falloff::InverseSquare });
    assert_near(light.diffuse.to_array(), [1.0, 0.5, 0.0], 1e-6);
    assert_eq!(light.specular, light.diffuse);
    assert_eq!(light.ambient, Vec3::ZERO);
    assert!(reported(&asset, Outcome::Lost, "light range"));
    assert!(!reported(&asset, Outcome::Changed, "light intensity"));
}

#[test]
fn directions_follow_the_node() {
    // A quarter turn around x takes -z to +y, which is up: AAM's z.
    let quarter = [std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2];
    let asset = lit(json!({ "type": "directional", "intensity": 1000.0 }), json!({ "rotation": quarter }));
    let LightKind::Directional { direction } = asset.lights[0].kind else { panic!("a directional light") };
    assert_near(direction.to_array(), [0.0, 0.0, 1.0], 1e-6);
    assert!(reported(&asset, Outcome::Changed, "light intensity"), "1000 lux need an exposure");

    let spot = json!({ "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.4 } });
    let asset = lit(spot, json!({ "scale": [2.0, 2.0, 2.0] }));
    let LightKind::Spot { direction, inner, outer, .. } = asset.lights[0].kind else { panic!("a spot") };
    assert_near(direction.to_array(), [0.0, 1.0, 0.0], 1e-6);
    assert_eq!((inner, outer), (0.1, 0.4));
}

#[test]
fn a_perspective_camera() {
    let mut file = Builder::triangle();
    let lens = json!({ "yfov": 0.7, "znear": 0.01, "aspectRatio": 1.5 });
    file.push("cameras", json!({ "type": "perspective", "perspective": lens, "name": "lens" }));
    file.push("nodes", json!({ "camera": 0, "name": "eye", "translation": [0.0, 0.0, 5.0] }));
    let asset = file.import();
    let [camera] = asset.cameras.as_slice() else { panic!("one camera") };
    assert_eq!(camera.name, "eye");
    assert_eq!(camera.position, Vec3::new(0.0, -5.0, 0.0));
    assert_near((camera.target - camera.position).normalize().to_array(), [0.0, 1.0, 0.0], 1e-6);
    assert_near([(camera.target - camera.position).length()], [5.0], 1e-5);
    assert_near(camera.up.to_array(), [0.0, 0.0, 1.0], 1e-6);
    assert_eq!(camera.projection, Projection::Perspective { fov_y: 0.7 });
    assert_eq!(camera.near, 0.01);
    assert!(camera.far >= 10.0, "a camera without a far plane sees everything: {}", camera.far);
    assert!(reported(&asset, Outcome::Lost, "camera aspect ratio"));
}

#[test]
fn an_impossible_field_of_view_is_narrowed() {
    let mut file = Builder::triangle();
    file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 4.0, "znear": 0.01 } }));
    file.push("nodes", json!({ "camera": 0 }));
    let asset = file.import();
    assert!(matches!(asset.cameras[0].projection, Projection::Perspective { fov_y } if fov_y < std::f32::consts::PI));
    assert!(reported(&asset, Outcome::Changed, "camera field of view"));
}

#[test]
fn an_orthographic_camera() {
    let mut file = Builder::triangle();
    let lens = json!({ "xmag": 2.0, "ymag": 3.0, "znear": 0.0, "zfar": 50.0 });
    file.push("cameras", json!({ "type": "orthographic", "orthographic": lens }));
    file.push("nodes", json!({ "camera": 0 }));
    let asset = file.import();
    assert_eq!(asset.cameras[0].projection, Projection::Orthographic { height: 6.0 });
    assert!(asset.cameras[0].near > 0.0 && asset.cameras[0].far == 50.0);
}
