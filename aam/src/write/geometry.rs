//! `GEOMETRY … ENDGEOMETRY`.

use super::WriteError;
use super::digits::{ShortText, short_integer};
use super::out::{InPlace, Out};
use crate::document::{AnimationMode, Faces, Flagged, Geometry, Object, Skin, TexCounts, Track, Triangle};

pub(crate) fn geometry(out: &mut Out, geometry: &Geometry) -> Result<(), WriteError> {
    let objects = geometry.frames.first().map_or(0, |frame| frame.objects.len());
    let mut place = InPlace::new(&geometry.unknown);
    out.line(0, if geometry.smoothing_groups { "GEOMETRY SmGEnabled" } else { "GEOMETRY" });
    place.before(out, 0, "NObj:");
    out.count(0, "NObj:", objects);
    place.before(out, 0, "NFrames:");
    match geometry.animation {
        AnimationMode::Keyframe => {
            if geometry.frames.len() != 1.min(geometry.animation_frames as usize) {
                out.refuse("geometry", "a Keyframe animation has one frame block if it has any frames, else none");
            }
            out.count(0, "NFrames:", geometry.animation_frames as usize);
        }
        _ => out.count(0, "NFrames:", geometry.frames.len()),
    }
    place.before(out, 0, "Animation_mode:");
    out.line(0, &format!("Animation_mode: {}", geometry.animation.word()));
    if let Some(rate) = geometry.frames_per_second {
        place.before(out, 0, "FPS:");
        out.real_field(0, "FPS:", &[rate]);
    }
    for frame in &geometry.frames {
        if frame.objects.len() != objects {
            out.refuse(&format!("frame {}", frame.number), format!("it must have the {objects} objects of the first"));
        }
        place.before(out, 0, "Frame:");
        out.integer_field(0, "Frame:", i64::from(frame.number));
        out.line(0, "{");
        let mut inside = InPlace::new(&frame.unknown);
        for (index, each) in frame.objects.iter().enumerate() {
            if index > 0 {
                out.end_line();
            }
            inside.before(out, 1, "Obj:");
            object(out, &mut inside, each);
        }
        inside.end(out, 1);
        out.line(0, "}");
    }
    place.end(out, 0);
    out.line(0, "ENDGEOMETRY");
    Ok(())
}

fn object(out: &mut Out, frame_place: &mut InPlace<'_>, object: &Object) {
    let subject = format!("object {} {:?}", object.id, object.name);
    out.indent(1);
    out.raw(b"Obj: ");
    out.integer(object.id);
    out.raw(b" ");
    out.free_text(&subject, object.name.bytes());
    out.end_line();
    frame_place.before(out, 1, "Par:");
    out.integer_field(1, "Par:", i64::from(object.parent));
    out.line(1, "{");
    let mut place = InPlace::new(&object.unknown);
    if let Some(node) = &object.node {
        place.before(out, 1, "Piv:");
        let [x, y, z] = node.pivot_position;
        let [qx, qy, qz, qw] = node.pivot_orientation;
        out.real_field(1, "Piv:", &[x, y, z, qx, qy, qz, qw]);
        place.before(out, 1, "Mir:");
        out.line(1, if node.mirrored { "Mir: 1" } else { "Mir: 0" });
        place.before(out, 1, "TM:");
        let tm: Vec<f32> =
            node.rotation.as_flattened().iter().chain(&node.position).chain(&node.scale).copied().collect();
        out.real_field(1, "TM:", &tm);
    }
    place.before(out, 1, "MatID:");
    out.integer_field(1, "MatID:", i64::from(object.material));
    if let Some(properties) = &object.user_properties {
        place.before(out, 1, "UserProp:");
        out.text(1, "UserProp:", properties);
    }
    if let Some(displacement) = &object.displacement {
        if displacement.tessellation == 0 {
            out.refuse(&subject, "the tessellation factor is 0");
        }
        place.before(out, 1, "TF:");
        out.integer_field(1, "TF:", i64::from(displacement.tessellation));
        place.before(out, 1, "BI:");
        out.real_field(1, "BI:", &[displacement.bias]);
        place.before(out, 1, "SC:");
        out.real_field(1, "SC:", &[displacement.scale]);
    }
    place.before(out, 1, "V_List:");
    out.count(1, "V_List:", object.vertices.len());
    out.rows(2, &object.vertices);
    match &object.skin {
        Flagged::Omitted => {}
        Flagged::No => {
            place.before(out, 1, "SKIN:");
            out.line(1, "SKIN: N");
        }
        Flagged::Yes(each) => {
            place.before(out, 1, "SKIN:");
            skin(out, &subject, object.vertices.len(), each);
        }
    }
    if let Some(colors) = &object.colors {
        if colors.len() != object.vertices.len() {
            out.refuse(&subject, "it must have as many vertex colours as vertices");
        }
        place.before(out, 1, "C_List:");
        out.count(1, "C_List:", colors.len());
        out.rows(2, colors);
    }
    if let Some(each) = &object.faces {
        faces(out, &subject, &mut place, object.vertices.len(), each);
    } else if let Some(normals) = &object.frame_normals {
        place.before(out, 1, "N_List:");
        out.count(1, "N_List:", normals.len());
        out.rows(2, normals);
    }
    match &object.keys {
        Flagged::Omitted => {}
        Flagged::No => {
            place.before(out, 1, "Anim_Ctrl:");
            out.line(1, "Anim_Ctrl: N");
        }
        Flagged::Yes(tracks) => {
            place.before(out, 1, "Anim_Ctrl:");
            out.line(1, "Anim_Ctrl: Y");
            for each in tracks {
                track(out, each);
            }
        }
    }
    place.end(out, 1);
    out.line(1, "}");
}

