//! Materials.

use crate::gltf_in::fault::Checked;
use crate::gltf_in::json::At;
use crate::gltf_in::model::{AlphaMode, Material, TextureRef, UvTransform, Workflow};

use super::{Counts, name};

/// Extensions of a material that are honoured here.
const HONOURED: [&str; 5] = [
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_ior",
];

pub(super) fn material(at: &At<'_>, counts: &Counts) -> Checked<Material> {
    let mut material = Material {
        name: name(at)?,
        alpha: alpha_mode(at)?,
        double_sided: at.flag("doubleSided")?,
        extras: at.get("extras").map(|extras| extras.to_json()),
        ..Material::default()
    };
    if let Some(extensions) = at.get("extensions") {
        for (name, _) in extensions.members()? {
            if !HONOURED.contains(&name) {
                material.ignored.push(name.to_owned());
            }
        }
    }
    metallic_roughness(at, counts, &mut material)?;
    if let Some(extension) = at.extension("KHR_materials_pbrSpecularGlossiness") {
        material.base_color = extension.numbers_of("diffuseFactor")?.unwrap_or([1.0; 4]);
        material.base_texture = texture(&extension, "diffuseTexture", counts)?;
        material.workflow = Workflow::SpecularGlossiness {
            specular: extension.numbers_of("specularFactor")?.unwrap_or([1.0; 3]),
            glossiness: extension.number_in("glossinessFactor", 0.0, 1.0)?.unwrap_or(1.0),
            texture: texture(&extension, "specularGlossinessTexture", counts)?,
        };
    }
    if at.extension("KHR_materials_unlit").is_some() {
        material.workflow = Workflow::Unlit;
    }
    if let Some(value) = material.base_color.iter().find(|value| **value < 0.0) {
        return Err(at.fault(format!("a base colour of {value} is less than 0")));
    }
    material.base_color = material.base_color.map(|value| value.min(1.0));
    if let Some(normal) = at.get("normalTexture") {
        let scale = normal.number_of("scale")?.unwrap_or(1.0);
        material.normal = texture(at, "normalTexture", counts)?.map(|texture| (texture, scale));
    }
    if let Some(occlusion) = at.get("occlusionTexture") {
        let strength = occlusion.number_in("strength", 0.0, 1.0)?.unwrap_or(1.0);
        material.occlusion = texture(at, "occlusionTexture", counts)?.map(|texture| (texture, strength));
    }
    let strength = match at.extension("KHR_materials_emissive_strength") {
        Some(extension) => extension.number_in("emissiveStrength", 0.0, f32::MAX)?.unwrap_or(1.0),
        None => 1.0,
    };
    let factor: [f32; 3] = at.numbers_of("emissiveFactor")?.unwrap_or([0.0; 3]);
    if let Some(value) = factor.iter().find(|value| **value < 0.0) {
        return Err(at.fault_of("emissiveFactor", format!("an emission of {value} is less than 0")));
    }
    material.emissive = factor.map(|value| (value * strength).min(f32::MAX));
    material.emissive_texture = texture(at, "emissiveTexture", counts)?;
    Ok(material)
}

fn metallic_roughness(at: &At<'_>, counts: &Counts, material: &mut Material) -> Checked<()> {
    let (mut metallic, mut roughness, mut map) = (1.0, 1.0, None);
    if let Some(pbr) = at.get("pbrMetallicRoughness") {
        pbr.object()?;
        material.base_color = pbr.numbers_of("baseColorFactor")?.unwrap_or([1.0; 4]);
        material.base_texture = texture(&pbr, "baseColorTexture", counts)?;
        metallic = pbr.number_in("metallicFactor", 0.0, 1.0)?.unwrap_or(1.0);
        roughness = pbr.number_in("roughnessFactor", 0.0, 1.0)?.unwrap_or(1.0);
        map = texture(&pbr, "metallicRoughnessTexture", counts)?;
    }
    let ior = match at.extension("KHR_materials_ior") {
        Some(extension) => extension.number_in("ior", 0.0, f32::MAX)?.unwrap_or(1.5),
        None => 1.5,
    };
    // An index of 0 stands for total reflection.
    let reflectance = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let mut f0 = [reflectance; 3];
    if let Some(extension) = at.extension("KHR_materials_specular") {
        let factor = extension.number_in("specularFactor", 0.0, 1.0)?.unwrap_or(1.0);
        let color: [f32; 3] = extension.numbers_of("specularColorFactor")?.unwrap_or([1.0; 3]);
        f0 = color.map(|color| (reflectance * color).clamp(0.0, 1.0) * factor);
        for key in ["specularTexture", "specularColorTexture"] {
            if texture(&extension, key, counts)?.is_some() {
                material.ignored.push(format!("KHR_materials_specular {key}"));
            }
        }
    }
    material.workflow = Workflow::MetallicRoughness { metallic, roughness, texture: map, f0 };
    Ok(())
}

fn alpha_mode(at: &At<'_>) -> Checked<AlphaMode> {
    Ok(match at.text_of("alphaMode")? {
        None | Some("OPAQUE") => AlphaMode::Opaque,
        Some("MASK") => AlphaMode::Mask { cutoff: at.number_in("alphaCutoff", 0.0, f32::MAX)?.unwrap_or(0.5) },
        Some("BLEND") => AlphaMode::Blend,
        Some(other) => {
            return Err(at.fault_of("alphaMode", format!("{other:?} is none of OPAQUE, MASK and BLEND")));
        }
    })
}

fn texture(at: &At<'_>, key: &str, counts: &Counts) -> Checked<Option<TextureRef>> {
    let Some(info) = at.get(key) else { return Ok(None) };
    let texture = info.require("index")?.index(counts.textures, "texture")?;
    let set = |at: &At<'_>| -> Checked<Option<u32>> {
        let Some(set) = at.unsigned_of("texCoord")? else { return Ok(None) };
        u32::try_from(set).map(Some).map_err(|_| at.fault_of("texCoord", format!("there is no set {set}")))
    };
    let mut found = TextureRef { texture, set: set(&info)?.unwrap_or(0), transform: UvTransform::default() };
    if let Some(extension) = info.extension("KHR_texture_transform") {
        found.transform = UvTransform {
            offset: extension.numbers_of("offset")?.unwrap_or([0.0; 2]),
            rotation: extension.number_of("rotation")?.unwrap_or(0.0),
            scale: extension.numbers_of("scale")?.unwrap_or([1.0; 2]),
        };
        found.set = set(&extension)?.unwrap_or(found.set);
    }
    Ok(Some(found))
}
