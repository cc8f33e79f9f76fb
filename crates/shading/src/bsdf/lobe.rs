// SPDX-License-Identifier: GPL-3.0-or-later
//! One lobe of a BSDF as numbers: its kind, weight, normal and parameters.
//! Source: see the file of each kind. Space: world. Colours are in [0, 1] except for the indices of metals.
//! Numbers that do not depend on directions are computed when a lobe is made, so that they can be stored.
//! Tests: `tests`.

use glam::{Vec2, Vec3};

use super::diffuse_once::Model;
use super::film::{self, Base, Film};
use super::{conductor, fresnel, ggx, phong, rough_dielectric};

/// The kind of a lobe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Nothing.
    #[default]
    None,
    /// Scatters to all sides; rough surfaces send more back to where light came from.
    Diffuse,
    /// GGX microfacets under Schlick's reflectances.
    Microfacets,
    /// GGX microfacets of a metal by its complex index.
    Metal,
    /// GGX microfacets with reflection and refraction.
    Glass,
    /// The same of a pane so thin that light goes through unbent.
    Pane,
    /// Upright fibres.
    Sheen,
    /// Mirrors in one direction.
    Mirror,
    /// Mirrors and refracts, in one direction each.
    SmoothGlass,
    /// The same of a pane.
    SmoothPane,
    /// Scatters to all sides beyond the surface.
    Translucent,
    /// Phong's lobe around the mirror image.
    Phong,
    /// Ward's lobe of brushed surfaces.
    Ward,
    /// Beckmann's microfacets with reflection and refraction, single scattering only.
    Beckmann,
    /// GGX microfacets with reflection and refraction under Schlick's reflectances.
    SchlickGlass,
    /// A layer of fibres that scatter light among them.
    Fibres,
    /// Light that one hair reflects, lets through or lets out later.
    Hair,
    /// A cone of even light around the normal.
    Toon,
    /// A cone of even light around the mirror image.
    GlossyToon,
    /// Light that a strand reflects or lets through, by angles along and around it.
    Strand,
    /// Light that a rough cylinder reflects, lets through or lets out later.
    RoughFibre,
    /// Mirrors in one direction under Schlick's reflectances.
    SmoothFacets,
    /// Mirrors in one direction as a metal by its complex index does.
    SmoothMetal,
}

/// Widths of slopes up to which reflections look like those in mirrors; twice the least width.
pub(super) const POLISHED: f32 = 2.0 * ggx::SMALLEST_ALPHA;

impl Kind {
    /// In the order of their numbers.
    pub(super) const ALL: [Self; 23] = [
        Self::None,
        Self::Diffuse,
        Self::Microfacets,
        Self::Metal,
        Self::Glass,
        Self::Pane,
        Self::Sheen,
        Self::Mirror,
        Self::SmoothGlass,
        Self::SmoothPane,
        Self::Translucent,
        Self::Phong,
        Self::Ward,
        Self::Beckmann,
        Self::SchlickGlass,
        Self::Fibres,
        Self::Hair,
        Self::Toon,
        Self::GlossyToon,
        Self::Strand,
        Self::RoughFibre,
        Self::SmoothFacets,
        Self::SmoothMetal,
    ];

    /// The bits of kinds that mirror in one direction and let nothing through.
    pub(super) const MIRRORS: u32 = Self::Mirror.bit() | Self::SmoothFacets.bit() | Self::SmoothMetal.bit();

    /// The bits of kinds that have no values, only branches.
    pub const DELTAS: u32 = Self::MIRRORS | Self::SmoothGlass.bit() | Self::SmoothPane.bit();

    /// Its bit in a set of kinds.
    #[inline(always)]
    #[must_use]
    pub const fn bit(self) -> u32 {
        1 << self as u32
    }

    /// Whether it has no values, only branches.
    #[must_use]
    pub fn is_delta(self) -> bool {
        Self::DELTAS & self.bit() != 0
    }

    /// Whether it reflects as microfacets or a smooth surface by Schlick's reflectances or a metal's index.
    fn is_reflector(self) -> bool {
        matches!(self, Self::Microfacets | Self::Metal | Self::SmoothFacets | Self::SmoothMetal)
    }

