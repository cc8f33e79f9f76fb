// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials: numbers, attributes or samplers for each parameter, and the scattering that they make at a point.
//! Source: ANARI 1.1, KHR_MATERIAL_*; the model is glTF's (`gnurt::shading::bsdf::Principled`). Tests: tests/{materials,lights}.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt::shading::bsdf::{Film, Lobe, Lobes, Principled};

use crate::attribute::{Attribute, Color, Point};
use crate::object::{Object, Snapshot, Value};
use crate::sampler::Sampler;

/// Where a parameter's value comes from.
pub(crate) enum Input {
    Constant(Color),
    Attribute(Attribute),
    Sampler(Arc<Sampler>),
}

impl Input {
    /// The value at a point.
    pub(crate) fn at(&self, point: &dyn Point) -> Color {
        match self {
            Self::Constant(value) => *value,
            Self::Attribute(which) => point.attribute(*which),
            Self::Sampler(sampler) => sampler.value(point),
        }
    }

    fn one(&self, point: &dyn Point) -> f32 {
        let value = self.at(point)[0];
        if value.is_nan() { 0.0 } else { value }
    }

    fn share(&self, point: &dyn Point) -> f32 {
        self.one(point).clamp(0.0, 1.0)
    }

    fn color(&self, point: &dyn Point) -> Vec3 {
        let [r, g, b, _] = self.at(point);
        let color = Vec3::new(r, g, b);
        if color.is_nan() { Vec3::ZERO } else { color.max(Vec3::ZERO) }
    }

    fn is(&self, value: f32) -> bool {
        matches!(self, Self::Constant([r, g, b, _]) if [*r, *g, *b].iter().all(|&x| x == value))
    }

    fn is_zero(&self) -> bool {
        matches!(self, Self::Constant([x, ..]) if *x <= 0.0)
    }
}

/// The meaning of the opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Alpha {
    Opaque,
    Blend,
    Mask(f32),
}

/// glTF's layers.
struct Physical {
    metallic: Input,
    roughness: Input,
    normal: Option<Arc<Sampler>>,
    emissive: Input,
    specular: Input,
    specular_color: Input,
    clearcoat: Input,
    clearcoat_roughness: Input,
    transmission: Input,
    ior: Input,
    thickness: Input,
    attenuation: Vec3,
    sheen_color: Input,
    sheen_roughness: Input,
    iridescence: Input,
    iridescence_ior: f32,
    iridescence_thickness: Input,
}

/// A material.
pub(crate) struct Material {
    color: Input,
    opacity: Input,
    alpha: Alpha,
    physical: Option<Box<Physical>>,
}

/// Traits of materials, as bits: surfaces of equal traits share one shader.
pub(crate) mod class {
    /// It has holes.
    pub(crate) const HOLES: u32 = 1;
    /// Some of it is glass.
    pub(crate) const GLASS: u32 = 2;
    /// It gives off light.
    pub(crate) const EMITS: u32 = 4;
    /// It absorbs light within.
    pub(crate) const FILLED: u32 = 8;
    /// How many combinations there are.
    pub(crate) const COUNT: u32 = 16;
}

/// Reads parameters, and collects their faults.
struct Reader<'a> {
    now: &'a Snapshot,
    sampler: &'a dyn Fn(&Arc<Object>) -> Option<Arc<Sampler>>,
    faults: &'a mut Vec<String>,
}

impl Reader<'_> {
    fn input(&mut self, name: &str, default: [f32; 3]) -> Input {
        let [r, g, b] = default;
        let otherwise = Input::Constant([r, g, b, 1.0]);
        match self.now.get(name) {
            Some(Value::Plain(..)) => self.now.color(name).map_or(otherwise, Input::Constant),
            Some(Value::Text(text)) => match Attribute::named(text) {
                Some(attribute) => Input::Attribute(attribute),
                None => {
                    self.faults.push(format!("parameter '{name}': '{text}': unknown attribute"));
                    otherwise
                }
            },
            Some(Value::Object(object)) => match (self.sampler)(object) {
                Some(sampler) => Input::Sampler(sampler),
                None => {
                    self.faults.push(format!("parameter '{name}': the sampler has no values"));
                    otherwise
                }
            },
            None => otherwise,
        }
    }

    fn scalar(&mut self, name: &str, default: f32) -> Input {
        self.input(name, [default; 3])
    }

    fn map(&mut self, name: &str) -> Option<Arc<Sampler>> {
        match self.now.get(name) {
            Some(Value::Object(object)) => (self.sampler)(object),
            _ => None,
        }
    }
}

