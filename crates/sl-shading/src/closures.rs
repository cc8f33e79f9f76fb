// SPDX-License-Identifier: GPL-3.0-or-later
//! The closures that the renderer knows: all of OSL's, MaterialX's among them, and `radiance`.
//! Source: the OSL specification, chapter 7.10, and its MaterialX closures; what becomes of each is in `parts`.
//! Proof: `tests/scripts/closures.rs`.

use std::sync::LazyLock;

use gnurt_sl::exec::{ClosureDecl, ClosureParam};
use gnurt_sl::types::{Base, Type};

/// `V` is a vector, `F` a float, `I` an int, `C` a colour, `S` a text, `K` a closure; `~` a thin film's thickness (nanometres) and
/// index, given by name.
const TABLE: [(&str, &str); 29] = [
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
    ("oren_nayar_diffuse_bsdf", "VCF"),
    ("burley_diffuse_bsdf", "VCF"),
    ("dielectric_bsdf", "VVCCFFFS~"),
    ("conductor_bsdf", "VVFFCCS~"),
    ("generalized_schlick_bsdf", "VVCCFFCCFS~"),
    ("translucent_bsdf", "VC"),
    ("transparent_bsdf", ""),
    ("subsurface_bssrdf", "VCCF"),
    ("sheen_bsdf", "VCF"),
    ("chiang_hair_bsdf", "VVCCCFFFFFFFFC"),
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
    let film = ["thinfilm_thickness", "thinfilm_ior"]
        .map(|name| ClosureParam { ty: Type::of(Base::Float), key: Some(name.into()) });
    let decl = |(name, codes): (&str, &str)| {
        let (plain, films) = codes.split_once('~').map_or((codes, false), |(plain, _)| (plain, true));
        let named = film.iter().filter(|_| films).cloned();
        ClosureDecl { name: name.into(), params: plain.chars().map(param).chain(named).collect() }
    };
    TABLE.into_iter().map(decl).collect()
});

/// What a closure takes.
pub(crate) fn find(name: &str) -> Option<&'static ClosureDecl> {
    ALL.iter().find(|closure| &*closure.name == name)
}
