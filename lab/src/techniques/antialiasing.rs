//! Smooth edges by several samples a pixel, and sharp textures at a slant by an anisotropic filter.

use aam_reference::Options;
use aam_renderer::{Msaa, RenderOptions};
use aam_scene::{Layer, Scene, View};

use crate::technique::{Limits, Technique, Variant};

/// Ratios of the anisotropic filter to try. Ratios between them cost the same on a software rasteriser.
const RATIOS: [u16; 2] = [1, 16];

/// Multisampling (1 or 4 samples a pixel) with anisotropic texture filtering (off or ratio 16).
#[derive(Clone, Copy, Debug, Default)]
pub struct Antialiasing;

impl Technique for Antialiasing {
    fn name(&self) -> &'static str {
        "antialiasing"
    }

    fn title(&self) -> &'static str {
        "Multisampling and anisotropic filtering: GPU time against difference from the reference"
    }

    fn variants(&self) -> Vec<Variant> {
        let settings = [Msaa::X1, Msaa::X4].into_iter().flat_map(|msaa| RATIOS.map(|anisotropy| (msaa, anisotropy)));
        let variant = |(msaa, anisotropy): (Msaa, u16)| Variant {
            label: format!("{}×{}", msaa.samples(), if anisotropy > 1 { " + A16" } else { "" }),
            options: RenderOptions { msaa, anisotropy, ..RenderOptions::default() },
        };
        settings.map(variant).collect()
    }

    fn truth(&self) -> Options<'static> {
        Options { samples_per_pixel: 64, ..Options::default() }
    }

    fn limits(&self, variant: &Variant, scene: &Scene, _view: &View) -> Limits {
        if variant.options.msaa == Msaa::X1 {
            return Limits::Degrades("edges are jagged".into());
        }
        if scene.materials.iter().any(|material| material.alpha_cutoff.is_some()) {
            return Limits::Degrades(
                "edges that an alpha cutoff makes lie inside triangles, where all samples are one".into(),
            );
        }
        if scene.materials.iter().any(|material| material.layers[Layer::Normal as usize].is_some()) {
            return Limits::Degrades("highlights on normal maps are shaded once a pixel and may sparkle".into());
        }
        Limits::Holds
    }
}

#[cfg(test)]
mod tests {
    use aam_scene::Material;

    use super::*;

    #[test]
    fn limits_name_what_multisampling_does_not_smooth() {
        let mut scene = Scene::default();
        let camera = scene.fitting_camera(1.0);
        let view = View { camera, width: 4, height: 4, frame: 0.0 };
        let variants = Antialiasing.variants();
        let limits = |scene: &Scene, label: &str| {
            let variant = variants.iter().find(|variant| variant.label == label).unwrap();
            Antialiasing.limits(variant, scene, &view)
        };
        assert!(matches!(limits(&scene, "1× + A16"), Limits::Degrades(_)));
        assert_eq!(limits(&scene, "4×"), Limits::Holds);
        scene.materials.push(Material { alpha_cutoff: Some(0.5), ..Material::default() });
        assert!(limits(&scene, "4×").text().starts_with("degrades because edges that an alpha cutoff makes"));
    }
}
