// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials and samplers and their parameters. Source: ANARI 1.1, KHR_MATERIAL_*, KHR_SAMPLER_*.
//! Tests: tests/introspection.rs.

use super::entry::{ATTRIBUTES, COLORS, Entry, Parameter, Values, entry, list, number, p, vector, word};
use crate::types as t;

const UNIT: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// A number, an attribute or a sampler.
fn scalar(name: &'static str, default: f32, about: &'static str) -> Parameter {
    let types = [t::FLOAT32, t::SAMPLER, t::STRING];
    Parameter { values: Values::Texts(ATTRIBUTES.to_vec()), ..p(name, &types, about).or(&[default]) }
}

/// A colour, an attribute or a sampler.
fn color(name: &'static str, default: [f32; 3], about: &'static str) -> Parameter {
    let types = [t::FLOAT32_VEC3, t::SAMPLER, t::STRING];
    let values = Values::Texts(ATTRIBUTES.to_vec());
    Parameter { values, ..p(name, &types, about).or(&default).means("color") }
}

fn alpha() -> Vec<Parameter> {
    vec![
        scalar("opacity", 1.0, "Share of light that the surface stops").share(),
        word("alphaMode", &["opaque", "blend", "mask"], "Meaning of the opacity"),
        number("alphaCutoff", 0.5, "Smallest opacity that is there, of 'mask'").share(),
    ]
}

fn materials() -> Vec<Entry> {
    let map = |name, about| p(name, &[t::SAMPLER], about);
    let pbr = vec![
        color("baseColor", [1.0; 3], "Albedo of plastic, reflectance of metal"),
        scalar("metallic", 1.0, "0 = plastic or glass, 1 = metal").share(),
        scalar("roughness", 1.0, "Perceptual roughness").share(),
        map("normal", "Normals in tangent space, 2 value - 1"),
        color("emissive", [0.0; 3], "Radiance that leaves both sides"),
        map("occlusion", "Read by rasterisers; rays find occlusion by themselves"),
        scalar("specular", 0.0, "Factor of the plastic's reflectance").share(),
        color("specularColor", [1.0; 3], "Colour of that reflectance, seen upright"),
        scalar("clearcoat", 0.0, "How much of a clear coat there is").share(),
        scalar("clearcoatRoughness", 0.0, "Its perceptual roughness").share(),
        map("clearcoatNormal", "Normals of the coat, in tangent space"),
        scalar("transmission", 0.0, "Share of the plastic that is glass").share(),
        scalar("ior", 1.5, "Index of refraction").least(1.0),
        scalar("thickness", 0.0, "0 = glass is a pane, more = it has an inside").least(0.0),
        number("attenuationDistance", f32::INFINITY, "Way in glass after which the colour below is left"),
        vector("attenuationColor", "color", [1.0; 3], "Light that is left after that way"),
        color("sheenColor", [0.0; 3], "Colour of the sheen of cloth"),
        scalar("sheenRoughness", 0.0, "Its perceptual roughness").share(),
        scalar("iridescence", 0.0, "How much of a thin film there is").share(),
        number("iridescenceIor", 1.3, "Its index of refraction").least(1.0),
        scalar("iridescenceThickness", 0.0, "Its thickness, nanometres").least(0.0),
    ];
    let matte = vec![color("color", [0.8; 3], "Albedo")];
    vec![
        entry(t::MATERIAL, "matte", "KHR_MATERIAL_MATTE", "Lambertian reflector", [matte, alpha()].concat()),
        entry(
            t::MATERIAL,
            "physicallyBased",
            "KHR_MATERIAL_PHYSICALLY_BASED",
            "glTF's metal, plastic and glass with coat, sheen and film",
            [pbr, alpha()].concat(),
        ),
    ]
}

fn input() -> Vec<Parameter> {
    let attribute = word("inAttribute", &ATTRIBUTES, "Attribute that is read");
    vec![
        attribute,
        p("inTransform", &[t::FLOAT32_MAT4], "Applied to the attribute").or(&UNIT),
        p("inOffset", &[t::FLOAT32_VEC4], "Added to it").or(&[0.0; 4]),
    ]
}

fn output() -> Vec<Parameter> {
    vec![
        p("outTransform", &[t::FLOAT32_MAT4], "Applied to the result").or(&UNIT),
        p("outOffset", &[t::FLOAT32_VEC4], "Added to it").or(&[0.0; 4]),
    ]
}

fn image(
    subtype: &'static str,
    extension: &'static str,
    array: t::DataType,
    wraps: &[&'static str],
) -> Entry {
    let about = "Texels";
    let elements =
        [&COLORS[..], &[t::FIXED8_VEC3, t::FIXED8_VEC4, t::FIXED16_VEC3, t::FIXED16_VEC4]].concat();
    let texels = p("image", &[array], about).of(&elements).needed();
    let wrap = |&name: &&'static str| {
        word(name, &["clampToEdge", "repeat", "mirrorRepeat", "clampToBorder"], "Beyond 0 and 1")
    };
    let border = p("borderColor", &[t::FLOAT32_VEC4], "Value beyond the border")
        .or(&[0.0; 4])
        .means("color")
        .by("KHR_SAMPLER_IMAGExD_CLAMP_TO_BORDER");
    let own = vec![texels, word("filter", &["linear", "nearest"], "Values between texels"), border];
    let all = [own, wraps.iter().map(wrap).collect(), input(), output()].concat();
    entry(t::SAMPLER, subtype, extension, "Values of a picture", all)
}

fn samplers() -> Vec<Entry> {
    let of_primitive = vec![
        list("array", &COLORS, "Value of each primitive").needed(),
        p("inOffset", &[t::UINT64], "Added to the primitive's number").or_whole(0),
    ];
    let own = word("inAttribute", &ATTRIBUTES, "Attribute that is read");
    let old = p("transform", &[t::FLOAT32_MAT4], "An older name of outTransform").or(&UNIT);
    let transform = [vec![own, old], output()].concat();
    vec![
        image("image1D", "KHR_SAMPLER_IMAGE1D", t::ARRAY1D, &["wrapMode"]),
        image("image2D", "KHR_SAMPLER_IMAGE2D", t::ARRAY2D, &["wrapMode1", "wrapMode2"]),
        image("image3D", "KHR_SAMPLER_IMAGE3D", t::ARRAY3D, &["wrapMode1", "wrapMode2", "wrapMode3"]),
        entry(t::SAMPLER, "primitive", "KHR_SAMPLER_PRIMITIVE", "A value for each primitive", of_primitive),
        entry(t::SAMPLER, "transform", "KHR_SAMPLER_TRANSFORM", "An attribute, transformed", transform),
    ]
}

/// All materials and samplers.
pub(super) fn entries() -> Vec<Entry> {
    [materials(), samplers()].concat()
}
