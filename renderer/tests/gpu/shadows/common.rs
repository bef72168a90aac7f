//! What holds for every technique. Digest requirements 1 to 11, 110 and 112.

use aam_renderer::{Renderer, Show};
use aam_scene::*;
use glam::{Affine3A, Quat, Vec3};

use super::*;
use crate::common::{black, directional, draw, front, point, renderer, sphere};

#[test]
fn a_surface_is_not_behind_itself() {
    let Some(mut renderer) = renderer() else { return };
    for technique in ["hard:slope_bias=1", "hard:slope_bias=1,bits=16", "hard:slope_bias=1,bits=24", "vsm", "evsm4"] {
        for depth in [0.0625, 0.3, 0.5, 0.77, 0.999] {
            let mut scene = stage(technique);
            shadows(&mut scene).sources[0].settings.resolution = 16;
            sheet(&mut scene, depth, ALL, ALL);
            let seen = texels(&mut renderer, &scene, 16);
            assert!(seen.min() > 0.999, "{technique} at {depth}: {}", seen.min());
        }
    }
}

#[test]
fn the_map_lies_on_the_world_as_it_should() {
    let Some(mut renderer) = renderer() else { return };
    let inside = |x: f32, y: f32| (0.25..0.75).contains(&x) && (0.5..0.875).contains(&y);
    let mut scene = stage("hard:resolution=32");
    sheet(&mut scene, 0.3, 0.25..0.75, 0.5..0.875);
    sheet(&mut scene, 0.9, ALL, ALL);
    let seen = texels(&mut renderer, &scene, 32);
    for y in 0..32 {
        for x in 0..32 {
            let at = |i: u32| (i as f32 + 0.5) / 16.0 - 1.0;
            assert_eq!(seen.at(x, y), f32::from(u8::from(!inside(at(x), at(y)))), "({x}, {y})");
        }
    }
}

#[test]
fn outside_of_the_volume_everything_is_lit() {
    let Some(mut renderer) = renderer() else { return };
    for technique in single() {
        for intensity in [0.3, 1.0] {
            let mut scene = stage(&format!("{technique}:resolution=16,intensity={intensity}"));
            sheet(&mut scene, 0.3, ALL, ALL);
            // To the side, beyond the far end, and before the near one.
            let mut wide = scene.clone();
            sheet(&mut wide, 0.8, ALL, ALL);
            let seen = see(&mut renderer, &wide, from_below((0.0, 0.0), 4.0), 16, 16);
            for (index, lit) in seen.lit.iter().enumerate() {
                let inside = (4..12).contains(&(index % 16)) && (4..12).contains(&(index / 16));
                if inside {
                    assert!(*lit < 1.0 - 0.9 * intensity, "{technique}: {lit}");
                } else {
                    assert_eq!(*lit, 1.0, "{technique}");
                }
            }
            for depth in [1.001, 1.5] {
                let mut scene = scene.clone();
                sheet(&mut scene, depth, ALL, ALL);
                assert!(texels(&mut renderer, &scene, 8).all(1.0), "{technique} beyond the end at {depth}");
            }
            let mut before = stage(&technique.to_string());
            sheet(&mut before, -0.5, ALL, ALL);
            assert!(texels(&mut renderer, &before, 8).all(1.0), "{technique} before the start");
        }
    }
}

#[test]
fn behind_the_source_everything_is_lit() {
    let Some(mut renderer) = renderer() else { return };
    for technique in single() {
        let mut scene = stage(&technique.to_string());
        shadows(&mut scene).sources[0].volume = Some(Camera {
            position: Vec3::ZERO,
            target: Vec3::NEG_Z,
            projection: Projection::Perspective { fov_y: std::f32::consts::FRAC_PI_2 },
            near: 0.1,
            far: 10.0,
            ..above()
        });
        // All around in front of the source, and one behind it at (1, 0.5, 3).
        sheet(&mut scene, 2.0, ALL, ALL);
        let mut in_front = scene.clone();
        sheet(&mut in_front, 4.0, ALL, ALL);
        assert!(texels(&mut renderer, &in_front, 4).min() < 0.2, "{technique} casts");
        placed(&mut scene, Affine3A::from_translation(Vec3::new(1.0, 0.5, 3.0)));
        let from_above = Camera { position: Vec3::Z * 5.0, target: Vec3::ZERO, far: 3.0, near: 1.0, ..front() };
        assert!(see(&mut renderer, &scene, from_above, 8, 8).all(1.0), "{technique}");
    }
}

