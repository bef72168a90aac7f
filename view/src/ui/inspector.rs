//! What the selected object is made of: its mesh, materials and texture layers.

use std::collections::BTreeMap;

use aam_scene::{Image, Layer, Material, MaterialId, NodeId, NormalSpace, Pixels, Scene, TextureId, TextureLayer};
use egui::{Color32, ColorImage, RichText, Sense, TextureHandle, TextureOptions, vec2};
use glam::{Mat3, Vec3};

use super::theme;

/// Longest side of a thumbnail in pixels.
const THUMBNAIL: u32 = 96;

/// Small pictures of the textures, made when first shown.
#[derive(Default)]
pub(crate) struct Thumbnails(BTreeMap<TextureId, TextureHandle>);

impl Thumbnails {
    /// Another scene's textures are others.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    fn of(&mut self, context: &egui::Context, id: TextureId, image: &Image) -> TextureHandle {
        self.0
            .entry(id)
            .or_insert_with(|| {
                context.load_texture(format!("thumbnail {}", id.0), thumbnail(image), TextureOptions::LINEAR)
            })
            .clone()
    }
}

/// Draws the details of the selected object, or of all materials.
pub(crate) fn show(ui: &mut egui::Ui, scene: &Scene, selected: Option<NodeId>, thumbnails: &mut Thumbnails) {
    let Some((node_id, node)) = selected.and_then(|id| Some((id, scene.nodes.get(id.index())?))) else {
        ui.label(theme::weak(format!("All materials ({})", scene.materials.len())));
        for index in 0..scene.materials.len() {
            material(ui, scene, MaterialId(index as u32), None, thumbnails);
        }
        return;
    };
    ui.heading(if node.name.is_empty() { "(no name)" } else { &node.name });
    let Some(mesh) = node.mesh.and_then(|id| scene.meshes.get(id.index())) else {
        ui.label(theme::weak("No mesh: it only places what hangs below it."));
        return;
    };
    egui::Grid::new(("object", node_id.0)).num_columns(2).spacing([14.0, 3.0]).show(ui, |ui| {
        fact(ui, "Triangles", count(mesh.indices.len() / 3));
        fact(ui, "Vertices", count(mesh.positions.len()));
        if !mesh.bounds.is_empty() {
            fact(ui, "Size", vector(mesh.bounds.max - mesh.bounds.min));
            fact(ui, "Centre", vector(mesh.bounds.center()));
        }
        let mut has = Vec::new();
        if mesh.colors.is_some() {
            has.push("vertex colours".to_owned());
        }
        if mesh.tangents.is_some() {
            has.push("tangents".to_owned());
        }
        if !mesh.frames.is_empty() {
            has.push(format!("{} frames", mesh.frames.len() + 1));
        }
        for layer in Layer::ALL {
            if mesh.uvs[layer as usize].is_some() {
                has.push(format!("{} coordinates", layer_name(layer)));
            }
        }
        if !has.is_empty() {
            fact(ui, "Has", has.join(", "));
        }
        if let Some(displacement) = mesh.displacement {
            let text = format!(
                "bias {}, scale {}, {} parts an edge",
                displacement.bias, displacement.scale, displacement.tessellation
            );
            fact(ui, "Displacement", text);
        }
    });
    let mut used: Vec<MaterialId> = mesh.subsets.iter().map(|subset| subset.material).collect();
    used.sort_unstable();
    used.dedup();
    ui.add_space(6.0);
    for id in &used {
        material(ui, scene, *id, Some((node_id, used.len() <= 3)), thumbnails);
    }
}

/// `of` is the object that is looked at, and whether its materials are open at first.
fn material(ui: &mut egui::Ui, scene: &Scene, id: MaterialId, of: Option<(NodeId, bool)>, thumbnails: &mut Thumbnails) {
    let Some(material) = scene.materials.get(id.index()) else { return };
    let name = if material.name.is_empty() { format!("material {}", id.0) } else { material.name.clone() };
    let header = egui::CollapsingHeader::new(name)
        .id_salt(("material", id.0, of.map(|(node, _)| node.0)))
        .default_open(of.is_some_and(|(_, open)| open));
    header.show(ui, |ui| {
        egui::Grid::new(("colours", id.0)).num_columns(2).spacing([14.0, 3.0]).show(ui, |ui| {
            colors(ui, material);
            fact(
                ui,
                "Exponent",
                if material.exponent == 0.0 { "0 (no highlight)".into() } else { number(material.exponent) },
            );
            fact(ui, "Opacity", number(material.opacity));
            if let Some(cutoff) = material.alpha_cutoff {
                fact(ui, "Alpha cutoff", number(cutoff));
            }
        });
        for layer in Layer::ALL {
            if let Some(used) = &material.layers[layer as usize] {
                texture(ui, scene, layer, used, thumbnails);
            }
        }
    });
}

fn colors(ui: &mut egui::Ui, material: &Material) {
    let colors = [
        ("Ambient", material.ambient),
        ("Diffuse", material.diffuse),
        ("Specular", material.specular),
        ("Emission", material.emission),
    ];
    for (name, color) in colors {
        ui.label(theme::weak(name));
        ui.horizontal(|ui| {
            let (rect, _) = ui.allocate_exact_size(vec2(22.0, 12.0), Sense::hover());
            let bytes = color.to_array().map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8);
            ui.painter().rect_filled(rect, 3.0, Color32::from_rgb(bytes[0], bytes[1], bytes[2]));
            ui.label(vector(color));
        });
        ui.end_row();
    }
}

