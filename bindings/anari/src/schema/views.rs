// SPDX-License-Identifier: GPL-3.0-or-later
//! The device, cameras, renderers and frames and their parameters. Source: ANARI 1.1; parameters of GNU_* extensions are our own.
//! Tests: tests/introspection.rs.

use super::entry::{COLORS, Entry, Parameter, Values, entry, number, p, truth, vector, word};
use super::moving::{MOTIONS, motion};
use crate::types as t;

fn camera(subtype: &'static str, extension: &'static str, about: &'static str, own: Vec<Parameter>) -> Entry {
    let lens = "KHR_CAMERA_DEPTH_OF_FIELD";
    let all = vec![
        vector("position", "point", [0.0; 3], "Where it is"),
        vector("direction", "direction", [0.0, 0.0, -1.0], "Where it looks"),
        vector("up", "direction", [0.0, 1.0, 0.0], "Upwards in the picture"),
        p("imageRegion", &[t::FLOAT32_BOX2], "Part of the picture that the frame shows")
            .or(&[0.0, 0.0, 1.0, 1.0]),
        number("apertureRadius", 0.0, "Of the lens; 0 = all is sharp").least(0.0).by(lens),
        number("focusDistance", 1.0, "Of what is sharp").least(0.0).by(lens),
        p("shutter", &[t::FLOAT32_BOX1], "When the shutter opens and closes")
            .or(&[0.5; 2])
            .by("KHR_CAMERA_SHUTTER"),
    ];
    let all = all.into_iter().chain(motion("KHR_CAMERA_MOTION_TRANSFORMATION", &MOTIONS));
    let all: Vec<Parameter> = all.collect();
    entry(t::CAMERA, subtype, extension, about, [all, own].concat())
}

fn planes() -> Vec<Parameter> {
    vec![
        p("aspect", &[t::FLOAT32], "Width over height; by default the frame's"),
        p("near", &[t::FLOAT32], "Distance of the nearest that is seen"),
        p("far", &[t::FLOAT32], "Distance of the farthest that is seen"),
    ]
}

/// Parameters of all renderers.
fn common() -> Vec<Parameter> {
    let background = Parameter {
        types: vec![t::FLOAT32_VEC4, t::FLOAT32_VEC3, t::ARRAY2D],
        extension: "KHR_RENDERER_BACKGROUND_COLOR",
        ..p("background", &[], "Colour or picture behind all")
            .or(&[0.0, 0.0, 0.0, 1.0])
            .means("color")
            .of(&COLORS)
    };
    vec![
        background,
        p(
            "pixelSamples",
            &[t::INT32],
            "Samples of a pixel in each frame; if unset 16, or 4 where frames add up",
        )
        .or_whole(16)
        .by("GNU_RENDERER"),
        truth("premultiplyBackground", false, "Whether the background's colour is multiplied by its opacity")
            .by("GNU_RENDERER"),
    ]
}

fn ambient() -> Vec<Parameter> {
    vec![
        vector("ambientColor", "color", [1.0; 3], "Colour of the light from everywhere")
            .by("KHR_RENDERER_AMBIENT_LIGHT"),
        number("ambientRadiance", 0.0, "Its radiance, W/(sr m2)").by("KHR_RENDERER_AMBIENT_LIGHT"),
    ]
}

fn whole(name: &'static str, default: u64, about: &'static str) -> Parameter {
    p(name, &[t::INT32], about).or_whole(default).by("GNU_RENDERER")
}