    /// The kind of such lobes for slopes of these widths: too narrow ones are smooth.
    fn for_slopes(self, alpha: f32) -> Self {
        let is_smooth = alpha <= ggx::SMALLEST_ALPHA;
        match self {
            Self::Microfacets | Self::SmoothFacets if is_smooth => Self::SmoothFacets,
            Self::Microfacets | Self::SmoothFacets => Self::Microfacets,
            Self::Metal | Self::SmoothMetal if is_smooth => Self::SmoothMetal,
            Self::Metal | Self::SmoothMetal => Self::Metal,
            other => other,
        }
    }

    /// Whether it sends light to all sides: neither microfacets nor mirrors nor glass.
    #[must_use]
    pub fn is_wide(self) -> bool {
        matches!(self, Self::Diffuse | Self::Translucent | Self::Sheen | Self::Fibres | Self::Toon)
    }

    /// Whether it has microfacets, or a width of slopes.
    fn has_slopes(self) -> bool {
        let is_common = matches!(self, Self::Microfacets | Self::Metal | Self::Glass | Self::Pane);
        is_common || matches!(self, Self::Ward | Self::Beckmann | Self::SchlickGlass)
    }

    /// Whether some of its light goes through the surface.
    #[must_use]
    pub fn goes_through(self) -> bool {
        let is_glass = matches!(self, Self::Glass | Self::Pane | Self::SmoothGlass | Self::SmoothPane);
        is_glass
            || matches!(
                self,
                Self::Translucent
                    | Self::Beckmann
                    | Self::SchlickGlass
                    | Self::Hair
                    | Self::Strand
                    | Self::RoughFibre
            )
    }
}

/// The fate of light that leaves its first microfacet and meets others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BetweenFacets {
    /// It leaves to all sides, in a lobe of its own, as \[KC17\] has it. Reciprocal.
    #[default]
    Spread,
    /// It leaves as light that met one facet, after \[Tur19\] with the colour of \[KC17\]: the lobe is scaled so that white facets keep
    /// all light that comes from one direction. Values are not reciprocal.
    Scaled,
    /// It is lost.
    Lost,
    /// It leaves as light that met one facet, after \[Tur19\] with the reflectance F of that facet, as MaterialX's own code has it. Values
    /// are times 1 + F (1 - E) / E, E the albedo of white facets after one bounce. For brushed facets E is that of even ones of the
    /// geometric mean width, so that white ones lose light, up to a sixth. Values are not reciprocal.
    Seen,
}

/// Rare features of lobes, as bits: lobes without them pay nothing.
pub(super) mod rare {
    /// Microfacets that are wider along one direction than across it.
    pub(crate) const ANISOTROPY: u32 = 1;
    /// A thin film.
    pub(crate) const FILM: u32 = 2;
    /// Indices that differ by colour.
    pub(crate) const SPREAD: u32 = 4;
    /// Reflectances that rise by another power than Schlick's.
    pub(crate) const POWER: u32 = 8;
    /// Microfacets whose light of further bounces is in their own lobe, or lost.
    pub(crate) const SCALED: u32 = 16;
}

/// The power by which Schlick's reflectances rise.
pub(super) const SCHLICK: f32 = 5.0;

/// The index of red, green and blue relative to that of yellow light (587.6 nm), as multiples of the
/// difference between blue-green (486.1 nm) and red light (656.3 nm). By Cauchy's law, at 611, 549 and 464
/// nm, the positions of sRGB's primaries.
const SPREADS: [f32; 3] = [-0.1158, 0.2199, 0.9134];

