// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures: a picture and how it is read.
//! Conventions of glTF 2.0 section 5.26 and of references/README (decode first, then interpolate).
//! Texel (0, 0) is the upper left one; texture coordinates have v upwards, so row 0 lies at v = 1.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use gnurt_image::{TexelData, Texels};

use crate::id::TextureId;

/// A two-dimensional texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// A label: usually its file's name.
    pub name: String,
    /// Its texels, shared with other textures.
    pub texels: Arc<Texels>,
    /// Wrapping outside of `[0, 1]` along u and v.
    pub wrap: [Wrap; 2],
    /// How a point between texel centres is read.
    pub filter: Filter,
}

/// Behaviour of a texture outside `[0, 1]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Wrap {
    /// The picture repeats.
    #[default]
    Repeat,
    /// The picture repeats mirrored.
    MirroredRepeat,
    /// The edge's texels go on.
    ClampToEdge,
}

/// How a point between texel centres is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Bilinear, after decoding.
    #[default]
    Linear,
}

/// A texture and the transform from the mesh's texture coordinates to its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextureRef {
    /// The texture.
    pub texture: TextureId,
    /// `uv' = (a u + c v + e, b u + d v + f)` as `[a, b, c, d, e, f]`, v upwards on both sides.
    pub uv_from_mesh: [f32; 6],
    /// Which of the mesh's coordinates it reads.
    pub set: TexcoordSet,
}

/// One of a mesh's two sets of texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TexcoordSet {
    /// [`Mesh::texcoords`](crate::Mesh::texcoords).
    #[default]
    First,
    /// The attribute [`TEXCOORD_1`](crate::mesh::TEXCOORD_1). Bump maps, textures of heights and the opacity
    /// of lamps read the first set.
    Second,
}

impl TextureRef {
    /// The texture under the mesh's own coordinates.
    #[must_use]
    pub fn new(texture: TextureId) -> Self {
        Self { texture, uv_from_mesh: [1.0, 0.0, 0.0, 1.0, 0.0, 0.0], set: TexcoordSet::First }
    }
}