fn renderers() -> Vec<Entry> {
    let path = vec![
        truth("denoise", false, "Whether noise is taken out").by("KHR_RENDERER_DENOISE"),
        whole("maxDepth", 8, "Most pieces of a path from the camera to a light"),
    ];
    let ao = vec![
        whole("aoSamples", 1, "Rays that look for occlusion, of each sample"),
        number("aoDistance", f32::INFINITY, "Distance beyond which nothing occludes").by("GNU_RENDERER"),
    ];
    let methods = [
        "normal",
        "geometricNormal",
        "albedo",
        "primitiveId",
        "objectId",
        "instanceId",
        "depth",
        "uv",
        "backFace",
    ];
    let debug = vec![word("method", &methods, "What is shown").by("GNU_RENDERER")];
    vec![
        entry(t::RENDERER, "default", "", "All light, by paths", [common(), ambient(), path].concat()),
        entry(
            t::RENDERER,
            "ao",
            "GNU_RENDERER",
            "Albedo under light from everywhere",
            [common(), ambient(), ao].concat(),
        ),
        entry(t::RENDERER, "eyelight", "GNU_RENDERER", "Albedo, lit from the eye", common()),
        entry(
            t::RENDERER,
            "debug",
            "GNU_RENDERER",
            "Numbers of what is seen, as colours",
            [common(), debug].concat(),
        ),
    ]
}

fn frame() -> Entry {
    let channel = |name, extension, types: &[t::DataType]| Parameter {
        values: Values::Types(types.to_vec()),
        extension,
        ..p(name, &[t::DATA_TYPE], "Format of the channel; unset = there is none")
    };
    let callback = "KHR_FRAME_COMPLETION_CALLBACK";
    entry(
        t::FRAME,
        "",
        "",
        "A picture",
        vec![
            p("world", &[t::WORLD], "What is seen").needed(),
            p("renderer", &[t::RENDERER], "By what means").needed(),
            p("camera", &[t::CAMERA], "From where").needed(),
            p("size", &[t::UINT32_VEC2], "Columns and rows").needed(),
            channel("channel.color", "", &[t::UFIXED8_VEC4, t::UFIXED8_RGBA_SRGB, t::FLOAT32_VEC4]),
            channel("channel.depth", "", &[t::FLOAT32]),
            channel("channel.normal", "KHR_FRAME_CHANNEL_NORMAL", &[t::FIXED16_VEC3, t::FLOAT32_VEC3]),
            channel(
                "channel.albedo",
                "KHR_FRAME_CHANNEL_ALBEDO",
                &[t::UFIXED8_VEC3, t::UFIXED8_RGB_SRGB, t::FLOAT32_VEC3],
            ),
            channel("channel.primitiveId", "KHR_FRAME_CHANNEL_PRIMITIVE_ID", &[t::UINT32]),
            channel("channel.objectId", "KHR_FRAME_CHANNEL_OBJECT_ID", &[t::UINT32]),
            channel("channel.instanceId", "KHR_FRAME_CHANNEL_INSTANCE_ID", &[t::UINT32]),
            truth("accumulation", false, "Whether renderings of the same add up")
                .by("KHR_FRAME_ACCUMULATION"),
            p("frameCompletionCallback", &[t::FRAME_COMPLETION_CALLBACK], "Called when a rendering ends")
                .by(callback),
            p("frameCompletionCallbackUserData", &[t::VOID_POINTER], "Given to it").by(callback),
        ],
    )
}

fn device() -> Entry {
    entry(
        t::DEVICE,
        "",
        "",
        "Path tracing on all cores",
        vec![
            p("statusCallback", &[t::STATUS_CALLBACK], "Called with messages"),
            p("statusCallbackUserData", &[t::VOID_POINTER], "Given to it"),
            p("threads", &[t::INT32], "Threads that render; 0 = one for each core")
                .or_whole(0)
                .by("GNU_DEVICE_THREADS"),
        ],
    )
}

/// All of them.
pub(super) fn entries() -> Vec<Entry> {
    let angle = number("fovy", std::f32::consts::FRAC_PI_3, "Vertical angle of view, radians");
    let height = number("height", 1.0, "Height of what the picture shows");
    let layout = word("layout", &["equirectangular"], "Projection");
    let mut all = vec![
        device(),
        camera("omnidirectional", "KHR_CAMERA_OMNIDIRECTIONAL", "All directions", vec![layout]),
        camera("orthographic", "KHR_CAMERA_ORTHOGRAPHIC", "Parallel rays", [vec![height], planes()].concat()),
        camera(
            "perspective",
            "KHR_CAMERA_PERSPECTIVE",
            "Rays from a point or a lens",
            [vec![angle], planes()].concat(),
        ),
        frame(),
    ];
    all.extend(renderers());
    all
}
