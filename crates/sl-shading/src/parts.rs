// SPDX-License-Identifier: GPL-3.0-or-later
//! From a closure to what a point does to light: weighted lobes, light that it gives off, light that goes straight through.
//! Source: original; what the closures are is in the OSL specification and MaterialX, the lobes' models are in docs/materials.md.
//! Differs from other renderers: facets are GGX whatever the distribution's name; light below the surface (`subsurface`, `subsurface_bssrdf`) is scattered where it enters; hair and volumes are not drawn.
//! Space: world. Proof: `tests/scripts/closures.rs`.

use std::sync::Arc;

use glam::Vec3;
use gnurt_shading::SurfaceBatch;
use gnurt_shading::bsdf::{Film, Lobe, Lobes, MOST};
use gnurt_sl::exec::{Closure, Component, parts};
use gnurt_sl::hir::Data;

/// Widths of facets below this are mirrors.
const SMOOTH: f32 = 1e-3;
/// Layers may lie on each other this deep.
const DEEPEST: u32 = 16;

/// What a point does to light.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Parts {
    pub(crate) lobes: Lobes,
    /// Light that it gives off.
    pub(crate) emission: Vec3,
    /// Share of light that goes straight through.
    pub(crate) through: Vec3,
    /// What the shader has worked out itself.
    pub(crate) radiance: Vec3,
    /// A lobe was left out.
    pub(crate) is_full: bool,
}

/// The point whose closures are looked at.
#[derive(Clone, Copy)]
pub(crate) struct At {
    /// Unit geometric normal, towards where the ray came from.
    pub(crate) ng: Vec3,
    /// Unit shading normal, likewise.
    pub(crate) ns: Vec3,
    /// Whether the ray came from the side of the mesh's normal.
    pub(crate) front: bool,
}

impl At {
    pub(crate) fn lane(hits: &SurfaceBatch, i: usize) -> Self {
        Self { ng: hits.facing_ng(i), ns: hits.facing_ns(i), front: hits.front(i) }
    }
}

/// The parameters of a component, by their places.
struct Params<'a>(&'a [(Option<Arc<str>>, gnurt_sl::types::Type, Data)]);

impl Params<'_> {
    fn floats(&self, i: usize) -> &[f32] {
        match self.0.get(i) {
            Some((_, _, Data::Float(list))) => list,
            _ => &[],
        }
    }

    /// A number; 0 if it is none.
    fn float(&self, i: usize) -> f32 {
        self.floats(i).first().copied().filter(|x| x.is_finite()).unwrap_or(0.0)
    }

    fn vec3(&self, i: usize) -> Vec3 {
        match self.floats(i) {
            &[x, y, z, ..] => Some(Vec3::new(x, y, z)).filter(|v| v.is_finite()).unwrap_or(Vec3::ZERO),
            _ => Vec3::ZERO,
        }
    }

    /// A share of light per channel.
    fn share(&self, i: usize) -> Vec3 {
        self.vec3(i).clamp(Vec3::ZERO, Vec3::ONE)
    }

    fn int(&self, i: usize) -> i32 {
        match self.0.get(i) {
            Some((_, _, Data::Int(list))) => list.first().copied().unwrap_or(0),
            _ => 0,
        }
    }

    /// Widths of facets along a direction and across it.
    fn slopes(&self, tangent: Option<usize>, x: usize, y: usize) -> Slopes {
        let [along, across] = [x, y].map(|i| self.float(i).clamp(0.0, 1.0));
        Slopes { tangent: tangent.map_or(Vec3::ZERO, |i| self.vec3(i)), along, across }
    }

    /// A number that is given by name; 0 if it is not.
    fn named(&self, name: &str) -> f32 {
        let place = self.0.iter().position(|(key, ..)| key.as_deref() == Some(name));
        place.map_or(0.0, |i| self.float(i))
    }

    /// The film of MaterialX's closures; one without a thickness is none.
    fn film(&self) -> Film {
        let (thickness, ior) = (self.named("thinfilm_thickness"), self.named("thinfilm_ior"));
        Film {
            share: f32::from(u8::from(thickness > 0.0)),
            ior: if ior > 0.0 { ior } else { 1.0 },
            thickness,
        }
    }
}

/// How wide facets' slopes are.
#[derive(Clone, Copy)]
struct Slopes {
    tangent: Vec3,
    along: f32,
    across: f32,
}

impl Slopes {
    fn even(alpha: f32) -> Self {
        Self { tangent: Vec3::ZERO, along: alpha, across: alpha }
    }

