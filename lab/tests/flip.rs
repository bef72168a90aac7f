//! FLIP against the authors' implementation.

mod pairs;

use std::error::Error;
use std::path::Path;

use aam_lab::metrics::{CompareError, PIXELS_PER_DEGREE, flip};
use aam_scene::Pixels;

/// Where a pixel's value is compared, as shares of width and height.
const PROBES: [(f64, f64); 4] = [(0.0, 0.0), (0.5, 0.5), (0.25, 0.75), (0.99, 0.3)];

/// `lab/tests/data/flip.csv` comes from `flip-evaluator` 1.7:
/// `AAM_FLIP_PAIRS=/tmp/pairs cargo test -p aam-lab --test flip -- --ignored`, then
/// `python3 lab/tests/data/flip.py /tmp/pairs > lab/tests/data/flip.csv`.
#[test]
fn flip_agrees_with_the_authors_implementation() -> Result<(), Box<dyn Error>> {
    let table = include_str!("data/flip.csv");
    let pairs = pairs::pairs();
    assert_eq!(table.lines().count(), 2 * pairs.len() + 1);
    let (mut worst_mean, mut worst_pixel) = (0.0_f64, 0.0_f64);
    for line in table.lines().skip(1) {
        let (name, numbers) = line.split_once(',').ok_or("a line has columns")?;
        let numbers = numbers.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let (_, reference, test) = pairs.iter().find(|pair| pair.0 == name).ok_or("a pair of that name")?;
        let map = flip(reference, test, numbers[0] as f32)?;
        worst_mean = worst_mean.max((map.mean() - numbers[1]).abs());
        // The authors add up the mean in single precision: of a constant map it is 6e-5 off.
        assert!((map.mean() - numbers[1]).abs() < 1e-4, "{name}: mean {} {}", map.mean(), numbers[1]);
        for ((x, y), expected) in PROBES.into_iter().zip(&numbers[2..]) {
            let column = (x * f64::from(map.width)) as usize;
            let row = (y * f64::from(map.height)) as usize;
            let found = f64::from(map.values[row * map.width as usize + column]);
            worst_pixel = worst_pixel.max((found - expected).abs());
            // Square roots of small feature differences magnify rounding.
            assert!((found - expected).abs() < 1e-3, "{name} at ({column}, {row}): {found} {expected}");
        }
    }
    println!("farthest from flip-evaluator: mean {worst_mean:.1e}, pixel {worst_pixel:.1e}");
    Ok(())
}

/// Writes the pictures for `flip.py`.
#[test]
#[ignore = "writes files; only for making flip.csv anew"]
fn write_the_pairs() -> Result<(), Box<dyn Error>> {
    let folder = std::env::var("AAM_FLIP_PAIRS")?;
    std::fs::create_dir_all(&folder)?;
    for (index, (name, reference, test)) in pairs::pairs().into_iter().enumerate() {
        for (role, image) in [("reference", reference), ("test", test)] {
            let Pixels::Rgba8(bytes) = image.pixels else { return Err("pairs have 8 bits".into()) };
            let path = Path::new(&folder).join(format!("{index:02} {name} {role}.png"));
            image::save_buffer(path, &bytes, image.width, image.height, image::ColorType::Rgba8)?;
        }
    }
    Ok(())
}

#[test]
fn statistics_of_the_map_are_what_they_say() -> Result<(), CompareError> {
    let (_, reference, test) = pairs::pairs().swap_remove(8);
    let map = flip(&reference, &test, PIXELS_PER_DEGREE)?;
    let mut sorted = map.values.clone();
    sorted.sort_by(f32::total_cmp);
    assert_eq!(map.percentile(1.0), map.max());
    assert_eq!(map.percentile(0.0), sorted[0]);
    assert_eq!(map.percentile(0.5), sorted[sorted.len() / 2 - 1]);
    // Most pixels are equal, so that half of the error is in few of them.
    let median = map.weighted_median();
    let above: f32 = sorted.iter().filter(|value| **value >= median).sum();
    let total: f32 = sorted.iter().sum();
    assert!(map.percentile(0.5) == 0.0 && median > 0.0 && above >= 0.5 * total && above - median < 0.5 * total + 1e-3);
    for resolution in [0.0, -1.0, f32::NAN, 1e9] {
        assert_eq!(flip(&reference, &test, resolution), Err(CompareError::Resolution));
    }
    Ok(())
}
