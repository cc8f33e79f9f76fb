// SPDX-License-Identifier: GPL-3.0-or-later
//! Readers of a description's textures, and their mip maps: one set for each picture, however often it is
//! used.
//! Invariant: a picture keeps its mip maps as long as a reader of it exists, so that readers can be compared,
//! and edits elsewhere cause no new ones. Tests: crates/render/tests/{commit,filtering}.rs.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use glam::Vec3;
use gnurt_image::{Texels, Weigh};
use gnurt_scene::detail::Interior;
use gnurt_scene::material::TextureRef;
use gnurt_scene::texture::{Filter, TexcoordSet, Wrap};
use gnurt_scene::{Scene, TextureId};
use gnurt_shading::ColorMap;
use gnurt_shading::mipmap::{Minify, MipMap};
use gnurt_shading::texture::{TextureSampler, Wrap as SamplerWrap};

/// Smaller copies by the addresses of pictures.
type ByPicture = HashMap<(usize, Weigh), Arc<MipMap>>;

/// Smaller copies by pictures; worlds that are committed from each other share it.
#[derive(Clone, Default)]
pub(crate) struct Textures {
    /// Each holds its picture, whose address is its key, so that no other picture can have that.
    mips: Arc<Mutex<ByPicture>>,
}

/// A description's textures as one of its materials reads them.
#[derive(Clone, Copy)]
pub(super) struct Reading<'a> {
    pub(super) scene: &'a Scene,
    pub(super) textures: &'a Textures,
    /// The texture of the material's opacity: its colours are weighted by it.
    pub(super) opacity_texture: Option<TextureId>,
    /// To the working space.
    pub(super) map: ColorMap,
}

impl Reading<'_> {
    /// A colour in the working space.
    pub(super) fn color(&self, color: [f32; 3]) -> Vec3 {
        self.map.of(Vec3::from(color))
    }

    /// The colour of a layer; one that a texture is multiplied to stays in the space of the texture.
    pub(super) fn layer(&self, color: [f32; 3], texture: Option<TextureRef>) -> Vec3 {
        let color = Vec3::from(color).clamp(Vec3::ZERO, Vec3::ONE);
        if texture.is_some() { color } else { self.map.of(color) }
    }

    /// The absorption of an interior: its colour is converted, as the colour of light that went through.
    pub(super) fn absorption(&self, interior: &Interior) -> Vec3 {
        let attenuation_color = self.color(interior.attenuation_color).to_array();
        Interior { attenuation_color, ..*interior }.absorption().into()
    }

    /// A reader under the material's transform, filtered over the ray's footprint.
    pub(super) fn sampler(&self, reference: &TextureRef, weigh: Weigh) -> TextureSampler {
        let sharp = sharp(self.scene, reference);
        TextureSampler { minify: Some((Minify::Ellipse, self.textures.mips(&sharp.texels, weigh))), ..sharp }
    }

    /// The same of a texture of colours.
    pub(super) fn colors(&self, reference: &TextureRef) -> TextureSampler {
        let is_partly_transparent = self.opacity_texture == Some(reference.texture);
        self.sampler(reference, if is_partly_transparent { Weigh::ByOpacity } else { Weigh::Alike })
    }
}

/// A reader without filtering: its value depends on coordinates alone.
pub(crate) fn sharp(scene: &Scene, reference: &TextureRef) -> TextureSampler {
    let texture = scene.texture(reference.texture);
    TextureSampler {
        minify: None,
        texels: texture.texels.clone(),
        wrap: texture.wrap.map(|wrap| match wrap {
            Wrap::Repeat => SamplerWrap::Repeat,
            Wrap::MirroredRepeat => SamplerWrap::Mirror,
            Wrap::ClampToEdge => SamplerWrap::Clamp,
        }),
        linear: texture.filter == Filter::Linear,
        uv_from_mesh: reference.uv_from_mesh,
        attribute: (reference.set == TexcoordSet::Second).then_some(0),
    }
}

impl Textures {
    /// Mip maps of a picture; made when a ray first needs one.
    fn mips(&self, texels: &Arc<Texels>, weigh: Weigh) -> Arc<MipMap> {
        let made = || Arc::new(MipMap::weighed(texels.clone(), weigh));
        // Where a thread has died, nothing is shared.
        let Ok(mut mips) = self.mips.lock() else { return made() };
        mips.entry((Arc::as_ptr(texels).addr(), weigh)).or_insert_with(made).clone()
    }

    /// Drops the mip maps without readers.
    pub(super) fn tidy(&self) {
        if let Ok(mut mips) = self.mips.lock() {
            mips.retain(|_, mips| Arc::strong_count(mips) > 1);
        }
    }
}
