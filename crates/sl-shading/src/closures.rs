// SPDX-License-Identifier: GPL-3.0-or-later
//! The closures that the renderer supports: all of OSL's, MaterialX's among them, Blender's toon and hair, and `radiance`.
//! `parts` converts each of them.
//! Tests: `tests/scripts/closures.rs`.

use std::sync::LazyLock;

use gnurt_sl::exec::{ClosureDecl, standard_closures};

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
    Toon,
    GlossyToon,
    HairReflection,
    HairTransmission,
    RoughHair,
    /// What lies behind the surface.
    AnisotropicVdf,
    MediumVdf,
    /// A share of the surface that is a hole in the picture.
    Holdout,
    /// A colour for a layer, without an appearance.
    Debug,
}

/// The counterparts of [`standard_closures`], by name.
const KNOWN: [(Known, &str); 34] = [
    (Known::Emission, "emission"),
    (Known::Emission, "background"),
    (Known::Radiance, "radiance"),
    (Known::Diffuse, "diffuse"),
    (Known::OrenNayar, "oren_nayar"),
    (Known::Translucent, "translucent"),
    (Known::Phong, "phong"),
    (Known::Ward, "ward"),
    (Known::Microfacet, "microfacet"),
    (Known::Reflection, "reflection"),
    (Known::Refraction, "refraction"),
    (Known::Transparent, "transparent"),
    (Known::Debug, "debug"),
    (Known::Holdout, "holdout"),
    (Known::Subsurface, "subsurface"),
    (Known::OrenNayarDiffuse, "oren_nayar_diffuse_bsdf"),
    (Known::Burley, "burley_diffuse_bsdf"),
    (Known::Dielectric, "dielectric_bsdf"),
    (Known::Conductor, "conductor_bsdf"),
    (Known::Schlick, "generalized_schlick_bsdf"),
    (Known::TranslucentBsdf, "translucent_bsdf"),
    (Known::Transparent, "transparent_bsdf"),
    (Known::SubsurfaceBssrdf, "subsurface_bssrdf"),
    (Known::Sheen, "sheen_bsdf"),
    (Known::Hair, "chiang_hair_bsdf"),
    (Known::Toon, "diffuse_toon"),
    (Known::GlossyToon, "glossy_toon"),
    (Known::HairReflection, "hair_reflection"),
    (Known::HairTransmission, "hair_transmission"),
    (Known::RoughHair, "huang_hair_bsdf"),
    (Known::UniformEdf, "uniform_edf"),
    (Known::AnisotropicVdf, "anisotropic_vdf"),
    (Known::MediumVdf, "medium_vdf"),
    (Known::Layer, "layer"),
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

static SHAPES: LazyLock<Vec<Shape>> = LazyLock::new(|| {
    let shape = |decl: &ClosureDecl| {
        let known =
            KNOWN.iter().find(|(_, name)| *name == &*decl.name).expect("the tables have the same names").0;
        let mut firsts = vec![0];
        for param in decl.params.iter() {
            firsts.push(firsts.last().copied().unwrap_or(0) + param.ty.size());
        }
        Shape { known, firsts, plain: decl.params.iter().filter(|param| !param.is_keyword).count() }
    };
    standard_closures().iter().map(shape).collect()
});

/// All of them, and their counterparts.
pub(crate) fn all() -> (&'static [ClosureDecl], &'static [Shape]) {
    (standard_closures(), &SHAPES)
}
