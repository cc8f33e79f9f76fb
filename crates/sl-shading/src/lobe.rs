// SPDX-License-Identifier: GPL-3.0-or-later
//! From one closure of a point to its lobes.
//! The closures are defined by the OSL specification and MaterialX, the lobes' models by
//! docs/reference/materials.md. Differs from other renderers: microfacets of MaterialX's closures are GGX
//! under any distribution's name.
//! Space: world. Tests: `tests/scripts/closures.rs`.

use std::f32::consts::FRAC_PI_2;

use glam::{Vec2, Vec3};
use gnurt_shading::bsdf::{BetweenFacets, Film, Lobe};
use gnurt_shading::{ColorMap, Interior};
use gnurt_sl::exec::{Cells, Part, WELL_KNOWN};

use crate::closures::{Known, Shape};

/// Microfacets of less roughness are mirrors.
pub(crate) const SMOOTH: f32 = 1e-3;

/// The parameters of a component at a point, by index.
pub(crate) struct Params<'a> {
    shape: &'a Shape,
    part: &'a Part<'a>,
    lane: usize,
    map: ColorMap,
}

impl Shape {
    /// The index of the normal among the parameters.
    pub(crate) fn normal(&self) -> Option<usize> {
        match self.known {
            Known::Subsurface => None,
            Known::Microfacet => Some(1),
            _ => Some(0),
        }
    }

    /// The slots of the direction of anisotropy and of the widths.
    pub(crate) fn anisotropy_slots(&self) -> Option<[usize; 3]> {
        match self.known {
            Known::Ward | Known::Conductor => Some([1, 2, 3]),
            Known::Microfacet => Some([2, 3, 4]),
            Known::Dielectric | Known::Schlick => Some([1, 4, 5]),
            _ => None,
        }
    }
}

impl<'a> Params<'a> {
    /// Colours among them are converted by `map`.
    pub(crate) fn new(shape: &'a Shape, part: &'a Part<'a>, lane: usize, map: ColorMap) -> Self {
        Self { shape, part, lane, map }
    }

    /// Whether all parameters of the lobe, except its normal, are the same for all points.
    pub(crate) fn are_one(shape: &Shape, part: &Part<'_>) -> bool {
        if shape.known == Known::RoughHair {
            // Its section lies by the normal.
            return false;
        }
        let one = |slot: usize| {
            let mut numbers = shape.firsts[slot]..shape.firsts[slot + 1];
            numbers.all(|i| matches!(part.cells(i), Cells::One(_)))
        };
        // The direction is irrelevant if both widths are equal.
        let along = shape.anisotropy_slots().filter(|[_, x, y]| {
            matches!((part.cells(shape.firsts[*x]), part.cells(shape.firsts[*y])), (Cells::One(x), Cells::One(y)) if x == y)
        });
        let left_out = [shape.normal(), along.map(|anisotropy_slots| anisotropy_slots[0])];
        (0..shape.firsts.len() - 1).all(|slot| left_out.contains(&Some(slot)) || one(slot))
    }

    fn bits_of(&self, i: usize, k: usize) -> u32 {
        self.part.cells(self.shape.firsts[i] + k).at(self.lane)
    }

    /// A number; 0 if it is none.
    fn float(&self, i: usize) -> f32 {
        Some(f32::from_bits(self.bits_of(i, 0))).filter(|x| x.is_finite()).unwrap_or(0.0)
    }

    pub(crate) fn vec3(&self, i: usize) -> Vec3 {
        let of = |k: usize| f32::from_bits(self.bits_of(i, k));
        let v = Vec3::new(of(0), of(1), of(2));
        if v.is_finite() { v } else { Vec3::ZERO }
    }

    /// A colour.
    pub(crate) fn color(&self, i: usize) -> Vec3 {
        self.map.of(self.vec3(i))
    }

    /// A share of light per channel.
    fn share(&self, i: usize) -> Vec3 {
        self.map.of(self.vec3(i).clamp(Vec3::ZERO, Vec3::ONE))
    }

