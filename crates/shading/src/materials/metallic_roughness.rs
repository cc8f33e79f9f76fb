// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF's metal and plastic with its layers: a diffuse body or glass under a rough boundary, or a rough
//! metal, or a mix, under sheen and a clear coat.
//! Source: glTF 2.0 section 3.9, KHR_materials_{specular, clearcoat, sheen, transmission}; the model itself
//! is `bsdf/principled.rs`.
//! Tests: crates/render/tests/appearance.rs, `tests` of `bsdf`.

use glam::{Vec2, Vec3};

use crate::batch::{SurfaceBatch, Vec3s};
use crate::bsdf::{ClosureBatch, Lobes, Medium, Principled, fresnel};
use crate::materials::SMOOTH;
use crate::materials::color::TexturedColor;
use crate::materials::dielectric::inside;
use crate::materials::layer_textures::LayerTextures;
use crate::materials::normal_map::{NormalMap, axes};
use crate::sampling::Basis;
use crate::shader::{SurfaceShader, Tracer};
use crate::texture::TextureSampler;

/// glTF's metal and plastic.
#[derive(Clone, Debug)]
pub struct MetallicRoughness {
    /// Albedo of the body, normal reflectance of the metal.
    pub base_color: TexturedColor,
    /// 0 = plastic, 1 = metal.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Green times roughness, blue times metallic.
    pub metallic_roughness_texture: Option<TextureSampler>,
    /// Index of refraction of the plastic and of the glass.
    pub ior: f32,
    /// Normals.
    pub normal_map: Option<NormalMap>,
    /// The rest of its model; the fields above replace its base, metal, roughness and index.
    pub model: Principled,
    /// The direction of brushing.
    pub anisotropy: Anisotropy,
    /// Absorption coefficient within solid glass, 1 over world units, >= 0.
    pub absorption: Vec3,
    /// Textures of its layers.
    pub layers: Option<Box<LayerTextures>>,
}

/// Anisotropy of microfacets: rougher along one direction than across it.
#[derive(Clone, Debug, Default)]
pub struct Anisotropy {
    /// How much rougher, in [0, 1]; 0 = not at all.
    pub strength: f32,
    /// That direction, from where the texture's u grows, counter-clockwise, radians.
    pub rotation: f32,
    /// Red and green: the direction before its rotation; blue: multiplied to the strength.
    pub texture: Option<TextureSampler>,
}

/// The most that fine slopes add to the square of microfacets' slopes \[TK19\].
const MOST_ROUGHER: f32 = 0.18;

/// Roughness of microfacets on fine slopes: the squares add up.
fn rougher(roughness: f32, slopes: f32) -> f32 {
    if slopes == 0.0 {
        return roughness;
    }
    let alpha = roughness * roughness;
    (alpha * alpha + (2.0 * slopes).min(MOST_ROUGHER)).sqrt().sqrt().min(1.0)
}

impl MetallicRoughness {
    /// Shading normal on the side that the ray came from, and the square of slopes that are too fine to be
    /// seen.
    fn normal(map: Option<&NormalMap>, hits: &SurfaceBatch, i: usize) -> (Vec3, f32) {
        let own = || (hits.scattering_ns(i), 0.0);
        let (ns, slopes) = map.map_or_else(own, |map| map.at_hit(hits, i));
        (if ns.dot(hits.facing_ng(i)) < 0.0 { -ns } else { ns }, slopes)
    }

    /// Normal and slopes of the coat, which has a map of its own: without one it is smooth above the body's.
    fn coat_normal(&self, hits: &SurfaceBatch, i: usize) -> Option<(Vec3, f32)> {
        let map = self.layers.as_ref().and_then(|layers| layers.coat_normals.as_ref());
        if self.model.coat == 0.0 || (map.is_none() && self.normal_map.is_none()) {
            return None;
        }
        let (normal, slopes) = Self::normal(map, hits, i);
        Some((hits.point(i).bent_normal(normal, -hits.ray_dir.get(i)), slopes))
    }
}

