//! Which extensions are honoured, which are left out with a report, and which end the import.

use super::fault::{Checked, Fault};
use super::json::At;
use super::log::Log;

/// Honoured, wholly or as the report says in its place.
const HONOURED: [&str; 12] = [
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_animation_pointer",
    "KHR_materials_variants",
];

/// Refinements of materials: without them the model still looks like itself. Each material reports its own.
const REFINEMENTS: [&str; 8] = [
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_transmission",
    "KHR_materials_volume",
];

/// Images in a form that cannot be decoded: harmless where the texture has another source too.
const UNDECODABLE_IMAGES: [&str; 3] = ["EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"];

/// The refusal of Draco-compressed geometry.
pub(super) fn draco() -> Fault {
    Fault::unsupported(
        "KHR_draco_mesh_compression",
        "decompress the file with `gltf-transform copy in.glb out.glb`, or export it without Draco",
    )
}

/// The refusal of compressed buffers.
pub(super) fn meshopt(name: &str) -> Fault {
    Fault::unsupported(
        name,
        "decompress the file with `gltf-transform copy in.glb out.glb`, or export it without compression",
    )
}

/// The refusal of an image that cannot be decoded.
pub(super) fn image(name: &str, place: &str) -> Fault {
    Fault::unsupported(
        format!("{name} ({place})"),
        "turn the textures into PNG or JPEG (`gltf-transform png in.glb out.glb` after `ktxdecompress` where they are KTX2)",
    )
}

/// Checks what the file requires and reports what it uses in vain.
pub(super) fn check(root: &At<'_>, log: &mut Log) -> Checked<()> {
    for item in root.list("extensionsRequired")? {
        let name = item.text()?;
        match name {
            "KHR_draco_mesh_compression" => return Err(draco()),
            "EXT_meshopt_compression" | "KHR_meshopt_compression" => return Err(meshopt(name)),
            _ if HONOURED.contains(&name) || REFINEMENTS.contains(&name) => {}
            // A texture that has no other source is refused when it is read.
            _ if UNDECODABLE_IMAGES.contains(&name) => {}
            _ => {
                return Err(Fault::unsupported(
                    name,
                    format!("the file says ({}) that it means nothing without it; export it without", item.place()),
                ));
            }
        }
    }
    for item in root.list("extensionsUsed")? {
        let name = item.text()?;
        if name == "KHR_materials_variants" {
            log.lost("", "material variants", "each primitive keeps its default material");
        } else if !HONOURED.contains(&name) && !REFINEMENTS.contains(&name) {
            let note = format!("{name} has no counterpart in AAM; the file permits leaving it out");
            log.lost("", "extension", note);
        }
    }
    Ok(())
}
