//! The measure: what a highlight adds to the picture, by GGX and by a Phong lobe.

use std::f64::consts::PI;

use aam_convert::phong::{MetallicRoughness, from_metallic_roughness};

/// A lobe as AAM draws it: what the highlight and its diffuse share add to a material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lobe {
    /// Specular colour, sRGB-encoded.
    pub(crate) specular: f64,
    /// Phong exponent; 0 is no highlight.
    pub(crate) exponent: f64,
    /// Added to the linear diffuse reflectance.
    pub(crate) share: f64,
}

/// A surface: reflectance at normal incidence, and the diffuse bodies below it that it is measured over.
pub(crate) struct Surface {
    /// For the table.
    pub(crate) name: &'static str,
    /// F at normal incidence, linear.
    pub(crate) f0: f64,
    /// Base colours of the body, linear.
    pub(crate) bases: &'static [f64],
}

/// What is measured: plastic over dark to white bases, and metals from dark to silver.
pub(crate) const SURFACES: [Surface; 4] = [
    Surface { name: "dielectric 0.04", f0: 0.04, bases: &[0.0, 0.05, 0.18, 0.5, 0.8] },
    Surface { name: "metal 0.30", f0: 0.30, bases: &[0.0] },
    Surface { name: "metal 0.60", f0: 0.60, bases: &[0.0] },
    Surface { name: "metal 0.95", f0: 0.95, bases: &[0.0] },
];

/// sRGB encoding.
pub(crate) fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB decoding.
pub(crate) fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// One direction of view.
struct Sample {
    /// Projected solid angle (cosine × solid angle): the weight.
    weight: f64,
    /// Cosine to the normal.
    cos_view: f64,
    /// Cosine to the mirror direction, not below 0.
    cos_mirror: f64,
    /// Cosine of the normal to the half vector, squared.
    cos_half_squared: f64,
    /// Cosine of the view to the half vector.
    cos_view_half: f64,
}

/// The hemisphere of views for one direction of light, finely divided around the mirror direction.
pub(crate) struct Incidence {
    /// Cosine of the light's angle to the normal.
    pub(crate) cos_light: f64,
    samples: Vec<Sample>,
}

impl Incidence {
    /// Light at this angle from the normal, in degrees.
    pub(crate) fn at(degrees: f64) -> Self {
        const RINGS: usize = 96;
        const SECTORS: usize = 12;
        let (sin, cos) = degrees.to_radians().sin_cos();
        let mut samples = Vec::new();
        let edge = |ring: usize| (PI * (ring as f64 / RINGS as f64).powi(3)).cos();
        for ring in 0..RINGS {
            let (inner, outer) = (edge(ring), edge(ring + 1));
            let cos_mirror = 0.5 * (inner + outer);
            let sin_mirror = (1.0 - cos_mirror * cos_mirror).max(0.0).sqrt();
            // Half the circle stands for both halves.
            let solid_angle = (inner - outer) * 2.0 * PI / SECTORS as f64;
            for sector in 0..SECTORS {
                let turn = PI * (sector as f64 + 0.5) / SECTORS as f64;
                let (across, along) = (sin_mirror * turn.sin(), sin_mirror * turn.cos());
                // Light (sin, 0, cos), mirror (−sin, 0, cos), and (cos, 0, sin), (0, 1, 0) across it.
                let view = [-sin * cos_mirror + cos * along, across, cos * cos_mirror + sin * along];
                if view[2] < 1e-4 {
                    continue;
                }
                let half = [view[0] + sin, view[1], view[2] + cos];
                let length = half.iter().map(|x| x * x).sum::<f64>().sqrt();
                samples.push(Sample {
                    weight: solid_angle * view[2],
                    cos_view: view[2],
                    cos_mirror: cos_mirror.max(0.0),
                    cos_half_squared: (half[2] / length).powi(2),
                    cos_view_half: view.iter().zip(half).map(|(v, h)| v * h).sum::<f64>() / length,
                });
            }
        }
        Self { cos_light: cos, samples }
    }

