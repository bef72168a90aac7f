//! The pictures of an environment, checked and brought into one of two shapes.

use std::path::PathBuf;

use aam::Limits;

use super::CubeFace;
use crate::texture::decode_found;
use crate::{FoundTexture, Image, Pixels};

/// The widest panorama that is kept; a wider one is halved until it fits. Its texel is 0.04°.
const MAX_PANORAMA: u32 = 8192;

/// The largest face that is kept; a larger one is halved until it fits.
const MAX_FACE: u32 = 4096;

/// The light from each direction: a panorama or a cube, whole, of texels that are neither negative nor not finite.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    shape: Shape,
    notes: Vec<String>,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Panorama(Image),
    Cube(Box<[Image; 6]>),
}

/// The pictures of an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapLayout<'a> {
    /// All directions in one picture, equirectangular, twice as wide as high.
    Panorama(&'a Image),
    /// Square faces of one size and kind, in the order of [`CubeFace::ALL`].
    Cube(&'a [Image; 6]),
}

/// Where the pictures of an environment come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EnvironmentPictures<T> {
    /// One picture: a panorama (2:1), or a cube unfolded to a cross that lies (4:3) or stands (3:4).
    One(T),
    /// The faces of a cube in the order of [`CubeFace::ALL`].
    Faces(Box<[T; 6]>),
}

impl EnvironmentPictures<PathBuf> {
    /// The same with each path replaced.
    ///
    /// # Errors
    /// The first that `f` gives.
    pub fn try_map<U, E>(&self, mut f: impl FnMut(&PathBuf) -> Result<U, E>) -> Result<EnvironmentPictures<U>, E> {
        Ok(match self {
            Self::One(path) => EnvironmentPictures::One(f(path)?),
            Self::Faces(paths) => {
                let [right, left, up, down, front, back] = &**paths;
                let faces = [f(right)?, f(left)?, f(up)?, f(down)?, f(front)?, f(back)?];
                EnvironmentPictures::Faces(Box::new(faces))
            }
        })
    }
}

/// Decodes the pictures of an environment.
///
/// # Errors
/// Why one cannot be read or decoded, or is no part of an environment, in words for people.
pub fn load_environment(
    pictures: &EnvironmentPictures<FoundTexture>,
    limits: &Limits,
) -> Result<EnvironmentMap, String> {
    match pictures {
        EnvironmentPictures::One(found) => EnvironmentMap::of_picture(decode_found(found, limits)?),
        EnvironmentPictures::Faces(found) => {
            let mut faces = Vec::with_capacity(6);
            for (face, found) in CubeFace::ALL.into_iter().zip(found.iter()) {
                let image = decode_found(found, limits).map_err(|reason| format!("face {}: {reason}", face.name()))?;
                faces.push(image);
            }
            let faces = <[Image; 6]>::try_from(faces).map_err(|_| "a cube has six faces".to_owned())?;
            EnvironmentMap::cube(faces)
        }
    }
}

impl EnvironmentMap {
    /// From one picture: a panorama or the cross of a cube, as its shape says.
    ///
    /// # Errors
    /// It has another shape, or lacks pixels.
    pub fn of_picture(image: Image) -> Result<Self, String> {
        whole(&image)?;
        let (width, height) = (u64::from(image.width), u64::from(image.height));
        if 3 * width == 4 * height && width.is_multiple_of(4) {
            return Self::cube(faces_of_cross(&image, true));
        }
        if 4 * width == 3 * height && width.is_multiple_of(3) {
            return Self::cube(faces_of_cross(&image, false));
        }
        Self::panorama(image)
    }

