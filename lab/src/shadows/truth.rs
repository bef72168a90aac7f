//! What the reference says of a light's shadow.

use std::fmt;

use aam_reference::{LightSize, Options, Seen};
use aam_scene::Image;

use super::Subject;
use crate::LabError;
use crate::metrics::{PIXELS_PER_DEGREE, PenumbraError, VisibilityError, flip, penumbra_error, visibility_error};

/// What a light is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TruthKind {
    /// A point: shadows have no penumbra.
    Point,
    /// As large as the scene says.
    Area,
}

impl TruthKind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Point, Self::Area];

    /// Its word in tables.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Area => "area",
        }
    }

    const fn size(self) -> LightSize {
        match self {
            Self::Point => LightSize::Point,
            Self::Area => LightSize::Area,
        }
    }
}

impl fmt::Display for TruthKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// The visibility of a subject's light and the picture with its shadow.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// What the light is taken for.
    pub kind: TruthKind,
    /// The share of the light that each pixel sees, where it faces the light.
    pub seen: Vec<Option<Seen>>,
    /// The picture; `None` if it was not asked for.
    pub picture: Option<Image>,
}

/// How a truth is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rays {
    /// Shadow rays from each pixel to a light with a size.
    pub light_samples: u32,
    /// Samples a pixel of the picture, each with 16 shadow rays; 0 draws none.
    pub picture_samples: u32,
}

impl Truth {
    /// Traces it. Where the light has no size, both kinds are the same.
    ///
    /// # Errors
    /// The reference cannot draw the scene.
    pub fn trace(
        subject: &Subject,
        kind: TruthKind,
        rays: Rays,
        progress: Option<&(dyn Fn(f32) + Sync)>,
    ) -> Result<Self, LabError> {
        let options = Options { light_samples: rays.light_samples, progress, ..Options::default() };
        let (mut visibility, _) = aam_reference::visibility(&subject.scene, &subject.view, kind.size(), &options)?;
        let seen = visibility.lights.swap_remove(subject.light);
        let picture = if rays.picture_samples == 0 {
            None
        } else {
            let options = Options {
                samples_per_pixel: rays.picture_samples,
                shadows: Some(kind.size()),
                light_samples: 16,
                progress: None,
                ..Options::default()
            };
            Some(aam_reference::render(&subject.scene, &subject.view, &options)?.0)
        };
        Ok(Self { kind, seen, picture })
    }

    /// How far a visibility is from it.
    ///
    /// # Errors
    /// The sizes differ, or a pixel is no number.
    pub fn judge(&self, width: u32, visibility: &[f32]) -> Result<(VisibilityError, PenumbraError), LabError> {
        let error = visibility_error(&self.seen, visibility)?;
        Ok((error, penumbra_error(width as usize, &self.seen, visibility)?))
    }

    /// The mean and the 95th percentile of a picture's FLIP difference from it.
    ///
    /// # Errors
    /// The sizes differ.
    pub fn flip(&self, picture: &Image) -> Result<Option<(f64, f64)>, LabError> {
        let Some(truth) = &self.picture else { return Ok(None) };
        let map = flip(truth, picture, PIXELS_PER_DEGREE)?;
        Ok(Some((map.mean(), map.percentile(0.95).into())))
    }

    /// Of the pixels that face the light, how many are dark, in between, and lit.
    pub fn counts(&self) -> [usize; 3] {
        let mut counts = [0; 3];
        for seen in self.seen.iter().flatten() {
            counts[if seen.share <= 0.0 { 0 } else { 1 + usize::from(seen.share >= 1.0) }] += 1;
        }
        counts
    }

    /// As a visibility that a technique could give: 1 where the surface does not face the light.
    pub fn shares(&self) -> Vec<f32> {
        self.seen.iter().map(|seen| seen.map_or(1.0, |seen| seen.share)).collect()
    }
}