    fn is_smooth(self) -> bool {
        self.along.max(self.across) < SMOOTH
    }

    /// The lobe that is made for one width, with both. Where nobody says along what, slopes are as wide on average.
    fn of(self, make: impl FnOnce(f32) -> Lobe) -> Lobe {
        let [along, across] = [self.along, self.across].map(|alpha| alpha.clamp(SMOOTH, 1.0));
        match self.tangent.try_normalize() {
            Some(tangent) if along != across => make(along).brushed(tangent, across),
            _ => make((along * across).sqrt()),
        }
    }
}

/// All of a closure: node `number`, counted from 1.
pub(crate) fn of(nodes: &[Closure], number: u32, at: At) -> Parts {
    tree(nodes, number, at, 0)
}

fn tree(nodes: &[Closure], number: u32, at: At, depth: u32) -> Parts {
    let mut all = Parts::default();
    if depth > DEEPEST {
        return all;
    }
    for (weight, component) in parts(nodes, number) {
        let weight = Vec3::from(weight).max(Vec3::ZERO);
        // Light without end, and what is no number, is none.
        if !weight.is_finite() || weight == Vec3::ZERO {
            continue;
        }
        let part = one(nodes, component, at, depth);
        all.emission += part.emission * weight;
        all.through += part.through * weight;
        all.radiance += part.radiance * weight;
        all.is_full |= part.is_full;
        let lobes = part.lobes.times(weight);
        all.is_full |= all.lobes.as_slice().len() + lobes.as_slice().len() > MOST;
        all.lobes = all.lobes.plus(lobes);
    }
    all
}

/// The normal that a lobe lies around; zero where it is that of the point.
fn normal(n: Vec3, at: At) -> Vec3 {
    let Some(n) = n.try_normalize() else { return Vec3::ZERO };
    let n = if n.dot(at.ng) < 0.0 { -n } else { n };
    if n.dot(at.ns) > 1.0 - 1e-6 { Vec3::ZERO } else { n }
}

