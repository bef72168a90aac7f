//! Which shader a mesh subset needs.

use super::assemble::Features;
use crate::shadows::ShadowSet;

/// Where shading normals come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum NormalSource {
    Vertex,
    ObjectMap,
    TangentMap,
}

impl NormalSource {
    const ALL: [Self; 3] = [Self::Vertex, Self::ObjectMap, Self::TangentMap];
}

/// What colour a surface has before its texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Surface {
    /// Phong reflection of lights. `falloff`: some weaken with distance.
    Lit { normal: NormalSource, specular: bool, falloff: bool },
    /// The light of an environment instead of lights.
    Environment { normal: NormalSource, specular: bool },
    /// Light from a texture.
    LightMapped,
    /// Emission and ambient light: no light's direction matters.
    Flat,
    /// One texture layer alone.
    ShowTexture,
    /// The shading normal as a colour.
    ShowNormal(NormalSource),
    /// Texture coordinates as a colour.
    ShowUv,
    /// The factor of one shadow source.
    ShowShadow,
    /// There is nothing to show.
    ShowNothing,
}

/// Vertex colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum ColorSource {
    None,
    /// As stored.
    Stored,
    /// Decoded from sRGB.
    Decoded,
}

/// What becomes of alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct AlphaMode {
    /// Fragments below the cutoff are discarded.
    pub test: bool,
    /// The rest blends.
    pub blend: bool,
}

impl AlphaMode {
    pub(crate) const OPAQUE: Self = Self { test: false, blend: false };
}

/// The features of the shader for one mesh subset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Variant {
    pub surface: Surface,
    pub diffuse_map: bool,
    pub color: ColorSource,
    pub alpha: AlphaMode,
    /// Sources that darken it.
    pub shadows: ShadowSet,
    /// A displacement map is drawn by parallax.
    pub relief: bool,
}

impl Variant {
    /// A variant that shows stored values: opaque, without vertex colours.
    pub(crate) fn show(surface: Surface) -> Self {
        Self {
            surface,
            diffuse_map: false,
            color: ColorSource::None,
            alpha: AlphaMode::OPAQUE,
            shadows: ShadowSet::NONE,
            relief: false,
        }
    }

    /// Every legal variant, in a fixed order; of shadows those sets that cover all text, and of relief what it is added to.
    pub(crate) fn all() -> Vec<Self> {
        let mut surfaces = vec![Surface::LightMapped, Surface::Flat];
        for normal in NormalSource::ALL {
            for specular in [false, true] {
                surfaces.extend([false, true].map(|falloff| Surface::Lit { normal, specular, falloff }));
            }
            surfaces.extend([false, true].map(|specular| Surface::Environment { normal, specular }));
        }
        let mut variants = Vec::new();
        for surface in surfaces {
            let relief = [false, true].map(|diffuse_map| Self { diffuse_map, relief: true, ..Self::show(surface) });
            variants.extend(relief.into_iter().filter(Self::shows_relief));
            for diffuse_map in [false, true] {
                for color in [ColorSource::None, ColorSource::Stored, ColorSource::Decoded] {
                    for (test, blend) in [(false, false), (false, true), (true, false), (true, true)] {
                        let alpha = AlphaMode { test, blend };
                        let plain = Self::show(surface);
                        variants.push(Self { diffuse_map, color, alpha, ..plain });
                    }
                }
            }
        }
        let shown = [Surface::ShowTexture, Surface::ShowUv, Surface::ShowNothing];
        variants.extend(shown.into_iter().chain(NormalSource::ALL.map(Surface::ShowNormal)).map(Self::show));
        let lit = Surface::Lit { normal: NormalSource::Vertex, specular: true, falloff: false };
        for shadows in ShadowSet::samples() {
            variants.extend([lit, Surface::ShowShadow].map(|surface| Self { shadows, ..Self::show(surface) }));
        }
        variants
    }

    /// A displacement map makes a difference by parallax: to normals or to where textures are.
    pub(crate) fn shows_relief(&self) -> bool {
        match self.surface {
            Surface::Lit { .. } | Surface::Environment { .. } | Surface::LightMapped => true,
            _ => self.diffuse_map,
        }
    }