    /// From a panorama.
    ///
    /// # Errors
    /// It is not twice as wide as high (to a hundredth of its width), or lacks pixels.
    pub fn panorama(image: Image) -> Result<Self, String> {
        whole(&image)?;
        let (width, height) = (u64::from(image.width), u64::from(image.height));
        if width < 2 || width.abs_diff(2 * height) > width / 100 {
            return Err(format!(
                "{width} × {height} pixels are no environment: a panorama is twice as wide as high, the cross of a cube \
                 4:3 or 3:4, and a single face needs its five neighbours"
            ));
        }
        let mut notes = Vec::new();
        let mut image = cleaned(image, "the panorama", &mut notes);
        if image.width > MAX_PANORAMA {
            image = reduced(image, MAX_PANORAMA);
            notes.push(format!("the panorama is {width} pixels wide; it is used at {}", image.width));
        }
        Ok(Self { shape: Shape::Panorama(image), notes })
    }

    /// From the faces of a cube in the order of [`CubeFace::ALL`], each as a viewer in the middle sees it.
    ///
    /// # Errors
    /// A face is not square, differs from the first in size or kind, or lacks pixels.
    pub fn cube(faces: [Image; 6]) -> Result<Self, String> {
        let (side, first) = (faces[0].width, std::mem::discriminant(&faces[0].pixels));
        for (face, image) in CubeFace::ALL.into_iter().zip(&faces) {
            let name = face.name();
            whole(image).map_err(|reason| format!("face {name}: {reason}"))?;
            let Image { width, height, .. } = image;
            if width != height {
                return Err(format!("face {name} is {width} × {height} pixels; the faces of a cube are square"));
            }
            if *width != side {
                return Err(format!("face {name} is {width} pixels wide and face right {side}; all six must be equal"));
            }
            if std::mem::discriminant(&image.pixels) != first {
                return Err(format!("face {name} has another kind of pixels (8 bit, 16 bit, float) than face right"));
            }
        }
        let mut notes = Vec::new();
        let mut index = 0;
        let faces = faces.map(|image| {
            let image = cleaned(image, &format!("face {}", CubeFace::ALL[index].name()), &mut notes);
            index += 1;
            reduced(image, MAX_FACE)
        });
        if side > MAX_FACE {
            notes.push(format!("the faces are {side} pixels wide; they are used at {}", faces[0].width));
        }
        Ok(Self { shape: Shape::Cube(Box::new(faces)), notes })
    }

    /// The pictures.
    pub fn layout(&self) -> MapLayout<'_> {
        match &self.shape {
            Shape::Panorama(image) => MapLayout::Panorama(image),
            Shape::Cube(faces) => MapLayout::Cube(faces),
        }
    }

    /// What was changed in the pictures, in words for people.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// True where the values are linear light; false where they are sRGB-encoded colours.
    pub fn is_linear(&self) -> bool {
        let image = match &self.shape {
            Shape::Panorama(image) => image,
            Shape::Cube(faces) => &faces[0],
        };
        matches!(image.pixels, Pixels::RgbF32(_))
    }

    /// Pixels, of all faces.
    pub fn texels(&self) -> u64 {
        let count = |image: &Image| u64::from(image.width) * u64::from(image.height);
        match &self.shape {
            Shape::Panorama(image) => count(image),
            Shape::Cube(faces) => 6 * count(&faces[0]),
        }
    }
}

fn channels(pixels: &Pixels) -> (usize, usize) {
    match pixels {
        Pixels::Rgba8(values) => (values.len(), 4),
        Pixels::Rgba16(values) => (values.len(), 4),
        Pixels::RgbF32(values) => (values.len(), 3),
    }
}

fn whole(image: &Image) -> Result<(), String> {
    let Image { width, height, pixels } = image;
    if *width == 0 || *height == 0 {
        return Err("it has no pixels".into());
    }
    let (values, channels) = channels(pixels);
    let wanted = u64::from(*width) * u64::from(*height) * channels as u64;
    if values as u64 == wanted {
        return Ok(());
    }
    Err(format!("{width} × {height} pixels need {wanted} values, and there are {values}"))
}