/// One lobe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobe {
    /// Its kind.
    pub kind: Kind,
    /// Multiplied to it.
    pub weight: Vec3,
    /// Unit normal that it lies around, on the side that the first ray came from; zero = that of its point.
    pub normal: Vec3,
    /// By kind: the albedo; reflectance at normal incidence; index of a metal; tint of reflection.
    pub a: Vec3,
    /// By kind: reflectance at grazing incidence; extinction of a metal; tint of transmission; mean free paths below a
    /// diffuse surface, 0 = light leaves where it enters.
    pub b: Vec3,
    /// Derived from the other parameters: mean reflectance of a metal or under a film; energy lost by rough
    /// glass on this side and beyond, and the share of it that ends beyond. Below a diffuse surface: mean cosine, and index
    /// of refraction.
    pub c: Vec3,
    /// Width of microfacets' slopes, the square of glTF's roughness; the roughness of diffuse and sheen
    /// lobes.
    pub alpha: f32,
    /// Index of refraction on the side that rays come from over the index beyond, > 0. Diffuse lobes: number
    /// of the model, 1 unless it loses light. Microfacets: below 0 the exponent of the rise of reflectance
    /// towards grazing angles, in place of Schlick's fifth. Beckmann's microfacets: 0 if all light is
    /// reflected. Phong: the exponent.
    pub eta: f32,
    /// About where along the surface `alpha` is meant, where slopes have another width across that; unit.
    pub tangent: Vec3,
    /// Width of the slopes across `tangent`; 0 = slopes are alike in all directions.
    pub across: f32,
    /// A film on the microfacets.
    pub film: Film,
    /// Dispersion of glass: its index for blue-green light (486.1 nm) minus that for red (656.3 nm); 0 =
    /// none. Glass under Schlick's reflectances: the exponent of their rise, for reflection; less than 0 for
    /// transmission. Microfacets that reflect: less than 0 if light of further bounces is in the lobe: -1, -2 and -3 are
    /// `BetweenFacets::{Scaled, Lost, Seen}`.
    pub spread: f32,
    /// The fraction of its scattered light that is missing below it, by colours.
    pub(super) cover: Vec3,
    /// Bits of the lobes of its point that lie above it.
    pub(super) layers_above: u32,
}

impl Lobe {
    #[inline]
    fn of(kind: Kind) -> Self {
        Self { kind, weight: Vec3::ONE, eta: 1.0, ..Self::default() }
    }

    /// Lambert's reflector: `albedo` is the share of light that is scattered.
    #[inline]
    #[must_use]
    pub fn lambert(albedo: Vec3) -> Self {
        Self::oren_nayar(albedo, 0.0)
    }

    /// A rough diffuse surface; `albedo` is that of a white furnace, `roughness` is in [0, 1], 0 is Lambert's
    /// reflector.
    #[inline]
    #[must_use]
    pub fn oren_nayar(albedo: Vec3, roughness: f32) -> Self {
        Self { a: albedo, alpha: roughness, ..Self::of(Kind::Diffuse) }
    }

    /// A rough diffuse surface after Oren and Nayar, with single scattering between the microfacets: further
    /// light is lost. `albedo` and `roughness` as for [`oren_nayar`](Self::oren_nayar); 0 is Lambert's
    /// reflector.
    #[must_use]
    pub fn oren_nayar_once(albedo: Vec3, roughness: f32) -> Self {
        let eta = if roughness > 0.0 { Model::OrenNayar.number() } else { 1.0 };
        Self { eta, ..Self::oren_nayar(albedo, roughness) }
    }

    /// Burley's diffuse surface: darker than Lambert's at grazing angles where it is smooth, brighter where
    /// it is rough; `roughness` is in [0, 1].
    #[must_use]
    pub fn burley(albedo: Vec3, roughness: f32) -> Self {
        Self { eta: Model::Burley.number(), ..Self::oren_nayar(albedo, roughness) }
    }

    /// Scatters to all sides beyond the surface, as thin paper does; `albedo` is the share of light that goes
    /// there.
    #[inline]
    #[must_use]
    pub fn translucent(albedo: Vec3) -> Self {
        Self { a: albedo, ..Self::of(Kind::Translucent) }
    }

