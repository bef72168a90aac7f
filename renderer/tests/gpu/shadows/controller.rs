//! Who casts, who receives, and what may be left out. Digest requirements 83 to 94.

use glam::{Affine3A, Vec3};

use super::*;
use crate::common::{renderer, sphere};

const SIZE: u32 = 16;

/// A roof, something that hangs below it in the tree, and a floor.
fn family() -> (Scene, [NodeId; 3]) {
    let mut scene = stage(&format!("hard:resolution={SIZE}"));
    let roof = sheet(&mut scene, 0.3, -1.0..0.0, ALL);
    let child = sheet(&mut scene, 0.4, 0.0..0.5, ALL);
    // In the roof's own coordinates.
    let above = scene.nodes[roof.index()].local;
    scene.nodes[child.index()].local = above.inverse() * scene.nodes[child.index()].local;
    scene.nodes[child.index()].parent = Some(roof);
    let floor = sheet(&mut scene, 0.9, ALL, ALL);
    (scene, [roof, child, floor])
}

/// Whether the floor is lit below the roof, below its child, and beside both.
fn lit(renderer: &mut Renderer, scene: &Scene) -> [f32; 3] {
    let row = profile(renderer, scene, 0.05, SIZE);
    [row[4], row[10], row[14]]
}

#[test]
fn children_cast_with_their_parents() {
    let Some(mut renderer) = renderer() else { return };
    let (mut scene, [roof, child, floor]) = family();
    assert_eq!(lit(&mut renderer, &scene), [0.0, 0.0, 1.0], "all cast");
    for (casters, expected) in [
        (vec![roof], [0.0, 0.0, 1.0]),
        (vec![child], [1.0, 0.0, 1.0]),
        (vec![floor], [1.0, 1.0, 1.0]),
        (vec![], [1.0, 1.0, 1.0]),
        (vec![roof, floor, child], [0.0, 0.0, 1.0]),
    ] {
        shadows(&mut scene).casters = Members::Only(casters.clone());
        assert_eq!(lit(&mut renderer, &scene), expected, "{casters:?}");
    }
}

#[test]
fn children_receive_with_their_parents() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = stage(&format!("hard:resolution={SIZE}"));
    sheet(&mut scene, 0.3, ALL, ALL);
    let parent = sheet(&mut scene, 0.6, -1.0..0.0, ALL);
    let child = sheet(&mut scene, 0.6, 0.0..1.0, ALL);
    scene.nodes[child.index()].local = scene.nodes[parent.index()].local.inverse() * scene.nodes[child.index()].local;
    scene.nodes[child.index()].parent = Some(parent);
    for (receivers, expected) in [
        (Members::All, [0.0, 0.0]),
        (Members::Only(vec![parent]), [0.0, 0.0]),
        (Members::Only(vec![child]), [1.0, 0.0]),
        (Members::Only(vec![]), [1.0, 1.0]),
    ] {
        shadows(&mut scene).receivers = receivers.clone();
        let row = profile(&mut renderer, &scene, 0.05, SIZE);
        assert_eq!([row[4], row[12]], expected, "{receivers:?}");
    }
}

#[test]
fn each_caster_is_drawn_once_for_each_source() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = stage(&format!("vsm:resolution={SIZE}"));
    // Two meshes: two draw calls, whatever the number of instances.
    scene.meshes.push(std::sync::Arc::new(sphere(5)));
    let floor = sheet(&mut scene, 0.9, ALL, ALL);
    scene.nodes.push(node(1, Affine3A::from_scale(Vec3::splat(0.3))));
    let counts = |renderer: &mut Renderer, scene: &Scene| {
        let stats = texels(renderer, scene, 8).stats;
        (stats.shadow_maps, stats.caster_draws)
    };
    assert_eq!(counts(&mut renderer, &scene), (1, 2));
    let second = shadows(&mut scene).sources[0].clone();
    shadows(&mut scene).sources.push(second);
    assert_eq!(counts(&mut renderer, &scene), (2, 4));
    shadows(&mut scene).casters = Members::Only(vec![floor]);
    assert_eq!(counts(&mut renderer, &scene), (2, 2));
    shadows(&mut scene).sources[0].enabled = false;
    assert_eq!(counts(&mut renderer, &scene), (1, 1));
    scene.nodes[floor.index()].visible = false;
    assert_eq!(counts(&mut renderer, &scene), (1, 0));
}

