//! Buffers, views, accessors, images, samplers, textures.

use crate::gltf_in::fault::{Checked, Fault};
use crate::gltf_in::json::At;
use crate::gltf_in::model::{
    Accessor, Buffer, Component, Image, ImageSource, Kind, Model, Sampler, Sparse, Texture, View,
};

use super::{Counts, name};

/// Compressions whose data may stand in a view while the buffer is only a place holder.
const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

pub(super) fn buffer(at: &At<'_>) -> Checked<Buffer> {
    let filled_by = COMPRESSIONS.into_iter().find(|name| at.extension(name).is_some());
    at.require("byteLength")?;
    Ok(Buffer {
        uri: at.text_of("uri")?.map(str::to_owned),
        length: at.size_of("byteLength")?.unwrap_or(0),
        filled_by,
        place: at.place().to_owned(),
    })
}

pub(super) fn view(at: &At<'_>, counts: &Counts) -> Checked<View> {
    at.require("byteLength")?;
    let stride = at.size_of("byteStride")?;
    if let Some(stride) = stride.filter(|stride| !(1..=252).contains(stride)) {
        return Err(at.fault_of("byteStride", format!("expected a stride from 4 to 252, found {stride}")));
    }
    Ok(View {
        buffer: at.require("buffer")?.index(counts.buffers, "buffer")?,
        offset: at.size_of("byteOffset")?.unwrap_or(0),
        length: at.size_of("byteLength")?.unwrap_or(0),
        stride,
    })
}

fn component(at: &At<'_>) -> Checked<Component> {
    let member = at.require("componentType")?;
    Ok(match member.unsigned()? {
        5120 => Component::I8,
        5121 => Component::U8,
        5122 => Component::I16,
        5123 => Component::U16,
        5125 => Component::U32,
        5126 => Component::F32,
        other => return Err(member.fault(format!("{other} is no component type (5120 to 5126 without 5124)"))),
    })
}

pub(super) fn accessor(at: &At<'_>, counts: &Counts) -> Checked<Accessor> {
    let shape = at.require("type")?;
    let kind = match shape.text()? {
        "SCALAR" => Kind::Scalar,
        "VEC2" => Kind::Vec2,
        "VEC3" => Kind::Vec3,
        "VEC4" => Kind::Vec4,
        "MAT2" => Kind::Mat2,
        "MAT3" => Kind::Mat3,
        "MAT4" => Kind::Mat4,
        other => return Err(shape.fault(format!("{other:?} is no accessor type"))),
    };
    at.require("count")?;
    let sparse = at.get("sparse").map(|sparse| self::sparse(&sparse, counts)).transpose()?;
    Ok(Accessor {
        view: at.index_of("bufferView", counts.views, "buffer view")?,
        offset: at.size_of("byteOffset")?.unwrap_or(0),
        count: at.size_of("count")?.unwrap_or(0),
        component: component(at)?,
        kind,
        normalized: at.flag("normalized")?,
        sparse,
        place: at.place().to_owned(),
    })
}

fn sparse(at: &At<'_>, counts: &Counts) -> Checked<Sparse> {
    at.require("count")?;
    let indices = at.require("indices")?;
    let values = at.require("values")?;
    let index_component = component(&indices)?;
    if !matches!(index_component, Component::U8 | Component::U16 | Component::U32) {
        return Err(indices.fault_of("componentType", "sparse indices must be unsigned integers"));
    }
    Ok(Sparse {
        count: at.size_of("count")?.unwrap_or(0),
        index_view: indices.require("bufferView")?.index(counts.views, "buffer view")?,
        index_offset: indices.size_of("byteOffset")?.unwrap_or(0),
        index_component,
        value_view: values.require("bufferView")?.index(counts.views, "buffer view")?,
        value_offset: values.size_of("byteOffset")?.unwrap_or(0),
    })
}

/// Checks that views lie in their buffers and accessors in their views, before anything is read or allocated.
pub(super) fn check_ranges(model: &Model) -> Checked<()> {
    for (number, view) in model.views.iter().enumerate() {
        let length = model.buffers[view.buffer].length;
        if view.offset.checked_add(view.length).is_none_or(|end| end > length) {
            let message = format!(
                "{} bytes from {} go beyond buffer {}, which has {length}",
                view.length, view.offset, view.buffer
            );
            return Err(Fault::broken(format!("/bufferViews/{number}/byteLength"), message));
        }
    }
    model.accessors.iter().try_for_each(|accessor| check_accessor(model, accessor))
}