fn texture(ui: &mut egui::Ui, scene: &Scene, layer: Layer, used: &TextureLayer, thumbnails: &mut Thumbnails) {
    let Some(texture) = scene.textures.get(used.texture.index()) else { return };
    ui.add_space(4.0);
    ui.horizontal_top(|ui| {
        let side = 56.0;
        match &texture.image {
            Ok(image) => {
                let handle = thumbnails.of(ui.ctx(), used.texture, image);
                let shown = ui.add(egui::Image::new(&handle).fit_to_exact_size(vec2(side, side)).corner_radius(4));
                shown.on_hover_ui(|ui| {
                    ui.add(egui::Image::new(&handle).fit_to_exact_size(vec2(192.0, 192.0)));
                });
            }
            Err(_) => {
                let (rect, _) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
                ui.painter().rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
                let font = egui::FontId::proportional(20.0);
                ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, "?", font, theme::ERROR);
            }
        }
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            ui.label(RichText::new(layer_title(layer, used)).color(theme::ACCENT));
            ui.add(egui::Label::new(&texture.name).truncate());
            match &texture.image {
                Ok(image) => ui.label(theme::weak(image_facts(image))),
                Err(reason) => ui.add(egui::Label::new(RichText::new(reason).small().color(theme::ERROR)).wrap()),
            };
            let mut notes = Vec::new();
            if used.transform != Mat3::IDENTITY {
                notes.push("coordinates transformed".to_owned());
            }
            if layer == Layer::Normal && used.intensity != 1.0 {
                notes.push(format!("intensity {}", number(used.intensity)));
            }
            if !notes.is_empty() {
                ui.label(theme::weak(notes.join(", ")));
            }
        });
    });
}

fn fact(ui: &mut egui::Ui, name: &str, value: String) {
    ui.label(theme::weak(name));
    ui.add(egui::Label::new(value).wrap());
    ui.end_row();
}

/// The name for people.
pub(crate) fn layer_name(layer: Layer) -> &'static str {
    match layer {
        Layer::Diffuse => "diffuse",
        Layer::LightMap => "light map",
        Layer::Normal => "normal map",
        Layer::Displacement => "displacement map",
    }
}

fn layer_title(layer: Layer, used: &TextureLayer) -> String {
    match (layer, used.normal_space) {
        (Layer::Normal, NormalSpace::Tangent) => "normal map, tangent space".into(),
        (Layer::Normal, NormalSpace::Object) => "normal map, object space".into(),
        _ => layer_name(layer).into(),
    }
}

fn image_facts(image: &Image) -> String {
    let kind = match &image.pixels {
        Pixels::Rgba8(_) => "8 bit",
        Pixels::Rgba16(_) => "16 bit",
        Pixels::RgbF32(_) => "float",
    };
    format!("{} × {}, {kind}", image.width, image.height)
}

fn number(value: f32) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn vector(value: Vec3) -> String {
    format!("{}  {}  {}", number(value.x), number(value.y), number(value.z))
}

/// With groups of three digits.
pub(crate) fn count(value: usize) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// One pixel of each block: cheap, and good enough to tell textures apart.
fn thumbnail(image: &Image) -> ColorImage {
    let (width, height) = (image.width.max(1), image.height.max(1));
    let scale = (THUMBNAIL as f32 / width.max(height) as f32).min(1.0);
    let side = |length: u32| ((length as f32 * scale).round() as u32).clamp(1, length);
    let (columns, rows) = (side(width), side(height));
    let mut pixels = Vec::with_capacity((columns * rows) as usize);
    for row in 0..rows {
        for column in 0..columns {
            let x = (u64::from(column) * 2 + 1) * u64::from(width) / (2 * u64::from(columns));
            let y = (u64::from(row) * 2 + 1) * u64::from(height) / (2 * u64::from(rows));
            pixels.push(pixel(image, (y * u64::from(width) + x) as usize));
        }
    }
    ColorImage::new([columns as usize, rows as usize], pixels)
}

fn pixel(image: &Image, index: usize) -> Color32 {
    let none = Color32::TRANSPARENT;
    match &image.pixels {
        Pixels::Rgba8(bytes) => bytes
            .get(4 * index..4 * index + 4)
            .map_or(none, |p| Color32::from_rgba_unmultiplied(p[0], p[1], p[2], p[3])),
        Pixels::Rgba16(words) => words.get(4 * index..4 * index + 4).map_or(none, |p| {
            let byte = |word: u16| (word >> 8) as u8;
            Color32::from_rgba_unmultiplied(byte(p[0]), byte(p[1]), byte(p[2]), byte(p[3]))
        }),
        Pixels::RgbF32(floats) => floats.get(3 * index..3 * index + 3).map_or(none, |p| {
            let byte = |value: f32| (value.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
            Color32::from_rgb(byte(p[0]), byte(p[1]), byte(p[2]))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thumbnails_keep_the_shape_and_bound_the_size() {
        let pixels = Pixels::Rgba8([10, 20, 30, 255].repeat(1000 * 250));
        let image = Image { width: 1000, height: 250, pixels };
        let small = thumbnail(&image);
        assert_eq!(small.size, [96, 24]);
        assert!(small.pixels.iter().all(|pixel| *pixel == Color32::from_rgb(10, 20, 30)));
    }

    #[test]
    fn thumbnails_survive_broken_images() {
        let image = Image { width: 4, height: 4, pixels: Pixels::Rgba16(vec![0; 8]) };
        assert_eq!(thumbnail(&image).size, [4, 4]);
        let line = Image { width: 1, height: 5000, pixels: Pixels::RgbF32(vec![9.0; 15000]) };
        assert_eq!(thumbnail(&line).size, [1, 96]);
    }
}