#[test]
fn sources_can_be_changed_between_pictures() {
    let Some(mut renderer) = renderer() else { return };
    let (mut scene, _) = family();
    for (text, expected) in [
        ("hard", 0.0),
        ("hard:intensity=0.25", 0.75),
        ("hard:intensity=0.25,resolution=64", 0.75),
        ("esm:exponent=3", (-3.0_f32 * 0.5).exp()),
        ("esm:exponent=3,intensity=0.5", 0.5 + 0.5 * (-3.0_f32 * 0.5).exp()),
        ("esm:exponent=3,bleed_reduction=0.4", 0.0),
        ("vsm:min_variance=0.01", 0.01 / (0.01 + 0.25)),
        ("hard:resolution=16", 0.0),
    ] {
        set(&mut scene, text);
        shadows(&mut scene).sources[0].settings.resolution = SIZE;
        let found = lit(&mut renderer, &scene)[1];
        // Below the child, 0.5 above the floor, except where the kernel reaches the roof.
        assert!((found - expected).abs() < 2e-2, "{text}: {found}, not {expected}");
    }
}

#[test]
fn nothing_is_made_once_a_picture_has_been_drawn() {
    let Some(mut renderer) = renderer() else { return };
    for technique in ["hard", "pcf", "pcss", "vsm", "esm", "evsm2", "evsm4", "msm"] {
        let (mut scene, [roof, ..]) = family();
        set(&mut scene, &format!("{technique}:resolution={SIZE}"));
        texels(&mut renderer, &scene, 8);
        let before = renderer.resources();
        for step in 0..4 {
            scene.nodes[roof.index()].local.translation.x += 0.1 * step as f32;
            let settings = &mut shadows(&mut scene).sources[0].settings;
            (settings.intensity, settings.radius) = (0.5 + 0.1 * step as f32, 1 + step);
            let stats = texels(&mut renderer, &scene, 8).stats;
            assert_eq!((stats.pipelines_built, stats.shadow_maps), (0, 1), "{technique}");
        }
        // Targets of the technique before go after some pictures.
        let targets = renderer.resources().targets.min(before.targets);
        assert_eq!(renderer.resources(), aam_renderer::Resources { targets, ..before }, "{technique}");
    }
}

#[test]
fn maps_of_sources_that_are_gone_are_freed() {
    let Some(mut renderer) = renderer() else { return };
    let (mut scene, _) = family();
    texels(&mut renderer, &scene, 8);
    assert_eq!(renderer.resources().shadow_maps, 1);
    scene.shadows = None;
    crate::common::draw(&mut renderer, &scene, &crate::common::front(), &options());
    assert_eq!(renderer.resources().shadow_maps, 0);
}

/// Balls, some of them outside of the volume, over a floor.
fn balls(text: &str) -> Scene {
    let mut scene = stage(text);
    scene.meshes.push(std::sync::Arc::new(sphere(16)));
    sheet(&mut scene, 0.95, ALL, ALL);
    for (x, y, z) in
        [(0.0, 0.0, 0.5), (0.6, 0.5, 0.3), (-0.9, 0.4, 0.6), (-0.3, -0.95, 0.95), (4.0, 0.0, 0.5), (0.0, 0.3, 2.0)]
    {
        let local =
            Affine3A::from_scale_rotation_translation(Vec3::splat(0.2), glam::Quat::IDENTITY, Vec3::new(x, y, z));
        scene.nodes.push(node(1, local));
    }
    scene
}

