//! From AAM's materials to an MTL library.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use aam::document::{Displacement, Flagged, Layer, NormalSpace, Rgb, SingleMaterial, Texture};
use glam::{Affine2, Mat2, Vec2};

use crate::aam_file::for_each_single;
use crate::files::{Files, within};
use crate::{Asset, Report};

use super::write::clean;

/// The materials of a document, each distinct one once.
pub(super) struct Library<'a> {
    entries: Vec<Entry<'a>>,
    /// The entry of each leaf material.
    of_leaf: Vec<usize>,
}

struct Entry<'a> {
    name: String,
    single: &'a SingleMaterial,
    used: bool,
    displacement: Option<Displacement>,
}

impl<'a> Library<'a> {
    pub(super) fn new(asset: &'a Asset, report: &mut Report) -> Self {
        let mut library = Self { entries: Vec::new(), of_leaf: Vec::new() };
        // Sub-materials of several Multi materials are often the same one.
        let mut by_name: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for_each_single(&asset.document, |name, single| {
            let name = clean(&name.decoded(), "material");
            let known = by_name.entry(name.clone()).or_default();
            // Of many of one name only the latest are compared, to stay linear.
            let same = known.iter().rev().take(64).copied().find(|entry| library.entries[*entry].single == single);
            let entry = same.unwrap_or_else(|| {
                known.push(library.entries.len());
                let name = if known.len() == 1 { name } else { format!("{name}_{}", known.len()) };
                library.entries.push(Entry { name, single, used: false, displacement: None });
                library.entries.len() - 1
            });
            library.of_leaf.push(entry);
        });
        let renamed = by_name.values().map(|entries| entries.len() - 1).sum::<usize>();
        if renamed > 0 {
            report.changed(
                "",
                "material names",
                format!("{renamed} occur twice for different materials; numbers tell them apart"),
                None,
            );
        }
        library
    }

    pub(super) fn is_needed(&self) -> bool {
        !self.entries.is_empty()
    }

    pub(super) fn name(&self, leaf: usize) -> &str {
        &self.entries[self.of_leaf[leaf]].name
    }

    /// Notes that an object with these displacement parameters uses a material.
    pub(super) fn use_leaf(
        &mut self,
        leaf: usize,
        displacement: Option<Displacement>,
        subject: &str,
        report: &mut Report,
    ) {
        let entry = &mut self.entries[self.of_leaf[leaf]];
        let displaced = entry.single.layers[Layer::Displacement as usize].as_ref().is_some();
        if entry.used && displaced && entry.displacement != displacement {
            let note = format!("material \"{}\" has the displacement of another object that uses it", entry.name);
            report.lost(subject, "displacement", note);
        } else {
            entry.displacement = displacement;
        }
        entry.used = true;
    }

    /// The transform of texture coordinates that `-s` and `-o` cannot say, since it turns.
    pub(super) fn turn(&self, leaf: usize) -> Option<Affine2> {
        let texture = self.entries[self.of_leaf[leaf]].single.layers[Layer::Diffuse as usize].as_ref()?;
        turns(texture).then(|| {
            let linear = Mat2::from_angle(texture.rotation[2]) * Mat2::from_diagonal(Vec2::from(texture.tiling));
            let center = Vec2::splat(0.5);
            Affine2 { matrix2: linear, translation: center - linear * (center + Vec2::from(texture.offset)) }
        })
    }

    /// The library and the textures it names.
    pub(super) fn into_files(self, stem: &str, asset: &Asset, files: &mut Files) {
        if !self.is_needed() {
            return;
        }
        let mut text = String::new();
        let mut unused = 0;
        for entry in &self.entries {
            if entry.used {
                entry.write(&mut text, asset, files);
            } else {
                unused += 1;
            }
        }
        if unused > 0 {
            files.report.lost("", "materials", format!("{unused} are used by no object"));
        }
        files.beside.insert(format!("{stem}.mtl"), crate::TextureFile::InMemory(text.into_bytes().into()));
    }
}

fn turns(texture: &Texture) -> bool {
    texture.rotation[2] != 0.0 && texture.rotation[2].is_finite()
}

