//! Layers that the source lacks: light maps, normal maps and displacement maps from files of their own.

use std::path::PathBuf;

use aam::Document;
use aam::document::{Displacement, Flagged, Layer, Material, MaterialBody, NormalSpace, SingleMaterial, Texture};
use aam::meaning::Materials;

use crate::{Asset, ConvertError, TextureFile, uv_lines};

/// Parts that each edge is cut into where nothing says how many.
pub const DEFAULT_TESSELLATION: u32 = 8;

/// A texture layer to give to materials.
#[derive(Clone, Debug, PartialEq)]
pub struct AddedLayer {
    /// Which layer; one that is there already is replaced.
    pub layer: Layer,
    /// The picture. It goes beside the output under its own file name.
    pub file: PathBuf,
    /// The names of the materials that get it; empty means all.
    pub materials: Vec<String>,
    /// For a normal map: the frame of its vectors.
    pub normal_space: NormalSpace,
    /// For a displacement map: the parameters of the objects that use the materials.
    pub displacement: Displacement,
}

impl AddedLayer {
    /// A layer for all materials: normals in tangent space, displacement of 0 to 1 units in
    /// [`DEFAULT_TESSELLATION`] parts.
    pub fn new(layer: Layer, file: impl Into<PathBuf>) -> Self {
        Self {
            layer,
            file: file.into(),
            materials: Vec::new(),
            normal_space: NormalSpace::Tangent,
            displacement: Displacement { tessellation: DEFAULT_TESSELLATION, bias: 0.0, scale: 1.0 },
        }
    }
}

/// Adds a layer. Its texture coordinates are those of the diffuse texture, or of the first layer that has some (import
/// with [`crate::ImportOptions::keep_uvs`] for materials without any texture).
///
/// # Errors
/// When the picture cannot be read, a material does not exist, or triangles have no texture coordinates; the asset is
/// then unchanged.
pub fn add_layer(asset: &mut Asset, added: &AddedLayer) -> Result<(), ConvertError> {
    let name = texture_name(asset, added)?;
    let document = &mut asset.document;
    let materials = Materials::of(document);
    let chosen = chosen(&materials, added)?;

    let objects = document.geometry.frames.first_mut().map_or(&mut [][..], |frame| &mut frame.objects);
    let mut rewritten = objects.to_vec();
    for object in &mut rewritten {
        let mut uses = false;
        let what = format!("object \"{}\"", object.name);
        uv_lines::rewrite(object, &materials, |triangle, lines| {
            let Some(leaf) = triangle.leaf.filter(|leaf| chosen[*leaf]) else {
                lines.extend(triangle.lines);
                return Ok(());
            };
            uses = true;
            insert(triangle, added.layer, lines).ok_or_else(|| {
                ConvertError::Option(format!(
                    "{what} has no texture coordinates for material \"{}\", which a {} needs",
                    materials.leaves()[leaf].name,
                    added.layer.name()
                ))
            })
        })?;
        if uses && added.layer == Layer::Displacement {
            object.displacement = Some(added.displacement);
        }
    }
    objects.clone_from_slice(&rewritten);

    let mut leaf = 0;
    for_each_single_mut(document, |material| {
        if chosen[leaf] {
            let mut texture = Texture::new(name.clone());
            if added.layer == Layer::Normal {
                texture.normal_space = Some(added.normal_space);
            }
            material.layers[added.layer as usize] = Flagged::Yes(Box::new(texture));
            // Light maps replace lighting, so the two on one material would hide the normal map without a word.
            if added.layer == Layer::Normal && material.layers[Layer::LightMap as usize].as_ref().is_some() {
                let note = "its light map replaces lighting, so the normal map shows nothing";
                asset.report.changed(
                    &format!("material \"{}\"", materials.leaves()[leaf].name),
                    "normal map",
                    note,
                    None,
                );
            }
        }
        leaf += 1;
    });
    asset.textures.insert(name, TextureFile::OnDisk(added.file.clone()));
    Ok(())
}

/// Takes out the `TI:` lines that belong to no layer, which [`crate::ImportOptions::keep_uvs`] left, and the texture
/// coordinates that nothing names any more.
pub(crate) fn drop_spare_lines(document: &mut Document) {
    let materials = Materials::of(document);
    for object in document.geometry.frames.iter_mut().flat_map(|frame| &mut frame.objects) {
        let result = uv_lines::rewrite(object, &materials, |triangle, lines| {
            lines.extend(triangle.lines.iter().take(triangle.layers.len()));
            Ok::<(), std::convert::Infallible>(())
        });
        match result {
            Ok(()) => {}
            Err(never) => match never {},
        }
        if let Some(faces) = &mut object.faces {
            uv_lines::drop_unused(faces);
        }
    }
}

