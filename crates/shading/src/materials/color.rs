// SPDX-License-Identifier: GPL-3.0-or-later
//! Values over a surface: a factor, times a texture where there is one.
//! Source: glTF 2.0 section 3.9 (factor times texture, alpha modes). Units: linear light, W·sr⁻¹·m⁻² for emission.
//! Tests: `tests::coverage_modes`.

use glam::Vec3;
use gnurt_image::srgb::luminance;

use crate::batch::SurfaceBatch;
use crate::color_map::ColorMap;
use crate::texture::TextureSampler;

/// A linear colour over a surface.
#[derive(Clone, Debug)]
pub struct TexturedColor {
    /// Linear red, green, blue.
    pub factor: Vec3,
    /// Multiplied to it.
    pub texture: Option<TextureSampler>,
    /// From both, and the mesh's colours, to the working space.
    pub map: ColorMap,
}

impl TexturedColor {
    /// The same everywhere.
    #[must_use]
    pub fn constant(factor: Vec3) -> Self {
        Self { factor, texture: None, map: ColorMap::default() }
    }

    /// At lane `i` of a batch, times the mesh's own colour there.
    #[must_use]
    pub fn at_hit(&self, hits: &SurfaceBatch, i: usize) -> Vec3 {
        let color = self.texture.as_ref().map_or(self.factor, |texture| {
            let [r, g, b, _] = texture.at_hit(hits, i);
            self.factor * Vec3::new(r, g, b)
        });
        self.map.of(color * hits.color.get(i))
    }
}

/// Radiance that leaves the side of the geometric normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// Radiance.
    pub factor: Vec3,
    /// Multiplied to it.
    pub texture: Option<TextureSampler>,
    /// From their product to the working space.
    pub map: ColorMap,
}

impl Emission {
    /// The same everywhere.
    #[must_use]
    pub fn constant(factor: Vec3) -> Self {
        Self { factor, texture: None, map: ColorMap::default() }
    }

    /// At texture coordinates of the mesh.
    #[must_use]
    pub fn at(&self, uv: [f32; 2]) -> Vec3 {
        self.times(|texture| texture.sample(uv))
    }

    /// At lane `i` of a batch.
    #[must_use]
    pub fn at_hit(&self, hits: &SurfaceBatch, i: usize) -> Vec3 {
        self.times(|texture| texture.at_hit(hits, i))
    }

    fn times(&self, read: impl FnOnce(&TextureSampler) -> [f32; 4]) -> Vec3 {
        self.map.of(self.texture.as_ref().map_or(self.factor, |texture| {
            let [r, g, b, _] = read(texture);
            self.factor * Vec3::new(r, g, b)
        }))
    }

    /// Mean luminance over the whole texture, for estimates of power. Above zero if any texel emits.
    #[must_use]
    pub fn mean_luminance(&self) -> f32 {
        let mean = self.texture.as_ref().map_or([1.0; 4], TextureSampler::mean);
        luminance((self.factor * Vec3::new(mean[0], mean[1], mean[2])).into())
    }
}

/// Which channel of a texture holds opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpacityChannel {
    /// The fourth.
    Alpha,
    /// The first.
    Red,
}

/// Where a surface is there.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Opacity.
    pub factor: f32,
    /// Multiplied to it.
    pub texture: Option<TextureSampler>,
    /// Where the texture keeps it.
    pub channel: OpacityChannel,
    /// All or nothing: there where the opacity reaches this. `None` = the opacity is the fraction of the
    /// surface.
    pub cutoff: Option<f32>,
}

impl Coverage {
    /// Share of light that the surface stops, in [0, 1].
    #[must_use]
    pub fn at(&self, uv: [f32; 2], vertex_opacity: f32) -> f32 {
        self.of(vertex_opacity, |texture| texture.sample(uv))
    }

    /// At lane `i` of a batch. Masks are read as they are: a mean that is cut off afterwards would make leaves grow or shrink.
    #[must_use]
    pub fn at_hit(&self, hits: &SurfaceBatch, i: usize) -> f32 {
        self.of(hits.alpha[i], |texture| match self.cutoff {
            Some(_) => texture.sample(texture.uv(hits, i)),
            None => texture.at_hit(hits, i),
        })
    }

    fn of(&self, vertex_opacity: f32, read: impl FnOnce(&TextureSampler) -> [f32; 4]) -> f32 {
        let texel = self.texture.as_ref().map_or(1.0, |texture| {
            let [r, _, _, a] = read(texture);
            if self.channel == OpacityChannel::Alpha { a } else { r }
        });
        let opacity = self.factor * texel * vertex_opacity;
        match self.cutoff {
            Some(cutoff) => f32::from(u8::from(opacity >= cutoff)),
            None => opacity.clamp(0.0, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_modes() {
        let blend = Coverage { factor: 0.4, texture: None, channel: OpacityChannel::Alpha, cutoff: None };
        assert_eq!(blend.at([0.0; 2], 0.5), 0.2, "shares are multiplied");
        let mask = Coverage { cutoff: Some(0.4), ..blend };
        assert_eq!(mask.at([0.0; 2], 1.0), 1.0, "there from the cutoff on");
        assert_eq!(mask.at([0.0; 2], 0.9), 0.0, "not below it");
    }
}
