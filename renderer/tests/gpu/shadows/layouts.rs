//! Cascades and cubes. Digest requirements 33 to 37.

use glam::{Affine3A, Vec3};

use super::*;
use crate::common::{directional, point, renderer};

/// A wide floor below a sun in the zenith, and half a roof whose edge runs away from the camera.
fn landscape(text: &str) -> Scene {
    let mut scene = stage(text);
    scene.up = Up::Z;
    scene.lights = vec![directional(Vec3::NEG_Z, Vec3::ONE)];
    let source = &mut shadows(&mut scene).sources[0];
    (source.light, source.volume) = (Some(0), None);
    placed(
        &mut scene,
        Affine3A::from_translation(Vec3::new(-20.0, 20.0, 6.0)) * Affine3A::from_scale(Vec3::new(20.0, 30.0, 1.0)),
    );
    placed(
        &mut scene,
        Affine3A::from_translation(Vec3::new(0.0, 20.0, 0.0)) * Affine3A::from_scale(Vec3::new(60.0, 60.0, 1.0)),
    );
    scene
}

/// Stands below the roof and looks along its edge, at the floor.
fn along_the_edge() -> Camera {
    Camera {
        name: "walker".into(),
        position: Vec3::new(0.3, 0.0, 2.0),
        target: Vec3::new(0.3, 10.0, 0.5),
        up: Vec3::Z,
        projection: Projection::Perspective { fov_y: 0.5 },
        near: 1.0,
        far: 40.0,
    }
}

#[test]
fn penumbras_are_as_wide_on_both_sides_of_a_split() {
    let Some(mut renderer) = renderer() else { return };
    for technique in ["csm-evsm4", "csm-vsm", "csm-pcf"] {
        let text = format!("{technique}:resolution=256,radius=10,cascades=2,split=0,blend=0");
        let (width, height) = (480, 200);
        let camera = along_the_edge();
        let look = (camera.target - camera.position).normalize();
        let up = Vec3::X.cross(look);
        let seen = see(&mut renderer, &landscape(&text), camera, width, height);
        let mut widths: Vec<(f32, f32)> = Vec::new();
        for y in 0..height {
            // The distance along the axis at which this row meets the floor.
            let v = 0.25_f32.tan() * (2.0 * (y as f32 + 0.5) / height as f32 - 1.0);
            let direction = look + v * up;
            let depth = -2.0 / direction.z;
            let row = seen.row(y);
            if !(0.0..28.0).contains(&depth) || row[0] > 0.05 || row[width as usize - 1] < 0.95 {
                continue;
            }
            let pixel = 2.0 * depth * 0.25_f32.tan() / height as f32;
            widths.push((depth, penumbra(row) * pixel));
        }
        let depths = (widths.last().unwrap().0, widths[0].0);
        assert!(depths.0 > 1.5 * depths.1 || depths.1 > 1.5 * depths.0, "both sides of splits are seen: {depths:?}");
        let mut sorted: Vec<f32> = widths.iter().map(|(_, width)| *width).collect();
        sorted.sort_by(f32::total_cmp);
        let median = sorted[sorted.len() / 2];
        for (depth, width) in &widths {
            assert!((width / median - 1.0).abs() < 0.1, "{technique}: {width} at {depth}, {median} elsewhere");
        }
    }
}

#[test]
fn edges_stay_when_the_camera_moves() {
    let Some(mut renderer) = renderer() else { return };
    let scene = {
        let mut scene = landscape("csm-hard:resolution=128,cascades=2,blend=0");
        // A fence across the view.
        for post in 0..12 {
            let at = Vec3::new(0.15 + 0.61 * post as f32 - 3.0, 8.0, 3.0);
            placed(&mut scene, Affine3A::from_translation(at) * Affine3A::from_scale(Vec3::new(0.17, 5.3, 1.0)));
        }
        scene
    };
    // From below through the floor: parallel rays, so that a picture is moved by whole pixels. The view's depths, and
    // with them the cascades, stay.
    let pixel = 8.0 / 128.0;
    let looking_up = |steps: f32| Camera {
        position: Vec3::new(steps * pixel, 8.0, -3.0),
        target: Vec3::new(steps * pixel, 8.0, 0.0),
        up: Vec3::Y,
        projection: Projection::Orthographic { height: 8.0 },
        near: 0.5,
        far: 20.0,
        name: String::new(),
    };
    let still = see(&mut renderer, &scene, looking_up(0.0), 128, 128);
    assert!(still.lit.contains(&0.0) && still.lit.contains(&1.0));
    for steps in [1_u32, 3, 10] {
        let moved = see(&mut renderer, &scene, looking_up(steps as f32), 128, 128);
        let mut apart = 0;
        for y in 0..128 {
            for x in steps..128 {
                apart += u32::from(still.at(x, y) != moved.at(x - steps, y));
            }
        }
        assert!(apart <= 16, "{steps} pixels: {apart} of {} differ", 128 * 128);
    }
}

