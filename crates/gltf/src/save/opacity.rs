// SPDX-License-Identifier: GPL-3.0-or-later
//! Opacity where glTF keeps it: in the alpha of the base colour's texture.
//! Source: glTF 2.0 section 3.9.4. OBJ has it in a separate picture (`map_d`), which is merged with that of
//! the colour here; the larger size counts, of the smaller one the nearest texel. Space: texels, from the
//! upper left one.
//! Tests: `tests/save.rs::cut_outs_survive`.

use std::sync::Arc;

use gnurt_scene::Scene;
use gnurt_scene::material::{Alpha, Material, OpacityChannel, TextureRef};
use gnurt_scene::texture::{TexelData, Texels, Texture};

/// The base colour's texture with the material's opacity in its alpha.
pub(super) enum BaseTexture {
    /// The material's texture is used as it is.
    AsIs(Option<TextureRef>),
    /// A new texture, and its transform.
    Merged(Texture, TextureRef),
    /// The two are laid out differently: the opacity's texture is left out.
    Lost(Option<TextureRef>),
}

/// The texture that a material with the colours of `base` needs.
pub(super) fn base_texture(scene: &Scene, material: &Material, base: Option<TextureRef>) -> BaseTexture {
    let opacity = match material.alpha {
        Alpha::Opaque => return BaseTexture::AsIs(base),
        Alpha::Mask { opacity, .. } | Alpha::Blend { opacity } => opacity,
    };
    if opacity.texture == base && opacity.channel == OpacityChannel::Alpha {
        return BaseTexture::AsIs(base);
    }
    let texels_of = |used: TextureRef| &*scene.texture(used.texture).texels;
    if opacity.texture.is_none() && base.is_none_or(|base| is_opaque(texels_of(base))) {
        return BaseTexture::AsIs(base);
    }
    let Some(first) = base.or(opacity.texture) else {
        return BaseTexture::AsIs(None);
    };
    let wrap_of = |used: TextureRef| scene.texture(used.texture).wrap;
    let differs = |other: TextureRef| {
        (other.uv_from_mesh, other.set) != (first.uv_from_mesh, first.set) || wrap_of(other) != wrap_of(first)
    };
    if opacity.texture.is_some_and(differs) {
        return BaseTexture::Lost(base);
    }
    let texels = merge(base.map(texels_of), opacity.texture.map(texels_of), opacity.channel);
    let from = scene.texture(first.texture);
    let merged = Texture {
        name: format!("{} with opacity", from.name),
        texels: Arc::new(texels),
        wrap: from.wrap,
        filter: from.filter,
    };
    BaseTexture::Merged(merged, first)
}

fn is_opaque(texels: &Texels) -> bool {
    let [width, height] = [texels.width, texels.height].map(|n| n as usize);
    (0..height).all(|y| (0..width).all(|x| texels.texel(x, y)[3] >= 1.0))
}

/// Colours of one, white without it, with a channel of the other as alpha, 1 without it.
fn merge(color: Option<&Texels>, opacity: Option<&Texels>, channel: OpacityChannel) -> Texels {
    let color = color.map(|color| color.clone().resident());
    let color = color.as_ref();
    let both = || color.into_iter().chain(opacity);
    let width = both().map(|t| t.width).max().unwrap_or(1);
    let height = both().map(|t| t.height).max().unwrap_or(1);
    let wide = color.is_some_and(|color| color.is_float() || matches!(color.data, TexelData::Linear16(_)));
    let channel = if channel == OpacityChannel::Red { 0 } else { 3 };
    let alpha =
        |x, y| opacity.map_or(1.0, |texels| linear(texels, channel, nearest(texels, [width, height], x, y)));
    let pixel_positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let data = if wide {
        let color = |x, y| {
            let at = |texels: &Texels| {
                [0, 1, 2].map(|k| linear(texels, k, nearest(texels, [width, height], x, y)))
            };
            color.map_or([1.0; 3], at)
        };
        let texel = |(x, y)| {
            let [r, g, b] = color(x, y);
            [r, g, b, alpha(x, y)]
        };
        TexelData::Float(pixel_positions.map(texel).collect())
    } else {
        let texel = |(x, y)| {
            let at = |texels: &Texels| match &texels.data {
                TexelData::Srgb8(pixels) | TexelData::Linear8(pixels) => {
                    pixels[nearest(texels, [width, height], x, y)]
                }
                TexelData::Linear16(_) | TexelData::Float(_) | TexelData::Tiled(_) => [255; 4],
            };
            let [r, g, b, _] = color.map_or([255; 4], at);
            [r, g, b, (alpha(x, y).clamp(0.0, 1.0) * 255.0 + 0.5) as u8]
        };
        TexelData::Srgb8(pixel_positions.map(texel).collect())
    };
    Texels { width, height, data }
}

/// Where the texel lies that is nearest to `(x, y)` of a picture of that size.
fn nearest(texels: &Texels, [width, height]: [u32; 2], x: u32, y: u32) -> usize {
    let scaled = |at: u32, from: u32, to: u32| (u64::from(at) * u64::from(to) / u64::from(from)) as usize;
    scaled(y, height, texels.height) * texels.width as usize + scaled(x, width, texels.width)
}

/// A channel of a texel in linear light, in `[0, 1]` for bytes.
fn linear(texels: &Texels, channel: usize, at: usize) -> f32 {
    let width = texels.width as usize;
    texels.texel(at % width, at / width)[channel]
}
