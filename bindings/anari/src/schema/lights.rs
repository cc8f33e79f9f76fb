// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights and their parameters. Source: ANARI 1.1, KHR_LIGHT_*. Tests: tests/introspection.rs.

use super::entry::{Entry, Parameter, entry, number, p, truth, vector, word};
use crate::types as t;

fn color() -> Parameter {
    vector("color", "color", [1.0; 3], "Multiplied to the light").share()
}

fn visible() -> Parameter {
    truth("visible", true, "Whether the camera sees it").by("KHR_LIGHT_PRIMARY_VISIBILITY")
}

/// A quantity that counts before others where it is set.
fn quantity(name: &'static str, about: &'static str) -> Parameter {
    p(name, &[t::FLOAT32], about)
}

fn intensity() -> Parameter {
    number("intensity", 1.0, "W/sr, of the whole light")
}

fn position() -> Parameter {
    vector("position", "point", [0.0; 3], "Where it is")
}

fn direction() -> Parameter {
    vector("direction", "direction", [0.0, 0.0, -1.0], "Where its light goes")
}

fn cone() -> [Parameter; 2] {
    [
        number("openingAngle", std::f32::consts::PI, "Full angle of the cone, radians"),
        number("falloffAngle", 0.1, "Angle between the cone's edge and full intensity, radians"),
    ]
}

fn distribution() -> Parameter {
    let types = [t::ARRAY1D, t::ARRAY2D];
    let about = "Factors by the angle to the axis, and for two dimensions around it";
    p("intensityDistribution", &types, about).of(&[t::FLOAT32])
}

/// All lights.
pub(super) fn entries() -> Vec<Entry> {
    let [opening, falloff] = cone();
    let radiance = || quantity("radiance", "W/(sr m2); counts before power and intensity");
    let power = || quantity("power", "W in all; counts before intensity");
    let texels = p("radiance", &[t::ARRAY2D], "Latitude-longitude picture").of(&[t::FLOAT32_VEC3]).needed();
    let of = |subtype, extension, about, own: Vec<Parameter>| {
        entry(t::LIGHT, subtype, extension, about, [vec![color(), visible()], own].concat())
    };
    vec![
        of(
            "directional",
            "KHR_LIGHT_DIRECTIONAL",
            "Parallel light",
            vec![
                number("irradiance", 1.0, "W/m2 on a surface that faces it"),
                direction(),
                number(
                    "angularDiameter",
                    0.0,
                    "Seen from a surface, radians; shadows are sharp all the same",
                ),
                quantity("radiance", "W/(sr m2) of a disc of that diameter; counts before irradiance"),
            ],
        ),
        of(
            "hdri",
            "KHR_LIGHT_HDRI",
            "Light from all around",
            vec![
                p("up", &[t::FLOAT32_VEC3], "Where the first row of the picture lies")
                    .or(&[0.0, 0.0, 1.0])
                    .means("direction"),
                vector("direction", "direction", [1.0, 0.0, 0.0], "Where the picture's middle lies"),
                texels,
                word("layout", &["equirectangular"], "Projection of the picture"),
                number("scale", 1.0, "Multiplied to the radiance"),
            ],
        ),
        of(
            "point",
            "KHR_LIGHT_POINT",
            "A point or a ball",
            vec![
                position(),
                intensity(),
                power(),
                number("radius", 0.0, "Of a ball; 0 = a point").least(0.0),
                radiance(),
            ],
        ),
        of(
            "quad",
            "KHR_LIGHT_QUAD",
            "A parallelogram",
            vec![
                position(),
                vector("edge1", "vector", [1.0, 0.0, 0.0], "One side"),
                vector("edge2", "vector", [0.0, 1.0, 0.0], "The other side; edge1 x edge2 is its front"),
                intensity(),
                power(),
                radiance(),
                word("side", &["front", "back", "both"], "Sides that shine"),
                distribution(),
            ],
        ),
        of(
            "ring",
            "KHR_LIGHT_RING",
            "A disc or a ring with a cone of light",
            vec![
                position(),
                direction(),
                opening.clone(),
                falloff.clone(),
                intensity(),
                power(),
                number("radius", 0.0, "Outer radius; 0 = a point").least(0.0),
                number("innerRadius", 0.0, "Radius of the hole").least(0.0),
                radiance(),
                distribution(),
                vector("c0", "direction", [1.0, 0.0, 0.0], "Where the distribution's first column lies"),
            ],
        ),
        of(
            "spot",
            "KHR_LIGHT_SPOT",
            "A point with a cone of light",
            vec![position(), direction(), opening, falloff, intensity(), power()],
        ),
    ]
}
