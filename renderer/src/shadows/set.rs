//! Which shadow sources a frame has, as far as shaders depend on it.

use aam_scene::{PcfKernel, ShadowFilter, ShadowLayout};

/// Most shadow sources that a frame can have. Each has a map of its own.
pub const MAX_SHADOW_SOURCES: usize = 8;

/// What the shader of one source depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct SourceKind {
    pub layout: ShadowLayout,
    pub filter: ShadowFilter,
    /// For percentage-closer filtering.
    pub kernel: PcfKernel,
    /// The light in the shader's list that it darkens; `None` darkens all.
    pub light: Option<u8>,
}

/// The sources of a frame, in order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct ShadowSet {
    sources: [Option<SourceKind>; MAX_SHADOW_SOURCES],
    /// Some objects receive no shadows.
    pub masked: bool,
    /// The device filters 32-bit textures.
    pub filterable: bool,
}

impl ShadowSet {
    pub(crate) const NONE: Self = Self { sources: [None; MAX_SHADOW_SOURCES], masked: false, filterable: false };

    pub(crate) fn new(sources: impl IntoIterator<Item = SourceKind>, masked: bool, filterable: bool) -> Self {
        let mut set = Self { masked, filterable, ..Self::NONE };
        for (place, source) in set.sources.iter_mut().zip(sources) {
            *place = Some(source);
        }
        set
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.sources[0].is_none()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = SourceKind> + use<> {
        self.sources.into_iter().map_while(|source| source)
    }

    /// Sets that cover every piece of shader text: each technique alone, and all filters together.
    pub(crate) fn samples() -> Vec<Self> {
        let kind = |technique: aam_scene::ShadowTechnique, kernel, light| SourceKind {
            layout: technique.layout,
            filter: technique.filter,
            kernel,
            light,
        };
        let drawn = aam_scene::ShadowTechnique::all;
        let mut sets: Vec<Self> = drawn()
            .into_iter()
            .map(|technique| Self::new([kind(technique, PcfKernel::Tent, Some(0))], false, true))
            .collect();
        let one = |filter| aam_scene::ShadowTechnique::one(filter);
        for kernel in [PcfKernel::Box, PcfKernel::Gaussian, PcfKernel::Poisson] {
            sets.push(Self::new([kind(one(ShadowFilter::Pcf), kernel, None)], false, false));
        }
        let all = drawn().into_iter().filter(|technique| technique.layout == ShadowLayout::One);
        sets.push(Self::new(all.map(|technique| kind(technique, PcfKernel::Box, None)), true, false));
        sets
    }
}
