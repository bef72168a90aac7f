//! How a source's shadow is computed.

use std::fmt;
use std::str::FromStr;

use super::ShadowParameter;

/// How a source's shadow is computed. As text, `evsm4:resolution=512,radius=5`: a [technique](ShadowTechnique), then
/// what differs from [`ShadowSettings::new`]. [`ShadowParameter`] says what each parameter means and which techniques
/// have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowSettings {
    /// Maps and what is done with them.
    pub technique: ShadowTechnique,
    /// Texels along each side of a map.
    pub resolution: u32,
    /// How much of a light a full shadow takes away, 0 to 1.
    pub intensity: f32,
    /// Bits of a stored depth: 8, 16, 24 or 32 (floating point).
    pub bits: u32,
    /// Distance in metres by which receivers are moved towards the source before they are compared.
    pub bias: f32,
    /// The same, in units of what a plane of the receiver's slope needs at this texel and kernel size to be free of acne.
    pub slope_bias: f32,
    /// The most that both biases are together, in metres.
    pub max_bias: f32,
    /// Distance by which receivers are moved along their normal, in texels times the sine of the angle of incidence.
    pub normal_offset: f32,
    /// Each sample of a kernel is compared with the receiver's plane, continued to there.
    pub receiver_plane: bool,
    /// Which faces of casters are in the map.
    pub faces: CasterFaces,
    /// Weights of percentage-closer filtering.
    pub kernel: PcfKernel,
    /// Texels from the middle of a kernel to its edge: `2·radius + 1` texels are averaged.
    pub radius: u32,
    /// Side or diameter of the light in metres, for penumbras that grow; 0 takes it from the light's shape.
    pub light_size: f32,
    /// Samples of a search or filter region.
    pub samples: u32,
    /// How a map is blurred.
    pub blur: BlurKind,
    /// Exponent of the warp of depths in `[0, 1]`.
    pub exponent: f32,
    /// The warp is of depth − 1/2, which leaves the numbers twice their range.
    pub centred: bool,
    /// Smallest variance, in squared depths in `[0, 1]`.
    pub min_variance: f32,
    /// Light up to this share is none.
    pub bleed_reduction: f32,
    /// What depth means in a map of moments.
    pub metric: DepthMetric,
    /// How many cascades.
    pub cascades: u32,
    /// Where cascades end: from 0, in equal steps, to 1, in steps of equal ratio.
    pub split: f32,
    /// The share of a cascade's depth in which it fades into the next.
    pub blend: f32,
}

/// How maps are laid out, and what is made of them. As text the filter's name after `csm-` for cascades and `cube-` for
/// cubes: `hard`, `csm-pcf`, `cube-evsm4`. `volume` has no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ShadowTechnique {
    /// How many maps there are, and what they see.
    pub layout: ShadowLayout,
    /// What is made of them.
    pub filter: ShadowFilter,
}

macro_rules! words {
    ($(#[$meta:meta])* $name:ident { $($(#[doc = $doc:literal])* $variant:ident = $word:literal),* $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $name { $($(#[doc = $doc])* $variant),* }

        impl $name {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Its word in files, flags and charts.
            pub const fn word(self) -> &'static str {
                match self { $(Self::$variant => $word),* }
            }

            /// Their words.
            pub const WORDS: &'static [&'static str] = &[$($word),*];

            /// What it means, in a sentence or two.
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$variant => concat!($($doc),*).trim_ascii()),* }
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.word())
            }
        }

        impl FromStr for $name {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                Self::ALL.iter().copied().find(|value| value.word() == text).ok_or_else(|| {
                    format!("`{text}` is none of {}", Self::WORDS.join(", "))
                })
            }
        }
    };
}

words! {
    /// How many maps there are, and what they see.
    ShadowLayout {
        /// One, through a square window.
        One = "one",
        /// Several, each for a range of distances from the camera. For directional lights.
        Cascades = "csm",
        /// Six, to all sides. For point lights.
        Cube = "cube",
    }
}