    /// Lambert's reflector whose light is scattered below it, and leaves elsewhere: `albedo` is the colour of a thick body,
    /// `radius` the mean free path by colour, world units. `anisotropy` is the mean cosine of scattering, in (-1, 1). Light
    /// enters to all sides alike, or bent by the index of refraction `ior` if that is above 1.
    #[must_use]
    pub fn subsurface(albedo: Vec3, radius: Vec3, anisotropy: f32, ior: f32) -> Self {
        let is_sound = |x: f32| if x.is_finite() { x.max(0.0) } else { 0.0 };
        let [x, y, z] = radius.to_array().map(is_sound);
        let anisotropy = if anisotropy.is_finite() { anisotropy.clamp(-0.99, 0.99) } else { 0.0 };
        Self { b: Vec3::new(x, y, z), c: Vec3::new(anisotropy, ior.max(1.0), 0.0), ..Self::lambert(albedo) }
    }

    /// Whether light below it leaves elsewhere.
    #[inline]
    #[must_use]
    pub fn is_subsurface(&self) -> bool {
        self.kind == Kind::Diffuse && self.b != Vec3::ZERO
    }

    /// Microfacets of width `alpha`, in [0, 1], with reflectance `f0` at normal and `f90` at grazing
    /// incidence. Up to 0.001 the surface is smooth: it mirrors in one direction.
    #[must_use]
    pub fn microfacets(alpha: f32, f0: Vec3, f90: Vec3) -> Self {
        Self { a: f0, b: f90, alpha, ..Self::of(Kind::Microfacets.for_slopes(alpha)) }
    }

    /// A metal of width `alpha` by its index of refraction (> 0) and its extinction coefficient (>= 0) per
    /// channel; smooth as [`microfacets`](Self::microfacets) are.
    #[must_use]
    pub fn metal(alpha: f32, eta: Vec3, k: Vec3) -> Self {
        Self { a: eta, b: k, c: conductor::average(eta, k), alpha, ..Self::of(Kind::Metal.for_slopes(alpha)) }
    }

    /// A perfect mirror.
    #[must_use]
    pub fn mirror(reflectance: Vec3) -> Self {
        Self { a: reflectance, ..Self::of(Kind::Mirror) }
    }

    /// Smooth glass, a pane if `thin`; `eta` is the index on the side that rays come from over the index
    /// beyond.
    #[must_use]
    pub fn glass(eta: f32, reflectance: Vec3, transmittance: Vec3, thin: bool) -> Self {
        let (kind, eta) =
            if thin { (Kind::SmoothPane, eta.min(1.0 / eta)) } else { (Kind::SmoothGlass, eta) };
        Self { a: reflectance, b: transmittance, eta, ..Self::of(kind) }
    }

    /// The same with microfacets of width `alpha`, in (0, 1].
    #[must_use]
    pub fn rough_glass(alpha: f32, eta: f32, reflectance: Vec3, transmittance: Vec3, thin: bool) -> Self {
        let (eta, c) = rough_dielectric::losses([alpha; 2], eta, thin);
        let kind = if thin { Kind::Pane } else { Kind::Glass };
        Self { a: reflectance, b: transmittance, c, alpha, eta, ..Self::of(kind) }
    }

    /// Phong's lobe, cos^`exponent` around the mirror image, white; `exponent` >= 0.
    #[must_use]
    pub fn phong(exponent: f32) -> Self {
        Self { eta: phong::exponent(exponent), alpha: phong::alpha(exponent), ..Self::of(Kind::Phong) }
    }

    /// Ward's lobe, white, of slopes of width `alpha`, in (0, 1].
    #[must_use]
    pub fn ward(alpha: f32) -> Self {
        Self { alpha, ..Self::of(Kind::Ward) }
    }

    /// Beckmann's microfacets of width `alpha`, in (0, 1]; `eta` is the index on the side of the ray over the
    /// index beyond, or 0 if all light is reflected. Light of further bounces is lost.
    #[must_use]
    pub fn beckmann(alpha: f32, eta: f32, reflectance: Vec3, transmittance: Vec3) -> Self {
        Self { a: reflectance, b: transmittance, alpha, eta, ..Self::of(Kind::Beckmann) }
    }