/// A tilted floor, stacked sheets, a ball, and a light of every kind that a layout needs.
fn clutter(technique: ShadowTechnique) -> Scene {
    let mut scene = stage(&technique.to_string());
    scene.meshes.push(std::sync::Arc::new(sphere(6)));
    sheet(&mut scene, 0.2, -0.6..0.1, -0.7..0.9);
    sheet(&mut scene, 0.45, -0.2..0.7, -0.5..0.4);
    placed(
        &mut scene,
        Affine3A::from_rotation_translation(Quat::from_rotation_y(0.4), Vec3::new(0.0, 0.0, 0.25))
            * Affine3A::from_scale(Vec3::splat(1.5)),
    );
    scene
        .nodes
        .push(node(1, Affine3A::from_scale_rotation_translation(Vec3::splat(0.2), Quat::IDENTITY, Vec3::Z * 0.5)));
    scene.lights = vec![directional(Vec3::new(0.1, 0.2, -1.0), Vec3::ONE), point(Vec3::new(0.0, 0.1, 0.9), Vec3::ONE)];
    let source = &mut shadows(&mut scene).sources[0];
    match technique.layout {
        ShadowLayout::One => {}
        ShadowLayout::Cascades => (source.light, source.volume) = (Some(0), None),
        ShadowLayout::Cube => (source.light, source.volume) = (Some(1), None),
    }
    scene
}

fn mapped() -> impl Iterator<Item = ShadowTechnique> {
    ShadowTechnique::all().into_iter().filter(|technique| technique.filter != ShadowFilter::Volume)
}

#[test]
fn shadows_are_shares_of_light_for_every_parameter() {
    let Some(mut renderer) = renderer() else { return };
    for technique in mapped() {
        let mut scene = clutter(technique);
        let usual = ShadowSettings { resolution: 48, ..settings(&technique.to_string()) };
        for parameter in usual.parameters() {
            // What is made of a map does not depend on how many there are.
            let of_layout =
                ["resolution", "radius", "intensity", "cascades", "split", "blend"].contains(&parameter.key);
            if technique.layout != ShadowLayout::One && !of_layout {
                continue;
            }
            let values: Vec<String> = match parameter.range {
                ParameterRange::Numbers { .. } if parameter.key == "resolution" => {
                    ["1", "3", "33"].map(String::from).into()
                }
                ParameterRange::Numbers { from, to, .. } => {
                    [from, if to.is_finite() { to } else { 1e9 }].map(|value| value.to_string()).into()
                }
                ParameterRange::Switch => ["true", "false"].map(String::from).into(),
                ParameterRange::Words(words) => words.iter().map(|word| (*word).into()).collect(),
            };
            for value in values {
                let mut changed = usual;
                if parameter.set(&mut changed, &value).is_err() || changed.check().is_err() {
                    continue;
                }
                let intensity = if parameter.key == "intensity" { changed.intensity } else { 0.75 };
                changed.intensity = intensity;
                shadows(&mut scene).sources[0].settings = changed;
                let seen = see(&mut renderer, &scene, from_below((0.1, 0.0), 1.8), 12, 12);
                let sound = seen.lit.iter().all(|lit| (1.0 - intensity - 1e-6..=1.0).contains(lit));
                assert!(sound, "{changed}: {:?}", seen.lit);
            }
        }
    }
}

#[test]
fn extreme_volumes_give_shares_of_light() {
    let Some(mut renderer) = renderer() else { return };
    for technique in single() {
        for (near, far) in [(1e-3, 10.0), (0.01, 100.0), (0.3, 3.0)] {
            let mut scene = clutter(technique);
            set(&mut scene, &format!("{technique}:resolution=32"));
            shadows(&mut scene).sources[0].volume = Some(Camera {
                position: Vec3::new(0.0, 0.0, 1.2),
                projection: Projection::Perspective { fov_y: 1.5 },
                near,
                far,
                ..above()
            });
            let seen = see(&mut renderer, &scene, from_below((0.0, 0.0), 2.0), 12, 12);
            assert!(seen.lit.iter().all(|lit| (0.0..=1.0).contains(lit)), "{technique}, {near} to {far}");
        }
    }
}