/// The lines of a triangle with one for a further layer; `None` if it has no coordinates to give it.
fn insert(triangle: &uv_lines::Lines, layer: Layer, lines: &mut Vec<[u32; 3]>) -> Option<()> {
    let place = |wanted: Layer| triangle.layers.iter().position(|layer| *layer == wanted);
    let of = |wanted: Layer| place(wanted).and_then(|at| triangle.lines.get(at));
    let source = of(layer).or_else(|| of(Layer::Diffuse)).or_else(|| triangle.lines.first())?;
    for other in Layer::ALL {
        if other == layer {
            lines.push(*source);
        } else if place(other).is_some() {
            // Lines count from the front, so none may be missing before the new one.
            match of(other) {
                Some(line) => lines.push(*line),
                None if other < layer => return None,
                None => {}
            }
        }
    }
    Some(())
}

/// Which leaf materials get the layer.
fn chosen(materials: &Materials, added: &AddedLayer) -> Result<Vec<bool>, ConvertError> {
    let names = || materials.leaves().iter().map(|leaf| leaf.name.as_str());
    let option = format!("{}: this {}", added.file.display(), added.layer.name());
    if materials.leaves().is_empty() {
        return Err(ConvertError::Option(format!("{option} has nowhere to go: the asset has no materials")));
    }
    for wanted in &added.materials {
        if !names().any(|name| name == wanted) {
            let near = aam::nearest(wanted.as_bytes(), names()).map(|name| format!("; did you mean \"{name}\"?"));
            let near = near.unwrap_or_default();
            let known: Vec<String> = names().take(20).map(|name| format!("\"{name}\"")).collect();
            return Err(ConvertError::Option(format!(
                "{option} is for material \"{wanted}\", which does not exist; there are {}{}{near}",
                known.join(", "),
                if materials.leaves().len() > 20 { " and others" } else { "" }
            )));
        }
    }
    Ok(names().map(|name| added.materials.is_empty() || added.materials.iter().any(|wanted| wanted == name)).collect())
}

/// The name of the picture in the document: its file name, unless another picture has that.
fn texture_name(asset: &Asset, added: &AddedLayer) -> Result<String, ConvertError> {
    let broken = |reason: String| ConvertError::Option(format!("{}: {reason}", added.file.display()));
    let reader = image::ImageReader::open(&added.file).map_err(|error| broken(format!("cannot read: {error}")))?;
    reader
        .with_guessed_format()
        .map_err(|error| broken(format!("cannot read: {error}")))?
        .into_dimensions()
        .map_err(|error| broken(format!("this is no picture that can be used: {error}")))?;
    let name = added.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let (stem, extension) = name.rsplit_once('.').unwrap_or((&name, ""));
    let free = |name: &String| match asset.textures.get(name) {
        None => true,
        Some(TextureFile::OnDisk(path)) => {
            *path == added.file || std::fs::canonicalize(path).ok() == std::fs::canonicalize(&added.file).ok()
        }
        Some(TextureFile::InMemory(_)) => false,
    };
    let numbered = (2..).map(|number| format!("{stem}-{number}.{extension}"));
    Ok(std::iter::once(name.clone()).chain(numbered).find(free).unwrap_or_default())
}