#[test]
fn cascades_end_where_the_camera_sees_no_more() {
    let Some(mut renderer) = renderer() else { return };
    for technique in ["csm-hard", "csm-pcf", "csm-esm", "csm-evsm4", "csm-msm"] {
        // All of the scene is in some cascade: under the roof there is no light anywhere.
        let scene = landscape(&format!("{technique}:resolution=128"));
        let mut camera = along_the_edge();
        (camera.position.x, camera.target.x) = (-6.0, -6.0);
        let seen = see(&mut renderer, &scene, camera, 16, 16);
        assert!(seen.lit[..64].iter().all(|lit| *lit < 0.01), "{technique}: {:?}", &seen.lit[..64]);
    }
}

/// A lamp one metre above a floor, and half a roof half way between them with its edge along x.
fn lamp(text: &str) -> Scene {
    let mut scene = stage(text);
    scene.lights = vec![point(Vec3::Z, Vec3::ONE)];
    let source = &mut shadows(&mut scene).sources[0];
    (source.light, source.volume) = (Some(0), None);
    sheet(&mut scene, 0.5, -2.0..2.0, 0.1..2.0);
    sheet(&mut scene, 1.0, ALL, ALL);
    scene
}

/// The picture of the floor on a line across the shadow's edge, which lies at y = 0.2 everywhere.
fn across(renderer: &mut Renderer, scene: &Scene, x: f32) -> Vec<f32> {
    see(renderer, scene, Camera { up: Vec3::X, ..from_below((x, 0.2), 0.8 / 256.0) }, 256, 1).lit
}

#[test]
fn hard_edges_go_on_across_the_faces_of_a_cube() {
    let Some(mut renderer) = renderer() else { return };
    let scene = lamp("cube-hard:resolution=64");
    // The lower face sees up to x = 1; beyond, the floor is seen by a face at the side, at a grazing angle.
    for x in [0.0, 0.5, 0.9, 0.99, 1.01, 1.1, 1.5] {
        let row = across(&mut renderer, &scene, x);
        let edge = crossing(&row, 0.5).unwrap();
        // Half a texel of the roof's distance, on the floor.
        let texel = 2.2 / 64.0 * x.max(1.0) / (0.8 / 256.0);
        assert!((edge - 128.0).abs() <= texel, "at x = {x}: {edge}, and a texel is {texel}");
    }
}

#[test]
fn soft_edges_go_on_across_the_faces_of_a_cube() {
    let Some(mut renderer) = renderer() else { return };
    for technique in ["cube-pcf", "cube-vsm", "cube-esm", "cube-evsm2", "cube-evsm4", "cube-msm"] {
        // Each face cuts the roof's edge into texels of its own: the mean over where the edge is in a texel.
        let mut mean = |x: f32| -> Vec<f32> {
            let mut sum = vec![0.0; 256];
            for part in 0..8 {
                let mut scene = lamp(&format!("{technique}:resolution=128,radius=4"));
                // 128 texels see 117 of their face, and 5.5 of each neighbour.
                let moved = part as f32 / 8.0 / 117.0;
                scene.nodes[0].local.translation.y += moved;
                let camera = Camera { up: Vec3::X, ..from_below((x, 0.2 + 2.0 * moved), 0.8 / 256.0) };
                let row = see(&mut renderer, &scene, camera, 256, 1).lit;
                sum.iter_mut().zip(row).for_each(|(sum, lit)| *sum += lit / 8.0);
            }
            sum
        };
        let [inside, outside] = [0.999_99, 1.000_01].map(&mut mean);
        let jump = inside.iter().zip(&outside).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // The kernel is a square on each face, and the edge slants on the second.
        assert!(jump <= 5.0 / 255.0, "{technique}: a step of {jump}");
        assert!(inside[5].min(inside[250]) < 0.02 && inside[5].max(inside[250]) > 0.98, "{technique}");
    }
}

#[test]
fn several_sources_with_one_map_are_a_cube() {
    let Some(mut renderer) = renderer() else { return };
    let cube = lamp("cube-hard:resolution=256");
    let mut one = lamp("hard:resolution=256");
    // What the lower face sees.
    shadows(&mut one).sources[0].volume = Some(Camera {
        projection: Projection::Perspective { fov_y: std::f32::consts::FRAC_PI_2 },
        near: 0.1,
        far: 5.0,
        ..above()
    });
    let mut look = |scene: &Scene| see(&mut renderer, scene, from_below((0.0, 0.2), 1.2), 96, 96).lit;
    let apart = look(&cube).iter().zip(look(&one)).filter(|(a, b)| *a != b).count();
    // A texel along the edge: 0.0078 m of 1.2.
    assert!(apart <= 96, "{apart} pixels differ");
}
