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

    /// What can be set.
    fn parameters(&self) -> Vec<Parameter> {
        Vec::new()
    }

    /// The parameter sets to try, each with the renderer's options for it; those that matter most stand first.
    fn variants(&self) -> Vec<Variant>;

    /// Puts a parameter set into the scene, where it is not the renderer's options that hold it.
    fn apply(&self, _variant: &Variant, _scene: &mut Scene) {}

    /// What the truth is drawn with.
    fn truth(&self) -> Options<'static>;

    /// Where a parameter set can be trusted.
    fn limits(&self, variant: &Variant, scene: &Scene, view: &View) -> Limits;
}

/// A parameter of a technique.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name in files, flags and charts.
    pub key: &'static str,
    /// What it means, in a line.
    pub meaning: &'static str,
    /// The values that it may have, in words.
    pub range: String,
}

/// One choice of a technique's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Parameters and values in a few characters, such as `MSAA 4`; no other variant of the technique has the same.
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