fn check_accessor(model: &Model, accessor: &Accessor) -> Checked<()> {
    let size = accessor.kind.size(accessor.component);
    let needed = accessor.kind.needed(accessor.component);
    let fits = |view: usize, offset: usize, count: usize, size: usize, stride: usize| -> Result<(), String> {
        let Some(last) = count.checked_sub(1) else { return Ok(()) };
        let length = model.views[view].length;
        let end =
            last.checked_mul(stride).and_then(|end| end.checked_add(size)).and_then(|end| end.checked_add(offset));
        if end.is_some_and(|end| end <= length) {
            return Ok(());
        }
        Err(format!(
            "{count} elements of {size} bytes, {stride} apart, from byte {offset} go beyond buffer view {view}, which has {length} bytes"
        ))
    };
    let place = &accessor.place;
    if let Some(view) = accessor.view {
        let stride = model.views[view].stride.unwrap_or(size);
        if stride < needed {
            let message = format!("a stride of {stride} is less than the accessor's element of {needed} bytes");
            return Err(Fault::broken(format!("/bufferViews/{view}/byteStride"), format!("{message} ({place})")));
        }
        fits(view, accessor.offset, accessor.count, needed, stride)
            .map_err(|message| Fault::broken(format!("{place}/count"), message))?;
    }
    if let Some(sparse) = &accessor.sparse {
        if sparse.count > accessor.count {
            let message = format!("{} replacements for {} elements", sparse.count, accessor.count);
            return Err(Fault::broken(format!("{place}/sparse/count"), message));
        }
        let index_size = sparse.index_component.size();
        fits(sparse.index_view, sparse.index_offset, sparse.count, index_size, index_size)
            .map_err(|message| Fault::broken(format!("{place}/sparse/indices"), message))?;
        fits(sparse.value_view, sparse.value_offset, sparse.count, needed, size)
            .map_err(|message| Fault::broken(format!("{place}/sparse/values"), message))?;
    }
    Ok(())
}

pub(super) fn image(at: &At<'_>, counts: &Counts) -> Checked<Image> {
    let view = at.index_of("bufferView", counts.views, "buffer view")?;
    let source = match (at.text_of("uri")?, view) {
        (Some(uri), _) => ImageSource::Uri(uri.to_owned()),
        (None, Some(view)) => ImageSource::View(view),
        (None, None) => ImageSource::Nothing,
    };
    Ok(Image { name: name(at)?, source, place: at.place().to_owned() })
}

pub(super) fn sampler(at: &At<'_>) -> Checked<Sampler> {
    let wrap = |key: &str| -> Checked<Option<&'static str>> {
        Ok(match at.unsigned_of(key)? {
            None | Some(10497) => None,
            Some(33071) => Some("clamp to edge"),
            Some(33648) => Some("mirrored repeat"),
            Some(other) => return Err(at.fault_of(key, format!("{other} is no wrap mode (33071, 33648 or 10497)"))),
        })
    };
    let filter = |key: &str, known: &[u64]| -> Checked<Option<&'static str>> {
        Ok(match at.unsigned_of(key)? {
            Some(9728 | 9984 | 9986) => Some("nearest"),
            Some(other) if !known.contains(&other) => {
                return Err(at.fault_of(key, format!("{other} is no filter")));
            }
            _ => None,
        })
    };
    let across = wrap("wrapS")?;
    let up = wrap("wrapT")?;
    let large = filter("magFilter", &[9729])?;
    let small = filter("minFilter", &[9729, 9985, 9987])?;
    Ok(Sampler { wrap: across.or(up), filter: large.or(small) })
}

pub(super) fn texture(at: &At<'_>, counts: &Counts) -> Checked<Texture> {
    /// What may hold the picture instead of `source`; only the first can be decoded.
    const ALTERNATIVES: [&str; 4] = ["EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif"];
    let mut image = at.index_of("source", counts.images, "image")?.ok_or("");
    for name in ALTERNATIVES {
        let Some(extension) = at.extension(name) else { continue };
        let source = extension.index_of("source", counts.images, "image")?;
        if image.is_err() {
            image = match source {
                Some(source) if name == ALTERNATIVES[0] => Ok(source),
                _ => Err(name),
            };
        }
    }
    Ok(Texture { image, sampler: at.index_of("sampler", counts.samplers, "sampler")?, place: at.place().to_owned() })
}
