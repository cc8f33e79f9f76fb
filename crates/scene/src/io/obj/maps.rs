// SPDX-License-Identifier: GPL-3.0-or-later
//! Maps of MTL's PBR extension as the textures of our surfaces: roughness and metalness share one.
//! Source: the PBR extension of MTL (`map_Pr`, `map_Pm`, `map_Ps`, `map_Pc`, `map_Pcr`): red of each counts.
//! Tests: `tests/obj.rs::maps_of_roughness_and_metal_are_packed`.

use std::sync::Arc;

use crate::io::source::Access;
use crate::layer_textures::LayerTextures;
use crate::material::{Surface, TextureRef};
use crate::scene::Scene;
use crate::texture::{TexelData, Texels, Texture};

/// A texture with the roughness in green and the metalness in blue, as large as the larger one; the error
/// gives the fault. The two have one layout: that of the roughness.
pub(super) fn packed(
    access: &Access,
    scene: &mut Scene,
    rough: Option<TextureRef>,
    metal: Option<TextureRef>,
) -> Result<Option<TextureRef>, String> {
    let Some(like) = rough.or(metal) else { return Ok(None) };
    if rough.zip(metal).is_some_and(|(rough, metal)| rough.uv_from_mesh != metal.uv_from_mesh) {
        return Err("`map_Pm` with another layout than `map_Pr`, read with that".into());
    }
    let texels = |map: Option<TextureRef>| map.map(|map| scene.texture(map.texture).texels.clone());
    let [rough, metal] = [rough, metal].map(texels);
    let size =
        |of: fn(&Texels) -> u32| rough.iter().chain(&metal).map(|texels| of(texels)).max().unwrap_or(1);
    let (width, height) = (size(|texels| texels.width), size(|texels| texels.height));
    let count = width as usize * height as usize;
    access.budget.hold(4 * count).map_err(|excess| excess.to_string())?;
    access.budget.work(4 * count).map_err(|excess| excess.to_string())?;
    let nearest = |k: u32, from: u32, to: u32| (u64::from(k) * u64::from(to) / u64::from(from)) as usize;
    let red = |texels: &Option<Arc<Texels>>, x: u32, y: u32| {
        texels.as_ref().map_or(255, |texels| {
            let (x, y) = (nearest(x, width, texels.width), nearest(y, height, texels.height));
            (texels.texel(x, y)[0].clamp(0.0, 1.0) * 255.0).round() as u8
        })
    };
    let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let data = TexelData::Linear8(all.map(|(x, y)| [0, red(&rough, x, y), red(&metal, x, y), 255]).collect());
    let from = scene.texture(like.texture);
    let (name, wrap, filter) = (from.name.clone(), from.wrap, from.filter);
    let texture = Texture { name, texels: Arc::new(Texels { width, height, data }), wrap, filter };
    Ok(Some(TextureRef { texture: scene.add_texture(texture), ..like }))
}

/// The surface with a packed texture and those of its layers; surfaces without roughness have none.
pub(super) fn with_maps(
    mut surface: Surface,
    details: Option<TextureRef>,
    layers: LayerTextures<TextureRef>,
) -> Surface {
    match &mut surface {
        Surface::MetallicRoughness { metallic_roughness_texture, .. } => {
            *metallic_roughness_texture = details
        }
        Surface::Principled(principled) => {
            principled.metallic_roughness_texture = details;
            principled.layer_textures = layers;
        }
        _ => {}
    }
    surface
}
