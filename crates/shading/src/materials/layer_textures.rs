// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures of the layers of glTF's surface, and the surface that they make at a point.
//! Source: KHR_materials_{clearcoat, diffuse_transmission, iridescence, sheen, specular, transmission}.
//! Tests: crates/gnurt/tests/gltf_twins.rs.

use glam::Vec3;

use crate::batch::SurfaceBatch;
use crate::bsdf::Principled;
use crate::color_map::ColorMap;
use crate::materials::normal_map::NormalMap;
use crate::texture::TextureSampler;

/// One channel of a texture.
#[derive(Clone, Debug)]
pub struct Channel {
    /// The texture.
    pub texture: TextureSampler,
    /// 0 = red, 3 = alpha.
    pub channel: usize,
}

impl Channel {
    fn at_hit(of: Option<&Self>, hits: &SurfaceBatch, i: usize) -> f32 {
        of.map_or(1.0, |of| of.texture.at_hit(hits, i)[of.channel].clamp(0.0, 1.0))
    }
}

/// Textures that are multiplied to the numbers of the layers.
#[derive(Clone, Debug, Default)]
pub struct LayerTextures {
    /// Strength of the dielectric reflection.
    pub specular: Option<Channel>,
    /// Its colour.
    pub specular_color: Option<TextureSampler>,
    /// Reflectance of the dielectric at normal incidence without the strength, before it is cut off at 1.
    pub specular_base: Vec3,
    /// Share of the coat.
    pub coat: Option<Channel>,
    /// Roughness of the coat: the square root of its width is multiplied.
    pub coat_roughness: Option<Channel>,
    /// Normals of the coat.
    pub coat_normals: Option<NormalMap>,
    /// Colour of the sheen.
    pub sheen_color: Option<TextureSampler>,
    /// Roughness of the sheen.
    pub sheen_roughness: Option<Channel>,
    /// Share of glass.
    pub transmission: Option<Channel>,
    /// Share of the film.
    pub film: Option<Channel>,
    /// From the least thickness of the film, which goes with it, to the greatest.
    pub film_thickness: Option<(Channel, f32)>,
    /// Share of the light that the body scatters through.
    pub translucence: Option<Channel>,
    /// Albedo of that.
    pub beyond: Option<TextureSampler>,
    /// To the working space: of the products of colours and their textures, and of `specular_base`. Colours without
    /// textures are in the working space.
    pub map: ColorMap,
}

impl LayerTextures {
    /// The share of glass at lane `i`.
    pub(super) fn transmission(&self, hits: &SurfaceBatch, i: usize) -> f32 {
        Channel::at_hit(self.transmission.as_ref(), hits, i)
    }

    /// The model at lane `i`, from that without textures.
    pub(super) fn apply(&self, hits: &SurfaceBatch, i: usize, model: &mut Principled) {
        let at = |of: &Option<Channel>| Channel::at_hit(of.as_ref(), hits, i);
        let color = |of: &TextureSampler| {
            let [r, g, b, _] = of.at_hit(hits, i);
            Vec3::new(r, g, b).max(Vec3::ZERO)
        };
        let times = |factor: Vec3, of: &Option<TextureSampler>| {
            of.as_ref().map_or(factor, |texture| self.map.of(factor * color(texture)))
        };
        if self.specular.is_some() || self.specular_color.is_some() {
            model.f90 *= at(&self.specular);
            let texel = self.specular_color.as_ref().map_or(Vec3::ONE, color);
            model.f0 = self.map.of(self.specular_base * texel).min(Vec3::ONE) * model.f90;
        }
        model.coat *= at(&self.coat);
        model.coat_alpha *= at(&self.coat_roughness).powi(2);
        model.sheen = times(model.sheen, &self.sheen_color).min(Vec3::ONE);
        model.sheen_roughness *= at(&self.sheen_roughness);
        model.transmission *= at(&self.transmission);
        model.film.share *= at(&self.film);
        if let Some((share, least)) = &self.film_thickness {
            let share = Channel::at_hit(Some(share), hits, i);
            model.film.thickness = least + (model.film.thickness - least) * share;
        }
        model.translucence *= at(&self.translucence);
        model.beyond = times(model.beyond, &self.beyond).min(Vec3::ONE);
    }
}