    fn int(&self, i: usize) -> i32 {
        self.bits_of(i, 0) as i32
    }

    /// Whether a microfacet distribution is Beckmann's, which is that of `default`, too.
    fn is_beckmann(&self, i: usize) -> bool {
        let number = self.bits_of(i, 0) as usize;
        number.checked_sub(1).is_some_and(|slot| slot < WELL_KNOWN.len())
    }

    /// Roughness of microfacets.
    fn slopes(&self) -> Slopes {
        let Some([tangent, x, y]) = self.shape.anisotropy_slots() else { return Slopes::even(0.0) };
        let (along, across) = (self.float(x).clamp(0.0, 1.0), self.float(y).clamp(0.0, 1.0));
        Slopes { tangent: self.vec3(tangent), along, across }
    }

    /// Light between microfacets: 0 leaves to all sides, 1 leaves as light of one bounce, 2 is lost, 3 is as 1 with the reflectance of
    /// the facets that are seen.
    fn between_facets(&self) -> BetweenFacets {
        match self.int(self.shape.plain + 2) {
            1 => BetweenFacets::Scaled,
            2 => BetweenFacets::Lost,
            3 => BetweenFacets::Seen,
            _ => BetweenFacets::Spread,
        }
    }

    /// The film of MaterialX's closures; one without a thickness is none.
    fn film(&self) -> Film {
        let (thickness, ior) = (self.float(self.shape.plain), self.float(self.shape.plain + 1));
        Film {
            share: f32::from(u8::from(thickness > 0.0)),
            ior: if ior > 0.0 { ior } else { 1.0 },
            thickness,
        }
    }
}

/// How wide microfacets' slopes are.
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

    /// The lobe made for one width, with both. Without a direction, slopes have the mean width.
    fn of(self, make: impl FnOnce(f32) -> Lobe) -> Lobe {
        let (along, across) = (self.along.clamp(SMOOTH, 1.0), self.across.clamp(SMOOTH, 1.0));
        match self.tangent.try_normalize() {
            Some(tangent) if along != across => make(along).brushed(tangent, across),
            _ => make((along * across).sqrt()),
        }
    }
}