impl MetallicRoughness {
    /// Makes microfacets rougher along the direction of anisotropy: glTF's alpha along it goes to 1 with the
    /// square of the strength.
    fn brush(&self, hits: &SurfaceBatch, i: usize, ns: Vec3, model: &mut Principled) {
        let Anisotropy { strength, rotation, texture } = &self.anisotropy;
        let (mut strength, mut axis) = (*strength, Vec2::X);
        let [mut u, mut v] = [hits.dp_du.get(i), hits.dp_dv.get(i)];
        if let Some(texture) = texture {
            let [r, g, b, _] = texture.at_hit(hits, i);
            strength *= b;
            axis = Vec2::new(2.0 * r - 1.0, 2.0 * g - 1.0).try_normalize().unwrap_or(Vec2::X);
            if let Some(axes) = axes(texture, u, v) {
                [u, v] = axes;
            }
        }
        let axis = Vec2::from_angle(*rotation).rotate(axis);
        let frame = Basis::along(ns, u);
        let bitangent = if frame.bitangent.dot(v) < 0.0 { -frame.bitangent } else { frame.bitangent };
        model.tangent = frame.tangent * axis.x + bitangent * axis.y;
        model.across = model.alpha.max(f32::MIN_POSITIVE);
        model.alpha += (1.0 - model.alpha) * (strength * strength).clamp(0.0, 1.0);
    }

    /// The model for these values of its textures, seen from its front or its back, not brushed.
    fn model(&self, base: Vec3, metallic: f32, roughness: f32, front: bool) -> Principled {
        let eta = if front { 1.0 / self.ior } else { self.ior };
        Principled {
            base: base.clamp(Vec3::ZERO, Vec3::ONE),
            metallic,
            alpha: roughness * roughness,
            eta,
            ..self.model
        }
    }

    /// Whether light is absorbed in it.
    fn has_inside(&self) -> bool {
        let Principled { transmission, thin, translucence, .. } = self.model;
        self.absorption != Vec3::ZERO && transmission > 0.0 && !thin && translucence == 0.0
    }
}

impl SurfaceShader for MetallicRoughness {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        let mut lobes = Lobes::default();
        // The last input of the lobes, because neighbours often are equal.
        let mut made = None;
        for i in 0..hits.len() {
            let texel = self.metallic_roughness_texture.as_ref().map_or([1.0; 4], |t| t.at_hit(hits, i));
            let (normal, slopes) = Self::normal(self.normal_map.as_ref(), hits, i);
            let roughness = rougher((self.roughness * texel[1]).clamp(0.0, 1.0), slopes);
            let metallic = (self.metallic * texel[2]).clamp(0.0, 1.0);
            let base = self.base_color.at_hit(hits, i);
            let ns = hits.point(i).bent_normal(normal, -hits.ray_dir.get(i));
            let front = hits.front(i);
            let is_brushed = self.anisotropy.strength > 0.0;
            let coat = self.coat_normal(hits, i);
            let is_own = is_brushed || coat.is_some() || self.layers.is_some();
            if is_own || made != Some((base, metallic, roughness, front)) {
                let mut model = self.model(base, metallic, roughness, front);
                if let Some(layers) = &self.layers {
                    layers.apply(hits, i, &mut model);
                }
                if let Some((normal, slopes)) = coat {
                    model.coat_normal = normal;
                    model.coat_alpha = rougher(model.coat_alpha.sqrt(), slopes).powi(2);
                }
                if is_brushed {
                    self.brush(hits, i, ns, &mut model);
                }
                model.write(&mut lobes);
                made = Some((base, metallic, roughness, front));
            }
            out.set(i, ns, lobes.as_slice());
            if self.has_inside() {
                out.fill(i, Medium::behind(self.absorption, front));
            }
        }
    }

    fn has_medium(&self) -> bool {
        self.has_inside()
    }

    fn transmit(&self, _tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if self.roughness >= SMOOTH {
            return;
        }
        for i in 0..hits.len() {
            // Straight on, as if the glass were thin: see `dielectric.rs`.
            let cos = hits.ray_dir.get(i).dot(hits.facing_ng(i)).abs();
            let share = fresnel::dielectric(cos, (1.0 / self.ior).min(self.ior));
            let there = self.layers.as_ref().map_or(1.0, |layers| layers.transmission(hits, i));
            let glass = self.model.transmission * there * (1.0 - self.metallic);
            let left = inside(hits, i, if self.has_inside() { self.absorption } else { Vec3::ZERO });
            out.set(i, self.base_color.at_hit(hits, i) * left * (glass * (1.0 - share)));
        }
    }

    fn is_opaque(&self) -> bool {
        self.model.transmission == 0.0 || self.roughness >= SMOOTH
    }

    fn is_solid(&self) -> bool {
        true
    }

    fn is_clear(&self) -> bool {
        let smoothest = if self.metallic_roughness_texture.is_some() { 0.0 } else { self.roughness };
        let model = self.model(Vec3::ONE, self.metallic, smoothest, true);
        model.transmission > 0.0 && model.has_smooth_glass()
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.base_color.at_hit(hits, i)));
    }
}