/// Light is neither negative nor not a number, and never infinite.
fn cleaned(mut image: Image, what: &str, notes: &mut Vec<String>) -> Image {
    const MOST: f32 = 1e9;
    let mut replaced = 0_u64;
    if let Pixels::RgbF32(values) = &mut image.pixels {
        for value in values {
            if !(0.0..=MOST).contains(value) {
                *value = if *value > MOST { MOST } else { 0.0 };
                replaced += 1;
            }
        }
    }
    if replaced > 0 {
        notes.push(format!("{replaced} values of {what} are negative, infinite or not a number; they are replaced"));
    }
    image
}

/// Halved until it is at most so wide.
pub(super) fn reduced(mut image: Image, most: u32) -> Image {
    while image.width > most {
        image = halved(&image);
    }
    image
}

/// Half as large; each pixel is the mean of four.
fn halved(image: &Image) -> Image {
    let (width, height) = ((image.width / 2).max(1) as usize, (image.height / 2).max(1) as usize);
    let stride = image.width as usize;
    // An image one pixel high or wide has no second row or column.
    let (right, below) = (usize::from(image.width > 1), usize::from(image.height > 1));
    let corners = |x: usize, y: usize| {
        let first = (y << below) * stride + (x << right);
        [first, first + right, first + below * stride, first + below * stride + right]
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = match &image.pixels {
        Pixels::Rgba8(values) => Pixels::Rgba8(
            places
                .flat_map(|(x, y)| {
                    let at = corners(x, y);
                    [0, 1, 2, 3].map(|c| (at.iter().map(|i| u32::from(values[4 * i + c])).sum::<u32>() + 2) / 4)
                })
                .map(|mean| mean as u8)
                .collect(),
        ),
        Pixels::Rgba16(values) => Pixels::Rgba16(
            places
                .flat_map(|(x, y)| {
                    let at = corners(x, y);
                    [0, 1, 2, 3].map(|c| (at.iter().map(|i| u32::from(values[4 * i + c])).sum::<u32>() + 2) / 4)
                })
                .map(|mean| mean as u16)
                .collect(),
        ),
        Pixels::RgbF32(values) => Pixels::RgbF32(
            places
                .flat_map(|(x, y)| {
                    let at = corners(x, y);
                    [0, 1, 2].map(|c| 0.25 * at.iter().map(|i| values[3 * i + c]).sum::<f32>())
                })
                .collect(),
        ),
    };
    Image { width: width as u32, height: height as u32, pixels }
}

/// The faces of a cube unfolded around its front: to the sides and on to the back if the cross lies, below that to the
/// back, upside down, if it stands.
fn faces_of_cross(image: &Image, lies: bool) -> [Image; 6] {
    let side = image.width as usize / if lies { 4 } else { 3 };
    CubeFace::ALL.map(|face| {
        let (column, row, turned) = match face {
            CubeFace::Up => (1, 0, false),
            CubeFace::Left => (0, 1, false),
            CubeFace::Front => (1, 1, false),
            CubeFace::Right => (2, 1, false),
            CubeFace::Down => (1, 2, false),
            CubeFace::Back if lies => (3, 1, false),
            CubeFace::Back => (1, 3, true),
        };
        cut(image, (column * side, row * side), side, turned)
    })
}

fn cut(image: &Image, (left, top): (usize, usize), side: usize, turned: bool) -> Image {
    let stride = image.width as usize;
    let places = (0..side * side).map(|place| if turned { side * side - 1 - place } else { place });
    let index = places.map(|place| (top + place / side) * stride + left + place % side);
    let pixels = match &image.pixels {
        Pixels::Rgba8(values) => Pixels::Rgba8(index.flat_map(|i| [0, 1, 2, 3].map(|c| values[4 * i + c])).collect()),
        Pixels::Rgba16(values) => Pixels::Rgba16(index.flat_map(|i| [0, 1, 2, 3].map(|c| values[4 * i + c])).collect()),
        Pixels::RgbF32(values) => Pixels::RgbF32(index.flat_map(|i| [0, 1, 2].map(|c| values[3 * i + c])).collect()),
    };
    Image { width: side as u32, height: side as u32, pixels }
}
