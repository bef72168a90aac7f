//! The pictures of a file: where they are, what they hold, and under which names they go to the document.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use aam::Limit;
use image::{ImageFormat, ImageReader};

use crate::files::nameable;
use crate::{ImportOptions, TextureFile};

use super::bake::{self, Pixels, Recipe};
use super::buffers::Buffers;
use super::extensions;
use super::fault::{Checked, Fault};
use super::limits;
use super::log::Log;
use super::model::{ImageSource, Model, Sampler, TextureRef};
use super::names::{Names, file_stem};
use super::uri::{self, Source};

/// Decoded pictures that are kept for the next material.
const CACHE_BYTES: usize = 512 << 20;

/// A picture as an encoded file.
#[derive(Clone, Debug)]
enum Picture {
    OnDisk { name: String, path: PathBuf, format: ImageFormat },
    InMemory { bytes: Arc<[u8]>, format: ImageFormat },
    Missing { name: String },
}

/// All pictures of a file, and the texture files made of them.
#[derive(Debug)]
pub(super) struct Textures<'a> {
    model: &'a Model,
    options: &'a ImportOptions,
    stem: String,
    pictures: Vec<Option<Picture>>,
    /// For each image the first one that holds the same bytes.
    same: Vec<usize>,
    decoded: BTreeMap<usize, Option<Arc<Pixels>>>,
    decoded_bytes: usize,
    decoded_pixels: u64,
    baked_pixels: u64,
    names: Names,
    /// The file of each recipe that was asked for.
    written: BTreeMap<Recipe, String>,
    files: BTreeMap<String, TextureFile>,
}

