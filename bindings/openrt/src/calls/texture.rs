// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures (rtGenTextures, rtBindTexture, rtTexImage2D, rtTexParameteri, rtDeleteTexture, rtIsTexture).
//! Source: OpenGL 1.x. Tests: tests/c/scene.c, tests/c/errors.c.

use crate::context::Context;
use crate::state::enums::{MinifyFilter, TextureFilter, TextureParameter, TextureTarget, TextureWrap};
use crate::state::error::{Error, Result, not_null};
use crate::state::texture::{ImageDescription, ReadTexels};

impl Context {
    /// rtGenTextures.
    pub(crate) fn gen_textures(&mut self, count: i32) -> Result<u32> {
        self.outside_block()?;
        self.textures.ids.reserve(count, |_| true)
    }

    /// rtBindTexture.
    pub(crate) fn bind_texture(&mut self, target: u32, id: u32) -> Result<()> {
        self.outside_block()?;
        TextureTarget::from_code(target)?;
        let id = if id == 0 { None } else { Some(self.textures.ids.check(id)?) };
        self.textures.bind(id);
        Ok(())
    }

    /// rtTexImage2D.
    pub(crate) fn tex_image(
        &mut self,
        description: &ImageDescription,
        read: Option<ReadTexels<'_>>,
    ) -> Result<()> {
        self.outside_block()?;
        let read = not_null(read)?;
        TextureTarget::from_code(description.target)?;
        let image = description.check()?;
        self.textures.check_bound()?;
        let texels = if description.level == 0 { Some(image.texels(read)?) } else { None };
        let texture = self.textures.bound_mut()?;
        if let Some(texels) = texels {
            texture.set_image(texels);
        }
        Ok(())
    }

    /// rtTexParameteri.
    pub(crate) fn tex_parameter(&mut self, target: u32, name: u32, value: i32) -> Result<()> {
        self.outside_block()?;
        TextureTarget::from_code(target)?;
        let name = TextureParameter::from_code(name)?;
        let value = u32::try_from(value).map_err(|_| Error::InvalidEnum)?;
        match name {
            TextureParameter::MagFilter => {
                let filter = TextureFilter::from_code(value)?;
                self.textures.bound_mut()?.filter = Some(filter);
            }
            TextureParameter::MinFilter => {
                let filter = MinifyFilter::from_code(value)?;
                self.textures.bound_mut()?.minify = Some(filter);
            }
            TextureParameter::WrapS | TextureParameter::WrapT => {
                let wrap = TextureWrap::from_code(value)?;
                let axis = usize::from(name == TextureParameter::WrapT);
                self.textures.bound_mut()?.set_wrap(axis, wrap);
            }
        }
        Ok(())
    }

    /// rtDeleteTexture.
    pub(crate) fn delete_texture(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        self.textures.remove(id)
    }

    /// rtIsTexture.
    pub(crate) fn is_texture(&self, id: u32) -> Result<bool> {
        self.outside_block()?;
        Ok(self.textures.ids.exists(id))
    }
}