    /// Reflection or, if `through`, transmission of rough glass with microfacets of width `alpha`, in (0, 1].
    /// The reflectance is `f0` at normal and `f90` at grazing incidence and rises with `power` (> 0) of one
    /// minus the cosine on the rarer side. `eta` as for [`glass`](Self::glass).
    #[must_use]
    pub fn schlick_glass(alpha: f32, eta: f32, [f0, f90]: [Vec3; 2], power: f32, through: bool) -> Self {
        let (eta, c) = rough_dielectric::losses([alpha; 2], eta, false);
        let power = if power > 0.0 && power.is_finite() { power } else { SCHLICK };
        let spread = if through { -power } else { power };
        Self { a: f0, b: f90, c, alpha, eta, spread, ..Self::of(Kind::SchlickGlass) }
    }

    /// A layer of fibres of a colour that scatter light among them; `roughness` is in [0, 1].
    #[must_use]
    pub fn fibres(color: Vec3, roughness: f32) -> Self {
        Self { weight: color, alpha: roughness, ..Self::of(Kind::Fibres) }
    }

    /// One of the terms of a hair along `tangent`, a unit vector to its tip: 0 what it reflects, 1 what it lets through, 2 what it
    /// lets out after reflections within. All three together are the hair. `variance` is that of angles along it, `scale` that of
    /// the logistic distribution around it, both above 0; `absorption` is for a radius of 1; `index` is over that around
    /// it; `tilt` is the angle of its scales in radians.
    #[must_use]
    pub fn hair(
        term: u32,
        tangent: Vec3,
        absorption: Vec3,
        [variance, scale]: [f32; 2],
        [index, tilt]: [f32; 2],
    ) -> Self {
        let numbers = Vec3::new(term.min(2) as f32, tilt, 0.0);
        let eta = 1.0 / index.max(1.0 + 1e-4);
        let (alpha, across) = (variance.clamp(1e-4, 10.0), scale.clamp(1e-3, 100.0));
        Self { a: absorption, c: numbers, alpha, across, eta, tangent, ..Self::of(Kind::Hair) }
    }

    /// A cone of even light, white: around the normal, or around the mirror image if `glossy`. It ends linearly in a border;
    /// `size` and `border` are angles in radians. The light does not depend on the cosine.
    #[must_use]
    pub fn toon(glossy: bool, size: f32, border: f32) -> Self {
        let kind = if glossy { Kind::GlossyToon } else { Kind::Toon };
        Self { c: Vec3::new(size, border, 0.0), ..Self::of(kind) }
    }

    /// Light that a strand along `tangent`, a unit vector to its tip, reflects, or lets through if `through`; white. `widths` are
    /// those of angles along and around it, above 0; `offset` rotates the lobe, in radians.
    #[must_use]
    pub fn strand(through: bool, tangent: Vec3, [along, around]: [f32; 2], offset: f32) -> Self {
        let c = Vec3::new(f32::from(u8::from(through)), offset, 0.0);
        let [alpha, across] = [along, around].map(|width| width.clamp(1e-3, 100.0));
        Self { c, alpha, across, tangent, ..Self::of(Kind::Strand) }
    }

    /// One of the terms of a hair along `tangent`, a unit vector to its tip, as a rough cylinder. All together are the hair:
    ///
    /// * 0: light that its surface reflects; 1: light that it lets through.
    /// * 2: light that leaves after a reflection within; 3: after further ones.
    ///
    /// `absorption` is for half of the major axis of its section. `alpha` is the width of the microfacets' slopes, `index` is over that
    /// around it. `tilt` is the angle in radians by which normals of its scales lean to the tip. `aspect` in (0, 1] is the minor
    /// axis over the major one. `major` is the direction of the major axis by its parts along the normal x tangent and along the
    /// normal; zero: across the view. `random`, in [0, 1), draws the way of light within. It should be another number at each point.
    #[must_use]
    pub fn rough_fibre(
        term: u32,
        tangent: Vec3,
        absorption: Vec3,
        [alpha, index, tilt, aspect]: [f32; 4],
        major: Vec2,
        random: f32,
    ) -> Self {
        let major = major.normalize_or_zero().extend(aspect.clamp(0.01, 1.0));
        let numbers = Vec3::new(term.min(3) as f32, tilt, random);
        let eta = 1.0 / index.max(1.0 + 1e-3);
        let alpha = alpha.clamp(ggx::SMALLEST_ALPHA, 1.0);
        Self {
            a: absorption,
            b: major,
            c: numbers,
            alpha,
            across: alpha,
            eta,
            tangent,
            ..Self::of(Kind::RoughFibre)
        }
    }

