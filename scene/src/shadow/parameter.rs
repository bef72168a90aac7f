//! The parameters of shadow techniques: what each means, its range, and which techniques have it.

use std::fmt;

use super::settings::{ShadowFilter, ShadowLayout, ShadowSettings, ShadowTechnique};

/// A parameter of [`ShadowSettings`].
#[derive(Clone, Copy)]
pub struct ShadowParameter {
    /// Its name in files, flags and charts: that of the field.
    pub key: &'static str,
    /// What it means, in a line.
    pub meaning: &'static str,
    /// The values that it may have.
    pub range: Range,
    belongs: fn(ShadowTechnique) -> bool,
    get: fn(&ShadowSettings) -> String,
    set: fn(&mut ShadowSettings, &str) -> Option<()>,
}

/// The values that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Numbers from one to another.
    Numbers {
        /// The least.
        from: f32,
        /// The most.
        to: f32,
        /// Only whole ones.
        whole: bool,
    },
    /// `true` or `false`.
    Switch,
    /// One of some words.
    Words(&'static [&'static str]),
}

/// A value that a parameter cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {value} is out of range: {range}")]
pub struct ParameterError {
    /// The parameter.
    pub key: &'static str,
    /// What was given.
    pub value: String,
    /// What it may be.
    pub range: String,
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Numbers { from, to, whole } => {
                let kind = if *whole { "a whole number" } else { "a number" };
                if to.is_finite() { write!(f, "{kind} from {from} to {to}") } else { write!(f, "{kind} from {from}") }
            }
            Self::Switch => f.write_str("true or false"),
            Self::Words(words) => write!(f, "one of {}", words.join(", ")),
        }
    }
}

impl fmt::Debug for ShadowParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ShadowParameter").field("key", &self.key).field("range", &self.range).finish_non_exhaustive()
    }
}

/// `get` and `set` of a field that has a text form.
macro_rules! parameter {
    ($field:ident, $meaning:literal, $range:expr, $belongs:expr) => {
        ShadowParameter {
            key: stringify!($field),
            meaning: $meaning,
            range: $range,
            belongs: $belongs,
            get: |settings| settings.$field.to_string(),
            set: |settings, text| {
                settings.$field = text.parse().ok()?;
                Some(())
            },
        }
    };
}

const fn numbers(from: f32, to: f32) -> Range {
    Range::Numbers { from, to, whole: false }
}

const fn whole(from: u32, to: u32) -> Range {
    Range::Numbers { from: from as f32, to: to as f32, whole: true }
}

const fn compares(technique: ShadowTechnique) -> bool {
    technique.filter.compares()
}

const fn has_moments(technique: ShadowTechnique) -> bool {
    technique.filter.has_moments()
}

const fn is_mapped(technique: ShadowTechnique) -> bool {
    !matches!(technique.filter, ShadowFilter::Volume)
}

const fn cascades(technique: ShadowTechnique) -> bool {
    matches!(technique.layout, ShadowLayout::Cascades)
}