words! {
    /// What is made of maps.
    ShadowFilter {
        /// Nearest texel: lit or not (Williams 1978).
        Hard = "hard",
        /// Percentage-closer filtering: the mean of comparisons (Reeves, Salesin, Cook 1987).
        Pcf = "pcf",
        /// Percentage-closer soft shadows: the kernel grows with the distance from the blocker (Fernando 2005).
        Pcss = "pcss",
        /// Variance shadow maps: two moments of depth (Donnelly, Lauritzen 2006).
        Vsm = "vsm",
        /// Exponential shadow maps (Annen et al. 2008).
        Esm = "esm",
        /// Exponential variance shadow maps, positive warp only (Lauritzen, McCool 2008).
        Evsm2 = "evsm2",
        /// Exponential variance shadow maps, both warps.
        Evsm4 = "evsm4",
        /// Moment shadow maps: four moments of depth (Peters, Klein 2015).
        Msm = "msm",
        /// Shadow volumes, counted behind the visible surface (Bilodeau, Songy 1999; Carmack 2000). No map.
        Volume = "volume",
    }
}

words! {
    /// Which faces of casters are in a map.
    CasterFaces {
        /// All.
        Both = "both",
        /// Those that face the source.
        Front = "front",
        /// Those that face away: lit sides need no bias, but open meshes lose their shadow.
        Back = "back",
    }
}

words! {
    /// Weights of percentage-closer filtering.
    PcfKernel {
        /// Equal.
        Box = "box",
        /// Equal, with the first and last row and column shared between neighbours: no bands.
        Tent = "tent",
        /// Gaussian with a standard deviation of a third of the radius.
        Gaussian = "gaussian",
        /// A disc of scattered samples, turned in each pixel: noise instead of bands.
        Poisson = "poisson",
    }
}

words! {
    /// How a map is blurred.
    BlurKind {
        /// Gaussian with a standard deviation of a third of the radius, in two passes of `2·radius + 1` samples.
        Gaussian = "gaussian",
        /// Two means of equal weights with about the Gaussian's variance, by running sums: the cost does not grow with the
        /// radius.
        Running = "running",
    }
}

words! {
    /// What depth means in a map of moments.
    DepthMetric {
        /// The distance where the volume is a pyramid, the depth where it is a box.
        Auto = "auto",
        /// Distance from the source.
        Radial = "radial",
        /// Depth along the source's axis.
        Planar = "planar",
    }
}

impl ShadowFilter {
    /// Compares depths of single texels, which needs a bias.
    pub const fn compares(self) -> bool {
        matches!(self, Self::Hard | Self::Pcf | Self::Pcss)
    }

    /// Keeps moments of depth, which can be blurred.
    pub const fn has_moments(self) -> bool {
        matches!(self, Self::Vsm | Self::Esm | Self::Evsm2 | Self::Evsm4 | Self::Msm)
    }

    /// Channels of its map, each of 32 bits; 0 where the map is a depth buffer or none.
    pub const fn channels(self) -> u32 {
        match self {
            Self::Esm => 1,
            Self::Vsm | Self::Evsm2 => 2,
            Self::Evsm4 | Self::Msm => 4,
            Self::Hard | Self::Pcf | Self::Pcss | Self::Volume => 0,
        }
    }
}

impl ShadowTechnique {
    /// One map.
    pub const fn one(filter: ShadowFilter) -> Self {
        Self { layout: ShadowLayout::One, filter }
    }

    /// Every technique there is.
    pub fn all() -> Vec<Self> {
        let mapped = ShadowLayout::ALL.iter().flat_map(|&layout| {
            ShadowFilter::ALL.iter().map(move |&filter| Self { layout, filter }).filter(|technique| technique.exists())
        });
        mapped.collect()
    }

    /// Only maps can be laid out; a growing kernel is offered for single maps alone.
    pub const fn exists(self) -> bool {
        matches!(self.layout, ShadowLayout::One) || !matches!(self.filter, ShadowFilter::Volume | ShadowFilter::Pcss)
    }
}

impl fmt::Display for ShadowTechnique {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.layout {
            ShadowLayout::One => write!(f, "{}", self.filter),
            layout => write!(f, "{layout}-{}", self.filter),
        }
    }
}

impl FromStr for ShadowTechnique {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = Self::all();
        all.iter().copied().find(|technique| technique.to_string() == text).ok_or_else(|| {
            let names: Vec<String> = all.iter().map(Self::to_string).collect();
            format!("`{text}` is no shadow technique; there are {}", names.join(", "))
        })
    }
}

impl Default for ShadowSettings {
    /// Percentage-closer filtering with one map.
    fn default() -> Self {
        Self::new(ShadowTechnique::one(ShadowFilter::Pcf))
    }
}

