//! Checks of frames, transforms and keys.

use glam::{Mat3, Vec3};

use super::{Findings, Part, counted, object_subject};
use crate::Document;
use crate::document::{AnimationMode, Header, NodeTransform, Object, Track};

pub(super) fn check(document: &Document, findings: &mut Findings) {
    let geometry = &document.geometry;
    if let Some(message) = unfitting(document) {
        findings.add(Part::Document, "animation", "animation/mode", message);
    }
    if let Some(rate) = geometry.frames_per_second
        && !(rate > 0.0 && rate.is_finite())
    {
        findings.add(Part::Document, "animation", "animation/rate", format!("FPS is {rate}, not above 0"));
    }
    let numbers = geometry.frames.iter().map(|frame| i64::from(frame.number));
    if let Some((expected, found)) = (0..).zip(numbers).find(|(expected, found)| expected != found) {
        let message = format!("frame {expected} in the file is numbered {found}");
        findings.add(Part::Document, "animation", "animation/frame-numbers", message);
    }
    for (index, object) in document.objects().iter().enumerate() {
        let part = Part::Object { frame: 0, index };
        if let Some(node) = &object.node {
            check_transform(part, object, node, findings);
        }
        if let Some(tracks) = object.keys.as_ref() {
            check_tracks(part, object, tracks, geometry.animation_frames, findings);
        }
    }
}

fn unfitting(document: &Document) -> Option<&'static str> {
    let geometry = &document.geometry;
    let frames = geometry.frames.len();
    let nodes = document.objects().iter().any(|object| object.node.is_some());
    match (document.header, geometry.animation) {
        (Some(Header::MeshMultiframe), mode) if mode != AnimationMode::Full => {
            Some("the header says multiframe, but `Animation_mode` is not `Full`")
        }
        (Some(Header::Character | Header::Avatar), AnimationMode::Full) => {
            Some("the header says character, but `Animation_mode` is `Full`")
        }
        (Some(Header::Mesh), AnimationMode::Keyframe) => {
            Some("the header says static mesh, but `Animation_mode` is `Keyframe`")
        }
        (_, AnimationMode::None) if frames > 1 => Some("`Animation_mode` is `None`, but there are several frames"),
        (None | Some(Header::Mesh), _) if nodes => {
            Some("objects have transforms, but the header does not say character")
        }
        _ => None,
    }
}

fn check_transform(part: Part, object: &Object, node: &NodeTransform, findings: &mut Findings) {
    let subject = object_subject(object);
    if node.scale.contains(&0.0) {
        findings.add(
            part,
            &subject,
            "transform/zero-scale",
            format!("TM scales by {:?}, which makes it flat", node.scale),
        );
    }
    let rotation = Mat3::from_cols_array_2d(&node.rotation);
    let off = (rotation.transpose() * rotation - Mat3::IDENTITY).to_cols_array();
    let worst = off.iter().fold(0.0f32, |worst, value| worst.max(value.abs()));
    if !(worst <= 0.02) {
        let message = format!("the rotation of TM is off by up to {worst:.3} from an orthonormal one");
        findings.add(part, &subject, "transform/rotation", message);
    }
}

fn check_tracks(part: Part, object: &Object, tracks: &[Track], frames: u32, findings: &mut Findings) {
    let subject = object_subject(object);
    let mut motions: Vec<Motion> = Vec::new();
    for track in tracks {
        let (motion, tag, keys) = describe(track);
        if motions.contains(&motion) {
            findings.add(
                part,
                &subject,
                "animation/repeated-track",
                format!("{tag} is the second track of its motion"),
            );
        }
        motions.push(motion);
        if keys.is_empty() {
            findings.add(part, &subject, "animation/empty-track", format!("{tag} has no keys"));
        }
        let unsorted = keys.windows(2).filter(|pair| !(pair[0] <= pair[1])).count();
        if unsorted > 0 {
            let message = format!("{tag}: {} before the one that it follows", counted(unsorted, "key"));
            findings.add(part, &subject, "animation/unsorted-keys", message);
        }
        let twice = keys.windows(2).filter(|pair| pair[0] == pair[1]).count();
        if twice > 0 {
            let message = format!("{tag}: {} at the frame of another", counted(twice, "key"));
            findings.add(part, &subject, "animation/duplicate-key", message);
        }
        let last = f64::from(frames.max(1) - 1);
        let outside = keys.iter().filter(|&&frame| !(0.0..=last).contains(&f64::from(frame))).count();
        if outside > 0 {
            let message = format!("{tag}: {} outside 0 … {last}", counted(outside, "key"));
            findings.add(part, &subject, "animation/key-outside", message);
        }
        let zero = match track {
            Track::RotationSampled(keys) => keys.iter().filter(|key| zero_axis(key.axis, key.angle)).count(),
            Track::RotationTcb(keys) => keys.iter().filter(|key| zero_axis(key.axis, key.angle)).count(),
            _ => 0,
        };
        if zero > 0 {
            findings.add(
                part,
                &subject,
                "animation/zero-axis",
                format!("{tag}: {} with a zero axis", counted(zero, "key")),
            );
        }
    }
}

fn zero_axis(axis: [f32; 3], angle: f32) -> bool {
    angle != 0.0 && Vec3::from(axis).length_squared() == 0.0
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Motion {
    Position,
    Rotation,
    Scale,
}

/// What a track moves, its tag, and its frames.
fn describe(track: &Track) -> (Motion, &'static str, Vec<f32>) {
    match track {
        Track::PositionSampled(keys) => (Motion::Position, "PsSam", keys.iter().map(|key| key.frame).collect()),
        Track::RotationSampled(keys) => (Motion::Rotation, "RtSam", keys.iter().map(|key| key.frame).collect()),
        Track::ScaleSampled(keys) => (Motion::Scale, "ScSam", keys.iter().map(|key| key.frame).collect()),
        Track::PositionBezier(keys) => (Motion::Position, "PsBez", keys.iter().map(|key| key.frame).collect()),
        Track::RotationBezier(keys) => (Motion::Rotation, "RtBez", keys.iter().map(|key| key.frame).collect()),
        Track::ScaleBezier(keys) => (Motion::Scale, "ScBez", keys.iter().map(|key| key.frame).collect()),
        Track::RotationTcb(keys) => (Motion::Rotation, "RtTcb", keys.iter().map(|key| key.frame).collect()),
        Track::RotationEuler(keys) => (Motion::Rotation, "RtIPA", keys.iter().map(|key| key.frame).collect()),
    }
}