/// Calls for each single material in the order of [`Materials::leaves`].
fn for_each_single_mut(document: &mut Document, mut call: impl FnMut(&mut SingleMaterial)) {
    let mut pending: Vec<&mut Material> = document.materials.iter_mut().rev().collect();
    while let Some(material) = pending.pop() {
        match &mut material.body {
            MaterialBody::Multi(subs) => pending.extend(subs.iter_mut().rev()),
            MaterialBody::Single(single) => call(single),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ConvertOptions, ImportOptions, Silent, convert, import};

    /// Two triangles of two materials; the first has a texture, both have texture coordinates.
    const MODEL: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        usemtl wood\nf 1/1 2/2 3/3\nusemtl wall\nf 1/1 3/3 4/4\n";

    fn folder(model: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let picture = image::RgbImage::from_pixel(2, 2, image::Rgb([10, 20, 30]));
        for name in ["wood.png", "light.png", "height.png"] {
            picture.save(folder.path().join(name)).unwrap();
        }
        std::fs::write(folder.path().join("m.mtl"), "newmtl wood\nmap_Kd wood.png\nnewmtl wall\nKd 1 0 0\n").unwrap();
        std::fs::write(folder.path().join("m.obj"), model).unwrap();
        folder
    }

    fn read(folder: &tempfile::TempDir) -> Asset {
        let options = ImportOptions { keep_uvs: true, ..ImportOptions::default() };
        import(&folder.path().join("m.obj"), &options, &Silent).unwrap()
    }

    fn lines(asset: &Asset) -> Vec<Vec<[u32; 3]>> {
        let faces = asset.document.objects()[0].faces.as_ref().unwrap();
        faces.tex_indices_of_triangles().map(<[_]>::to_vec).collect()
    }

    #[test]
    fn layers_get_the_coordinates_of_the_diffuse_texture() {
        let folder = folder(MODEL);
        let mut asset = read(&folder);
        add_layer(&mut asset, &AddedLayer::new(Layer::LightMap, folder.path().join("light.png"))).unwrap();
        let mut height = AddedLayer::new(Layer::Displacement, folder.path().join("height.png"));
        height.materials = vec!["wall".into()];
        height.displacement.scale = 0.25;
        add_layer(&mut asset, &height).unwrap();

        assert_eq!(lines(&asset), [vec![[0, 1, 2]; 2], vec![[0, 2, 3]; 2]]);
        let materials = Materials::of(&asset.document);
        let layers: Vec<Vec<Layer>> = materials.leaves().iter().map(|leaf| leaf.present_layers().collect()).collect();
        assert_eq!(layers, [vec![Layer::Diffuse, Layer::LightMap], vec![Layer::LightMap, Layer::Displacement]]);
        let expected = Displacement { tessellation: DEFAULT_TESSELLATION, bias: 0.0, scale: 0.25 };
        assert_eq!(asset.document.objects()[0].displacement, Some(expected));
        assert_eq!(asset.textures.keys().collect::<Vec<_>>(), ["height.png", "light.png", "wood.png"]);
    }

    #[test]
    fn spare_coordinates_go_when_no_layer_came() {
        let folder = folder(MODEL);
        let mut asset = read(&folder);
        assert_eq!(lines(&asset), [vec![[0, 1, 2]], vec![[0, 2, 3]]]);
        drop_spare_lines(&mut asset.document);
        assert_eq!(lines(&asset), [vec![[0, 1, 2]], vec![]]);
        let plain = import(&folder.path().join("m.obj"), &ImportOptions::default(), &Silent).unwrap();
        assert_eq!(plain.document, asset.document);
    }

    #[test]
    fn errors_name_what_is_missing() {
        let folder = folder(&MODEL.replace("1/1 3/3 4/4", "1 3 4"));
        let mut asset = read(&folder);
        let before = asset.document.clone();
        let mut layer = AddedLayer::new(Layer::LightMap, folder.path().join("light.png"));
        let error = add_layer(&mut asset, &layer).unwrap_err().to_string();
        assert_eq!(error, "object \"m\" has no texture coordinates for material \"wall\", which a light map needs");
        layer.materials = vec!["wood".into(), "Wall".into()];
        let error = add_layer(&mut asset, &layer).unwrap_err().to_string();
        assert!(
            error.ends_with(
                "is for material \"Wall\", which does not exist; there are \"wood\", \"wall\"; did you mean \"wall\"?"
            ),
            "{error}"
        );
        layer.file = folder.path().join("m.mtl");
        assert!(add_layer(&mut asset, &layer).unwrap_err().to_string().contains("no picture"));
        layer.file = folder.path().join("none.png");
        assert!(add_layer(&mut asset, &layer).unwrap_err().to_string().contains("cannot read"));
        assert_eq!(asset.document, before);

        layer.file = folder.path().join("light.png");
        layer.materials = vec!["wood".into()];
        add_layer(&mut asset, &layer).unwrap();
    }

    #[test]
    fn a_conversion_with_a_layer() {
        let folder = folder(MODEL);
        let options = ConvertOptions {
            layers: vec![AddedLayer::new(Layer::Normal, folder.path().join("light.png"))],
            ..ConvertOptions::default()
        };
        let converted = convert(&folder.path().join("m.obj"), None, &options, &Silent).unwrap();
        assert_eq!(converted.output, folder.path().join("m.aam"));
        let text = std::fs::read_to_string(converted.output).unwrap();
        assert_eq!(text.matches("NS: TANGENT").count(), 2);
        assert_eq!(text.matches("TI:").count(), 3);
    }
}
