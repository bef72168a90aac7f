use std::f32::consts::FRAC_PI_2;

use glam::{Vec2, Vec3};

use super::*;
use crate::{Image, Pixels};

fn floats(width: u32, height: u32, value: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Image { width, height, pixels: Pixels::RgbF32(places.flat_map(|(x, y)| value(x, y)).collect()) }
}

fn near(a: Vec3, b: Vec3) -> bool {
    a.distance(b) < 1e-5
}

#[test]
fn points_and_directions_are_each_others_inverse() {
    for x in -3..=3 {
        for y in -3..=3 {
            for z in -3..=3 {
                let direction = Vec3::new(x as f32 + 0.1, y as f32 - 0.2, z as f32 + 0.05).normalize();
                assert!(near(panorama_direction(panorama_point(direction)), direction), "{direction}");
                let (face, point) = cube_point(direction);
                assert!(near(cube_direction(face, point).normalize(), direction), "{direction} {face:?}");
                assert!(point.cmpge(Vec2::ZERO).all() && point.cmple(Vec2::ONE).all());
            }
        }
    }
    for pole in [Vec3::Y, Vec3::NEG_Y] {
        assert!(near(panorama_direction(panorama_point(pole)), pole));
    }
}

#[test]
fn faces_meet_at_their_edges_as_a_viewer_in_the_middle_sees_them() {
    let at = |face, x: f32, y: f32| cube_direction(face, Vec2::new(x, y));
    for along in [0.0, 0.3, 1.0] {
        assert!(near(at(CubeFace::Front, 1.0, along), at(CubeFace::Right, 0.0, along)));
        assert!(near(at(CubeFace::Right, 1.0, along), at(CubeFace::Back, 0.0, along)));
        assert!(near(at(CubeFace::Back, 1.0, along), at(CubeFace::Left, 0.0, along)));
        assert!(near(at(CubeFace::Left, 1.0, along), at(CubeFace::Front, 0.0, along)));
        assert!(near(at(CubeFace::Up, along, 1.0), at(CubeFace::Front, along, 0.0)));
        assert!(near(at(CubeFace::Down, along, 0.0), at(CubeFace::Front, along, 1.0)));
    }
}

#[test]
fn the_middle_of_a_panorama_is_in_front_and_rotation_is_counter_clockwise_from_above() {
    let map = Arc::new(EnvironmentMap::panorama(floats(2, 1, |_, _| [0.0; 3])).unwrap());
    let mut environment = Environment::new(map);
    let middle =
        |environment: &Environment, up: Up, direction: Vec3| panorama_point(environment.map_from_world(up) * direction);
    // Front is −Z with Y up and +Y with Z up, as for the view from the front.
    for (up, front, right) in [(Up::Y, Vec3::NEG_Z, Vec3::X), (Up::Z, Vec3::Y, Vec3::X)] {
        environment.rotation = 0.0;
        assert!(middle(&environment, up, front).distance(Vec2::splat(0.5)) < 1e-6);
        assert!(middle(&environment, up, right).distance(Vec2::new(0.75, 0.5)) < 1e-6);
        assert!(middle(&environment, up, up.axis()).y < 1e-6);
        environment.rotation = FRAC_PI_2;
        assert!(middle(&environment, up, -right).distance(Vec2::splat(0.5)) < 1e-6, "{up:?}");
    }
}

#[test]
fn crosses_are_cut_into_faces() {
    let label = |face: CubeFace| [face as u32 as f32 + 1.0; 3];
    let lying = floats(8, 6, |x, y| match (x / 2, y / 2) {
        (1, 0) => label(CubeFace::Up),
        (0, 1) => label(CubeFace::Left),
        (1, 1) => label(CubeFace::Front),
        (2, 1) => label(CubeFace::Right),
        (3, 1) => label(CubeFace::Back),
        (1, 2) => label(CubeFace::Down),
        _ => [0.0; 3],
    });
    let standing = floats(6, 8, |x, y| match (x / 2, y / 2) {
        (1, 0) => label(CubeFace::Up),
        (0, 1) => label(CubeFace::Left),
        (1, 1) => label(CubeFace::Front),
        (2, 1) => label(CubeFace::Right),
        (1, 2) => label(CubeFace::Down),
        // Upside down: what is above and to the left is stored last.
        (1, 3) if (x, y) == (3, 7) => [60.0; 3],
        (1, 3) => label(CubeFace::Back),
        _ => [0.0; 3],
    });
    for (image, first) in [(lying, 6.0), (standing, 60.0)] {
        let map = EnvironmentMap::of_picture(image).unwrap();
        let MapLayout::Cube(faces) = map.layout() else { panic!("a cross is a cube") };
        for face in CubeFace::ALL {
            let Pixels::RgbF32(values) = &faces[face as usize].pixels else { panic!() };
            let expected = if face == CubeFace::Back { first } else { label(face)[0] };
            assert_eq!((values.len(), values[0]), (12, expected), "{face:?}");
        }
    }
}

#[test]
fn what_is_no_environment_is_refused_with_its_reason() {
    let refused = |image: Image| EnvironmentMap::of_picture(image).unwrap_err();
    assert!(refused(floats(100, 60, |_, _| [0.0; 3])).contains("100 × 60 pixels are no environment"));
    assert!(refused(floats(64, 64, |_, _| [0.0; 3])).contains("five neighbours"));
    assert_eq!(refused(floats(0, 0, |_, _| [0.0; 3])), "it has no pixels");
    let short = Image { width: 4, height: 2, pixels: Pixels::Rgba8(vec![0; 5]) };
    assert_eq!(refused(short), "4 × 2 pixels need 32 values, and there are 5");

    let face = || floats(4, 4, |_, _| [1.0; 3]);
    let with = |index: usize, other: Image| {
        let mut faces = [(); 6].map(|()| face());
        faces[index] = other;
        EnvironmentMap::cube(faces).unwrap_err()
    };
    assert!(with(2, floats(4, 5, |_, _| [0.0; 3])).contains("face up is 4 × 5"));
    assert!(with(5, floats(8, 8, |_, _| [0.0; 3])).contains("face back is 8 pixels wide and face right 4"));
    assert!(with(1, Image { width: 4, height: 4, pixels: Pixels::Rgba8(vec![0; 64]) }).contains("face left"));
    assert!(with(3, floats(4, 0, |_, _| [0.0; 3])).contains("face down: it has no pixels"));
}

