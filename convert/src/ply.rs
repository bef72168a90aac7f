//! PLY (Greg Turk, "The PLY Polygon File Format", 1994), text and binary of either byte order.
//!
//! Vertices with normals, colours and texture coordinates; faces as polygons; triangle strips. Other elements are
//! skipped.

mod body;
mod header;

use std::path::Path;

use aam::document::{Flagged, SingleMaterial, Texture};
use aam::read_bytes;
use aam_scene::{FolderTextures, TextureData, TextureSource, Up};

use crate::mesh::{Part, PartMaterial, PartTriangle, document, to_z_up};
use crate::polygon::Triangulator;
use crate::source::Source;
use crate::{Asset, ConvertError, ImportOptions, Report, TextureFile};

use body::Model;

/// Reads a PLY file. Axes: +Z up unless told otherwise.
pub(crate) fn import(path: &Path, options: &ImportOptions) -> Result<Asset, ConvertError> {
    let bytes = read_bytes(path, &options.limits)?;
    let source = Source { path, bytes: &bytes };
    let header = header::parse(source)?;
    let mut asset = Asset::default();
    let model = body::read(source, &header, &mut asset.report)?;
    if model.faces.is_empty() {
        return Err(source.no_faces());
    }
    let materials = header.texture.as_deref().map(|name| textured(name, path, options, &mut asset));
    let up = options.up.unwrap_or(Up::Z);
    let name = path.file_stem().map_or_else(|| "object".into(), |stem| stem.to_string_lossy().into_owned());
    let part = part(name, model, up, materials.is_some(), &mut asset.report);
    let materials: Vec<PartMaterial> = materials.into_iter().collect();
    asset.document = document(vec![part], &materials, options.normal_tolerance, options.keep_uvs, &mut asset.report);
    Ok(asset)
}

/// `comment TextureFile NAME`, as MeshLab writes it.
fn textured(name: &str, path: &Path, options: &ImportOptions, asset: &mut Asset) -> PartMaterial {
    let mut folder = FolderTextures::beside(path);
    folder.allow_outside = options.allow_outside;
    let bare = name.replace('\\', "/").rsplit('/').next().unwrap_or(name).to_owned();
    match folder.find(name) {
        Ok(found) => {
            let file = match found.data {
                TextureData::OnDisk(path) => TextureFile::OnDisk(path),
                TextureData::InMemory(bytes) => TextureFile::InMemory(bytes),
            };
            asset.textures.insert(bare.clone(), file);
        }
        Err(reason) => asset.report.lost("", "texture", format!("{name}: {reason}")),
    }
    let mut single =
        SingleMaterial { class: "Standard".into(), ambient: [1.0; 3], diffuse: [1.0; 3], ..SingleMaterial::default() };
    single.layers[0] = Flagged::Yes(Box::new(Texture::new(bare.as_str())));
    PartMaterial { name: bare, single, displacement: None }
}

fn part(name: String, model: Model, up: Up, textured: bool, report: &mut Report) -> Part {
    let Model { positions, normals, colors, tex_coords, corners, faces, corner_tex_coords, .. } = model;
    let mut triangulator = Triangulator::default();
    let (mut points, mut cut, mut odd) = (Vec::new(), Vec::new(), 0);
    let by_corner = !corner_tex_coords.is_empty();
    let mut part = Part { name, ..Part::default() };
    for (index, first) in faces.iter().enumerate() {
        let end = faces.get(index + 1).map_or(corners.len(), |next| *next as usize);
        let first = *first as usize;
        points.clear();
        points.extend(corners[first..end].iter().map(|corner| positions[*corner as usize]));
        cut.clear();
        odd += usize::from(!triangulator.triangulate(&points, &mut cut));
        for triangle in &cut {
            let places = triangle.map(|at| first + at as usize);
            let vertices = places.map(|place| corners[place]);
            part.triangles.push(PartTriangle {
                vertices,
                tex_coords: if by_corner {
                    Some(places.map(|place| place as u32))
                } else {
                    (!tex_coords.is_empty()).then_some(vertices)
                },
                material: textured.then_some(0),
                smoothing: 0,
            });
            if !normals.is_empty() {
                part.normals.push(vertices.map(|vertex| to_z_up(up, normals[vertex as usize])));
            }
        }
    }
    if odd > 0 {
        let note = format!("{odd} cross themselves or have no area; their triangles may overlap");
        report.changed("", "polygons", note, None);
    }
    if normals.is_empty() {
        report.changed("", "normals", "the file has none, so every face is flat", None);
    }
    part.vertices = positions.into_iter().map(|position| to_z_up(up, position)).collect();
    part.colors = colors;
    part.tex_coords = if by_corner { corner_tex_coords } else { tex_coords };
    // Programs repeat a vertex for each normal or texture coordinate it has.
    part.weld();
    part
}

#[cfg(test)]
mod tests;
