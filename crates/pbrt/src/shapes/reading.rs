// SPDX-License-Identifier: GPL-3.0-or-later
//! Data for reading shapes.

use gnurt_scene::io::Warnings;
use gnurt_scene::io::reader::Access;

/// Data for reading shapes.
pub(crate) struct Reading<'a> {
    pub(crate) access: &'a Access,
    pub(crate) warnings: &'a mut Warnings,
    /// Whether triangles turn the other way.
    pub(crate) reversed: bool,
    /// Whether texture coordinates that pbrt makes up are wanted.
    pub(crate) wants_texcoords: bool,
    /// Whether a whole sphere may be one, without triangles.
    pub(crate) takes_spheres: bool,
}