#[test]
fn without_casters_everything_is_lit() {
    let Some(mut renderer) = renderer() else { return };
    for technique in mapped() {
        let mut scene = clutter(technique);
        shadows(&mut scene).casters = Members::Only(Vec::new());
        let seen = texels(&mut renderer, &scene, 8);
        // Moments that are mixed with others, so that rounding leaves them sound, tell 1 from what is next to it.
        let least = if technique.filter == ShadowFilter::Msm { 1.0 - 1e-4 } else { 1.0 };
        assert!(seen.min() >= least, "{technique}: {:?}", seen.lit);
        assert_eq!(seen.stats.caster_draws, 0);
    }
}

/// A wall that faces the camera, and a small caster to the left of the picture whose shadow falls on its middle.
fn slanting(text: &str) -> Scene {
    let mut scene = stage(text);
    placed(&mut scene, Affine3A::from_scale(Vec3::splat(1.5)));
    placed(
        &mut scene,
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.2), Quat::IDENTITY, Vec3::new(-1.3, 0.0, 1.3)),
    );
    shadows(&mut scene).sources[0].volume = Some(Camera {
        position: Vec3::new(-4.0, 0.0, 4.0),
        projection: Projection::Orthographic { height: 5.0 },
        near: 0.1,
        far: 20.0,
        ..above()
    });
    scene.lights = vec![directional(Vec3::NEG_Z, Vec3::ONE)];
    scene.materials[0] = Material { diffuse: Vec3::ONE, ..black() };
    scene
}

#[test]
fn ambient_light_and_emission_are_not_darkened() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = slanting("pcf");
    scene.lights[0].ambient = Vec3::splat(0.5);
    scene.materials[0] =
        Material { ambient: Vec3::new(0.5, 0.25, 0.0), emission: Vec3::new(0.0, 0.25, 0.5), ..black() };
    let mut shadowless = scene.clone();
    shadowless.shadows = None;
    let shadowed = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!(shadowed.bytes, draw(&mut renderer, &shadowless, &front(), &options()).bytes);
    // What diffuse and specular light add is what a full shadow takes.
    let expected = shadowed.center();
    scene.materials[0].diffuse = Vec3::splat(0.25);
    scene.materials[0].specular = Vec3::splat(0.25);
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!(picture.center(), expected);
    assert_ne!(picture.at(60, 5), draw(&mut renderer, &shadowless, &front(), &options()).at(60, 5));
}

#[test]
fn shadows_do_not_depend_on_lights_unless_they_belong_to_one() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = slanting("evsm4");
    let before = see(&mut renderer, &scene, front(), 32, 32).lit;
    scene.lights.push(point(Vec3::new(1.0, 1.0, 3.0), Vec3::splat(0.5)));
    assert_eq!(see(&mut renderer, &scene, front(), 32, 32).lit, before);
    scene.lights.clear();
    assert_eq!(see(&mut renderer, &scene, front(), 32, 32).lit, before);
    shadows(&mut scene).sources[0].enabled = false;
    assert!(see(&mut renderer, &scene, front(), 32, 32).all(1.0));
}

#[test]
fn a_source_of_a_light_darkens_that_light_alone() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = slanting("hard");
    scene.lights = vec![directional(Vec3::NEG_Z, Vec3::X), directional(Vec3::NEG_Z, Vec3::Y)];
    shadows(&mut scene).sources[0].light = Some(1);
    let picture = draw(&mut renderer, &scene, &front(), &options());
    assert_eq!((picture.center(), picture.at(60, 32)), ([255, 0, 0, 255], [255, 255, 0, 255]));
    shadows(&mut scene).sources[0].light = None;
    assert_eq!(draw(&mut renderer, &scene, &front(), &options()).center(), [0, 0, 0, 255]);
}

#[test]
fn several_sources_multiply_in_any_order() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = slanting("pcf:intensity=0.5");
    let other = ShadowSource { settings: settings("vsm:intensity=0.4"), ..shadows(&mut scene).sources[0].clone() };
    shadows(&mut scene).sources.push(other);
    let first = draw(&mut renderer, &scene, &front(), &options());
    shadows(&mut scene).sources.reverse();
    assert_eq!(first.bytes, draw(&mut renderer, &scene, &front(), &options()).bytes);
    assert_eq!((first.center()[0], first.at(60, 32)[0], first.stats.shadow_maps), (77, 255, 2));
}

