//! Light from all around: how finely it is kept.

use aam_reference::Options;
use aam_renderer::{DiffuseLight, EnvironmentDetail, RenderOptions};
use aam_scene::{Scene, SpecularFilter, View};

use crate::technique::{Limits, Technique, Variant};

/// Diffuse light as a cube or in spherical harmonics, specular light by the size and number of its levels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Environment;

/// The exponent of the last level of a specular map with this many levels, as the renderer spaces them: a lobe one and a
/// half texels wide on the second level, a quarter of the exponent for each further one.
fn last_exponent(detail: &EnvironmentDetail) -> f32 {
    let width = 1.5 * std::f32::consts::PI / detail.specular_size as f32;
    4.0_f32.powi(2 - detail.specular_levels as i32) / (width * width)
}

impl Technique for Environment {
    fn name(&self) -> &'static str {
        "environment"
    }

    fn title(&self) -> &'static str {
        "Image-based lighting: GPU time against difference from the reference"
    }

    fn variants(&self) -> Vec<Variant> {
        let usual = EnvironmentDetail::default();
        let diffuse = [
            ("D2", DiffuseLight::Cube(2)),
            ("D4", DiffuseLight::Cube(4)),
            ("D16", DiffuseLight::Cube(16)),
            ("D64", DiffuseLight::Cube(64)),
            ("H2", DiffuseLight::Harmonics(2)),
            ("H3", DiffuseLight::Harmonics(3)),
            ("H5", DiffuseLight::Harmonics(5)),
        ];
        let diffuse = diffuse.map(|(label, diffuse)| (format!("{label} S256"), EnvironmentDetail { diffuse, ..usual }));
        let sizes = [16, 32, 64, 128, 512]
            .map(|specular_size| (format!("D16 S{specular_size}"), EnvironmentDetail { specular_size, ..usual }));
        let levels = [1, 3, 5].map(|specular_levels| {
            (format!("D16 S256 L{specular_levels}"), EnvironmentDetail { specular_levels, ..usual })
        });
        let all = diffuse.into_iter().chain(sizes).chain(levels);
        all.map(|(label, environment)| Variant {
            label,
            options: RenderOptions { environment, ..RenderOptions::default() },
        })
        .collect()
    }

    fn truth(&self) -> Options<'static> {
        Options { samples_per_pixel: 9, environment_samples: 64, ..Options::default() }
    }

    fn limits(&self, variant: &Variant, scene: &Scene, _view: &View) -> Limits {
        let Some(environment) = scene.lighting_environment() else {
            return Limits::Refuses("the scene is not lit by an environment".into());
        };
        let detail = &variant.options.environment;
        if let DiffuseLight::Harmonics(bands) = detail.diffuse {
            let share = match bands {
                2 => 25,
                3 => 10,
                _ => 6,
            };
            return Limits::Degrades(format!("light from one point is off by up to {share} % of its peak"));
        }
        if let DiffuseLight::Cube(side @ ..8) = detail.diffuse {
            return Limits::Degrades(format!("diffuse light is interpolated over {} degrees", 90 / side));
        }
        let least = scene.materials.iter().map(|material| material.exponent).filter(|exponent| *exponent > 0.0);
        let least = least.fold(f32::INFINITY, f32::min);
        let phong = environment.filter_for(scene.shading) == SpecularFilter::Phong;
        if phong && detail.specular_levels < 12 && least < last_exponent(detail) {
            return Limits::Degrades(format!(
                "exponents below {:.0} reflect as sharply as that",
                last_exponent(detail)
            ));
        }
        if detail.specular_size < 64 {
            return Limits::Degrades(format!(
                "mirrors show texels of {:.1} degrees",
                90.0 / detail.specular_size as f32
            ));
        }
        Limits::Holds
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use aam_scene::{Image, Material, Pixels, Shading};

    use super::*;

    #[test]
    fn limits_say_what_is_coarse() {
        let mut scene = Scene { shading: Shading::Linear, ..Scene::default() };
        let view = View { camera: scene.fitting_camera(1.0), width: 4, height: 4, frame: 0.0 };
        let variants = Environment.variants();
        let limits = |scene: &Scene, label: &str| {
            let variant = variants.iter().find(|variant| variant.label == label).unwrap();
            Environment.limits(variant, scene, &view)
        };
        assert!(matches!(limits(&scene, "D16 S256"), Limits::Refuses(_)));
        let sky = Image { width: 2, height: 1, pixels: Pixels::RgbF32(vec![1.0; 6]) };
        let map = Arc::new(aam_scene::EnvironmentMap::panorama(sky).unwrap());
        scene.environment = Some(aam_scene::Environment::new(map));
        assert_eq!(limits(&scene, "D16 S256"), Limits::Holds);
        assert!(limits(&scene, "H3 S256").text().contains("10 %"));
        assert!(limits(&scene, "D4 S256").text().contains("22 degrees"));
        assert!(limits(&scene, "D16 S16").text().contains("5.6 degrees"));
        assert_eq!(limits(&scene, "D16 S256 L3"), Limits::Holds, "nothing reflects");
        scene.materials.push(Material { exponent: 8.0, ..Material::default() });
        assert!(limits(&scene, "D16 S256 L3").text().contains("as sharply as that"));
    }
}
