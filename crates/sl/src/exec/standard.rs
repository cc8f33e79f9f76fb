// SPDX-License-Identifier: GPL-3.0-or-later
//! The closures of OSL and MaterialX with their parameters, Blender's toon and hair, and `radiance`.
//! Source: the OSL specification, chapter 7.10, and its MaterialX closures.
//! Tests: crates/sl/tests/closures.rs, against `stdosl.h`.

use super::components::{ClosureDecl, ClosureParam};
use crate::types::{Base, Type};
use std::sync::LazyLock;

/// A parameter is its type's letter and its name: `N` is a normal, `V` a vector, `F` a float, `I` an int, `C` a colour, `S` a
/// text, `K` a closure. Those after the bar are keywords.
const TABLE: [(&str, &str); 34] = [
    ("emission", ""),
    ("background", ""),
    ("radiance", ""),
    ("diffuse", "N:N"),
    ("oren_nayar", "N:N F:sigma"),
    ("translucent", "N:N"),
    ("phong", "N:N F:exponent"),
    ("ward", "N:N V:T F:ax F:ay"),
    ("microfacet", "S:distribution N:N V:U F:xalpha F:yalpha F:eta I:refract"),
    ("reflection", "N:N F:eta"),
    ("refraction", "N:N F:eta"),
    ("transparent", ""),
    ("debug", "S:tag"),
    ("holdout", ""),
    ("subsurface", "F:eta F:g C:mfp C:albedo"),
    ("oren_nayar_diffuse_bsdf", "N:N C:albedo F:roughness | I:energy_compensation"),
    ("burley_diffuse_bsdf", "N:N C:albedo F:roughness"),
    (
        "dielectric_bsdf",
        "N:N V:U C:reflection_tint C:transmission_tint F:roughness_x F:roughness_y F:ior S:distribution \
         | F:thinfilm_thickness F:thinfilm_ior I:thin_walled",
    ),
    (
        "conductor_bsdf",
        "N:N V:U F:roughness_x F:roughness_y C:ior C:extinction S:distribution \
         | F:thinfilm_thickness F:thinfilm_ior I:multiscatter",
    ),
    (
        "generalized_schlick_bsdf",
        "N:N V:U C:reflection_tint C:transmission_tint F:roughness_x F:roughness_y C:f0 C:f90 F:exponent \
         S:distribution | F:thinfilm_thickness F:thinfilm_ior I:multiscatter",
    ),
    ("translucent_bsdf", "N:N C:albedo"),
    ("transparent_bsdf", ""),
    ("subsurface_bssrdf", "N:N C:albedo C:radius F:anisotropy | F:ior"),
    ("sheen_bsdf", "N:N C:albedo F:roughness | I:mode"),
    (
        "chiang_hair_bsdf",
        "N:N V:curve_direction C:tint_R C:tint_TT C:tint_TRT F:ior F:longitudual_roughness_R \
         F:longitudual_roughness_TT F:longitudual_roughness_TRT F:azimuthal_roughness_R F:azimuthal_roughness_TT \
         F:azimuthal_roughness_TRT F:cuticle_angle C:absorption_coefficient",
    ),
    ("diffuse_toon", "N:N F:size F:smooth"),
    ("glossy_toon", "N:N F:size F:smooth"),
    ("hair_reflection", "N:N F:roughnessu F:roughnessv V:T F:offset"),
    ("hair_transmission", "N:N F:roughnessu F:roughnessv V:T F:offset"),
    (
        "huang_hair_bsdf",
        "N:N V:curve_direction V:major_axis C:tint_R C:tint_TT C:tint_TRT C:tint_rest F:ior F:roughness \
         F:aspect_ratio F:cuticle_angle F:random C:absorption_coefficient",
    ),
    ("uniform_edf", "C:emittance"),
    ("anisotropic_vdf", "C:albedo C:extinction F:anisotropy"),
    ("medium_vdf", "C:albedo F:transmission_depth C:transmission_color F:anisotropy F:ior I:priority"),
    ("layer", "K:top K:base"),
];

static ALL: LazyLock<Vec<ClosureDecl>> = LazyLock::new(|| {
    let param = |text: &str, is_keyword: bool| {
        let (code, name) = text.split_once(':').unwrap_or_default();
        let base = match code {
            "N" => Base::Normal,
            "V" => Base::Vector,
            "F" => Base::Float,
            "I" => Base::Int,
            "C" => Base::Color,
            "K" => Base::Closure,
            _ => Base::String,
        };
        ClosureParam { name: name.into(), ty: Type::of(base), is_keyword }
    };
    let decl = |(name, params): (&str, &str)| {
        let (plain, keywords) = params.split_once('|').unwrap_or((params, ""));
        let plain = plain.split_whitespace().map(|text| param(text, false));
        let all = plain.chain(keywords.split_whitespace().map(|text| param(text, true)));
        ClosureDecl { name: name.into(), params: all.collect() }
    };
    TABLE.into_iter().map(decl).collect()
});

/// All of them, always in the same order: what most renderers return from [`Host::closures`](super::Host::closures). Each prints
/// as its declaration, with the names of its parameters.
#[must_use]
pub fn standard_closures() -> &'static [ClosureDecl] {
    &ALL
}
