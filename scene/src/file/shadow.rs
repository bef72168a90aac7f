//! Shadows in a scene file: by name there, by number in a scene.

use std::collections::BTreeMap;

use aam::{Finding, nearest};

use super::assemble::warning;
use crate::{Camera, Light, Members, Node, NodeId, Scene, ShadowCulling, ShadowSettings, ShadowSource, Shadows};

/// Names that a warning lists at most.
const LISTED: usize = 12;

/// Who casts and receives shadows, and where they come from: `[shadows]` and all `[[shadow]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowsEntry {
    /// Where shadows come from.
    pub sources: Vec<ShadowEntry>,
    /// What casts; `None` means everything.
    pub casters: Option<Vec<MemberEntry>>,
    /// What is darkened; `None` means everything.
    pub receivers: Option<Vec<MemberEntry>>,
    /// What may be left out of maps.
    pub culling: ShadowCulling,
    /// Displaced surfaces cast as they are drawn.
    pub displaced: bool,
}

/// Objects of one name, with all below them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemberEntry {
    /// The name of an asset or of a node.
    pub name: String,
    /// Which of several objects with this name, from 1, in the order of the scene's node list; `None` means all.
    pub occurrence: Option<usize>,
}

/// Where a shadow comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowEntry {
    /// Name.
    pub name: String,
    /// False: it costs nothing and casts nothing.
    pub enabled: bool,
    /// The light that it darkens; `None` darkens all.
    pub light: Option<LightEntry>,
    /// How it is computed.
    pub settings: ShadowSettings,
    /// What it sees; `None` fits it.
    pub volume: Option<Camera>,
}

/// A light of the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LightEntry {
    /// The first of this name.
    Named(String),
    /// By its place in the list, from 1.
    Numbered(usize),
}

impl ShadowsEntry {
    /// Finds what is meant; what is not there is left out and warned of.
    pub(super) fn resolve(&self, scene: &Scene, warnings: &mut Vec<Finding>) -> Shadows {
        let mut places: BTreeMap<&str, Vec<NodeId>> = BTreeMap::new();
        for (id, node) in (0..).map(NodeId).zip(&scene.nodes) {
            places.entry(&node.name).or_default().push(id);
        }
        let mut members = |key: &str, entries: &Option<Vec<MemberEntry>>| {
            let Some(entries) = entries else { return Members::All };
            let mut ids = Vec::new();
            for entry in entries {
                match (places.get(entry.name.as_str()), entry.occurrence) {
                    (None, _) => warnings.push(warning(
                        "scene/shadow",
                        format!("{key} of [shadows]"),
                        format!("there is no object \"{}\"; {}", entry.name, there_are(&entry.name, places.keys())),
                    )),
                    (Some(found), None) => ids.extend(found),
                    (Some(found), Some(number)) => match number.checked_sub(1).and_then(|at| found.get(at)) {
                        Some(&id) => ids.push(id),
                        None => warnings.push(warning(
                            "scene/shadow",
                            format!("{key} of [shadows]"),
                            format!("there are only {} objects \"{}\", no number {number}", found.len(), entry.name),
                        )),
                    },
                }
            }
            ids.sort_unstable();
            ids.dedup();
            Members::Only(ids)
        };
        let casters = members("casters", &self.casters);
        let receivers = members("receivers", &self.receivers);
        let sources = self.sources.iter().enumerate().filter_map(|(index, source)| {
            let light = match &source.light {
                None => None,
                Some(entry) => match entry.find(&scene.lights) {
                    Ok(light) => Some(light),
                    Err(reason) => {
                        let name = if source.name.is_empty() {
                            (index + 1).to_string()
                        } else {
                            format!("\"{}\"", source.name)
                        };
                        let message = format!("{reason}; the shadow is left out");
                        warnings.push(warning("scene/shadow", format!("shadow {name}"), message));
                        return None;
                    }
                },
            };
            let ShadowEntry { name, enabled, settings, volume, .. } = source.clone();
            Some(ShadowSource { name, enabled, light, volume, settings })
        });
        Shadows { sources: sources.collect(), casters, receivers, culling: self.culling, displaced: self.displaced }
    }

    /// The entry from which a scene's shadows come back.
    pub fn of(scene: &Scene) -> Option<Self> {
        let shadows = scene.shadows.as_ref()?;
        let source = |source: &ShadowSource| ShadowEntry {
            name: source.name.clone(),
            enabled: source.enabled,
            light: source.light.map(|light| LightEntry::of(light, &scene.lights)),
            settings: source.settings,
            volume: source.volume.clone().map(|volume| Camera { name: String::new(), ..volume }),
        };
        Some(Self {
            sources: shadows.sources.iter().map(source).collect(),
            casters: entries(&shadows.casters, &scene.nodes),
            receivers: entries(&shadows.receivers, &scene.nodes),
            culling: shadows.culling,
            displaced: shadows.displaced,
        })
    }
}

impl LightEntry {
    fn find(&self, lights: &[Light]) -> Result<usize, String> {
        let names = || lights.iter().map(|light| &light.name).filter(|name| !name.is_empty());
        match self {
            Self::Named(name) => lights
                .iter()
                .position(|light| light.name == *name)
                .ok_or_else(|| format!("there is no light \"{name}\"; {}", there_are(name, names()))),
            Self::Numbered(number) => number
                .checked_sub(1)
                .filter(|&index| index < lights.len())
                .ok_or_else(|| format!("there is no light number {number}; there are {}", lights.len())),
        }
    }

    /// By name where the name finds it.
    fn of(light: usize, lights: &[Light]) -> Self {
        let name = lights.get(light).map_or("", |light| &light.name);
        let named = Self::Named(name.to_owned());
        if !name.is_empty() && named.find(lights) == Ok(light) { named } else { Self::Numbered(light + 1) }
    }
}

/// Entries that find these nodes again: by name alone where all of that name are meant.
fn entries(members: &Members, nodes: &[Node]) -> Option<Vec<MemberEntry>> {
    let Members::Only(ids) = members else { return None };
    let mut seen: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    let mut total: BTreeMap<&str, usize> = BTreeMap::new();
    for (id, node) in (0..).map(NodeId).zip(nodes) {
        let number = total.entry(&node.name).or_default();
        *number += 1;
        if ids.contains(&id) {
            seen.entry(&node.name).or_default().push(*number);
        }
    }
    let entry = |name: &str, occurrence| MemberEntry { name: name.to_owned(), occurrence };
    let of_name = |(name, numbers): (&str, Vec<usize>)| {
        if total.get(name) == Some(&numbers.len()) {
            vec![entry(name, None)]
        } else {
            numbers.into_iter().map(|number| entry(name, Some(number))).collect()
        }
    };
    Some(seen.into_iter().flat_map(of_name).collect())
}

/// What there is instead of `wanted`.
fn there_are<S: AsRef<str>>(wanted: &str, names: impl Iterator<Item = S> + Clone) -> String {
    let all: Vec<String> = names.clone().take(LISTED).map(|name| format!("\"{}\"", name.as_ref())).collect();
    if all.is_empty() {
        return "there is none with a name".to_owned();
    }
    let rest = names.clone().count() - all.len();
    let known: Vec<S> = names.collect();
    let near = nearest(wanted.as_bytes(), known.iter().map(AsRef::as_ref));
    let meant = near.map_or_else(String::new, |name| format!(" (did you mean \"{name}\"?)"));
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    format!("there are {}{more}{meant}", all.join(", "))
}
