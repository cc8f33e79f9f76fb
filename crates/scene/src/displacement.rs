// SPDX-License-Identifier: GPL-3.0-or-later
//! Displacement of surfaces: vertices that are moved when a scene is committed.
//! It belongs to a material, as in MaterialX, USD and OSL, and moves the triangles of all meshes that have the material. The scene
//! keeps the meshes as they are; a world has the moved ones, so that trees, normals, lights and boxes follow.
//! Space: object. Lengths are in the object's unit. Tests: crates/render/tests/displacement.rs.

use serde::{Deserialize, Serialize};

use crate::texture::TextureRef;

/// How far and where to a material's surfaces are moved.
///
/// Vertices of an object at the same position move together, by the mean of their offsets: at seams of texture coordinates, at
/// hard edges and between meshes of different materials no cracks open. The direction is the mean of their normals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Displacement {
    /// The offsets before `midlevel` and `scale`.
    pub offset: Offset,
    /// Multiplied to the offset. Ignored for shaders.
    pub scale: f32,
    /// The value that moves nothing, subtracted before scaling. Ignored for shaders.
    pub midlevel: f32,
    /// How meshes are cut to smaller triangles before they are moved.
    pub refinement: Refinement,
}

/// Offsets over a surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Offset {
    /// The same everywhere, along the normals.
    Constant(f32),
    /// Lengths along the normals: a channel of a texture, 0 to 3. Bytes are linear.
    Height {
        /// The texture.
        texture: TextureRef,
        /// Red, green, blue or alpha.
        channel: u8,
    },
    /// Vectors: red, green and blue of a texture. Bytes are linear.
    Vector {
        /// The texture.
        texture: TextureRef,
        /// The directions that the three numbers count along.
        space: VectorSpace,
    },
    /// A shader of the renderer's shader table, by its number there.
    Shader(u32),
}

/// Directions of vectors in a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum VectorSpace {
    /// The axes of the object.
    #[default]
    Object,
    /// To where the texture's u grows, to where v grows, and along the normal; all of unit length and square to the normal.
    Tangent,
}

/// How meshes are cut to smaller triangles before they are moved. All meshes of an object are cut alike, by the finest of its
/// materials. New vertices are in the middle of edges, so that no cracks open; normals are interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Refinement {
    /// They stay as they are.
    #[default]
    None,
    /// Each triangle is cut into four, this many times.
    Levels(u8),
    /// Edges that are longer than this are cut, until none is; 0, negative or NaN = none is cut.
    Edges(f32),
}

impl Displacement {
    /// Offsets as they are: scale 1, midlevel 0, no refinement.
    #[must_use]
    pub fn new(offset: Offset) -> Self {
        Self { offset, scale: 1.0, midlevel: 0.0, refinement: Refinement::None }
    }

    /// The texture that it reads.
    #[must_use]
    pub fn texture(&self) -> Option<TextureRef> {
        match self.offset {
            Offset::Height { texture, .. } | Offset::Vector { texture, .. } => Some(texture),
            Offset::Constant(_) | Offset::Shader(_) => None,
        }
    }
}
