//! Shadows: each technique over its grid of parameters.

use std::sync::LazyLock;

use aam_reference::{LightSize, Options};
use aam_renderer::RenderOptions;
use aam_scene::{
    BlurKind, LightKind, PcfKernel, Scene, ShadowFilter, ShadowLayout, ShadowParameter, ShadowSettings,
    ShadowTechnique, View,
};

use crate::technique::{Limits, Parameter, Technique, Variant};

/// How many parameter sets are tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// A few of each technique.
    Quick,
    /// Those that are likely to matter.
    #[default]
    Normal,
    /// A dense grid.
    Full,
}

/// A shadow technique over a grid of its parameters.
///
/// A variant's label is the settings as text, such as `evsm4:resolution=512,radius=5`, and [`Technique::apply`] gives
/// them to every source of the scene.
#[derive(Clone, Copy, Debug)]
pub struct ShadowMapping {
    technique: ShadowTechnique,
    effort: Effort,
}

impl ShadowMapping {
    /// A technique with its grid.
    pub const fn new(technique: ShadowTechnique, effort: Effort) -> Self {
        Self { technique, effort }
    }

    /// The parameter sets of the grid, the most usual first.
    pub fn settings(&self) -> Vec<ShadowSettings> {
        let usual = ShadowSettings::new(self.technique);
        let filter = self.technique.filter;
        let mut all = Vec::new();
        if filter == ShadowFilter::Volume {
            return vec![usual];
        }
        for &resolution in self.resolutions() {
            let sized = ShadowSettings { resolution, ..usual };
            match filter {
                ShadowFilter::Hard => all.push(sized),
                ShadowFilter::Pcss => {
                    all.extend(self.samples().iter().map(|&samples| ShadowSettings { samples, ..sized }))
                }
                _ => all.extend(self.radii().iter().map(|&radius| ShadowSettings { radius, ..sized })),
            }
        }
        if self.effort != Effort::Quick && self.technique.layout == ShadowLayout::One {
            all.extend(self.extras(usual));
        }
        all.retain(|settings| settings.check().is_ok());
        all
    }

    fn resolutions(&self) -> &'static [u32] {
        let one = self.technique.layout == ShadowLayout::One;
        match self.effort {
            Effort::Quick if self.technique.filter == ShadowFilter::Hard && one => &[1024, 512, 2048],
            Effort::Quick if one => &[1024, 512],
            Effort::Quick => &[512],
            Effort::Normal if one => &[1024, 512, 2048, 256],
            Effort::Normal => &[512, 1024],
            Effort::Full => &[1024, 512, 2048, 256, 4096, 128],
        }
    }

    fn radii(&self) -> &'static [u32] {
        let one = self.technique.layout == ShadowLayout::One;
        match self.effort {
            Effort::Quick if one => &[2, 5],
            Effort::Quick => &[2],
            Effort::Normal if one => &[2, 5, 1, 10],
            Effort::Normal => &[2, 5],
            Effort::Full => &[2, 5, 1, 10, 3, 4, 6, 7, 8, 9],
        }
    }

    fn samples(&self) -> &'static [u32] {
        match self.effort {
            Effort::Quick => &[32],
            Effort::Normal => &[32, 16],
            Effort::Full => &[32, 16, 64, 8],
        }
    }

    /// The other parameters, at one resolution each.
    fn extras(&self, usual: ShadowSettings) -> Vec<ShadowSettings> {
        use ShadowFilter::{Esm, Evsm2, Evsm4, Hard, Msm, Pcf, Pcss, Volume, Vsm};
        let wide = ShadowSettings { radius: 5, ..usual };
        match self.technique.filter {
            Hard => vec![
                ShadowSettings { bits: 16, ..usual },
                ShadowSettings { normal_offset: 2.0, slope_bias: 0.5, ..usual },
            ],
            Pcf => vec![
                ShadowSettings { kernel: PcfKernel::Poisson, ..wide },
                ShadowSettings { kernel: PcfKernel::Gaussian, ..wide },
                ShadowSettings { receiver_plane: true, slope_bias: 0.5, ..wide },
            ],
            Pcss => vec![ShadowSettings { receiver_plane: true, slope_bias: 0.5, ..usual }],
            Vsm | Esm | Evsm2 | Evsm4 | Msm => {
                let running = |radius| ShadowSettings { blur: BlurKind::Running, radius, ..usual };
                let mut all = vec![running(10), running(20), ShadowSettings { bleed_reduction: 0.2, ..wide }];
                if matches!(self.technique.filter, Esm | Evsm2 | Evsm4) {
                    all.push(ShadowSettings { exponent: 0.5 * usual.exponent, ..wide });
                }
                all
            }
            Volume => Vec::new(),
        }
    }
}

/// The names of all techniques, which live as long as the program.
static NAMES: LazyLock<Vec<(ShadowTechnique, String, String)>> = LazyLock::new(|| {
    let named = |technique: ShadowTechnique| {
        let title = format!("Shadows by {technique}: GPU time against difference from the reference");
        (technique, technique.to_string(), title)
    };
    ShadowTechnique::all().into_iter().map(named).collect()
});

