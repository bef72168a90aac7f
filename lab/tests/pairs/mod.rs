//! Pairs of pictures, made by whole-number formulas, for comparing FLIP implementations.

use aam_scene::{Image, Pixels};

/// Pictures to compare: a name, the reference, the test.
pub(crate) fn pairs() -> Vec<(&'static str, Image, Image)> {
    let (width, height) = (96, 64);
    let picture = |texel: &dyn Fn(u32, u32) -> [u8; 3]| image(width, height, texel);
    vec![
        ("equal", picture(&ramp), picture(&ramp)),
        ("quantised", picture(&ramp), picture(&|x, y| ramp(x, y).map(|value| value / 16 * 16 + 8))),
        (
            "noise",
            picture(&ramp),
            picture(&|x, y| {
                let noise = hash(x, y) % 41;
                ramp(x, y).map(|value| value.saturating_add(noise as u8).saturating_sub(20))
            }),
        ),
        ("shifted edge", picture(&|x, y| disc(x, y)), picture(&|x, y| disc(x + 1, y))),
        (
            "channels swapped",
            picture(&ramp),
            picture(&|x, y| {
                let [r, g, b] = ramp(x, y);
                [g, b, r]
            }),
        ),
        ("black and white", picture(&|_, _| [0; 3]), picture(&|_, _| [255; 3])),
        ("green and blue", picture(&|_, _| [0, 255, 0]), picture(&|_, _| [0, 0, 255])),
        ("checker and grey", picture(&|x, y| [255 * ((x + y) % 2) as u8; 3]), picture(&|_, _| [188; 3])),
        ("one bright pixel", picture(&|_, _| [60; 3]), picture(&|x, y| [if (x, y) == (48, 20) { 255 } else { 60 }; 3])),
        ("smaller than the filters", image(5, 3, &ramp), image(5, 3, &|x, y| disc(9 * x, 20 * y))),
    ]
}

fn image(width: u32, height: u32, texel: &dyn Fn(u32, u32) -> [u8; 3]) -> Image {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| texel(x, y)));
    let pixels = Pixels::Rgba8(texels.flat_map(|[r, g, b]| [r, g, b, 255]).collect());
    Image { width, height, pixels }
}

fn ramp(x: u32, y: u32) -> [u8; 3] {
    [(x * 5 / 2 % 256) as u8, (y * 4 % 256) as u8, ((x * 3 + y * 2) % 256) as u8]
}

fn disc(x: u32, y: u32) -> [u8; 3] {
    let (dx, dy) = (x as i32 - 47, y as i32 - 31);
    if dx * dx + dy * dy < 500 { [230, 120, 40] } else { [40, 60, 90] }
}

fn hash(x: u32, y: u32) -> u32 {
    let mut state = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
    state = (state ^ state >> 15).wrapping_mul(0x2c1b_3c6d);
    (state ^ state >> 12).wrapping_mul(0x297a_2d39) >> 8
}