#[test]
fn texels_that_no_light_has_are_replaced_and_counted() {
    let odd = [f32::NAN, f32::NEG_INFINITY, f32::INFINITY];
    let map = EnvironmentMap::panorama(floats(4, 2, |x, _| if x == 0 { odd } else { [7.0, -1.0, 1e5] })).unwrap();
    let MapLayout::Panorama(Image { pixels: Pixels::RgbF32(values), .. }) = map.layout() else { panic!() };
    assert_eq!(values[..6], [0.0, 0.0, 1e9, 7.0, 0.0, 1e5], "values above 1 stay");
    assert!(map.notes()[0].starts_with("12 values of the panorama are negative"), "{:?}", map.notes());
}

#[test]
fn huge_pictures_are_halved_until_they_fit_and_keep_their_mean() {
    for (width, height, expected) in [(64, 32, (8, 4)), (70, 35, (8, 4)), (64, 1, (8, 1)), (8, 4, (8, 4))] {
        let image = map::reduced(floats(width, height, |x, _| [(x % 2) as f32, 1.0, 3.0]), 8);
        let Pixels::RgbF32(values) = &image.pixels else { panic!() };
        assert_eq!((image.width, image.height), expected);
        let first = if width == 8 { 0.0 } else { 0.5 };
        assert_eq!((values.len() as u32, &values[..3]), (3 * image.width * image.height, &[first, 1.0, 3.0][..]));
    }
    let bytes = Image { width: 4, height: 2, pixels: Pixels::Rgba8((0..32).collect()) };
    assert_eq!(map::reduced(bytes, 2).pixels, Pixels::Rgba8(vec![10, 11, 12, 13, 18, 19, 20, 21]));
}

#[test]
fn broken_numbers_do_nothing() {
    let map = Arc::new(EnvironmentMap::panorama(floats(2, 1, |_, _| [1.0; 3])).unwrap());
    for broken in [f32::NAN, -1.0] {
        assert_eq!(Environment { intensity: broken, ..Environment::new(Arc::clone(&map)) }.factor(), 0.0);
    }
    let turned = Environment { rotation: f32::NAN, ..Environment::new(map) };
    assert_eq!(turned.map_from_world(Up::Y), Mat3::IDENTITY);
    assert_eq!((exposure_factor(f32::NAN), exposure_factor(1.0)), (1.0, 2.0));
    assert!(exposure_factor(f32::INFINITY).is_finite() && exposure_factor(f32::NEG_INFINITY) > 0.0);
}

#[test]
fn nothing_jumps_across_seams_and_poles() {
    let smooth = |d: Vec3| Vec3::new(2.0 + d.x + d.y * d.z, 2.0 + d.z, 2.0 + d.y);
    let middle = |x: u32, y: u32, size: Vec2| (Vec2::new(x as f32, y as f32) + 0.5) / size;
    let sides = CubeFace::ALL.map(|face| {
        floats(64, 64, |x, y| smooth(cube_direction(face, middle(x, y, Vec2::splat(64.0))).normalize()).to_array())
    });
    let panorama =
        floats(256, 128, |x, y| smooth(panorama_direction(middle(x, y, Vec2::new(256.0, 128.0)))).to_array());
    for map in [EnvironmentMap::panorama(panorama).unwrap(), EnvironmentMap::cube(sides).unwrap()] {
        let around = (0..4000)
            .map(|step| panorama_direction(Vec2::new((step as f32 * 0.37).fract(), (step as f32 / 4000.0).powi(2))));
        let corners = [Vec3::ONE, Vec3::new(-1.0, 1.0, -1.0), Vec3::Y, Vec3::NEG_Y, Vec3::Z];
        for direction in around.chain(corners) {
            let (found, expected) = (map.light(direction, true), smooth(direction.normalize()));
            assert!((found - expected).abs().max_element() < 0.03, "{direction} {found}");
        }
        for odd in [Vec3::ZERO, Vec3::NAN, Vec3::splat(1e-38), Vec3::splat(1e19), Vec3::INFINITY] {
            assert!(map.light(odd, false).is_finite(), "{odd}");
        }
    }
}

#[test]
fn encoded_pictures_are_decoded_when_asked_and_alpha_counts_for_nothing() {
    let grey = |pixels| EnvironmentMap::panorama(Image { width: 2, height: 1, pixels }).unwrap();
    let bytes = grey(Pixels::Rgba8(vec![188, 188, 188, 0, 188, 188, 188, 255]));
    let words = grey(Pixels::Rgba16(vec![188 * 257; 8]));
    for map in [bytes, words] {
        assert!(!map.is_linear());
        assert!((map.light(Vec3::X, false).x - 188.0 / 255.0).abs() < 1e-6);
        assert!((map.light(Vec3::X, true).x - 0.5029).abs() < 1e-4);
    }
    let float = EnvironmentMap::panorama(floats(2, 1, |_, _| [0.5; 3])).unwrap();
    assert_eq!((float.is_linear(), float.light(Vec3::X, true)), (true, Vec3::splat(0.5)));
}
