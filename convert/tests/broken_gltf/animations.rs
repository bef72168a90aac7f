//! Faults of animations.

use super::*;

pub(super) fn cases(file: &Builder) -> Vec<Case> {
    let one = |code, name, place, says, pointer: &str, value| case(code, name, place, says, file, &[(pointer, value)]);
    let sampler = |key: &str| format!("/animations/0/samplers/0/{key}");
    vec![
        one(
            "UNRESOLVED_REFERENCE",
            "sampler of a channel",
            "/animations/0/channels/0/sampler",
            "sampler of this",
            "/animations/0/channels/0/sampler",
            json!(3),
        ),
        one(
            "UNRESOLVED_REFERENCE",
            "node of a channel",
            "/animations/0/channels/0/target/node",
            "node 44",
            "/animations/0/channels/0/target/node",
            json!(44),
        ),
        one(
            "UNDEFINED_PROPERTY",
            "channel without target",
            "/animations/0/channels/0/target",
            "missing",
            "/animations/0/channels/0/target",
            Value::Null,
        ),
        one(
            "VALUE_NOT_IN_LIST",
            "interpolation",
            "/animations/0/samplers/0/interpolation",
            "BEZIER",
            &sampler("interpolation"),
            json!("BEZIER"),
        ),
        one(
            "UNRESOLVED_REFERENCE",
            "input",
            "/animations/0/samplers/0/input",
            "accessor 50",
            &sampler("input"),
            json!(50),
        ),
        one(
            "UNRESOLVED_REFERENCE",
            "output",
            "/animations/0/samplers/0/output",
            "accessor 50",
            &sampler("output"),
            json!(50),
        ),
        one(
            "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT",
            "values of another shape",
            "/accessors/4/type",
            "4 numbers each",
            &sampler("output"),
            json!(4),
        ),
        one(
            "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
            "more values than times",
            "/accessors/0/count",
            "9 numbers for 2",
            &sampler("output"),
            json!(0),
        ),
        one(
            "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
            "spline without tangents",
            "/accessors/8/count",
            "9 a time",
            &sampler("interpolation"),
            json!("CUBICSPLINE"),
        ),
        one(
            "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS",
            "weights without targets",
            "/animations/0/channels/0",
            "no morph targets",
            "/animations/0/channels/0/target/path",
            json!("weights"),
        ),
        one(
            "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT",
            "times that are matrices",
            "/accessors/6/type",
            "MAT4",
            &sampler("input"),
            json!(6),
        ),
    ]
}
