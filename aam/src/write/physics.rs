//! `PHYSICS … ENDPHYSICS`. Always text, also in a BINARY file.

use super::WriteError;
use super::out::{InPlace, Out};
use crate::document::{Body, Convex, Physics, Primitive};

pub(crate) fn physics(out: &mut Out, physics: &Physics) -> Result<(), WriteError> {
    out.binary = false;
    out.line(0, "PHYSICS");
    let mut place = InPlace::new(&physics.unknown);
    place.before(out, 0, "NBody:");
    out.count(0, "NBody:", physics.bodies.len());
    for each in &physics.bodies {
        place.before(out, 0, "Body:");
        body(out, each);
    }
    place.end(out, 0);
    out.line(0, "ENDPHYSICS");
    Ok(())
}

fn body(out: &mut Out, body: &Body) {
    let subject = format!("body {} {:?}", body.object, body.name);
    out.raw(b"Body: ");
    out.integer(body.object);
    out.raw(b" ");
    out.free_text(&subject, body.name.bytes());
    out.end_line();
    out.line(0, "{");
    let mut place = InPlace::new(&body.unknown);
    place.before(out, 1, "Mode:");
    out.line(1, &format!("Mode: {}", body.mode.word()));
    let values = [("SF:", body.static_friction), ("DF:", body.dynamic_friction), ("Re:", body.restitution)];
    for (tag, value) in values {
        place.before(out, 1, tag);
        out.real_field(1, tag, &[value]);
    }
    if let Some(mass) = body.mass {
        place.before(out, 1, "Ma:");
        out.real_field(1, "Ma:", &[mass]);
    }
    if let Some(primitives) = &body.primitives {
        place.before(out, 1, "NPrim:");
        out.count(1, "NPrim:", primitives.len());
        for each in primitives {
            primitive(out, &mut place, each);
        }
    }
    if let Some(pieces) = &body.pieces {
        place.before(out, 1, "NConvex:");
        out.count(1, "NConvex:", pieces.len());
        for piece in pieces {
            place.before(out, 1, "Convex:");
            convex(out, &subject, piece);
        }
    }
    place.end(out, 1);
    out.line(0, "}");
}

fn primitive(out: &mut Out, place: &mut InPlace<'_>, primitive: &Primitive) {
    match primitive {
        Primitive::Box { center: [x, y, z], orientation: [qx, qy, qz, qw], half: [hx, hy, hz] } => {
            place.before(out, 2, "Box:");
            out.real_field(2, "Box:", &[*x, *y, *z, *qx, *qy, *qz, *qw, *hx, *hy, *hz]);
        }
        Primitive::Sphere { center: [x, y, z], radius } => {
            place.before(out, 2, "Sphere:");
            out.real_field(2, "Sphere:", &[*x, *y, *z, *radius]);
        }
        Primitive::Capsule { a: [ax, ay, az], b: [bx, by, bz], radius } => {
            place.before(out, 2, "Capsule:");
            out.real_field(2, "Capsule:", &[*ax, *ay, *az, *bx, *by, *bz, *radius]);
        }
    }
}

fn convex(out: &mut Out, subject: &str, piece: &Convex) {
    if piece.triangles.as_flattened().iter().any(|&index| index as usize >= piece.vertices.len()) {
        out.refuse(subject, format!("piece {} has an index outside its vertices", piece.number));
        return;
    }
    out.integer_field(1, "Convex:", i64::from(piece.number));
    out.line(1, "{");
    out.count(2, "V_List:", piece.vertices.len());
    out.rows(3, &piece.vertices);
    out.count(2, "I_List:", piece.triangles.len());
    for triangle in &piece.triangles {
        out.indent(3);
        out.raw(b"I:");
        for &corner in triangle {
            out.raw(b" ");
            out.integer(corner);
        }
        out.end_line();
    }
    out.line(1, "}");
}