impl<'a> Textures<'a> {
    /// Finds the pictures that materials use, and checks that they can be used.
    pub(super) fn find(
        model: &'a Model,
        buffers: &Buffers,
        path: &Path,
        options: &'a ImportOptions,
        log: &mut Log,
    ) -> Checked<Self> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut used = vec![false; model.images.len()];
        let mut refused: Vec<(usize, &str)> = Vec::new();
        for texture in model.materials.iter().flat_map(|material| material.textures()) {
            match model.textures[texture.texture].image {
                Ok(image) => used[image] = true,
                Err("") => {}
                Err(extension) => refused.push((texture.texture, extension)),
            }
        }
        if let Some((texture, extension)) = refused.first() {
            return Err(extensions::image(extension, &model.textures[*texture].place));
        }
        let mut pictures: Vec<Option<Picture>> = Vec::new();
        let mut same = Vec::new();
        let mut known: BTreeMap<Arc<[u8]>, usize> = BTreeMap::new();
        let mut names = Names::default();
        for (number, image) in model.images.iter().enumerate() {
            let picture = if used[number] { find(image, model, buffers, folder, options, log)? } else { None };
            if let Some(Picture::OnDisk { name, .. } | Picture::Missing { name }) = &picture {
                names.reserve(name);
            }
            same.push(match &picture {
                Some(Picture::InMemory { bytes, .. }) => *known.entry(Arc::clone(bytes)).or_insert(number),
                _ => number,
            });
            pictures.push(picture);
        }
        let stem = path.file_stem().map_or_else(String::new, |stem| file_stem(&stem.to_string_lossy()));
        Ok(Self {
            model,
            options,
            stem,
            pictures,
            same,
            decoded: BTreeMap::new(),
            decoded_bytes: 0,
            decoded_pixels: 0,
            baked_pixels: 0,
            names,
            written: BTreeMap::new(),
            files: BTreeMap::new(),
        })
    }

    /// The image behind a use of a texture.
    pub(super) fn image(&self, texture: &TextureRef) -> Option<usize> {
        let image = self.model.textures[texture.texture].image.ok()?;
        self.pictures[image].as_ref().map(|_| self.same[image])
    }

    /// How a use of a texture is sampled.
    pub(super) fn sampler(&self, texture: &TextureRef) -> Option<&'a Sampler> {
        self.model.textures[texture.texture].sampler.map(|sampler| &self.model.samplers[sampler])
    }

    /// Whether the file's format can hold transparency.
    pub(super) fn may_have_alpha(&self, image: usize) -> bool {
        match &self.pictures[image] {
            Some(Picture::OnDisk { format, .. } | Picture::InMemory { format, .. }) => *format != ImageFormat::Jpeg,
            _ => false,
        }
    }

    /// The pixels of an image; `None` if it is not there or cannot be decoded, which is reported once.
    pub(super) fn pixels(&mut self, image: usize, log: &mut Log) -> Checked<Option<Arc<Pixels>>> {
        if let Some(known) = self.decoded.get(&image) {
            return Ok(known.clone());
        }
        let pixels = match self.decode(image) {
            Ok(pixels) => pixels.map(Arc::new),
            Err(Fault::Broken { place, message }) => {
                log.lost(&self.subject(image), "picture", format!("{place}: {message}; used as it is, unseen"));
                None
            }
            Err(other) => return Err(other),
        };
        let bytes = pixels.as_ref().map_or(0, |pixels| pixels.rgba.len());
        if self.decoded_bytes + bytes > CACHE_BYTES {
            self.decoded.retain(|_, known| known.is_none());
            self.decoded_bytes = 0;
        }
        self.decoded_bytes += bytes;
        self.decoded_pixels += bytes as u64 / 4;
        limits::check_decoded(self.decoded_pixels)?;
        self.decoded.insert(image, pixels.clone());
        Ok(pixels)
    }

    fn decode(&self, image: usize) -> Checked<Option<Pixels>> {
        let owned;
        let (bytes, format) = match &self.pictures[image] {
            Some(Picture::OnDisk { path, format, .. }) => {
                owned = aam::read_bytes(path, &self.options.limits)?;
                (owned.as_slice(), *format)
            }
            Some(Picture::InMemory { bytes, format }) => (&**bytes, *format),
            _ => return Ok(None),
        };
        let broken = |message: String| Fault::broken(&self.model.images[image].place, message);
        let reader = || ImageReader::with_format(Cursor::new(bytes), format);
        let (width, height) = reader().into_dimensions().map_err(|error| broken(error.to_string()))?;
        let pixels = u64::from(width) * u64::from(height);
        let too_large = |exceeded| broken(format!("{width} × {height} = {exceeded}"));
        self.options.limits.check(Limit::TexturePixels, pixels).map_err(too_large)?;
        let mut reader = reader();
        // Sixteen bytes a pixel is the widest that any format unpacks to.
        let mut bound = image::Limits::default();
        bound.max_alloc = Some(pixels.saturating_mul(16).saturating_add(1 << 20));
        reader.limits(bound);
        let decoded = reader.decode().map_err(|error| broken(error.to_string()))?;
        Ok(Some(Pixels { width, height, rgba: decoded.into_rgba8().into_raw() }))
    }

    /// The image in words.
    pub(super) fn subject(&self, image: usize) -> String {
        match (&self.model.images[image].name, &self.pictures[image]) {
            (Some(name), _) => format!("image {name:?}"),
            (None, Some(Picture::OnDisk { name, .. } | Picture::Missing { name })) => format!("image {name:?}"),
            _ => format!("image {image}"),
        }
    }

    /// The texture file of a recipe, made if it was not asked for before; `None` if a picture that must be baked cannot be.
    pub(super) fn file(&mut self, recipe: Recipe, log: &mut Log) -> Checked<Option<String>> {
        if let Some(name) = self.written.get(&recipe) {
            return Ok(Some(name.clone()));
        }
        let name = match recipe.untouched() {
            Some(image) => self.as_it_is(image),
            None => self.baked(&recipe, log)?,
        };
        if let Some(name) = &name {
            self.written.insert(recipe, name.clone());
        }
        Ok(name)
    }

    fn as_it_is(&mut self, image: usize) -> Option<String> {
        match self.pictures[image].clone()? {
            Picture::OnDisk { name, path, .. } => {
                self.files.insert(name.clone(), TextureFile::OnDisk(path));
                Some(name)
            }
            Picture::InMemory { bytes, format } => {
                let ending = format.extensions_str().first().copied().unwrap_or("img");
                let name = self.new_name(image, "", &format!(".{ending}"));
                self.files.insert(name.clone(), TextureFile::InMemory(bytes));
                Some(name)
            }
            Picture::Missing { name } => Some(name),
        }
    }

    fn baked(&mut self, recipe: &Recipe, log: &mut Log) -> Checked<Option<String>> {
        let mut pixels = |image: Option<usize>| -> Checked<Option<Arc<Pixels>>> {
            image.map_or(Ok(None), |image| self.pixels(image, log))
        };
        let base = pixels(recipe.base)?;
        let occlusion = pixels(recipe.occlusion.map(|(image, _)| image))?;
        if base.is_none() && recipe.base.is_some() || occlusion.is_none() && recipe.occlusion.is_some() {
            return Ok(None);
        }
        let [width, height] = bake::size(base.as_deref(), occlusion.as_deref());
        let count = u64::from(width) * u64::from(height);
        if let Err(exceeded) = self.options.limits.check(Limit::TexturePixels, count) {
            log.lost("", "baked texture", format!("{width} × {height} = {exceeded}"));
            return Ok(None);
        }
        self.baked_pixels += count;
        limits::check_baked(self.baked_pixels)?;
        let Some(composed) = bake::compose(recipe, base.as_deref(), occlusion.as_deref()) else { return Ok(None) };
        let bytes = composed.encode().map_err(|error| {
            let message = format!("the baked texture cannot be encoded: {error}");
            Fault::broken(recipe.image().map_or("/images", |image| &self.model.images[image].place), message)
        })?;
        let Some(image) = recipe.image() else { return Ok(None) };
        let name = self.new_name(image, recipe.word(), ".png");
        self.files.insert(name.clone(), TextureFile::InMemory(bytes.into()));
        Ok(Some(name))
    }

    /// A name that starts with the asset's, so that two assets can stand in one folder.
    fn new_name(&mut self, image: usize, word: &str, ending: &str) -> String {
        let own = match (&self.model.images[image].name, &self.pictures[image]) {
            (_, Some(Picture::OnDisk { name, .. })) => {
                let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
                file_stem(&stem.unwrap_or_default())
            }
            (Some(name), _) => {
                let lower = name.to_lowercase();
                let bare = [".png", ".jpg", ".jpeg", ".webp"].iter().find(|ending| lower.ends_with(**ending));
                file_stem(name.get(..name.len() - bare.map_or(0, |ending| ending.len())).unwrap_or(name))
            }
            _ => format!("image{image}"),
        };
        let own = if own.is_empty() { format!("image{image}") } else { own };
        let prefix =
            if own.starts_with(&self.stem) || self.stem.is_empty() { String::new() } else { format!("{}_", self.stem) };
        self.names.unique(&format!("{prefix}{own}{word}"), ending)
    }

    /// The texture files that were asked for.
    pub(super) fn into_files(self) -> BTreeMap<String, TextureFile> {
        self.files
    }
}

