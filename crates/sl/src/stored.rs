// SPDX-License-Identifier: GPL-3.0-or-later
//! The pictures of `testshade`: read elsewhere, because the language crate has no picture files.

use crate::exec::TextureOptions;
use crate::hir::Data;
use crate::types::Type;
use gnurt_sl_lib::Dual;

/// Pictures by their files' names. Values are the stored ones.
pub trait Textures {
    /// Four channels at `s` and `t`, t downwards, and how they change from pixel to pixel.
    ///
    /// # Errors
    /// Why there are none, in OSL's words.
    fn texture(
        &self,
        file: &str,
        at: [Dual<f32>; 2],
        options: &TextureOptions,
    ) -> Result<[Dual<f32>; 4], String>;

    /// The same in a direction.
    ///
    /// # Errors
    /// Why there are none, in OSL's words.
    fn environment(
        &self,
        file: &str,
        direction: [Dual<f32>; 3],
        options: &TextureOptions,
    ) -> Result<[Dual<f32>; 4], String>;

    /// The same of a volume, at a position.
    ///
    /// # Errors
    /// Why there are none, in OSL's words.
    fn texture3d(
        &self,
        file: &str,
        at: [Dual<f32>; 3],
        options: &TextureOptions,
    ) -> Result<[Dual<f32>; 4], String>;

    /// A query of `gettextureinfo`, of the tile at `at` if a name represents many files.
    ///
    /// # Errors
    /// Why there is no such picture, in OSL's words.
    fn info(&self, file: &str, at: Option<[f32; 2]>, name: &str, ty: Type) -> Result<Option<Data>, String>;
}