    /// Upright fibres of a colour; `roughness` is glTF's, in [0, 1].
    #[must_use]
    pub fn sheen(color: Vec3, roughness: f32) -> Self {
        Self { weight: color, alpha: roughness, ..Self::of(Kind::Sheen) }
    }

    /// The same with slopes of the width `across` across `tangent` (unit, about along the surface):
    /// microfacets of brushed surfaces. Lobes without microfacets are unchanged.
    #[must_use]
    pub fn brushed(self, tangent: Vec3, across: f32) -> Self {
        let has_slopes = self.kind.has_slopes() || self.kind.is_reflector();
        if !has_slopes || across == self.alpha || !tangent.is_finite() || tangent == Vec3::ZERO {
            return self;
        }
        let kind = self.kind.for_slopes(self.alpha.max(across));
        if kind.is_delta() {
            return self;
        }
        let brushed = Self { kind, tangent, across: across.max(f32::MIN_POSITIVE), ..self };
        match self.kind {
            Kind::Glass | Kind::Pane | Kind::SchlickGlass => {
                let thin = self.kind == Kind::Pane;
                let (eta, c) = rough_dielectric::losses([self.alpha, across], self.eta, thin);
                Self { eta, c, ..brushed }
            }
            _ => brushed,
        }
    }

    /// The same with reflectances that rise from normal to grazing incidence by this power of one minus the
    /// cosine, > 0, in place of Schlick's fifth; other lobes are unchanged.
    #[must_use]
    pub fn risen(self, power: f32) -> Self {
        let is_other = power != SCHLICK && power > 0.0 && power.is_finite();
        let is_schlick = matches!(self.kind, Kind::Microfacets | Kind::SmoothFacets);
        if is_schlick && is_other { Self { eta: -power, ..self } } else { self }
    }

    /// The same with light of further bounces as `light` has it. Lobes other than microfacets that reflect are unchanged.
    #[must_use]
    pub fn between_facets(self, light: BetweenFacets) -> Self {
        if !self.kind.is_reflector() {
            return self;
        }
        let spread = match light {
            BetweenFacets::Spread => 0.0,
            BetweenFacets::Scaled => -1.0,
            BetweenFacets::Lost => -2.0,
            BetweenFacets::Seen => -3.0,
        };
        Self { spread, ..self }
    }

    /// The same under a film. Lobes without microfacets and other than glass are unchanged.
    #[must_use]
    pub fn filmed(self, film: Film) -> Self {
        let is_glass = matches!(
            self.kind,
            Kind::Glass | Kind::Pane | Kind::SmoothGlass | Kind::SmoothPane | Kind::SchlickGlass
        );
        if !(is_glass || self.kind.is_reflector()) || !film.is_there() {
            return self;
        }
        let filmed = Self { film, ..self };
        match self.kind {
            kind if kind.is_reflector() => {
                let bare = match kind {
                    Kind::Metal | Kind::SmoothMetal => self.c,
                    _ => fresnel::schlick_average(self.a.into(), self.b.into()).into(),
                };
                Self { c: bare.lerp(film::average(film, filmed.base()), film.share), ..filmed }
            }
            _ => filmed,
        }
    }

    /// The same for glass whose index is greater by `spread` (>= 0) for blue-green light (486.1 nm) than for
    /// red (656.3 nm): (index - 1) over Abbe's number. Lobes without refraction are unchanged.
    #[must_use]
    pub fn dispersed(self, spread: f32) -> Self {
        let bends = matches!(self.kind, Kind::Glass | Kind::SmoothGlass);
        if bends && spread > 0.0 && spread.is_finite() { Self { spread, ..self } } else { self }
    }

    /// The material below a film.
    pub(super) fn base(&self) -> Base {
        match self.kind {
            Kind::Metal | Kind::SmoothMetal => Base::Metal(self.a, self.b),
            Kind::Microfacets | Kind::SmoothFacets => Base::Normal(self.a),
            _ => Base::Index(self.eta),
        }
    }