fn find(
    image: &super::model::Image,
    model: &Model,
    buffers: &Buffers,
    folder: &Path,
    options: &ImportOptions,
    log: &mut Log,
) -> Checked<Option<Picture>> {
    let bytes: Vec<u8> = match &image.source {
        ImageSource::Nothing => {
            return Err(Fault::broken(&image.place, "the image has neither a uri nor a bufferView"));
        }
        ImageSource::View(view) => {
            buffers.check(&model.views[*view])?;
            buffers.view(&model.views[*view]).to_vec()
        }
        ImageSource::Uri(text) => {
            let place = format!("{}/uri", image.place);
            match uri::follow(text, folder, options.allow_outside, &place)? {
                Source::Data(bytes) => bytes,
                Source::Missing { name } => {
                    let name = nameable(&name);
                    log.lost(
                        &format!("image {name:?}"),
                        "picture",
                        "the file does not exist; the layer counts as absent",
                    );
                    return Ok(Some(Picture::Missing { name }));
                }
                Source::File { name, path } => {
                    let name = nameable(&name);
                    let head = head(&path)?;
                    return match format(&head, &image.place)? {
                        Some(format) => Ok(Some(Picture::OnDisk { name, path, format })),
                        None => {
                            log.lost(&format!("image {name:?}"), "picture", UNKNOWN);
                            Ok(Some(Picture::Missing { name }))
                        }
                    };
                }
            }
        }
    };
    match format(&bytes, &image.place)? {
        Some(format) => Ok(Some(Picture::InMemory { bytes: bytes.into(), format })),
        None => Err(Fault::broken(&image.place, UNKNOWN)),
    }
}

const UNKNOWN: &str = "the data is in no picture format that can be decoded (PNG, JPEG, WebP …)";

/// The first bytes of a file, enough to tell its format.
fn head(path: &Path) -> Checked<Vec<u8>> {
    use std::io::Read;
    let open = |source| aam::FileError::Open { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    std::fs::File::open(path).map_err(open)?.take(32).read_to_end(&mut bytes).map_err(open)?;
    Ok(bytes)
}

/// The format of a picture by its first bytes.
fn format(bytes: &[u8], place: &str) -> Checked<Option<ImageFormat>> {
    if bytes.starts_with(b"\xABKTX 20\xBB") {
        return Err(extensions::image("KTX2", place));
    }
    if bytes.starts_with(b"DDS ") {
        return Err(extensions::image("DDS", place));
    }
    let decodable =
        [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP, ImageFormat::Bmp, ImageFormat::Gif, ImageFormat::Tiff];
    Ok(image::guess_format(bytes).ok().filter(|format| decodable.contains(format)))
}