impl Material {
    /// The material of an object; `sampler` makes samplers. Faults are told in words.
    pub(crate) fn new(
        object: &Object,
        sampler: &dyn Fn(&Arc<Object>) -> Option<Arc<Sampler>>,
        faults: &mut Vec<String>,
    ) -> Self {
        let now = object.committed();
        let mut read = Reader { now: &now, sampler, faults };
        let alpha = match now.text("alphaMode") {
            Some("blend") => Alpha::Blend,
            Some("mask") => Alpha::Mask(now.f32("alphaCutoff").unwrap_or(0.5)),
            _ => Alpha::Opaque,
        };
        let opacity = read.scalar("opacity", 1.0);
        if object.subtype != "physicallyBased" {
            let color = read.input("color", [0.8; 3]);
            return Self { color, opacity, alpha, physical: None };
        }
        for name in ["clearcoatNormal", "occlusion"] {
            if read.map(name).is_some() {
                read.faults.push(format!("parameter '{name}': unsupported, ignored"));
            }
        }
        let physical = Physical {
            metallic: read.scalar("metallic", 1.0),
            roughness: read.scalar("roughness", 1.0),
            normal: read.map("normal"),
            emissive: read.input("emissive", [0.0; 3]),
            specular: read.scalar("specular", 0.0),
            specular_color: read.input("specularColor", [1.0; 3]),
            clearcoat: read.scalar("clearcoat", 0.0),
            clearcoat_roughness: read.scalar("clearcoatRoughness", 0.0),
            transmission: read.scalar("transmission", 0.0),
            ior: read.scalar("ior", 1.5),
            thickness: read.scalar("thickness", 0.0),
            attenuation: attenuation(&now),
            sheen_color: read.input("sheenColor", [0.0; 3]),
            sheen_roughness: read.scalar("sheenRoughness", 0.0),
            iridescence: read.scalar("iridescence", 0.0),
            iridescence_ior: now.f32("iridescenceIor").unwrap_or(1.3).max(1.0),
            iridescence_thickness: read.scalar("iridescenceThickness", 0.0),
        };
        let color = read.input("baseColor", [1.0; 3]);
        Self { color, opacity, alpha, physical: Some(Box::new(physical)) }
    }

    /// Grey that stands where a surface has no material.
    pub(crate) fn missing() -> Self {
        let constant = |x| Input::Constant([x, x, x, 1.0]);
        Self { color: constant(0.8), opacity: constant(1.0), alpha: Alpha::Opaque, physical: None }
    }

    /// Its traits.
    pub(crate) fn class(&self) -> u32 {
        let colors_have_alpha = !matches!(self.color, Input::Constant([.., a]) if a >= 1.0);
        let has_holes = self.alpha != Alpha::Opaque && (!self.opacity.is(1.0) || colors_have_alpha);
        let mut bits = if has_holes { class::HOLES } else { 0 };
        if let Some(physical) = &self.physical {
            let is_glass = !physical.transmission.is_zero();
            bits |= if is_glass { class::GLASS } else { 0 };
            bits |= if physical.emissive.is(0.0) { 0 } else { class::EMITS };
            let is_filled = is_glass && physical.attenuation != Vec3::ZERO && !physical.thickness.is_zero();
            bits |= if is_filled { class::FILLED } else { 0 };
        }
        bits
    }

    /// Albedo, or reflectance of metal.
    pub(crate) fn base(&self, point: &dyn Point) -> Vec3 {
        self.color.color(point).min(Vec3::ONE)
    }

    /// Share of light that the surface stops.
    pub(crate) fn coverage(&self, point: &dyn Point) -> f32 {
        if self.alpha == Alpha::Opaque {
            return 1.0;
        }
        let opacity = self.opacity.share(point) * self.color.at(point)[3].clamp(0.0, 1.0);
        match self.alpha {
            Alpha::Mask(cutoff) => f32::from(u8::from(opacity >= cutoff)),
            _ => opacity,
        }
    }

    /// Radiance that it gives off to both sides.
    pub(crate) fn emission(&self, point: &dyn Point) -> Vec3 {
        self.physical.as_ref().map_or(Vec3::ZERO, |physical| physical.emissive.color(point))
    }

    /// The sampler of its normals.
    pub(crate) fn normal_map(&self) -> Option<&Sampler> {
        self.physical.as_ref()?.normal.as_deref()
    }

    /// Its lobes at a point that is seen from the front or not, and the absorption behind the point.
    pub(crate) fn lobes(&self, point: &dyn Point, front: bool, lobes: &mut Lobes) -> Vec3 {
        let base = self.base(point);
        let Some(physical) = &self.physical else {
            *lobes = Lobes::from(Lobe::lambert(base));
            return Vec3::ZERO;
        };
        let ior = physical.ior.one(point);
        let ior = if ior > 0.0 && ior.is_finite() { ior } else { 1.5 };
        let plain =
            Principled::new(base, physical.metallic.share(point), physical.roughness.share(point), ior);
        let specular = physical.specular.share(point);
        let tint = physical.specular_color.color(point);
        let coat_roughness = physical.clearcoat_roughness.share(point);
        let thin = physical.thickness.one(point) <= 0.0;
        Principled {
            f0: (plain.f0 * tint * specular).min(Vec3::ONE),
            f90: specular,
            coat: physical.clearcoat.share(point),
            coat_alpha: coat_roughness * coat_roughness,
            sheen: physical.sheen_color.color(point).min(Vec3::ONE),
            sheen_roughness: physical.sheen_roughness.share(point),
            transmission: physical.transmission.share(point),
            thin,
            eta: if front { 1.0 / ior } else { ior },
            film: Film {
                share: physical.iridescence.share(point),
                ior: physical.iridescence_ior,
                thickness: physical.iridescence_thickness.one(point).max(0.0),
            },
            ..plain
        }
        .write(lobes);
        if thin { Vec3::ZERO } else { physical.attenuation }
    }
}

/// Absorption per way in glass, after Beer.
fn attenuation(now: &Snapshot) -> Vec3 {
    let interior = gnurt::scene::detail::Interior {
        attenuation_color: now.vec3("attenuationColor").unwrap_or([1.0; 3]),
        attenuation_distance: now.f32("attenuationDistance").unwrap_or(f32::INFINITY),
        ..Default::default()
    };
    Vec3::from(interior.absorption())
}