    /// The incidences that count: 0° to 80°.
    pub(crate) fn all() -> Vec<Self> {
        (0..=8).map(|step| Self::at(10.0 * f64::from(step))).collect()
    }

    /// GGX with height-correlated Smith masking and Schlick's Fresnel, times cosine, for each view, under a light
    /// that lights a white diffuse surface to 1.
    fn truth(&self, alpha: f64, f0: f64) -> impl Iterator<Item = f64> {
        let a2 = alpha * alpha;
        let l = self.cos_light;
        self.samples.iter().map(move |sample| {
            let v = sample.cos_view;
            let distribution = a2 / (sample.cos_half_squared * (a2 - 1.0) + 1.0).powi(2);
            let masking = 0.5 / (l * (v * v * (1.0 - a2) + a2).sqrt() + v * (l * l * (1.0 - a2) + a2).sqrt());
            distribution * masking * (f0 + (1.0 - f0) * (1.0 - sample.cos_view_half).powi(5)) * l
        })
    }

    /// Cosine-weighted mean of a quantity over the views.
    fn mean(&self, values: impl Iterator<Item = f64>) -> f64 {
        let total: f64 = self.samples.iter().map(|sample| sample.weight).sum();
        self.samples.iter().zip(values).map(|(sample, value)| sample.weight * value).sum::<f64>() / total
    }

    /// Part of the light from here that GGX reflects.
    pub(crate) fn albedo(&self, alpha: f64, f0: f64) -> f64 {
        // The mean over projected solid angle is the integral over π, and so is the white surface's unit.
        self.mean(self.truth(alpha, f0)) / self.cos_light
    }
}

/// On which values the picture is lit.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shading {
    /// Stored values as they are.
    Source,
    /// Decoded first, encoded last.
    Linear,
}

/// Mean squares over views and incidences of one surface: of the error, and of what the truth adds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Error {
    /// RMS difference in display values (0 black … 1 white).
    pub(crate) rms: f64,
    /// RMS of what the highlight adds, in display values: the error of leaving it out.
    pub(crate) without: f64,
    /// Light sent to the viewer in the linear picture, relative to the truth, minus 1.
    pub(crate) energy: f64,
}

/// How far a lobe's picture is from GGX's: over both shadings, all bases, incidences and views.
pub(crate) fn error(incidences: &[Incidence], surface: &Surface, alpha: f64, lobe: Lobe) -> Error {
    let (mut squares, mut without, mut light, mut light_truth) = (0.0, 0.0, 0.0, 0.0);
    for incidence in incidences {
        let l = incidence.cos_light;
        let truth: Vec<f64> = incidence.truth(alpha, surface.f0).collect();
        let phong: Vec<f64> = incidence
            .samples
            .iter()
            .map(|sample| if lobe.exponent > 0.0 { sample.cos_mirror.powf(lobe.exponent) } else { 0.0 })
            .collect();
        for base in surface.bases {
            let body = base * (1.0 - surface.f0);
            let diffuse = body + lobe.share;
            // What the highlight adds to the picture of the body alone, so that the difference between the two
            // shadings' diffuse falloff, which no mapping can mend, does not count.
            let wanted = |truth: f64| encode((truth + body * l).min(1.0)) - encode(body * l);
            without += incidence.mean(truth.iter().map(|&t| wanted(t).powi(2)));
            for shading in [Shading::Source, Shading::Linear] {
                let shown = |phong: f64| match shading {
                    Shading::Source => (encode(diffuse) * l + lobe.specular * phong).min(1.0) - encode(body) * l,
                    Shading::Linear => {
                        encode((diffuse * l + decode(lobe.specular) * phong).min(1.0)) - encode(body * l)
                    }
                };
                squares += incidence.mean(truth.iter().zip(&phong).map(|(&t, &p)| (shown(p) - wanted(t)).powi(2)));
            }
            light_truth += incidence.mean(truth.iter().map(|&t| (t + body * l).min(1.0) - body * l));
            light +=
                incidence.mean(phong.iter().map(|&p| (diffuse * l + decode(lobe.specular) * p).min(1.0) - body * l));
        }
    }
    let count = (incidences.len() * surface.bases.len()) as f64;
    Error {
        rms: (squares / (2.0 * count)).sqrt(),
        without: (without / count).sqrt(),
        energy: light / light_truth - 1.0,
    }
}

