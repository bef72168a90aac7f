//! A texture block's coordinate transform as `KHR_texture_transform`.
//!
//! AAM's, v up: `M·uv = ½ + R(WA)·S(UT, VT)·(uv − ½ − (UO, VO))`. Seen with v down, F: v → 1 − v, it is F·M·F, whose linear
//! part `[c·UT, s·VT; −s·UT, c·VT]` is the extension's own for rotation = WA and scale = (UT, VT), and whose translation is
//! M at the picture's top left corner (0, 1), with v flipped. So every block can be expressed, and exactly. (The extension's
//! text shows two directions of rotation; its worked example, the sample model and the implementations turn this way:
//! Khronos glTF issue 1563.)

use aam::document::Texture;
use aam::meaning::TextureLayer;
use glam::{Mat2, Vec2};

use super::json::TextureTransform;

/// The extension for a texture block; `None` for the identity.
pub(super) fn of(texture: &Texture, layer: &TextureLayer) -> Option<TextureTransform> {
    let rotation = if texture.rotation[2].is_finite() { texture.rotation[2] } else { 0.0 };
    let scale = texture.tiling.map(|value| if value.is_finite() { value } else { 1.0 });
    let matrix = layer.transform;
    let corner = matrix.transform_point2(Vec2::Y);
    // The resolved transform is the identity where the block's leaves the range of numbers.
    let linear = Mat2::from_angle(rotation) * Mat2::from_diagonal(Vec2::from(scale));
    let resolved = Mat2::from_cols(matrix.x_axis.truncate(), matrix.y_axis.truncate());
    let largest = scale[0].abs().max(scale[1].abs()).max(1.0);
    if !resolved.abs_diff_eq(linear, 1e-4 * largest) {
        return None;
    }
    let transform = TextureTransform { offset: [corner.x, 1.0 - corner.y], rotation, scale };
    let identity = TextureTransform { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] };
    (transform != identity).then_some(transform)
}

#[cfg(test)]
mod tests {
    use aam::Document;
    use aam::document::{Flagged, Layer, Material, MaterialBody, SingleMaterial};
    use aam::meaning::Materials;

    use super::*;

    /// The extension, by the equations of its worked example.
    fn apply(transform: &TextureTransform, uv: Vec2) -> Vec2 {
        let (s, c) = transform.rotation.sin_cos();
        let scaled = uv * Vec2::from(transform.scale);
        Vec2::new(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x) + Vec2::from(transform.offset)
    }

    fn resolve(texture: Texture) -> TextureLayer {
        let mut single = SingleMaterial::default();
        single.layers[Layer::Diffuse as usize] = Flagged::Yes(Box::new(texture));
        let material =
            Material { number: 0, name: "m".into(), body: MaterialBody::Single(Box::new(single)), unknown: Vec::new() };
        let document = Document { materials: vec![material], ..Document::default() };
        Materials::of(&document).leaves()[0].layers[0].clone().unwrap()
    }

    #[test]
    fn both_transforms_take_a_point_to_the_same_texel() {
        for (rotation, tiling, offset) in [
            (0.0, [1.0, 1.0], [0.0, 0.0]),
            (0.0, [4.0, 3.0], [0.25, -0.5]),
            (0.7, [1.0, 1.0], [0.0, 0.0]),
            (std::f32::consts::FRAC_PI_2, [2.0, -0.5], [0.1, 0.2]),
            (-2.0, [-1.0, 5.0], [3.0, 0.0]),
        ] {
            let texture = Texture { rotation: [0.3, 0.4, rotation], tiling, offset, ..Texture::new("a.png") };
            let layer = resolve(texture.clone());
            let transform = of(&texture, &layer);
            assert_eq!(transform.is_none(), rotation == 0.0 && tiling == [1.0; 2]);
            for uv in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.3, 0.8), Vec2::new(-2.0, 5.0)] {
                let expected = layer.transform.transform_point2(uv);
                let down = Vec2::new(uv.x, 1.0 - uv.y);
                let got = transform.map_or(down, |transform| apply(&transform, down));
                assert!(
                    (Vec2::new(got.x, 1.0 - got.y) - expected).length() < 1e-4,
                    "{texture:?} {uv}: {got} {expected}"
                );
            }
        }
    }

    #[test]
    fn numbers_that_are_none_do_no_harm() {
        let texture = Texture { rotation: [0.0, 0.0, f32::NAN], tiling: [f32::INFINITY, 2.0], ..Texture::new("a.png") };
        let transform = of(&texture, &resolve(texture.clone())).unwrap();
        assert_eq!((transform.rotation, transform.scale), (0.0, [1.0, 2.0]));
        let texture = Texture { tiling: [3e38, 1.0], offset: [3e38, 0.0], ..Texture::new("a.png") };
        assert_eq!(of(&texture, &resolve(texture.clone())), None);
    }
}