fn fresnel_at_normal(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// Glass by the index beyond over the index on the side that the ray came from.
fn glass(slopes: Slopes, eta: f32, reflectance: Vec3, transmittance: Vec3) -> Lobe {
    glass_or_pane(slopes, eta, reflectance, transmittance, false)
}

fn glass_or_pane(slopes: Slopes, eta: f32, reflectance: Vec3, transmittance: Vec3, thin: bool) -> Lobe {
    let eta = if eta > 0.0 { 1.0 / eta } else { 1.0 };
    if slopes.is_smooth() {
        Lobe::glass(eta, reflectance, transmittance, thin)
    } else {
        slopes.of(|alpha| Lobe::rough_glass(alpha, eta, reflectance, transmittance, thin))
    }
}

fn microfacets(slopes: Slopes, f0: Vec3, f90: Vec3) -> Lobe {
    slopes.of(|alpha| Lobe::microfacets(alpha, f0, f90))
}

/// The lobes of a closure, at most three, each around the point's normal; `front` = the ray came from the side
/// of the mesh's normal.
pub(crate) fn lobes(p: &Params, front: bool) -> [Option<Lobe>; 4] {
    let one = match p.shape.known {
        Known::Diffuse => Lobe::lambert(Vec3::ONE),
        Known::OrenNayar => Lobe::oren_nayar_once(Vec3::ONE, p.float(1).clamp(0.0, 1.0)),
        Known::OrenNayarDiffuse if p.int(3) != 0 => Lobe::oren_nayar(p.share(1), p.float(2).clamp(0.0, 1.0)),
        Known::OrenNayarDiffuse => Lobe::oren_nayar_once(p.share(1), p.float(2).clamp(0.0, 1.0)),
        Known::Burley => Lobe::burley(p.share(1), p.float(2).clamp(0.0, 1.0)),
        Known::Subsurface => Lobe::subsurface(p.share(3), p.color(2), p.float(1), p.float(0)),
        Known::SubsurfaceBssrdf => {
            Lobe::subsurface(p.share(1), p.color(2), p.float(3), p.float(p.shape.plain))
        }
        Known::Translucent => Lobe::translucent(Vec3::ONE),
        Known::TranslucentBsdf => Lobe::translucent(p.share(1)),
        Known::Sheen if p.int(3) == 1 => Lobe::fibres(p.share(1), p.float(2).clamp(0.0, 1.0).sqrt()),
        // Its roughness is the square of glTF's.
        Known::Sheen => Lobe::sheen(p.share(1), p.float(2).clamp(0.0, 1.0).sqrt()),
        Known::Phong => Lobe::phong(p.float(1)),
        Known::Ward => p.slopes().of(Lobe::ward),
        Known::Microfacet => microfacet(p),
        Known::Reflection => match p.float(1) {
            eta if eta <= 0.0 => Lobe::mirror(Vec3::ONE),
            eta => glass(Slopes::even(0.0), eta, Vec3::ONE, Vec3::ZERO),
        },
        Known::Refraction => glass(Slopes::even(0.0), p.float(1), Vec3::ZERO, Vec3::ONE),
        Known::Dielectric => {
            let index = Some(p.float(6)).filter(|&index| index > 0.0).unwrap_or(1.0);
            let (slopes, reflectance, transmittance) = (p.slopes(), p.share(2), p.share(3));
            // A coat has no inside: rays from behind the mesh meet it from the outside, too, smooth or rough.
            let outside = front || transmittance == Vec3::ZERO;
            let eta = if outside { index } else { 1.0 / index };
            if transmittance == Vec3::ZERO && !slopes.is_smooth() {
                let f0 = Vec3::splat(fresnel_at_normal(index));
                tinted(microfacets(slopes, f0, Vec3::ONE).filmed(p.film()), reflectance)
            } else {
                let thin = transmittance != Vec3::ZERO && p.int(p.shape.plain + 2) != 0;
                glass_or_pane(slopes, eta, reflectance, transmittance, thin).filmed(p.film())
            }
        }
        Known::Conductor => {
            let (eta, k) = p.map.metal(p.vec3(4).max(Vec3::splat(1e-3)), p.vec3(5).max(Vec3::ZERO));
            p.slopes()
                .of(|alpha| Lobe::metal(alpha, eta, k))
                .filmed(p.film())
                .between_facets(p.between_facets())
        }
        Known::Schlick => return schlick(p, front),
        Known::Hair => return hair(p),
        Known::RoughHair => return rough_hair(p),
        Known::Toon | Known::GlossyToon => {
            // Shares of a right angle.
            let [size, border] = [p.float(1), p.float(2)].map(|share| FRAC_PI_2 * share.clamp(0.0, 1.0));
            Lobe::toon(p.shape.known == Known::GlossyToon, size, border)
        }
        Known::HairReflection | Known::HairTransmission => {
            let through = p.shape.known == Known::HairTransmission;
            Lobe::strand(through, p.vec3(3), [p.float(1), p.float(2)], p.float(4))
        }
        _ => return [None; 4],
    };
    [Some(one), None, None, None]
}

/// The medium of a volume closure.
pub(crate) fn interior(p: &Params) -> Interior {
    let albedo = p.share(0);
    let (extinction, anisotropy) = match p.shape.known {
        Known::MediumVdf => {
            let (depth, left) = (p.float(1), p.share(2).max(Vec3::splat(1e-6)));
            // Black twice is no medium, as in OSL's renderer: it only has an index.
            let is_empty = albedo == Vec3::ZERO && p.share(2) == Vec3::ZERO;
            let most = if depth > 0.0 && !is_empty { left.map(|x| -x.ln()) / depth } else { Vec3::ZERO };
            (most, p.float(3))
        }
        _ => (p.color(1), p.float(2)),
    };
    let extinction = if extinction.is_finite() { extinction.max(Vec3::ZERO) } else { Vec3::ZERO };
    let scattering = extinction * albedo;
    Interior { absorption: extinction - scattering, scattering, anisotropy: anisotropy.clamp(-0.99, 0.99) }
}

/// A hair: a lobe for each of its terms. Scales of the distribution around it are those before the factor of \[CBTB16\].
fn hair(p: &Params) -> [Option<Lobe>; 4] {
    let absorption = p.color(13).max(Vec3::ZERO);
    let (index, tilt) = (p.float(5).max(1.0), p.float(12));
    let [first, second, third] = [0, 1, 2].map(|term| {
        let scale = (std::f32::consts::PI / 8.0).sqrt() * p.float(9 + term);
        let widths = [p.float(6 + term), scale];
        let mut lobe = Lobe::hair(term as u32, p.vec3(1), absorption, widths, [index, tilt]);
        lobe.weight = p.share(2 + term);
        Some(lobe)
    });
    [first, second, third, None]
}

/// A hair as a rough cylinder: a lobe for each of its terms.
fn rough_hair(p: &Params) -> [Option<Lobe>; 4] {
    let absorption = p.color(12).max(Vec3::ZERO);
    let numbers = [p.float(8), p.float(7), p.float(10), p.float(9)];
    let (normal, tangent) = (p.vec3(0).normalize_or_zero(), p.vec3(1).normalize_or_zero());
    let major = p.vec3(2);
    let major = Vec2::new(major.dot(normal.cross(tangent)), major.dot(normal));
    [0, 1, 2, 3].map(|term| {
        let mut lobe = Lobe::rough_fibre(term as u32, tangent, absorption, numbers, major, p.float(11));
        lobe.weight = p.share(3 + term);
        Some(lobe)
    })
}

/// Microfacets that reflect, refract or both, by the number of the last parameter.
fn microfacet(p: &Params) -> Lobe {
    let (slopes, eta) = (p.slopes(), p.float(5));
    let [mirrored, through] = match p.int(6) {
        0 => [1.0, 0.0],
        1 => [0.0, 1.0],
        _ => [1.0, 1.0],
    }
    .map(Vec3::splat);
    if eta <= 0.0 && p.int(6) == 0 {
        // Without an index all light is reflected.
        return if p.is_beckmann(0) {
            slopes.of(|alpha| Lobe::beckmann(alpha, 0.0, mirrored, through))
        } else {
            microfacets(slopes, Vec3::ONE, Vec3::ONE)
        };
    }
    if p.is_beckmann(0) && !slopes.is_smooth() {
        let eta = if eta > 0.0 { 1.0 / eta } else { 1.0 };
        return slopes.of(|alpha| Lobe::beckmann(alpha, eta, mirrored, through));
    }
    glass(slopes, eta, mirrored, through)
}

/// Microfacets under Schlick's reflectances; with transmission, a lobe for each of reflection and
/// transmission.
fn schlick(p: &Params, front: bool) -> [Option<Lobe>; 4] {
    let (slopes, [f0, f90], power, tint) = (p.slopes(), [p.share(6), p.share(7)], p.float(8), p.share(2));
    let through = p.share(3);
    if through == Vec3::ZERO {
        let lobe = microfacets(slopes, f0, f90).risen(power).filmed(p.film());
        return [Some(tinted(lobe.between_facets(p.between_facets()), tint)), None, None, None];
    }
    let root = (f0.element_sum() / 3.0).min(0.99).sqrt();
    let index = (1.0 + root) / (1.0 - root);
    let eta = if front { 1.0 / index } else { index };
    let part = |weight: Vec3, through: bool| {
        let mut lobe = slopes.of(|alpha| Lobe::schlick_glass(alpha, eta, [f0, f90], power, through));
        lobe.weight = weight;
        lobe.filmed(p.film())
    };
    [Some(part(tint, false)), Some(part(through, true)), None, None]
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
