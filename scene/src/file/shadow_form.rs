//! Shadows as TOML.

use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::SceneSyntaxError;
use super::form::{At, CameraForm, Fault, camera, camera_form, check, checked, unplaced};
use super::shadow::{LightEntry, MemberEntry, ShadowEntry, ShadowsEntry};
use crate::{Camera, ShadowCulling, ShadowSettings, Up};

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShadowsForm {
    #[serde(skip_serializing_if = "Option::is_none")]
    casters: Option<Vec<MemberForm>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    receivers: Option<Vec<MemberForm>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cull_back_faces: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cull_casters: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cull_sources: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    displaced: Option<bool>,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "expected an object's name, or { name = \"…\", occurrence = 2 }")]
enum MemberForm {
    All(String),
    One(OccurrenceForm),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OccurrenceForm {
    name: String,
    occurrence: usize,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShadowForm {
    #[serde(default, skip_serializing_if = "String::is_empty")]
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    enabled: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    light: Option<LightNameForm>,
    #[serde(skip_serializing_if = "Option::is_none")]
    technique: Option<Spanned<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    volume: Option<Spanned<CameraForm>>,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a light's name, or its number from 1")]
enum LightNameForm {
    Named(String),
    Numbered(usize),
}

// ---- reading ----------------------------------------------------------------------------------------------------

pub(super) fn read(
    shadows: Option<Spanned<ShadowsForm>>,
    sources: Vec<Spanned<ShadowForm>>,
    up: Up,
    at: &At<'_>,
) -> Result<Option<ShadowsEntry>, SceneSyntaxError> {
    if shadows.is_none() && sources.is_empty() {
        return Ok(None);
    }
    let mut entry = shadows.map(|form| check(form, at, "shadows", shadows_entry)).transpose()?.unwrap_or_default();
    entry.sources = checked(sources, at, "shadow", |form| source(form, up, at))?;
    Ok(Some(entry))
}

fn shadows_entry(form: ShadowsForm) -> Result<ShadowsEntry, String> {
    let member = |form| match form {
        MemberForm::All(name) => Ok(MemberEntry { name, occurrence: None }),
        MemberForm::One(OccurrenceForm { occurrence: 0, .. }) => Err("`occurrence` counts from 1".to_owned()),
        MemberForm::One(OccurrenceForm { name, occurrence }) => Ok(MemberEntry { name, occurrence: Some(occurrence) }),
    };
    let members = |forms: Option<Vec<MemberForm>>| {
        forms.map(|forms| forms.into_iter().map(member).collect::<Result<Vec<_>, _>>()).transpose()
    };
    let usual = ShadowCulling::default();
    Ok(ShadowsEntry {
        sources: Vec::new(),
        casters: members(form.casters)?,
        receivers: members(form.receivers)?,
        culling: ShadowCulling {
            back_faces: form.cull_back_faces.unwrap_or(usual.back_faces),
            casters: form.cull_casters.unwrap_or(usual.casters),
            sources: form.cull_sources.unwrap_or(usual.sources),
        },
        displaced: form.displaced.unwrap_or(false),
    })
}

fn source(form: ShadowForm, up: Up, at: &At<'_>) -> Result<ShadowEntry, Fault> {
    let ShadowForm { name, enabled, light, technique, volume } = form;
    let settings = match technique {
        None => ShadowSettings::default(),
        Some(text) => check(text, at, "[shadow]", |text| text.parse::<ShadowSettings>()).map_err(Fault::Placed)?,
    };
    let light = match light {
        Some(LightNameForm::Numbered(0)) => return Err(Fault::Key("a light's number counts from 1".to_owned())),
        Some(LightNameForm::Numbered(number)) => Some(LightEntry::Numbered(number)),
        Some(LightNameForm::Named(name)) => Some(LightEntry::Named(name)),
        None => None,
    };
    let volume = volume.map(|form| check(form, at, "[shadow.volume]", |form| self::volume(form, up))).transpose();
    let volume = volume.map_err(Fault::Placed)?;
    if light.is_none() && volume.is_none() {
        return Err(Fault::Key("a `light` or a `volume` is needed, or both".to_owned()));
    }
    Ok(ShadowEntry { name, enabled: enabled.unwrap_or(true), light, settings, volume })
}

fn volume(form: CameraForm, up: Up) -> Result<Camera, String> {
    if !form.name.is_empty() {
        return Err("a volume has no `name`; its shadow has".to_owned());
    }
    if form.near.is_none() || form.far.is_none() {
        return Err("`near` and `far` are needed".to_owned());
    }
    camera(form, up)
}

// ---- writing ----------------------------------------------------------------------------------------------------

/// The table and the sources; the table only where it says something.
pub(super) fn write(entry: &ShadowsEntry) -> (Option<ShadowsForm>, Vec<ShadowForm>) {
    let unless = |value: bool, usual: bool| (value != usual).then_some(value);
    let member = |member: &MemberEntry| match member.occurrence {
        None => MemberForm::All(member.name.clone()),
        Some(occurrence) => MemberForm::One(OccurrenceForm { name: member.name.clone(), occurrence }),
    };
    let members = |members: &Option<Vec<MemberEntry>>| members.as_ref().map(|list| list.iter().map(member).collect());
    let usual = ShadowCulling::default();
    let form = ShadowsForm {
        casters: members(&entry.casters),
        receivers: members(&entry.receivers),
        cull_back_faces: unless(entry.culling.back_faces, usual.back_faces),
        cull_casters: unless(entry.culling.casters, usual.casters),
        cull_sources: unless(entry.culling.sources, usual.sources),
        displaced: unless(entry.displaced, false),
    };
    let says_nothing = *entry == ShadowsEntry { sources: entry.sources.clone(), ..ShadowsEntry::default() };
    let table = (!says_nothing || entry.sources.is_empty()).then_some(form);
    (table, entry.sources.iter().map(shadow_form).collect())
}

fn shadow_form(source: &ShadowEntry) -> ShadowForm {
    ShadowForm {
        name: source.name.clone(),
        enabled: (!source.enabled).then_some(false),
        light: source.light.clone().map(|light| match light {
            LightEntry::Named(name) => LightNameForm::Named(name),
            LightEntry::Numbered(number) => LightNameForm::Numbered(number),
        }),
        technique: Some(unplaced(source.settings.to_string())),
        volume: source.volume.as_ref().map(|volume| unplaced(camera_form(volume))),
    }
}