impl ShadowSettings {
    /// A technique with its usual parameters.
    pub const fn new(technique: ShadowTechnique) -> Self {
        let exponential = matches!(technique.filter, ShadowFilter::Esm);
        let moments = matches!(technique.filter, ShadowFilter::Msm);
        Self {
            technique,
            resolution: 1024,
            intensity: 1.0,
            bits: 32,
            bias: 0.0,
            slope_bias: 1.1,
            max_bias: f32::INFINITY,
            normal_offset: 0.0,
            receiver_plane: false,
            faces: CasterFaces::Both,
            kernel: PcfKernel::Tent,
            radius: 2,
            light_size: 0.0,
            samples: 32,
            blur: BlurKind::Gaussian,
            exponent: if exponential { 80.0 } else { 40.0 },
            centred: true,
            min_variance: if moments { 1e-5 } else { 1e-6 },
            bleed_reduction: 0.0,
            metric: DepthMetric::Auto,
            cascades: 4,
            split: 0.7,
            blend: 0.1,
        }
    }

    /// Another technique with the parameters that both have; the rest as usual.
    #[must_use]
    pub fn with_technique(&self, technique: ShadowTechnique) -> Self {
        let mut settings = Self::new(technique);
        for parameter in self.parameters().filter(|parameter| parameter.belongs_to(technique)) {
            // What is usual for one filter need not be for another, and what one may have another may not.
            if parameter.get(self) != parameter.get(&Self::new(self.technique)) {
                let _ = parameter.set(&mut settings, &parameter.get(self));
            }
        }
        if settings.check().is_ok() { settings } else { Self::new(technique) }
    }

    /// The parameters that its technique has.
    pub fn parameters(&self) -> impl Iterator<Item = &'static ShadowParameter> {
        let technique = self.technique;
        ShadowParameter::ALL.iter().filter(move |parameter| parameter.belongs_to(technique))
    }

    /// Whether every parameter that its technique has is in its range.
    ///
    /// # Errors
    /// A sentence about the first that is not.
    pub fn check(&self) -> Result<(), String> {
        let mut copy = *self;
        for parameter in self.parameters() {
            parameter.set(&mut copy, &parameter.get(self)).map_err(|error| error.to_string())?;
        }
        self.check_together()
    }

    /// What parameters forbid each other.
    pub(super) fn check_together(&self) -> Result<(), String> {
        use ShadowFilter::{Esm, Evsm2, Evsm4};
        let filter = self.technique.filter;
        // The square of the warp has to fit in an f32, and its smallest variance must not vanish (section 4 of the
        // shadow page).
        let most = match (filter, self.centred) {
            (Esm, _) => 87.0,
            (Evsm2 | Evsm4, true) => 87.0,
            (Evsm2 | Evsm4, false) => 43.0,
            _ => f32::INFINITY,
        };
        if self.exponent > most {
            return Err(format!(
                "exponent = {} leaves the range of 32-bit floats; at most {most} for {}{}",
                self.exponent,
                self.technique,
                if filter == Esm || self.centred { "" } else { " without `centred`" }
            ));
        }
        // Below, roundings of four moments are larger than what they differ by.
        if filter == ShadowFilter::Msm && self.min_variance < 1e-5 {
            return Err(format!(
                "min_variance = {} is too small for four moments of 32 bits; at least 0.00001 for {}",
                self.min_variance, self.technique
            ));
        }
        Ok(())
    }
}

impl fmt::Display for ShadowSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.technique)?;
        let usual = Self::new(self.technique);
        let mut separator = ':';
        for parameter in self.parameters() {
            let value = parameter.get(self);
            if value != parameter.get(&usual) {
                write!(f, "{separator}{}={value}", parameter.key)?;
                separator = ',';
            }
        }
        Ok(())
    }
}

impl FromStr for ShadowSettings {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (technique, rest) = text.split_once(':').unwrap_or((text, ""));
        let mut settings = Self::new(technique.trim().parse()?);
        let pairs = rest.split(',').filter(|pair| !pair.trim().is_empty());
        let mut pairs: Vec<(&str, &str)> = pairs
            .map(|pair| pair.split_once('=').ok_or_else(|| format!("`{pair}` is not of the form key=value")))
            .collect::<Result<_, _>>()?;
        // How wide a kernel may be depends on how it is blurred.
        pairs.sort_by_key(|(key, _)| key.trim() == "radius");
        for (key, value) in pairs {
            let parameter = ShadowParameter::named(settings.technique, key.trim())?;
            parameter.set(&mut settings, value.trim()).map_err(|error| error.to_string())?;
        }
        settings.check_together()?;
        Ok(settings)
    }
}
