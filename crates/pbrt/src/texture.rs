// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures as a tree of their inputs. `texture_parameters` reads them, `osl` writes them as shaders.
//! Spaces: transforms go from the renderer's world to the texture's space.

use std::path::PathBuf;
use std::sync::Arc;

use gnurt_scene::Affine;
use gnurt_scene::texture::Wrap;

use crate::location::Location;

/// Textures may be made of textures this deep.
pub(crate) const DEEPEST: u32 = 32;

/// A value of a material or a texture: one for all places, or a texture.
#[derive(Clone, Debug)]
pub(crate) enum Input {
    /// A colour, or a number three times.
    Constant([f32; 3]),
    /// A texture.
    Texture(Arc<Texture>),
}

impl Input {
    /// A number for all places.
    pub(crate) fn number(x: f32) -> Self {
        Self::Constant([x; 3])
    }

    /// How deep its textures are nested.
    pub(crate) fn depth(&self) -> u32 {
        match self {
            Self::Constant(_) => 0,
            Self::Texture(texture) => texture.depth,
        }
    }

    /// The colour, if it is one for all places.
    pub(crate) fn constant(&self) -> Option<[f32; 3]> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Texture(texture) => match texture.node {
                Node::Constant(value) => Some(value),
                _ => None,
            },
        }
    }
}

/// A texture.
#[derive(Debug)]
pub(crate) struct Texture {
    pub(crate) node: Node,
    /// 1, or one more than the depth of its deepest input.
    pub(crate) depth: u32,
    pub(crate) location: Location,
}

/// The kind of a texture, and its inputs.
#[derive(Debug)]
pub(crate) enum Node {
    Constant([f32; 3]),
    Image(Image),
    /// A texture times a number.
    Scale(Input, Input),
    /// From the first to the second by the third.
    Mix([Input; 2], Input),
    /// The same by the normal's cosine to a direction of the world.
    DirectionMix([Input; 2], [f32; 3]),
    /// Four corners: (0, 0), (0, 1), (1, 0), (1, 1).
    Bilerp(Mapping, [[f32; 3]; 4]),
    Checkerboard(Mapping, [Input; 2]),
    /// Boxes in space.
    Boxes(Affine, [Input; 2]),
    /// Inside and outside.
    Dots(Mapping, [Input; 2]),
    Fbm(Affine, Noise),
    Wrinkled(Affine, Noise),
    Windy(Affine),
    Marble {
        texture_from_world: Affine,
        noise: Noise,
        scale: f32,
        variation: f32,
    },
}

/// Octaves of noise, and how much smaller each is than the one before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    pub(crate) octaves: i32,
    pub(crate) roughness: f32,
}

/// A picture.
#[derive(Debug)]
pub(crate) struct Image {
    pub(crate) path: PathBuf,
    pub(crate) mapping: Mapping,
    /// `None` = black beyond its borders.
    pub(crate) wrap: Option<Wrap>,
    /// Whether the nearest texel is shown.
    pub(crate) nearest: bool,
    pub(crate) scale: f32,
    pub(crate) invert: bool,
    pub(crate) encoding: Encoding,
    /// Whether its texels are numbers: opacity where it has some, the mean of the colours otherwise.
    pub(crate) is_float: bool,
}

/// The meaning of bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Encoding {
    Srgb,
    Linear,
    Gamma(f32),
}

/// From a place on a surface to texture coordinates.
#[derive(Clone, Debug)]
pub(crate) enum Mapping {
    Uv { scale: [f32; 2], offset: [f32; 2] },
    Spherical(Affine),
    Cylindrical(Affine),
    Planar { texture_from_world: Affine, axes: [[f32; 3]; 2], offset: [f32; 2] },
}