    /// Its rare features, as bits.
    #[inline]
    pub(super) fn rare(&self) -> u32 {
        let bit = |has: bool, bit: u32| if has { bit } else { 0 };
        let brushed = bit(self.across > 0.0, rare::ANISOTROPY);
        let is_schlick = matches!(self.kind, Kind::Microfacets | Kind::SmoothFacets);
        let risen = is_schlick && self.eta < 0.0 || self.kind == Kind::SchlickGlass;
        let film = bit(self.film.share > 0.0, rare::FILM);
        let scaled = matches!(self.kind, Kind::Microfacets | Kind::Metal) && self.spread < 0.0;
        let light = bit(self.is_dispersed(), rare::SPREAD) | bit(scaled, rare::SCALED);
        brushed | bit(risen, rare::POWER) | film | light
    }

    /// Whether light is missing below it.
    pub(super) fn covers(&self) -> bool {
        self.cover.max_element() > 0.0
    }

    /// Its effect on lobes below, by colours: dimming per scattered light, and constant dimming.
    pub(super) fn above(&self) -> [Vec3; 2] {
        let weight = self.weight;
        let through = match self.kind {
            Kind::Diffuse | Kind::Metal | Kind::SmoothMetal | Kind::Translucent => {
                return [Vec3::ZERO, weight];
            }
            Kind::Glass | Kind::Pane | Kind::SmoothGlass | Kind::SmoothPane | Kind::Beckmann => {
                self.b.max_element().clamp(0.0, 1.0)
            }
            Kind::SchlickGlass if self.spread < 0.0 => 1.0,
            _ => 0.0,
        };
        [weight, weight * through]
    }

    /// Whether it sends colours into different directions.
    #[must_use]
    pub fn is_dispersed(&self) -> bool {
        self.spread > 0.0 && self.kind != Kind::SchlickGlass
    }

    /// Whether it is smooth glass, which lets some light through.
    pub(super) fn is_clear(&self) -> bool {
        matches!(self.kind, Kind::SmoothGlass | Kind::SmoothPane) && !self.is_black()
    }

    /// A clear coat: microfacets of an index of 1.5.
    #[must_use]
    pub fn coat(alpha: f32) -> Self {
        Self::microfacets(alpha, Vec3::splat(fresnel::normal_reflectance(1.5)), Vec3::ONE)
    }

    /// Whether it is a mirror or has microfacets narrower than `alpha`.
    #[must_use]
    pub fn is_narrow(&self, alpha: f32) -> bool {
        match self.kind {
            Kind::Phong => self.alpha < alpha,
            kind if kind.has_slopes() => self.alpha.max(self.across) < alpha,
            kind => kind.is_delta(),
        }
    }

    /// Whether its microfacets are those of a mirror: reflections of points are points.
    #[must_use]
    pub fn is_polished(&self) -> bool {
        matches!(self.kind, Kind::Microfacets | Kind::Metal) && self.alpha.max(self.across) <= POLISHED
    }

    /// Whether it scatters nothing.
    #[must_use]
    pub fn is_black(&self) -> bool {
        self.kind == Kind::None || self.weight == Vec3::ZERO
    }

    /// Index of refraction for light that goes through, by colour; 1 where it is not bent.
    pub(super) fn bending(&self) -> Vec3 {
        match self.kind {
            Kind::Glass | Kind::SmoothGlass => {}
            Kind::Beckmann | Kind::SchlickGlass if self.eta > 0.0 => return Vec3::splat(self.eta),
            _ => return Vec3::ONE,
        }
        Vec3::from([0, 1, 2].map(|channel| eta_of(self.eta, self.spread, channel)))
    }
}

/// The index here over that beyond for one colour, of glass whose index differs by colour: the denser side's
/// does.
pub(super) fn eta_of(eta: f32, spread: f32, channel: usize) -> f32 {
    if spread == 0.0 {
        return eta;
    }
    let of = |dense: f32| (dense + spread * SPREADS[channel]).max(1.0);
    if eta > 1.0 { of(eta) } else { 1.0 / of(1.0 / eta) }
}