fn names(technique: ShadowTechnique) -> (&'static str, &'static str) {
    let found = NAMES.iter().find(|(known, _, _)| *known == technique);
    found.map_or(("shadows", "Shadows"), |(_, name, title)| (name, title))
}

impl Technique for ShadowMapping {
    fn name(&self) -> &'static str {
        names(self.technique).0
    }

    fn title(&self) -> &'static str {
        names(self.technique).1
    }

    fn parameters(&self) -> Vec<Parameter> {
        let own = ShadowParameter::ALL.iter().filter(|parameter| parameter.belongs_to(self.technique));
        own.map(|parameter| Parameter {
            key: parameter.key,
            meaning: parameter.meaning,
            range: parameter.range.to_string(),
        })
        .collect()
    }

    fn variants(&self) -> Vec<Variant> {
        let variant =
            |settings: ShadowSettings| Variant { label: settings.to_string(), options: RenderOptions::default() };
        self.settings().into_iter().map(variant).collect()
    }

    fn apply(&self, variant: &Variant, scene: &mut Scene) {
        let Ok(settings) = variant.label.parse::<ShadowSettings>() else { return };
        for source in scene.shadows.iter_mut().flat_map(|shadows| &mut shadows.sources) {
            source.settings = settings;
        }
    }

    fn truth(&self) -> Options<'static> {
        Options { samples_per_pixel: 64, shadows: Some(LightSize::Area), ..Options::default() }
    }

    /// Whether the layout fits the lights; what the renderer knows of its limits comes on top.
    fn limits(&self, _variant: &Variant, scene: &Scene, _view: &View) -> Limits {
        let Some(shadows) = &scene.shadows else {
            return Limits::Refuses("the scene has no shadow sources".into());
        };
        let lights = shadows.sources.iter().filter_map(|source| scene.lights.get(source.light?));
        for light in lights {
            match (self.technique.layout, &light.kind) {
                (ShadowLayout::Cascades, LightKind::Point { .. } | LightKind::Spot { .. }) => {
                    return Limits::Refuses("cascades are for directional lights".into());
                }
                (ShadowLayout::Cube, LightKind::Directional { .. }) => {
                    return Limits::Refuses("a cube needs a place to stand, and this light is directional".into());
                }
                (ShadowLayout::Cube, LightKind::Spot { .. }) => {
                    return Limits::Refuses("a spot light needs one map, not six".into());
                }
                _ => {}
            }
        }
        Limits::Holds
    }
}

#[cfg(test)]
mod tests {
    use aam_scene::{Light, ShadowSource, Shadows};
    use glam::Vec3;

    use super::*;

    fn scene(kind: LightKind) -> Scene {
        let light = Light {
            name: "sun".into(),
            kind,
            ambient: Vec3::ZERO,
            diffuse: Vec3::ONE,
            specular: Vec3::ONE,
            shape: None,
        };
        let sources = vec![ShadowSource::of_light(0, ShadowSettings::default())];
        Scene { lights: vec![light], shadows: Some(Shadows { sources, ..Shadows::default() }), ..Scene::default() }
    }

    #[test]
    fn every_technique_has_a_grid_without_repetition_that_its_labels_bring_back() {
        for effort in [Effort::Quick, Effort::Normal, Effort::Full] {
            for technique in ShadowTechnique::all() {
                let shadow = ShadowMapping::new(technique, effort);
                let (settings, variants) = (shadow.settings(), shadow.variants());
                assert!(!settings.is_empty() && settings.len() == variants.len());
                let mut labels: Vec<&str> = variants.iter().map(|variant| variant.label.as_str()).collect();
                labels.sort_unstable();
                labels.dedup();
                assert_eq!(labels.len(), variants.len(), "{technique}");
                let mut scene = scene(LightKind::Directional { direction: Vec3::NEG_Z });
                for (settings, variant) in settings.iter().zip(&variants) {
                    shadow.apply(variant, &mut scene);
                    assert_eq!(scene.shadows.as_ref().unwrap().sources[0].settings, *settings);
                }
                let keys: Vec<&str> = shadow.parameters().iter().map(|parameter| parameter.key).collect();
                assert!(keys.contains(&"intensity"), "{keys:?}");
            }
        }
    }

    #[test]
    fn layouts_are_refused_where_they_do_not_fit_the_light() {
        let scene = scene(LightKind::Directional { direction: Vec3::NEG_Z });
        let view = View { camera: scene.fitting_camera(1.0), width: 4, height: 4, frame: 0.0 };
        let limits = |name: &str| {
            let technique = crate::technique(name).unwrap();
            technique.limits(&technique.variants()[0], &scene, &view)
        };
        assert_eq!(limits("csm-pcf"), Limits::Holds);
        assert_eq!(limits("evsm4"), Limits::Holds);
        assert!(limits("cube-pcf").text().starts_with("refuses because a cube needs a place"));
    }
}
