// SPDX-License-Identifier: GPL-3.0-or-later
//! The closures that the renderer supports: all of OSL's, MaterialX's among them, and `radiance`.
//! Source: the OSL specification, chapter 7.10, and its MaterialX closures; `parts` converts each of them.
//! Tests: `tests/scripts/closures.rs`.

use std::sync::LazyLock;

use gnurt_sl::exec::{ClosureDecl, ClosureParam};
use gnurt_sl::types::{Base, Type};

/// The renderer's counterpart of a closure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Known {
    Emission,
    Radiance,
    UniformEdf,
    Transparent,
    Layer,
    Diffuse,
    OrenNayar,
    OrenNayarDiffuse,
    Burley,
    Subsurface,
    SubsurfaceBssrdf,
    Translucent,
    TranslucentBsdf,
    Sheen,
    Phong,
    Ward,
    Microfacet,
    Reflection,
    Refraction,
    Dielectric,
    Conductor,
    Schlick,
    Hair,
    /// Volumes and closures without an appearance.
    Nothing,
}

/// `V` is a vector, `F` a float, `I` an int, `C` a colour, `S` a text, `K` a closure. Keyword arguments: `~`
/// a thin film's thickness (nanometres) and index, `+` whether multiple scattering between microfacets is
/// added, `?` the name of the model, `|` a film and whether both sides of a pane are one surface.
const TABLE: [(Known, &str, &str); 29] = [
    (Known::Emission, "emission", ""),
    (Known::Emission, "background", ""),
    (Known::Radiance, "radiance", ""),
    (Known::Diffuse, "diffuse", "V"),
    (Known::OrenNayar, "oren_nayar", "VF"),
    (Known::Translucent, "translucent", "V"),
    (Known::Phong, "phong", "VF"),
    (Known::Ward, "ward", "VVFF"),
    (Known::Microfacet, "microfacet", "SVVFFFI"),
    (Known::Reflection, "reflection", "VF"),
    (Known::Refraction, "refraction", "VF"),
    (Known::Transparent, "transparent", ""),
    (Known::Nothing, "debug", "S"),
    (Known::Nothing, "holdout", ""),
    (Known::Subsurface, "subsurface", "FFCC"),
    (Known::OrenNayarDiffuse, "oren_nayar_diffuse_bsdf", "VCF+"),
    (Known::Burley, "burley_diffuse_bsdf", "VCF"),
    (Known::Dielectric, "dielectric_bsdf", "VVCCFFFS|"),
    (Known::Conductor, "conductor_bsdf", "VVFFCCS~"),
    (Known::Schlick, "generalized_schlick_bsdf", "VVCCFFCCFS~"),
    (Known::TranslucentBsdf, "translucent_bsdf", "VC"),
    (Known::Transparent, "transparent_bsdf", ""),
    (Known::SubsurfaceBssrdf, "subsurface_bssrdf", "VCCF"),
    (Known::Sheen, "sheen_bsdf", "VCF?"),
    (Known::Hair, "chiang_hair_bsdf", "VVCCCFFFFFFFFC"),
    (Known::UniformEdf, "uniform_edf", "C"),
    (Known::Nothing, "anisotropic_vdf", "CCF"),
    (Known::Nothing, "medium_vdf", "CFCFFI"),
    (Known::Layer, "layer", "KK"),
];

/// A closure, and where its parameters' numbers are.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub(crate) known: Known,
    /// By parameter, the first of its numbers; then how many there are.
    pub(crate) firsts: Vec<usize>,
    /// Parameters without those that are given by name.
    pub(crate) plain: usize,
}

static ALL: LazyLock<(Vec<ClosureDecl>, Vec<Shape>)> = LazyLock::new(|| {
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
    let decl = |(known, name, codes): (Known, &str, &str)| {
        let plain = codes.trim_end_matches(['~', '+', '?', '|']);
        let named = match &codes[plain.len()..] {
            "~" => vec![key("thinfilm_thickness", Base::Float), key("thinfilm_ior", Base::Float)],
            "|" => vec![
                key("thinfilm_thickness", Base::Float),
                key("thinfilm_ior", Base::Float),
                key("thin_walled", Base::Int),
            ],
            "+" => vec![key("energy_compensation", Base::Int)],
            "?" => vec![key("mode", Base::Int)],
            _ => Vec::new(),
        };
        let params: Vec<ClosureParam> = plain.chars().map(param).chain(named).collect();
        let mut firsts = vec![0];
        for param in &params {
            firsts.push(firsts.last().copied().unwrap_or(0) + param.ty.size());
        }
        let shape = Shape { known, firsts, plain: plain.len() };
        (ClosureDecl { name: name.into(), params }, shape)
    };
    TABLE.into_iter().map(decl).unzip()
});

/// All of them, and their counterparts.
pub(crate) fn all() -> (&'static [ClosureDecl], &'static [Shape]) {
    (&ALL.0, &ALL.1)
}
