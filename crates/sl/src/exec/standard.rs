// SPDX-License-Identifier: GPL-3.0-or-later
//! The closures of OSL and MaterialX with their parameters, Blender's toon and hair, and `radiance`.
//! Source: the OSL specification, chapter 7.10, and its MaterialX closures. Tests: crates/sl-shading/tests/scripts/closures.rs.

use super::components::{ClosureDecl, ClosureParam};
use crate::types::{Base, Type};
use std::sync::LazyLock;

/// `V` is a vector, `F` a float, `I` an int, `C` a colour, `S` a text, `K` a closure. Keyword arguments: `~`
/// a thin film's thickness (nanometres) and index, and the fate of light between microfacets. `+` whether
/// multiple scattering between microfacets is added. `?` the name of the model. `|` a film and whether both
/// sides of a pane are one surface.
const TABLE: [(&str, &str); 34] = [
    ("emission", ""),
    ("background", ""),
    ("radiance", ""),
    ("diffuse", "V"),
    ("oren_nayar", "VF"),
    ("translucent", "V"),
    ("phong", "VF"),
    ("ward", "VVFF"),
    ("microfacet", "SVVFFFI"),
    ("reflection", "VF"),
    ("refraction", "VF"),
    ("transparent", ""),
    ("debug", "S"),
    ("holdout", ""),
    ("subsurface", "FFCC"),
    ("oren_nayar_diffuse_bsdf", "VCF+"),
    ("burley_diffuse_bsdf", "VCF"),
    ("dielectric_bsdf", "VVCCFFFS|"),
    ("conductor_bsdf", "VVFFCCS~"),
    ("generalized_schlick_bsdf", "VVCCFFCCFS~"),
    ("translucent_bsdf", "VC"),
    ("transparent_bsdf", ""),
    ("subsurface_bssrdf", "VCCF>"),
    ("sheen_bsdf", "VCF?"),
    ("chiang_hair_bsdf", "VVCCCFFFFFFFFC"),
    ("diffuse_toon", "VFF"),
    ("glossy_toon", "VFF"),
    ("hair_reflection", "VFFVF"),
    ("hair_transmission", "VFFVF"),
    ("huang_hair_bsdf", "VVVCCCCFFFFFC"),
    ("uniform_edf", "C"),
    ("anisotropic_vdf", "CCF"),
    ("medium_vdf", "CFCFFI"),
    ("layer", "KK"),
];

static ALL: LazyLock<Vec<ClosureDecl>> = LazyLock::new(|| {
    let param = |code: char| {
        let base = match code {
            'V' => Base::Vector,
            'F' => Base::Float,
            'I' => Base::Int,
            'C' => Base::Color,
            'K' => Base::Closure,
            _ => Base::String,
        };
        ClosureParam { ty: Type::of(base), key: None }
    };
    let key = |name: &str, base| ClosureParam { ty: Type::of(base), key: Some(name.into()) };
    let decl = |(name, codes): (&str, &str)| {
        let plain = codes.trim_end_matches(['~', '+', '?', '|', '>']);
        let named = match &codes[plain.len()..] {
            "~" => vec![
                key("thinfilm_thickness", Base::Float),
                key("thinfilm_ior", Base::Float),
                key("multiscatter", Base::Int),
            ],
            "|" => vec![
                key("thinfilm_thickness", Base::Float),
                key("thinfilm_ior", Base::Float),
                key("thin_walled", Base::Int),
            ],
            "+" => vec![key("energy_compensation", Base::Int)],
            "?" => vec![key("mode", Base::Int)],
            ">" => vec![key("ior", Base::Float)],
            _ => Vec::new(),
        };
        ClosureDecl { name: name.into(), params: plain.chars().map(param).chain(named).collect() }
    };
    TABLE.into_iter().map(decl).collect()
});

/// All of them, always in the same order: what most renderers return from [`Host::closures`](super::Host::closures).
#[must_use]
pub fn standard_closures() -> &'static [ClosureDecl] {
    &ALL
}
