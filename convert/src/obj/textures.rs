//! The pictures that materials name: finding them, and making those that AAM needs in another form.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use aam_scene::{FolderTextures, FoundTexture, Image, TextureData, TextureSource, load_texture};

use crate::files::{nameable, within};
use crate::picture::{Encoded, combined_alpha, heights_to_normals, looks_like_normals, mean};
use crate::{ImportOptions, Report, TextureFile};

/// Pixels that may be made altogether, so that a small file cannot ask for hours of work.
const MOST_PIXELS: u64 = 1 << 29;

pub(super) struct Textures {
    finder: FolderTextures,
    /// The OBJ file's folder, links resolved.
    folder: PathBuf,
    /// From there to the library's folder, with `/` at its end, or empty.
    pub(super) library: String,
    files: BTreeMap<String, TextureFile>,
    /// The name under which a picture that was found goes into the document.
    names: BTreeMap<String, String>,
    /// Pictures that were made: what of, and their name.
    made: BTreeMap<String, Option<String>>,
    pixels: u64,
}

/// A picture in the document.
#[derive(Clone)]
pub(super) struct Picture {
    /// Its `FN:` name.
    pub(super) name: String,
    /// Where it was found.
    found: Option<FoundTexture>,
}

impl Textures {
    pub(super) fn new(obj: &Path, options: &ImportOptions) -> Self {
        let mut finder = FolderTextures::beside(obj);
        finder.allow_outside = options.allow_outside;
        finder.limits = options.limits;
        let folder = obj.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Self {
            finder,
            folder: std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned()),
            library: String::new(),
            files: BTreeMap::new(),
            names: BTreeMap::new(),
            made: BTreeMap::new(),
            pixels: 0,
        }
    }

    /// The texture files of the asset.
    pub(super) fn into_files(self) -> BTreeMap<String, TextureFile> {
        self.files
    }

    /// Looks for a picture beside the library, then beside the OBJ file. One that is not there keeps its name.
    pub(super) fn find(&self, file: &str) -> Result<Picture, String> {
        let beside_library = format!("{}{file}", self.library);
        let found = self.finder.find(&beside_library).or_else(|_| self.finder.find(file))?;
        let TextureData::OnDisk(path) = &found.data else { return Err("it is no file".into()) };
        let name = match path.strip_prefix(&self.folder).ok().and_then(Path::to_str) {
            Some(relative) => relative.replace('\\', "/"),
            None => path.file_name().map_or_else(|| "texture".into(), |name| name.to_string_lossy().into_owned()),
        };
        Ok(Picture { name: nameable(&name), found: Some(found) })
    }

    /// The path of a material library that an `mtllib` line names.
    pub(super) fn library_file(&self, file: &str) -> Result<PathBuf, String> {
        match self.finder.find(file)?.data {
            TextureData::OnDisk(path) => Ok(path),
            TextureData::InMemory(_) => Err("it is no file".into()),
        }
    }

    /// Adds a picture to the asset; gives its name in the document.
    pub(super) fn add(&mut self, picture: &Picture) -> String {
        let Some(FoundTexture { key, data: TextureData::OnDisk(path) }) = &picture.found else {
            return picture.name.clone();
        };
        if let Some(known) = self.names.get(key) {
            return known.clone();
        }
        let name = self.free_name(&picture.name);
        self.files.insert(name.clone(), TextureFile::OnDisk(path.clone()));
        self.names.insert(key.clone(), name.clone());
        name
    }

    /// The name of a picture that is missing: as written, but inside the folder.
    pub(super) fn missing(file: &str) -> Picture {
        let slashed = file.replace('\\', "/");
        let bare = slashed.rsplit('/').next().unwrap_or("texture").to_owned();
        Picture { name: nameable(if within(&slashed).is_some() { &slashed } else { &bare }), found: None }
    }

    fn free_name(&self, name: &str) -> String {
        let (stem, extension) = match name.rsplit_once('.') {
            Some((stem, extension)) if !extension.contains('/') => (stem, format!(".{extension}")),
            _ => (name, String::new()),
        };
        let taken = |name: &str| self.files.keys().any(|known| known.eq_ignore_ascii_case(name));
        std::iter::once(name.to_owned())
            .chain((2..).map(|number| format!("{stem}-{number}{extension}")))
            .find(|name| !taken(name))
            .unwrap_or_default()
    }

    pub(super) fn load(&self, picture: &Picture) -> Result<Image, String> {
        let found = picture.found.as_ref().ok_or("there is no such file")?;
        load_texture(found, &self.finder.limits)
    }

    /// A tangent-space normal map for a height map, or `None` if the picture holds normals already (as many exporters
    /// write under `bump`).
    pub(super) fn normals(&mut self, heights: &Picture, strength: f32) -> Result<Option<String>, String> {
        let what = format!("normals {strength} {}", heights.name);
        if let Some(name) = self.made.get(&what) {
            return Ok(name.clone());
        }
        let image = self.load(heights)?;
        self.spend(&image)?;
        let name = if looks_like_normals(&image) {
            None
        } else {
            Some(self.keep(&heights.name, "normal", heights_to_normals(&image, strength)?))
        };
        self.made.insert(what, name.clone());
        Ok(name)
    }

    /// A picture with the colours of one and the alpha of another.
    pub(super) fn with_alpha(
        &mut self,
        color: &Picture,
        alpha: &Picture,
        channel: Option<u8>,
    ) -> Result<String, String> {
        let what = format!("alpha {channel:?} {} {}", color.name, alpha.name);
        if let Some(Some(name)) = self.made.get(&what) {
            return Ok(name.clone());
        }
        let (colors, alphas) = (self.load(color)?, self.load(alpha)?);
        self.spend(&colors)?;
        self.spend(&alphas)?;
        let name = self.keep(&color.name, "alpha", combined_alpha(&colors, &alphas, channel)?);
        self.made.insert(what, Some(name.clone()));
        Ok(name)
    }

    /// The mean of a picture's red channel, for a factor that cannot vary over a surface.
    pub(super) fn mean(&mut self, picture: &Picture) -> Result<f32, String> {
        let image = self.load(picture)?;
        self.spend(&image)?;
        Ok(mean(&image))
    }

    fn spend(&mut self, image: &Image) -> Result<(), String> {
        self.pixels += u64::from(image.width) * u64::from(image.height);
        if self.pixels > MOST_PIXELS {
            return Err(format!("more than {MOST_PIXELS} pixels of textures would have to be converted"));
        }
        Ok(())
    }

    fn keep(&mut self, source: &str, suffix: &str, bytes: Encoded) -> String {
        let stem = source.rsplit_once('.').map_or(source, |(stem, _)| stem);
        let name = self.free_name(&format!("{stem}_{suffix}.png"));
        self.files.insert(name.clone(), TextureFile::InMemory(bytes));
        name
    }
}

/// Adds a picture, or reports that it is missing; the name goes into the document all the same.
pub(super) fn named(
    textures: &mut Textures,
    file: &str,
    subject: &str,
    property: &str,
    report: &mut Report,
) -> Picture {
    textures.find(file).unwrap_or_else(|reason| {
        report.lost(subject, property, format!("{file}: {reason}"));
        Textures::missing(file)
    })
}
