//! The colour map of error pictures.

/// Every 15th entry of the 256 of magma (S. van der Walt, N. Smith, 2015, CC0); between them a line is at most 3 steps
/// off.
const KNOTS: [[u8; 3]; 18] = [
    [0, 0, 4],
    [9, 7, 32],
    [26, 16, 66],
    [49, 17, 101],
    [74, 16, 121],
    [98, 25, 128],
    [121, 34, 130],
    [145, 43, 129],
    [170, 51, 125],
    [194, 59, 117],
    [217, 70, 107],
    [236, 88, 96],
    [247, 114, 92],
    [252, 142, 100],
    [254, 170, 116],
    [254, 198, 138],
    [253, 226, 163],
    [252, 253, 191],
];

/// The magma colour of a value in `[0, 1]`, from black through magenta to pale yellow; evenly brighter to the eye.
pub fn magma(value: f32) -> [u8; 3] {
    let shown = if value > 0.0 { value.min(1.0) } else { 0.0 };
    let place = shown * (KNOTS.len() - 1) as f32;
    let knot = (place as usize).min(KNOTS.len() - 2);
    let share = place - knot as f32;
    [0, 1, 2].map(|channel| {
        let (a, b) = (f32::from(KNOTS[knot][channel]), f32::from(KNOTS[knot + 1][channel]));
        (a + (b - a) * share).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::magma;

    #[test]
    fn the_map_is_matplotlibs_within_three_steps() {
        let published = [
            (0, [0, 0, 4]),
            (32, [29, 17, 71]),
            (96, [131, 38, 129]),
            (128, [183, 55, 121]),
            (176, [245, 107, 92]),
            (255, [252, 253, 191]),
        ];
        for (index, color) in published {
            let found = magma(index as f32 / 255.0);
            assert!(found.iter().zip(&color).all(|(a, b): (&u8, &u8)| a.abs_diff(*b) <= 3), "{index}: {found:?}");
        }
        assert_eq!((magma(-1.0), magma(f32::NAN), magma(7.0)), (magma(0.0), magma(0.0), magma(1.0)));
    }
}
