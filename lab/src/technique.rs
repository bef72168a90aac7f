//! What a technique tells the lab.

use aam_reference::Options;
use aam_renderer::RenderOptions;
use aam_scene::{Scene, View};

/// A technique with parameters, to be measured against the reference.
///
/// Each lives in a module of its own in `techniques/` and stands in the list of [`techniques`](crate::techniques()).
pub trait Technique {
    /// A short name for files and commands, such as `antialiasing`.
    fn name(&self) -> &'static str;

    /// What its chart shows, in a sentence without a full stop.
    fn title(&self) -> &'static str;

    /// The parameter sets to try, each with the renderer's options for it.
    fn variants(&self) -> Vec<Variant>;

    /// What the truth is drawn with.
    fn truth(&self) -> Options<'static>;

    /// Where a parameter set can be trusted.
    fn limits(&self, variant: &Variant, scene: &Scene, view: &View) -> Limits;
}

/// One choice of a technique's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Parameters and values in a few characters, such as `MSAA 4`.
    pub label: String,
    /// The renderer's options.
    pub options: RenderOptions,
}

/// Whether a technique does what it promises.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Limits {
    /// It does.
    Holds,
    /// It draws, with a fault.
    Degrades(String),
    /// It cannot draw this.
    Refuses(String),
}

impl Limits {
    /// In words, empty where the technique holds.
    pub fn text(&self) -> String {
        match self {
            Self::Holds => String::new(),
            Self::Degrades(why) => format!("degrades because {why}"),
            Self::Refuses(why) => format!("refuses because {why}"),
        }
    }
}