#[test]
fn leaving_out_casters_that_are_outside_changes_nothing() {
    let Some(mut renderer) = renderer() else { return };
    for technique in ["hard", "evsm4"] {
        let mut scene = balls(&format!("{technique}:resolution=64"));
        shadows(&mut scene).culling = ShadowCulling { back_faces: false, casters: false, sources: false };
        let all = texels(&mut renderer, &scene, 64);
        shadows(&mut scene).culling.casters = true;
        let some = texels(&mut renderer, &scene, 64);
        assert_eq!(some.lit, all.lit);
        // The ball at x = 4 and the one above the source are not drawn; the ones on the edge are.
        assert!(some.stats.triangles < all.stats.triangles);
        let ball = scene.meshes[1].indices.len() as u64 / 3;
        assert_eq!(all.stats.triangles - some.stats.triangles, 2 * ball);
    }
}

#[test]
fn leaving_out_back_faces_changes_next_to_nothing_on_closed_meshes() {
    let Some(mut renderer) = renderer() else { return };
    let mut scene = balls("hard:resolution=128");
    // The ball that the near end cuts open is not closed any more.
    scene.nodes.remove(4);
    let all = texels(&mut renderer, &scene, 128).lit;
    shadows(&mut scene).culling.back_faces = true;
    let some = texels(&mut renderer, &scene, 128).lit;
    let apart = all.iter().zip(&some).filter(|(a, b)| a != b).count();
    assert!(apart * 100 < all.len(), "{apart} of {} differ", all.len());
}

#[test]
fn sources_that_the_camera_cannot_see_cost_nothing() {
    let Some(mut renderer) = renderer() else { return };
    for technique in ["hard", "evsm4"] {
        let mut scene = balls(&format!("{technique}:resolution=64"));
        let beside = from_below((2.4, 0.0), 2.0);
        let seen = see(&mut renderer, &scene, beside.clone(), 8, 8);
        assert_eq!((seen.stats.shadow_maps, seen.stats.caster_draws), (0, 0));
        assert!(seen.all(1.0));
        shadows(&mut scene).culling.sources = false;
        let all = see(&mut renderer, &scene, beside, 8, 8);
        assert_eq!((all.stats.shadow_maps, &all.lit), (1, &seen.lit));
        // One that it just sees is drawn.
        shadows(&mut scene).culling.sources = true;
        assert_eq!(see(&mut renderer, &scene, from_below((1.9, 0.0), 2.0), 8, 8).stats.shadow_maps, 1);
    }
}

#[test]
fn kept_maps_are_used_again_and_go_stale() {
    let Some(mut renderer) = renderer() else { return };
    let keep = RenderOptions { keep_shadow_maps: true, ..options() };
    for technique in ["hard", "evsm4"] {
        let (mut scene, [roof, ..]) = family();
        set(&mut scene, &format!("{technique}:resolution={SIZE}"));
        scene.nodes.remove(1);
        let look = |renderer: &mut Renderer, scene: &Scene, options: &RenderOptions| {
            see_with(renderer, scene, from_below((0.0, 0.05), 2.0 / SIZE as f32), SIZE, 1, options)
        };
        // With nothing to keep the flag does nothing.
        let Some(mut fresh) = self::renderer() else { return };
        let first = look(&mut fresh, &scene, &keep);
        assert_eq!((first.stats.shadow_maps, first.lit[3] < 0.01, first.lit[13]), (1, true, 1.0));
        assert_eq!(look(&mut renderer, &scene, &options()).lit, first.lit);
        scene.nodes[roof.index()].local.translation.x += 1.0;
        let stale = look(&mut renderer, &scene, &keep);
        assert_eq!((stale.stats.shadow_maps, stale.stats.caster_draws), (0, 0));
        assert_eq!(stale.lit, first.lit, "{technique}: the shadow stays where it was");
        let moved = look(&mut renderer, &scene, &options());
        assert_eq!((moved.stats.shadow_maps, moved.lit[3], moved.lit[12] < 0.01), (1, 1.0, true));
    }
}
