// SPDX-License-Identifier: GPL-3.0-or-later
//! Fields, volumes, surfaces, groups, instances and worlds and their parameters. Source: ANARI 1.1. Tests: tests/introspection.rs.

use super::entry::{COLORS, Entry, Parameter, entry, list, number, p, truth, vector, word};
use super::geometries::constant;
use super::moving::{MOTIONS, motion};
use crate::types as t;

const UNIT: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
const FIELD: [t::DataType; 5] = [t::UFIXED8, t::FIXED16, t::UFIXED16, t::FLOAT32, t::FLOAT64];
const OBJECT_ID: &str = "KHR_FRAME_CHANNEL_OBJECT_ID";
const INSTANCE_ID: &str = "KHR_FRAME_CHANNEL_INSTANCE_ID";

fn id(extension: &'static str) -> Parameter {
    p("id", &[t::UINT32], "Number in the channel of ids").or_whole(u64::from(u32::MAX)).by(extension)
}

fn contents() -> Vec<Parameter> {
    vec![
        list("surface", &[t::SURFACE], "Surfaces"),
        list("volume", &[t::VOLUME], "Volumes"),
        list("light", &[t::LIGHT], "Lights"),
    ]
}

fn volume() -> Vec<Parameter> {
    let color = Parameter {
        types: vec![t::FLOAT32_VEC4, t::FLOAT32_VEC3, t::ARRAY1D],
        ..list("color", &COLORS, "Colours over the range").or(&[1.0; 4]).means("color")
    };
    let opacity = Parameter {
        types: vec![t::FLOAT32, t::ARRAY1D],
        ..list("opacity", &[t::FLOAT32], "Opacities over the range, of the unit distance").or(&[1.0])
    };
    vec![
        truth("visible", true, "Whether it is there"),
        p("value", &[t::SPATIAL_FIELD], "The field").needed(),
        p("valueRange", &[t::FLOAT32_BOX1, t::FLOAT64_BOX1], "Values of the first and the last colour")
            .or(&[0.0, 1.0]),
        color,
        opacity,
        number("unitDistance", 1.0, "Way that the opacities are meant for"),
        id(OBJECT_ID),
    ]
}

/// All of them.
pub(super) fn entries() -> Vec<Entry> {
    let field = vec![
        p("data", &[t::ARRAY3D], "Values at the points of a grid").of(&FIELD).needed(),
        vector("origin", "point", [0.0; 3], "The first point, object space"),
        vector("spacing", "vector", [1.0; 3], "From point to point along each axis"),
        word("filter", &["linear", "nearest", "cubic"], "Values between points"),
    ];
    let sparse = vec![
        p("data", &[t::ARRAY1D], "A grid of NanoVDB as it lies in memory").of(&[t::UINT8]).needed(),
        word("filter", &["linear", "nearest", "cubic"], "Values between points"),
    ];
    let surface = vec![
        p("geometry", &[t::GEOMETRY], "Shape").needed(),
        p("material", &[t::MATERIAL], "Look").needed(),
        truth("visible", true, "Whether it is there"),
        id(OBJECT_ID),
    ];
    let transform = p(
        "transform",
        &[t::FLOAT32_MAT4, t::ARRAY1D],
        "From the group to the world; an array makes as many instances",
    )
    .or(&UNIT)
    .of(&[t::FLOAT32_MAT4]);
    let ids = Parameter { types: vec![t::UINT32, t::ARRAY1D], ..id(INSTANCE_ID).of(&[t::UINT32]) };
    let each = Parameter {
        types: vec![t::FLOAT32_VEC4, t::ARRAY1D],
        ..p("", &[], "Attribute in place of the geometry's; an array has one for each transform")
    };
    let attributes =
        constant().into_iter().map(|own| Parameter { name: own.name, ..each.clone().of(&COLORS) });
    let group = p("group", &[t::GROUP], "What is shown").needed();
    let attributes: Vec<Parameter> = attributes.collect();
    let of_all = [vec![group, ids], attributes].concat();
    let instance = [vec![transform], of_all.clone()].concat();
    let moving = |extension: &'static str, kinds: &[&'static str]| {
        let still =
            p("transform", &[t::FLOAT32_MAT4], "From the group to the world, without motion").or(&UNIT);
        [vec![still], motion(extension, kinds), of_all.clone()].concat()
    };
    let world =
        [vec![list("instance", &[t::INSTANCE], "Instances")], contents(), vec![id(INSTANCE_ID)]].concat();
    let array = || vec![];
    let region = p("region", &[t::UINT64_REGION1], "Elements that count, first and one beyond the last")
        .by("KHR_ARRAY1D_REGION");
    vec![
        entry(t::ARRAY1D, "", "", "A list", vec![region]),
        entry(t::ARRAY2D, "", "", "Rows, the lowest first", array()),
        entry(t::ARRAY3D, "", "", "Slices of rows", array()),
        entry(
            t::SPATIAL_FIELD,
            "structuredRegular",
            "KHR_SPATIAL_FIELD_STRUCTURED_REGULAR",
            "Values on a regular grid",
            field,
        ),
        entry(t::SPATIAL_FIELD, "nanovdb", "KHR_SPATIAL_FIELD_NANOVDB", "Values on a sparse grid", sparse),
        entry(
            t::VOLUME,
            "transferFunction1D",
            "KHR_VOLUME_TRANSFER_FUNCTION1D",
            "A field seen through colours and opacities",
            volume(),
        ),
        entry(t::SURFACE, "", "", "A geometry with a material", surface),
        entry(t::GROUP, "", "", "Surfaces, volumes and lights that go together", contents()),
        entry(t::INSTANCE, "transform", "KHR_INSTANCE_TRANSFORM", "A group put somewhere", instance),
        entry(
            t::INSTANCE,
            "motionTransform",
            "KHR_INSTANCE_MOTION_TRANSFORM",
            "A group that moves by matrices",
            moving("KHR_INSTANCE_MOTION_TRANSFORM", &MOTIONS[..1]),
        ),
        entry(
            t::INSTANCE,
            "motionScaleRotationTranslation",
            "KHR_INSTANCE_MOTION_SCALE_ROTATION_TRANSLATION",
            "A group that moves by scales, rotations and translations",
            moving("KHR_INSTANCE_MOTION_SCALE_ROTATION_TRANSLATION", &MOTIONS[1..]),
        ),
        entry(t::WORLD, "", "", "All that is seen", world),
    ]
}