/// Angle in degrees from the mirror direction at which the linear picture over black falls to half its value there,
/// light along the normal; 90 if it does not.
pub(crate) fn half_width(value_at: impl Fn(f64) -> f64) -> f64 {
    let half = 0.5 * encode(value_at(0.0).min(1.0));
    (1..=1800)
        .map(|step| 0.05 * f64::from(step))
        .find(|degrees| encode(value_at(degrees.to_radians()).min(1.0)) < half)
        .unwrap_or(90.0)
}

/// [`half_width`] of GGX.
pub(crate) fn half_width_of_ggx(alpha: f64, f0: f64) -> f64 {
    let a2 = alpha * alpha;
    half_width(|angle| {
        let v = angle.cos().max(0.0);
        let h = (0.5 * angle).cos();
        let distribution = a2 / (h * h * (a2 - 1.0) + 1.0).powi(2);
        let masking = 0.5 / ((v * v * (1.0 - a2) + a2).sqrt() + v);
        distribution * masking * (f0 + (1.0 - f0) * (1.0 - h).powi(5))
    })
}

/// [`half_width`] of a lobe.
pub(crate) fn half_width_of(lobe: Lobe) -> f64 {
    half_width(|angle| {
        let highlight = if lobe.exponent > 0.0 { angle.cos().max(0.0).powf(lobe.exponent) } else { 0.0 };
        lobe.share + decode(lobe.specular) * highlight
    })
}

/// The peak that GGX has for light and view along the normal, encoded and clipped.
fn clipped_peak(alpha: f64, f0: f64) -> f64 {
    encode((f0 / (4.0 * alpha * alpha)).min(1.0))
}

/// A mapping: from the GGX width α and the reflectance at normal incidence to a lobe.
pub(crate) type Mapping = fn(f64, f64) -> Lobe;

/// The candidates, with their names.
pub(crate) const CANDIDATES: [(&str, Mapping); 4] = [
    ("half-vector 2/α²−2", half_vector),
    ("quarter of it", quarter),
    ("displayed half width", displayed_half_width),
    ("chosen", chosen),
];

fn half_vector(alpha: f64, f0: f64) -> Lobe {
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    Lobe { specular: clipped_peak(alpha, f0), exponent, share: 0.0 }
}

fn quarter(alpha: f64, f0: f64) -> Lobe {
    Lobe { exponent: 0.25 * half_vector(alpha, f0).exponent, ..half_vector(alpha, f0) }
}

fn displayed_half_width(alpha: f64, f0: f64) -> Lobe {
    let angle = half_width_of_ggx(alpha, f0).to_radians();
    let exponent = if angle < 1.55 { 0.5_f64.ln() / angle.cos().ln() } else { 0.0 };
    Lobe { specular: clipped_peak(alpha, f0), exponent, share: 0.0 }
}

/// The mapping of the library.
pub(crate) fn chosen(alpha: f64, f0: f64) -> Lobe {
    let phong = from_metallic_roughness(&MetallicRoughness {
        base_color: [0.0; 3],
        metallic: 0.0,
        roughness: alpha.sqrt() as f32,
        dielectric_f0: [f0 as f32; 3],
    });
    Lobe {
        specular: f64::from(phong.specular[0]),
        exponent: f64::from(phong.exponent),
        share: decode(f64::from(phong.diffuse[0])),
    }
}