#[test]
fn without_active_sources_nothing_is_drawn_for_shadows() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = slanting("evsm4");
    let mut plain = scene.clone();
    plain.shadows = None;
    let expected = draw(&mut renderer, &plain, &front(), &options());
    let built = renderer.resources().pipelines_built;
    for off in [
        |source: &mut ShadowSource| source.enabled = false,
        |source: &mut ShadowSource| (source.enabled, source.settings.intensity) = (true, 0.0),
    ] {
        off(&mut shadows(&mut scene).sources[0]);
        let picture = draw(&mut renderer, &scene, &front(), &options());
        assert_eq!(picture.bytes, expected.bytes);
        let stats = &picture.stats;
        assert_eq!(
            (stats.shadow_maps, stats.caster_draws, stats.shadow_bytes, stats.draws),
            (0, 0, 0, expected.stats.draws)
        );
        assert_eq!((renderer.resources().pipelines_built, renderer.resources().shadow_maps), (built, 0));
    }
}

#[test]
fn the_same_twice_is_the_same_to_the_bit() {
    let Some(mut first) = renderer() else { return };
    let Some(mut second) = renderer() else { return };
    for technique in mapped() {
        let mut scene = clutter(technique);
        shadows(&mut scene).sources[0].settings.resolution = 64;
        let look = |renderer: &mut Renderer| texels(renderer, &scene, 16).lit;
        let once = look(&mut first);
        assert_eq!(once, look(&mut first), "{technique}");
        // Another device is asked only about some: it compiles everything anew.
        if technique.layout == ShadowLayout::One {
            assert_eq!(once, look(&mut second), "{technique}");
        }
    }
    let mut scene = clutter(ShadowTechnique::one(ShadowFilter::Pcf));
    set(&mut scene, "pcf:kernel=poisson,resolution=64");
    assert_eq!(texels(&mut first, &scene, 16).lit, texels(&mut first, &scene, 16).lit);
}

#[test]
fn degenerate_sources_cast_nothing_and_say_why() {
    let Some(mut renderer) = renderer() else { return };
    for technique in single() {
        let broken: [fn(&mut Camera); 5] = [
            |camera| camera.far = camera.near,
            |camera| camera.projection = Projection::Orthographic { height: 0.0 },
            |camera| camera.projection = Projection::Perspective { fov_y: 1.0 },
            |camera| camera.position = camera.target,
            |camera| camera.far = f32::NAN,
        ];
        for breaks in broken {
            let mut scene = clutter(technique);
            breaks(shadows(&mut scene).sources[0].volume.as_mut().unwrap());
            let seen = texels(&mut renderer, &scene, 8);
            assert!(seen.all(1.0), "{technique}");
            assert!(
                seen.stats.warnings[0].starts_with("shadow 0 is not drawn: its volume"),
                "{:?}",
                seen.stats.warnings
            );
        }
        // A map of one texel, a mesh without triangles, and a source in the receiver.
        let mut scene = clutter(technique);
        shadows(&mut scene).sources[0].settings.resolution = 1;
        scene.meshes[1] = std::sync::Arc::new(Mesh::default());
        let share = |seen: Seen| seen.lit.iter().all(|lit| (0.0..=1.0).contains(lit));
        assert!(share(texels(&mut renderer, &scene, 8)), "{technique}");
        let mut scene = clutter(technique);
        shadows(&mut scene).sources[0].volume = Some(Camera {
            position: Vec3::new(0.0, 0.0, 0.25),
            projection: Projection::Perspective { fov_y: 1.5 },
            near: 1e-3,
            target: Vec3::new(0.0, 0.0, -1.0),
            ..above()
        });
        assert!(share(texels(&mut renderer, &scene, 8)), "{technique}");
    }
}

#[test]
fn a_source_that_is_not_there_is_lit() {
    let Some(mut renderer) = renderer() else { return };
    let scene = slanting("hard");
    let view = View { camera: front(), width: 4, height: 4, frame: 0.0 };
    assert_eq!(renderer.visibility(&scene, &view, 7, &options()).unwrap().0, [1.0; 16]);
    let picture = draw(&mut renderer, &scene, &front(), &RenderOptions { show: Show::Shadow(7), ..options() });
    assert_eq!(picture.center(), [255; 4]);
}