fn skin(out: &mut Out, subject: &str, vertices: usize, skin: &Skin) {
    let total: usize = skin.rows.iter().map(|&(_, count)| count as usize).sum();
    if skin.rows.len() != vertices
        || total != skin.weights.len()
        || skin.rows.iter().any(|&(vertex, _)| vertex as usize >= vertices)
    {
        out.refuse(subject, "its skin must have one row for each vertex and a weight for each that the rows count");
        return;
    }
    out.line(1, "SKIN: Y");
    let mut weights = skin.weights.iter();
    for &(vertex, count) in &skin.rows {
        out.indent(2);
        out.integer(vertex);
        out.raw(b" ");
        out.integer(count);
        for &(bone, weight) in weights.by_ref().take(count as usize) {
            out.raw(b" ");
            out.integer(bone);
            out.raw(b" ");
            out.real(weight);
        }
        out.end_line();
    }
}

fn faces(out: &mut Out, subject: &str, place: &mut InPlace<'_>, vertices: usize, faces: &Faces) {
    if let Err(message) = consistent(vertices, faces) {
        out.refuse(subject, message);
        return;
    }
    place.before(out, 1, "TV_List:");
    out.count(1, "TV_List:", faces.tex_coords.len());
    out.rows(2, &faces.tex_coords);
    if let Some(normals) = &faces.normals {
        place.before(out, 1, "N_List:");
        out.count(1, "N_List:", normals.len());
        out.rows(2, normals);
    }
    place.before(out, 1, "I_List:");
    out.indent(1);
    out.raw(b"I_List: ");
    out.integer(faces.triangles.len());
    if !faces.groups.is_empty() {
        out.raw(b" ");
        out.integer(faces.groups.len());
    }
    out.end_line();
    let mut triangle = 0;
    let mut textures = 0;
    for group in &faces.groups {
        out.indent(2);
        out.raw(b"NEWGROUP: ");
        out.integer(group.id);
        out.end_line();
        for _ in 0..group.triangles {
            let corners = &faces.triangles[triangle];
            let short = triangle_row(out, corners);
            if let Some(indices) = faces.normal_indices.get(triangle) {
                index_row(out, *b"NI: ", indices, corners, short);
            }
            let count = faces.tex_counts.of(triangle);
            for indices in &faces.tex_indices[textures..textures + count] {
                index_row(out, *b"TI: ", indices, corners, short);
            }
            triangle += 1;
            textures += count;
        }
        out.line(2, "ENDGROUP");
    }
}

#[inline(always)]
fn short_indices(&[a, b, c]: &[u32; 3]) -> [Option<ShortText>; 3] {
    [short_integer(a.into()), short_integer(b.into()), short_integer(c.into())]
}

/// `I:`, and the texts of its indices. In BINARY it starts at once, and has no line end.
#[inline(always)]
fn triangle_row(out: &mut Out, triangle: &Triangle) -> [Option<ShortText>; 3] {
    let Triangle { vertices, smoothing } = triangle;
    if out.binary {
        out.row(|row| {
            row.short(*b"I: ", 3);
            vertices.iter().for_each(|index| row.short(index.to_le_bytes(), 4));
            row.short(smoothing.to_le_bytes(), 4);
        });
        return [None; 3];
    }
    let short = short_indices(vertices);
    out.row(|row| {
        row.indent(2);
        row.short(*b"I: ", 3);
        row.indices(vertices, short);
        row.short(*b" ", 1);
        row.integer(i64::from(*smoothing), short_integer(i64::from(*smoothing)));
        row.end_line();
    });
    short
}

/// `NI:` or `TI:` of a triangle, which often has the triangle's own indices. In BINARY it starts on a new line.
#[inline(always)]
fn index_row(out: &mut Out, tag: [u8; 4], indices: &[u32; 3], triangle: &Triangle, short: [Option<ShortText>; 3]) {
    if out.binary {
        out.row(|row| {
            row.end_line();
            row.short(tag, 4);
            indices.iter().for_each(|index| row.short(index.to_le_bytes(), 4));
        });
        return;
    }
    let same = *indices == triangle.vertices;
    let short = if same { short } else { short_indices(indices) };
    out.row(|row| {
        row.indent(2);
        row.short(tag, 4);
        row.indices(indices, short);
        row.end_line();
    });
}