impl ShadowParameter {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        parameter!(resolution, "texels along each side of a map", whole(1, 16_384), is_mapped),
        parameter!(intensity, "how much of a light a full shadow takes away", numbers(0.0, 1.0), |_| true),
        Self {
            range: Range::Words(&["8", "16", "24", "32"]),
            ..parameter!(bits, "bits of a stored depth", Range::Switch, compares)
        },
        parameter!(bias, "metres that receivers are moved towards the source", numbers(0.0, f32::INFINITY), compares),
        parameter!(
            slope_bias,
            "the same, in units of what a plane of this slope needs to be free of acne",
            numbers(0.0, 16.0),
            compares
        ),
        parameter!(max_bias, "the most that both are together, in metres", numbers(0.0, f32::INFINITY), compares),
        parameter!(
            normal_offset,
            "texels that receivers are moved along their normal at grazing incidence",
            numbers(0.0, 16.0),
            compares
        ),
        parameter!(
            receiver_plane,
            "samples are compared with the receiver's plane",
            Range::Switch,
            |technique| matches!(technique.filter, ShadowFilter::Pcf | ShadowFilter::Pcss)
                && !matches!(technique.layout, ShadowLayout::Cube)
        ),
        parameter!(faces, "faces of casters that are in the map", Range::Words(super::CasterFaces::WORDS), is_mapped),
        parameter!(kernel, "weights of the kernel", Range::Words(super::PcfKernel::WORDS), |technique| matches!(
            technique.filter,
            ShadowFilter::Pcf
        )),
        parameter!(radius, "texels from the middle of the kernel to its edge", whole(1, 10), |technique| {
            matches!(technique.filter, ShadowFilter::Pcf) || technique.filter.has_moments()
        }),
        parameter!(
            light_size,
            "side or diameter of the light in metres; 0 takes it from the light's shape",
            numbers(0.0, 1e6),
            |technique| matches!(technique.filter, ShadowFilter::Pcss)
        ),
        parameter!(samples, "samples of a region", whole(4, 64), |technique| matches!(
            technique.filter,
            ShadowFilter::Pcss | ShadowFilter::Pcf
        )),
        parameter!(blur, "how the map is blurred", Range::Words(super::BlurKind::WORDS), has_moments),
        parameter!(exponent, "exponent of the warp", numbers(1.0, 87.0), |technique| matches!(
            technique.filter,
            ShadowFilter::Esm | ShadowFilter::Evsm2 | ShadowFilter::Evsm4
        )),
        parameter!(centred, "the warp is of depth − 1/2", Range::Switch, |technique| matches!(
            technique.filter,
            ShadowFilter::Evsm2 | ShadowFilter::Evsm4
        )),
        parameter!(
            min_variance,
            "smallest variance, in squared depths from 0 to 1",
            numbers(1e-9, 1e-2),
            |technique| has_moments(technique) && !matches!(technique.filter, ShadowFilter::Esm)
        ),
        parameter!(bleed_reduction, "light up to this share is none", numbers(0.0, 0.99), has_moments),
        parameter!(metric, "what depth means in the map", Range::Words(super::DepthMetric::WORDS), |technique| {
            has_moments(technique) && matches!(technique.layout, ShadowLayout::One)
        }),
        parameter!(cascades, "how many cascades", whole(1, 4), cascades),
        parameter!(split, "where cascades end: equal steps (0) to equal ratios (1)", numbers(0.0, 1.0), cascades),
        parameter!(blend, "share of a cascade in which it fades into the next", numbers(0.0, 0.5), cascades),
    ];

    /// Whether a technique has it.
    pub fn belongs_to(&self, technique: ShadowTechnique) -> bool {
        (self.belongs)(technique)
    }

    /// The parameter of a technique with this name.
    ///
    /// # Errors
    /// A sentence that says which there are.
    pub fn named(technique: ShadowTechnique, key: &str) -> Result<&'static Self, String> {
        let own = || Self::ALL.iter().filter(|parameter| parameter.belongs_to(technique));
        own().find(|parameter| parameter.key == key).ok_or_else(|| {
            let keys: Vec<&str> = own().map(|parameter| parameter.key).collect();
            format!("{technique} has no parameter `{key}`; it has {}", keys.join(", "))
        })
    }

    /// The values that it may have beside the others of these settings.
    pub fn range_in(&self, settings: &ShadowSettings) -> Range {
        match (self.range, self.most(settings)) {
            (Range::Numbers { from, whole, .. }, Some(to)) => Range::Numbers { from, to, whole },
            (range, _) => range,
        }
    }

    /// Its value as text.
    pub fn get(&self, settings: &ShadowSettings) -> String {
        (self.get)(settings)
    }

    /// Sets it from text.
    ///
    /// # Errors
    /// The text is no value that it may have; nothing is changed then.
    pub fn set(&self, settings: &mut ShadowSettings, text: &str) -> Result<(), ParameterError> {
        let range = self.range_in(settings);
        let allowed = match range {
            Range::Numbers { from, to, .. } => text.parse::<f32>().is_ok_and(|value| value >= from && value <= to),
            Range::Switch => true,
            Range::Words(words) => words.contains(&text),
        };
        allowed.then(|| (self.set)(settings, text)).flatten().ok_or_else(|| ParameterError {
            key: self.key,
            value: text.to_owned(),
            range: range.to_string(),
        })
    }

    /// A bound that depends on other parameters: running sums cost the same for any radius.
    fn most(&self, settings: &ShadowSettings) -> Option<f32> {
        let running = self.key == "radius"
            && settings.technique.filter.has_moments()
            && settings.blur == super::BlurKind::Running;
        running.then_some(64.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_read_back_what_they_print() {
        for technique in ShadowTechnique::all() {
            let usual = ShadowSettings::new(technique);
            usual.check().unwrap();
            assert_eq!(usual.to_string(), technique.to_string());
            assert_eq!(technique.to_string().parse(), Ok(usual));
            for parameter in usual.parameters() {
                let other = match parameter.range {
                    Range::Numbers { from, whole: true, .. } => from.to_string(),
                    Range::Numbers { from, to, .. } if to.is_finite() => (from + 0.25 * (to - from)).to_string(),
                    Range::Numbers { .. } => "0.125".into(),
                    Range::Switch => (parameter.get(&usual) == "false").to_string(),
                    Range::Words(words) => words[words.len() - 1].into(),
                };
                let mut changed = usual;
                parameter.set(&mut changed, &other).unwrap();
                assert_eq!(parameter.get(&changed), other);
                if changed.check().is_ok() {
                    assert_eq!(changed.to_string().parse(), Ok(changed), "{changed}");
                }
            }
        }
    }

    #[test]
    fn another_technique_keeps_what_both_have() {
        let with = |text: &str, technique: &str| {
            let settings: ShadowSettings = text.parse().unwrap();
            settings.with_technique(technique.parse().unwrap()).to_string()
        };
        assert_eq!(with("pcf:resolution=512,radius=5,bias=0.1", "evsm4"), "evsm4:resolution=512,radius=5");
        assert_eq!(with("evsm4:radius=3", "cube-evsm4"), "cube-evsm4:radius=3");
        assert_eq!(with("esm", "evsm4"), "evsm4", "each has its own usual exponent");
        assert_eq!(with("vsm:blur=running,radius=60", "pcf"), "pcf", "no more than it may have");
    }

    #[test]
    fn what_cannot_be_is_refused_with_a_sentence() {
        let message = |text: &str| text.parse::<ShadowSettings>().unwrap_err();
        assert!(message("soft").contains("is no shadow technique; there are hard, pcf"));
        assert!(message("hard:radius=3").starts_with("hard has no parameter `radius`; it has resolution, intensity"));
        assert_eq!(message("pcf:radius=0"), "radius = 0 is out of range: a whole number from 1 to 10");
        assert_eq!(message("vsm:radius=11"), "radius = 11 is out of range: a whole number from 1 to 10");
        assert_eq!(message("vsm:blur=running,radius=65"), "radius = 65 is out of range: a whole number from 1 to 64");
        assert_eq!(message("vsm:bleed_reduction=1"), "bleed_reduction = 1 is out of range: a number from 0 to 0.99");
        assert_eq!(
            message("vsm:min_variance=0"),
            "min_variance = 0 is out of range: a number from 0.000000001 to 0.01"
        );
        assert_eq!(message("hard:bits=12"), "bits = 12 is out of range: one of 8, 16, 24, 32");
        assert!(message("esm:exponent=NaN").contains("out of range"));
        assert!(message("evsm4:exponent=45,centred=false").contains("at most 43 for evsm4 without `centred`"));
        assert!(message("pcf:radius").contains("not of the form key=value"));
        assert!("evsm4:exponent=45".parse::<ShadowSettings>().is_ok());
        let wide: ShadowSettings = "vsm:radius=20,blur=running".parse().unwrap();
        assert_eq!(wide.to_string().parse(), Ok(wide));
    }
}