fn fresnel_at_normal(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// Glass by the index beyond over the index on the side that the ray came from.
fn glass(slopes: Slopes, eta: f32, reflectance: Vec3, transmittance: Vec3) -> Lobe {
    let eta = if eta > 0.0 { 1.0 / eta } else { 1.0 };
    if slopes.is_smooth() {
        Lobe::glass(eta, reflectance, transmittance, false)
    } else {
        slopes.of(|alpha| Lobe::rough_glass(alpha, eta, reflectance, transmittance, false))
    }
}

fn facets(slopes: Slopes, f0: Vec3, f90: Vec3) -> Lobe {
    slopes.of(|alpha| Lobe::facets(alpha, f0, f90))
}

fn one(nodes: &[Closure], component: &Component, at: At, depth: u32) -> Parts {
    let p = Params(&component.params);
    let mut out = Parts::default();
    let around = |mut lobe: Lobe, n: usize| {
        lobe.normal = normal(p.vec3(n), at);
        Lobes::from(lobe)
    };
    let lobes = match &*component.name {
        "emission" | "background" => {
            out.emission = Vec3::ONE;
            return out;
        }
        "uniform_edf" => {
            out.emission = p.vec3(0).max(Vec3::ZERO);
            return out;
        }
        "radiance" => {
            out.radiance = Vec3::ONE;
            return out;
        }
        "transparent" | "transparent_bsdf" => {
            out.through = Vec3::ONE;
            return out;
        }
        "layer" => return layer(nodes, &p, at, depth),
        "diffuse" => around(Lobe::lambert(Vec3::ONE), 0),
        "oren_nayar" => around(Lobe::oren_nayar(Vec3::ONE, p.float(1).clamp(0.0, 1.0)), 0),
        "oren_nayar_diffuse_bsdf" => around(Lobe::oren_nayar(p.share(1), p.float(2).clamp(0.0, 1.0)), 0),
        // Burley's surface of middle roughness is Lambert's; rougher ones send light back as Oren's and Nayar's do.
        "burley_diffuse_bsdf" => {
            around(Lobe::oren_nayar(p.share(1), (2.0 * p.float(2) - 1.0).clamp(0.0, 1.0)), 0)
        }
        "subsurface" => Lobes::from(Lobe::lambert(p.share(3))),
        "subsurface_bssrdf" => around(Lobe::lambert(p.share(1)), 0),
        "translucent" => around(Lobe::translucent(Vec3::ONE), 0),
        "translucent_bsdf" => around(Lobe::translucent(p.share(1)), 0),
        "sheen_bsdf" => around(Lobe::sheen(p.share(1), p.float(2).clamp(0.0, 1.0)), 0),
        // cos^n around the mirror image is cos^4n around the half vector, near it.
        "phong" => {
            let exponent = p.float(1).max(0.0);
            let alpha = (2.0 / (4.0 * exponent + 2.0)).sqrt();
            around(facets(Slopes::even(alpha), Vec3::ONE, Vec3::ONE), 0)
        }
        "ward" => around(facets(p.slopes(Some(1), 2, 3), Vec3::ONE, Vec3::ONE), 0),
        "microfacet" => {
            let (slopes, eta) = (p.slopes(Some(2), 3, 4), p.float(5));
            match p.int(6) {
                0 if eta <= 0.0 => around(facets(slopes, Vec3::ONE, Vec3::ONE), 1),
                0 => around(facets(slopes, Vec3::splat(fresnel_at_normal(eta)), Vec3::ONE), 1),
                1 => around(glass(slopes, eta, Vec3::ZERO, Vec3::ONE), 1),
                _ => around(glass(slopes, eta, Vec3::ONE, Vec3::ONE), 1),
            }
        }
        "reflection" => match p.float(1) {
            eta if eta <= 0.0 => around(Lobe::mirror(Vec3::ONE), 0),
            eta => around(glass(Slopes::even(0.0), eta, Vec3::ONE, Vec3::ZERO), 0),
        },
        "refraction" => around(glass(Slopes::even(0.0), p.float(1), Vec3::ZERO, Vec3::ONE), 0),
        "dielectric_bsdf" => {
            let index = Some(p.float(6)).filter(|&index| index > 0.0).unwrap_or(1.0);
            let eta = if at.front { index } else { 1.0 / index };
            let (slopes, reflectance, transmittance) = (p.slopes(Some(1), 4, 5), p.share(2), p.share(3));
            if transmittance == Vec3::ZERO && !slopes.is_smooth() {
                let f0 = Vec3::splat(fresnel_at_normal(index));
                around(tinted(facets(slopes, f0, Vec3::ONE).filmed(p.film()), reflectance), 0)
            } else {
                around(glass(slopes, eta, reflectance, transmittance).filmed(p.film()), 0)
            }
        }
        "conductor_bsdf" => {
            let (eta, k) = (p.vec3(4).max(Vec3::splat(1e-3)), p.vec3(5).max(Vec3::ZERO));
            let metal = p.slopes(Some(1), 2, 3).of(|alpha| Lobe::metal(alpha, eta, k));
            around(metal.filmed(p.film()), 0)
        }
        "generalized_schlick_bsdf" => {
            let (slopes, f0, tint) = (p.slopes(Some(1), 4, 5), p.share(6), p.share(2));
            let mirrored = facets(slopes, f0, p.share(7)).filmed(p.film());
            let mirrored = around(tinted(mirrored, tint), 0);
            match p.share(3) {
                Vec3::ZERO => mirrored,
                through => {
                    let root = f0.element_sum().max(0.0).mul_add(1.0 / 3.0, 0.0).min(0.99).sqrt();
                    let index = (1.0 + root) / (1.0 - root);
                    let eta = if at.front { index } else { 1.0 / index };
                    mirrored.plus(around(glass(slopes, eta, Vec3::ZERO, through), 0))
                }
            }
        }
        // `debug`, `holdout`, hair and volumes show nothing.
        _ => return out,
    };
    out.lobes = lobes;
    out
}

/// A lobe times a tint. Without a film that is in its reflectances, where layers find it.
fn tinted(mut lobe: Lobe, tint: Vec3) -> Lobe {
    if lobe.film.is_there() {
        lobe.weight = tint;
    } else {
        (lobe.a, lobe.b) = (lobe.a * tint, lobe.b * tint);
    }
    lobe
}

fn layer(nodes: &[Closure], p: &Params, at: At, depth: u32) -> Parts {
    let [top, base] = [0, 1].map(|i| tree(nodes, p.int(i) as u32, at, depth + 1));
    Parts {
        lobes: top.lobes.over(base.lobes),
        emission: top.emission + base.emission,
        // What the layer lets through arrives at what lies below.
        through: base.through,
        radiance: top.radiance + base.radiance,
        is_full: top.is_full
            || base.is_full
            || top.lobes.as_slice().len() + base.lobes.as_slice().len() > MOST,
    }
}
