// SPDX-License-Identifier: GPL-3.0-or-later
//! Geometries and their parameters. Source: ANARI 1.1, KHR_GEOMETRY_*. Tests: tests/introspection.rs.

use super::entry::{COLORS, Entry, Parameter, entry, list, number, p, word};
use crate::types as t;

const NORMALS: [t::DataType; 2] = [t::FLOAT32_VEC3, t::FIXED16_VEC3];
const TANGENTS: [t::DataType; 4] = [t::FLOAT32_VEC3, t::FIXED16_VEC3, t::FLOAT32_VEC4, t::FIXED16_VEC4];

/// Attributes of the whole geometry.
pub(super) fn constant() -> Vec<Parameter> {
    let one = |name| p(name, &[t::FLOAT32_VEC4], "Attribute of all that has no finer one");
    ["color", "attribute0", "attribute1", "attribute2", "attribute3"].map(one).to_vec()
}

macro_rules! rate {
    ($prefix:literal, $about:literal) => {
        vec![
            list(concat!($prefix, ".color"), &COLORS, $about),
            list(concat!($prefix, ".attribute0"), &COLORS, $about),
            list(concat!($prefix, ".attribute1"), &COLORS, $about),
            list(concat!($prefix, ".attribute2"), &COLORS, $about),
            list(concat!($prefix, ".attribute3"), &COLORS, $about),
        ]
    };
}

fn primitive() -> Vec<Parameter> {
    let id = list(
        "primitive.id",
        &[t::UINT32, t::UINT64],
        "Numbers in the channel of ids, in place of the count from 0",
    )
    .by("KHR_FRAME_CHANNEL_PRIMITIVE_ID");
    [rate!("primitive", "Attribute of each primitive"), vec![id]].concat()
}

fn vertex() -> Vec<Parameter> {
    let position = list("vertex.position", &[t::FLOAT32_VEC3], "Vertices, object space").needed();
    [vec![position], rate!("vertex", "Attribute of each vertex, interpolated")].concat()
}

/// Parameters that triangles and quads share.
fn faces(index: [t::DataType; 2]) -> Vec<Parameter> {
    let own = vec![
        list("vertex.normal", &NORMALS, "Shading normals, of any length"),
        list(
            "vertex.tangent",
            &TANGENTS,
            "Tangents of normal maps; the fourth number is the side of the bitangent",
        ),
        list("faceVarying.normal", &NORMALS, "Shading normals of each corner"),
        list("faceVarying.tangent", &TANGENTS, "Tangents of each corner"),
        list("primitive.index", &index, "Vertices of each primitive; without it they follow each other"),
    ];
    [constant(), primitive(), vertex(), rate!("faceVarying", "Attribute of each corner"), own].concat()
}

fn caps() -> Vec<Parameter> {
    vec![
        list("vertex.cap", &[t::UINT8], "Whether each end is closed, beside what 'caps' says"),
        word("caps", &["none", "first", "second", "both"], "Ends that are closed by a disc"),
    ]
}

fn segments() -> Parameter {
    let index = [t::UINT32_VEC2, t::UINT64_VEC2];
    list("primitive.index", &index, "The two ends of each primitive; without it they follow each other")
}

fn single(about: &'static str) -> Parameter {
    list("primitive.index", &[t::UINT32, t::UINT64], about)
}

fn radii() -> Vec<Parameter> {
    vec![
        list("vertex.radius", &[t::FLOAT32], "Radius at each vertex"),
        number("radius", 1.0, "Radius where there are no finer ones").least(0.0),
    ]
}

/// All geometries.
pub(super) fn entries() -> Vec<Entry> {
    let of = |subtype, extension, about, parameters: &[Vec<Parameter>]| {
        entry(t::GEOMETRY, subtype, extension, about, parameters.concat())
    };
    let rates = [constant(), primitive(), vertex()].concat();
    let isovalue = Parameter {
        types: vec![t::FLOAT32, t::ARRAY1D],
        ..list("isovalue", &[t::FLOAT32], "Values of the surfaces; each is a primitive").needed()
    };
    vec![
        of(
            "cone",
            "KHR_GEOMETRY_CONE",
            "Cones, cut or pointed, between two vertices",
            &[
                rates.clone(),
                vec![
                    segments(),
                    list("vertex.radius", &[t::FLOAT32], "Radius at each vertex"),
                    number("radius", 1.0, "Radius where there are no finer ones").least(0.0),
                ],
                caps(),
            ],
        ),
        of(
            "curve",
            "KHR_GEOMETRY_CURVE",
            "Round, straight pieces between neighbouring vertices",
            &[
                rates.clone(),
                vec![single("First vertex of each piece; without it all vertices make one curve")],
                radii(),
            ],
        ),
        of(
            "cylinder",
            "KHR_GEOMETRY_CYLINDER",
            "Cylinders between two vertices",
            &[
                rates.clone(),
                vec![
                    segments(),
                    list("primitive.radius", &[t::FLOAT32], "Radius of each cylinder"),
                    number("radius", 1.0, "Radius where there are no finer ones").least(0.0),
                ],
                caps(),
            ],
        ),
        of(
            "isosurface",
            "KHR_GEOMETRY_ISOSURFACE",
            "Surfaces of equal value of a field",
            &[constant(), primitive(), vec![isovalue, p("field", &[t::SPATIAL_FIELD], "The field").needed()]],
        ),
        of(
            "quad",
            "KHR_GEOMETRY_QUAD",
            "Quadrilaterals, two triangles each",
            &[faces([t::UINT32_VEC4, t::UINT64_VEC4])],
        ),
        of(
            "sphere",
            "KHR_GEOMETRY_SPHERE",
            "Spheres around vertices",
            &[
                rates,
                vec![single("Vertex of each sphere; without it there is one around each vertex")],
                radii(),
            ],
        ),
        of(
            "triangle",
            "KHR_GEOMETRY_TRIANGLE",
            "Triangles, counter-clockwise from the front",
            &[faces([t::UINT32_VEC3, t::UINT64_VEC3])],
        ),
    ]
}