/// Whether the lists of faces agree with each other, so that what is written reads back.
fn consistent(vertices: usize, faces: &Faces) -> Result<(), String> {
    let grouped: usize = faces.groups.iter().map(|group| group.triangles).sum();
    if grouped != faces.triangles.len() {
        return Err(format!("its groups hold {grouped} triangles of {}", faces.triangles.len()));
    }
    let counted = match &faces.tex_counts {
        TexCounts::Uniform(count) => usize::from(*count) * faces.triangles.len(),
        TexCounts::Each(counts) => counts.iter().map(|&count| usize::from(count)).sum(),
    };
    let most = match &faces.tex_counts {
        TexCounts::Uniform(count) => *count,
        TexCounts::Each(counts) => counts.iter().copied().max().unwrap_or(0),
    };
    let each = !matches!(&faces.tex_counts, TexCounts::Each(counts) if counts.len() != faces.triangles.len());
    if counted != faces.tex_indices.len() || most > 4 || !each {
        return Err(format!(
            "it has {} texture index rows where its triangles count {counted}, at most four each",
            faces.tex_indices.len()
        ));
    }
    match &faces.normals {
        Some(_) if faces.normal_indices.len() != faces.triangles.len() => {
            return Err("explicit normals need one row of indices for each triangle".into());
        }
        None if !faces.normal_indices.is_empty() => return Err("normal indices without normals".into()),
        _ => {}
    }
    let inside = |indices: &[u32; 3], limit: usize| indices.iter().all(|&index| (index as usize) < limit);
    if !faces.triangles.iter().all(|triangle| inside(&triangle.vertices, vertices)) {
        return Err(format!("a triangle's index is outside its {vertices} vertices"));
    }
    if !faces.tex_indices.iter().all(|indices| inside(indices, faces.tex_coords.len())) {
        return Err(format!("a texture index is outside its {} texture vertices", faces.tex_coords.len()));
    }
    let normals = faces.normals.as_ref().map_or(0, Vec::len);
    if !faces.normal_indices.iter().all(|indices| inside(indices, normals)) {
        return Err(format!("a normal index is outside its {normals} normals"));
    }
    Ok(())
}

fn track(out: &mut Out, track: &Track) {
    match track {
        Track::PositionSampled(keys) => keyed(out, "PsSam:", keys, |key| (key.frame, vec![&key.position[..]], None)),
        Track::RotationSampled(keys) => {
            keyed(out, "RtSam:", keys, |key| (key.frame, vec![&key.axis[..], std::slice::from_ref(&key.angle)], None))
        }
        Track::ScaleSampled(keys) => {
            keyed(out, "ScSam:", keys, |key| (key.frame, vec![&key.axes[..], &key.scale], None))
        }
        Track::PositionBezier(keys) => keyed(out, "PsBez:", keys, |key| {
            (key.frame, vec![&key.position[..], &key.tangent_in, &key.tangent_out], Some(key.flag))
        }),
        Track::RotationBezier(keys) => keyed(out, "RtBez:", keys, |key| {
            (key.frame, vec![&key.euler[..], &key.tangent_in, &key.tangent_out], Some(key.flag))
        }),
        Track::ScaleBezier(keys) => keyed(out, "ScBez:", keys, |key| {
            (key.frame, vec![&key.scale[..], &key.axes, &key.tangent_in, &key.tangent_out], Some(key.flag))
        }),
        Track::RotationTcb(keys) => keyed(out, "RtTcb:", keys, |key| {
            let one = std::slice::from_ref;
            let parameters =
                vec![&key.axis[..], one(&key.angle), one(&key.tension), one(&key.continuity), one(&key.bias)];
            (key.frame, [parameters, vec![one(&key.ease_in), one(&key.ease_out)]].concat(), None)
        }),
        Track::RotationEuler(keys) => keyed(out, "RtIPA:", keys, |key| (key.frame, vec![&key.euler[..]], None)),
    }
}

fn keyed<'a, K>(out: &mut Out, tag: &str, keys: &'a [K], row: impl Fn(&'a K) -> (f32, Vec<&'a [f32]>, Option<i32>)) {
    out.count(2, tag, keys.len());
    for key in keys {
        let (frame, values, flag) = row(key);
        out.indent(3);
        out.frame(frame);
        for &value in values.into_iter().flatten() {
            out.raw(b" ");
            out.real(value);
        }
        if let Some(flag) = flag {
            out.raw(b" ");
            out.integer(flag);
        }
        out.end_line();
    }
}
