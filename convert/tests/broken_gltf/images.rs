//! Faults of images.

use super::*;

/// The valid file with this picture.
fn with_picture(file: &Builder, picture: &[u8]) -> Builder {
    let mut file = file.clone();
    let view = file.view(picture);
    file.set("/images/0/bufferView", json!(view));
    file
}

pub(super) fn cases(file: &Builder) -> Vec<Case> {
    let one = |code, name, place, says, pointer: &str, value| case(code, name, place, says, file, &[(pointer, value)]);
    let good = png(2, 2, |_, _| [255; 4]);
    let shown =
        |code, name, outcome, picture: &[u8]| Case { code, name, outcome, bytes: with_picture(file, picture).glb() };
    let edited = |code, name, outcome, edits: &[(&str, Value)]| {
        let mut file = file.clone();
        edits.iter().for_each(|(pointer, value)| {
            file.set(pointer, value.clone());
        });
        Case { code, name, outcome, bytes: file.glb() }
    };
    vec![
        one("UNRESOLVED_REFERENCE", "image view", "/images/0/bufferView", "99", "/images/0/bufferView", json!(99)),
        one("ONE_OF_MISMATCH", "image of nothing", "/images/0", "neither", "/images/0", json!({})),
        one(
            "IMAGE_UNRECOGNIZED_FORMAT",
            "image of floats",
            "/images/0",
            "no picture format",
            "/images/0/bufferView",
            json!(0),
        ),
        one("TYPE_MISMATCH", "a number as image name", "/images/0/name", "string", "/images/0/name", json!(4)),
        one("TYPE_MISMATCH", "a number as image address", "/images/0/uri", "string", "/images/0/uri", json!(4)),
        edited(
            "INVALID_URI",
            "base64 that is none",
            Outcome::Refused("/images/0/uri", "base64"),
            &[("/images/0", json!({ "uri": "data:image/png;base64,@@@@" }))],
        ),
        edited(
            "INVALID_URI",
            "a data address without data",
            Outcome::Refused("/images/0/uri", "comma"),
            &[("/images/0", json!({ "uri": "data:image/png;base64" }))],
        ),
        edited(
            "IO_ERROR",
            "an image outside the folder",
            Outcome::Refused("/images/0/uri", "--allow-outside"),
            &[("/images/0", json!({ "uri": "../../secret.png" }))],
        ),
        edited(
            "IO_ERROR",
            "an image that is not there",
            Outcome::Read("does not exist"),
            &[("/images/0", json!({ "uri": "missing.png" }))],
        ),
        edited(
            "NON_RELATIVE_URI",
            "an image of the network",
            Outcome::Refused("", "https: address"),
            &[("/images/0", json!({ "uri": "https://example.com/a.png" }))],
        ),
        edited(
            "ONE_OF_MISMATCH",
            "an image that is in two places",
            Outcome::Read(""),
            &[("/images/0/uri", json!("data:image/png;base64,iVBORw0KGgo="))],
        ),
        edited(
            "VALUE_NOT_IN_LIST",
            "a type that no picture has",
            Outcome::Read(""),
            &[("/images/0/mimeType", json!("text/plain"))],
        ),
        edited(
            "IMAGE_MIME_TYPE_INVALID",
            "a PNG said to be JPEG",
            Outcome::Read(""),
            &[("/images/0/mimeType", json!("image/jpeg"))],
        ),
        edited(
            "UNSATISFIED_DEPENDENCY",
            "a picture in a view without its type",
            Outcome::Read(""),
            &[("/images/0", json!({ "bufferView": 10 }))],
        ),
        shown("IMAGE_UNEXPECTED_EOS", "a picture cut in its header", Outcome::Read("unseen"), &good[..20]),
        shown("IMAGE_DATA_INVALID", "a picture whose header is nonsense", Outcome::Read("unseen"), &{
            let mut bytes = good.clone();
            bytes[11] = 99;
            bytes
        }),
        shown("VALUE_NOT_IN_RANGE", "an empty picture", Outcome::Refused("/images/0", "no picture"), b""),
    ]
}