impl Entry<'_> {
    fn write(&self, text: &mut String, asset: &Asset, files: &mut Files) {
        let single = self.single;
        let subject = format!("material \"{}\"", self.name);
        let color = |text: &mut String, word: &str, [r, g, b]: Rgb| {
            let _ = writeln!(text, "{word} {r} {g} {b}");
        };
        let _ = writeln!(text, "newmtl {}", self.name);
        let black = [0.0; 3];
        let highlight = single.specular != black || single.shininess != 0.0;
        let unlit = single.emission.filter(|_| single.ambient == black && single.diffuse == black && !highlight);
        if let Some(shown) = unlit {
            color(text, "Kd", shown);
            text.push_str("illum 0\n");
        } else {
            color(text, "Ka", single.ambient);
            color(text, "Kd", single.diffuse);
            if highlight {
                color(text, "Ks", single.specular);
                let exponent = if single.shininess <= 1.0 { 128.0 * single.shininess } else { single.shininess };
                let _ = writeln!(text, "Ns {exponent}");
            }
            if let Some(emission) = single.emission {
                color(text, "Ke", emission);
            }
            let _ = writeln!(text, "illum {}", if highlight { 2 } else { 1 });
        }
        let _ = writeln!(text, "d {}", 1.0 - single.transparency);
        if let Some(cutoff) = single.alpha_cutoff {
            let note = format!("alpha below {cutoff} is transparent, not cut away");
            files.report.changed(&subject, "alpha cutoff", note, None);
        }
        for layer in Layer::ALL {
            if let Flagged::Yes(texture) = &single.layers[layer as usize] {
                self.map(text, layer, texture, &subject, asset, files);
            }
        }
    }

    fn map(&self, text: &mut String, layer: Layer, texture: &Texture, subject: &str, asset: &Asset, files: &mut Files) {
        let tangent = texture.normal_space == Some(NormalSpace::Tangent);
        let reason = match layer {
            Layer::LightMap => Some("MTL has no light maps"),
            Layer::Normal if !tangent => Some("MTL has no normal maps in object space"),
            _ => None,
        };
        if let Some(reason) = reason {
            return files.report.lost(subject, layer.name(), format!("{}: {reason}", texture.file));
        }
        let name = texture.file.decoded();
        let file = name.replace('\\', "/");
        match asset.textures.get(&name) {
            Some(source) if within(&name).is_some() => {
                files.beside.insert(file.clone(), source.clone());
            }
            Some(_) => {
                files.report.changed(
                    "",
                    "texture",
                    format!("\"{name}\" is not copied: it leads out of the folder"),
                    None,
                );
            }
            None => {}
        }
        let mut options = String::new();
        match layer {
            Layer::Normal if texture.intensity != 1.0 => drop(write!(options, " -bm {}", texture.intensity)),
            Layer::Displacement => {
                if let Some(displacement) = self.displacement {
                    let _ = write!(options, " -mm {} {}", displacement.bias, displacement.scale);
                }
            }
            _ => {}
        }
        if turns(texture) {
            if layer == Layer::Diffuse {
                let note = "its rotation goes into the texture coordinates";
                files.report.changed(subject, "texture rotation", note, None);
            } else {
                files.report.lost(subject, "texture rotation", format!("{}: MTL cannot turn a texture", texture.file));
            }
        }
        if !(turns(texture) && layer == Layer::Diffuse) {
            // AAM: ½ + s·(uv − ½ − offset). OBJ: s·uv + o.
            let scale = texture.tiling.map(f64::from);
            let offset: [f64; 2] = std::array::from_fn(|i| 0.5 - scale[i] * (0.5 + f64::from(texture.offset[i])));
            if scale != [1.0; 2] {
                let _ = write!(options, " -s {} {} 1", scale[0], scale[1]);
            }
            if offset != [0.0; 2] {
                let _ = write!(options, " -o {} {} 0", offset[0], offset[1]);
            }
        }
        let word = match layer {
            Layer::Normal => "norm",
            Layer::Displacement => "disp",
            _ => "map_Kd",
        };
        let _ = writeln!(text, "{word}{options} {file}");
        if layer == Layer::Diffuse && self.single.alpha_cutoff.is_some() {
            let _ = writeln!(text, "map_d{options} {file}");
        }
    }
}