    fn normal(&self) -> Option<NormalSource> {
        match self.surface {
            Surface::Lit { normal, .. } | Surface::Environment { normal, .. } | Surface::ShowNormal(normal) => {
                Some(normal)
            }
            _ => None,
        }
    }

    /// True where what is drawn is light, not a stored value.
    pub(crate) fn is_shaded(&self) -> bool {
        use Surface::{Environment, Flat, LightMapped, Lit};
        matches!(self.surface, Lit { .. } | Environment { .. } | LightMapped | Flat)
    }

    /// Reads vertex normals.
    pub(crate) fn vertex_normals(&self) -> bool {
        matches!(self.normal(), Some(NormalSource::Vertex | NormalSource::TangentMap))
    }

    /// Reads tangents.
    pub(crate) fn tangents(&self) -> bool {
        self.normal() == Some(NormalSource::TangentMap)
    }

    /// Reads vertex colours.
    pub(crate) fn vertex_colors(&self) -> bool {
        self.color != ColorSource::None
    }

    /// Reads the matrix of normals.
    pub(crate) fn node_normals(&self) -> bool {
        self.normal().is_some()
    }

    /// Samples the first texture: the diffuse one, or the one shown alone.
    pub(crate) fn base_map(&self) -> bool {
        self.diffuse_map || self.surface == Surface::ShowTexture
    }

    /// Reads the first texture coordinates.
    pub(crate) fn base_uv(&self) -> bool {
        self.base_map() || self.surface == Surface::ShowUv
    }

    /// Samples the second texture: light map or normal map.
    pub(crate) fn second_map(&self) -> bool {
        self.surface == Surface::LightMapped
            || matches!(self.normal(), Some(NormalSource::ObjectMap | NormalSource::TangentMap))
    }

    /// The value of every feature that the shader's files ask for.
    pub(crate) fn features(&self) -> Features {
        let (specular, falloff) = match self.surface {
            Surface::Lit { specular, falloff, .. } => (specular, falloff),
            Surface::Environment { specular, .. } => (specular, false),
            _ => (false, false),
        };
        vec![
            ("LIT", matches!(self.surface, Surface::Lit { .. })),
            ("ENVIRONMENT", matches!(self.surface, Surface::Environment { .. })),
            ("SHADED", self.is_shaded()),
            ("LIGHT_MAPPED", self.surface == Surface::LightMapped),
            ("FLAT", self.surface == Surface::Flat),
            ("SHOW_NORMAL", matches!(self.surface, Surface::ShowNormal(_))),
            ("SHOW_UV", self.surface == Surface::ShowUv),
            ("SHOW_NOTHING", self.surface == Surface::ShowNothing),
            ("SHOW_SHADOW", self.surface == Surface::ShowShadow),
            (
                "POSITION",
                self.relief
                    || matches!(self.surface, Surface::Lit { .. } | Surface::Environment { .. } | Surface::ShowShadow),
            ),
            ("SHADOWS", !self.shadows.is_empty()),
            ("RECEIVERS", self.shadows.masked),
            ("FILTERABLE", self.shadows.filterable),
            ("SHADING_NORMAL", self.normal().is_some()),
            ("NODE_NORMALS", self.node_normals()),
            ("VERTEX_NORMALS", self.vertex_normals()),
            ("NORMAL_MAP", self.normal().is_some() && self.second_map()),
            ("TANGENTS", self.tangents()),
            ("VERTEX_COLORS", self.vertex_colors()),
            ("DECODE_COLORS", self.color == ColorSource::Decoded),
            ("BASE_MAP", self.base_map()),
            ("BASE_UV", self.base_uv()),
            ("SECOND_MAP", self.second_map()),
            ("RELIEF", self.relief),
            ("SPECULAR", specular),
            ("FALLOFF", falloff),
            ("ALPHA_TEST", self.alpha.test),
            ("BLEND", self.alpha.blend),
        ]
    }
}
