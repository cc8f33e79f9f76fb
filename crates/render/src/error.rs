// SPDX-License-Identifier: GPL-3.0-or-later
//! Errors, and their causes. Bad geometry is no error: commit drops it and counts it.

use gnurt_scene::nesting::NestingError;

use crate::expressions::ExpressionError;
use crate::piece::Piece;

/// A description that cannot become a world. All are mistakes of the caller.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CommitError {
    /// An id names nothing in the scene.
    #[error("{what} {index} uses {used} {id}, which the scene does not have")]
    DanglingId {
        /// Kind of the element with the id.
        what: &'static str,
        /// Its own position.
        index: usize,
        /// Kind of the missing element.
        used: &'static str,
        /// The id that names nothing.
        id: u32,
    },
    /// A material names a shader that the shader table does not have.
    #[error("material {material} uses shader {shader}, but the shader table has {known}")]
    UnknownShader {
        /// The material.
        material: usize,
        /// The number it gives.
        shader: u32,
        /// How many there are.
        known: usize,
    },
    /// A displacement names a shader that the shader table does not have.
    #[error("material {material} is displaced by shader {shader}, but the shader table has {known}")]
    UnknownDisplacement {
        /// The material.
        material: usize,
        /// The number it gives.
        shader: u32,
        /// How many there are.
        known: usize,
    },
    /// A medium whose numbers make no sense.
    #[error("medium {medium}: {problem}")]
    BadMedium {
        /// The medium.
        medium: usize,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Objects whose nesting is invalid.
    #[error(transparent)]
    Nesting(#[from] NestingError),
    /// More triangles or instances than 32-bit ids can count.
    #[error("the scene is too large: {0}")]
    TooLarge(String),
}

/// A checkpoint that a rendering cannot go on from.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointError {
    /// The bytes are something else.
    #[error("it is not a checkpoint of a rendering")]
    NoCheckpoint,
    /// Another version of this program wrote it.
    #[error("another version of the program wrote it")]
    OtherVersion,
    /// It was cut off or changed.
    #[error("it is damaged")]
    Damaged,
    /// Scene, camera or options differ from those of the checkpoint.
    #[error("it is of another picture: scene, camera or options differ")]
    OtherPicture,
    /// The picture already has more samples than it shall get.
    #[error("it holds {has} samples per pixel already, {requested} are requested")]
    MoreSamples {
        /// How many it holds.
        has: u32,
        /// The requested number.
        requested: u32,
    },
}

/// A picture that cannot be made. All are mistakes of the caller.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// A size or the number of samples is 0.
    #[error("a picture of {width}x{height} pixels with {spp} samples each is empty")]
    NothingToDo {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Samples per pixel.
        spp: u32,
    },
    /// More pixels than a picture may have.
    #[error("a picture of {width}x{height} pixels is too large: at most 2^31 pixels")]
    TooLarge {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The crop has no pixel in common with the picture.
    #[error("the crop {},{},{},{} holds no pixel of the picture", crop[0], crop[1], crop[2], crop[3])]
    EmptyCrop {
        /// As it was given.
        crop: [u32; 4],
    },
    /// A piece that the picture is not cut into.
    #[error("piece {piece} is out of range: pieces count from 1 to their number")]
    NoSuchPiece {
        /// As it was given.
        piece: Piece,
    },
    /// Pixels that read their neighbours, which other pieces have.
    #[error(
        "interleaved pixels read their neighbours, which are in other pieces; render without one of the two"
    )]
    InterleavedPiece,
    /// Rows that cannot be rendered alone.
    #[error(
        "rows {} to {} of {height} cannot be rendered alone: both are multiples of {unit}, or the last is the height; \
         neither pieces nor interleaved pixels have rows",
        rows[0], rows[1], unit = crate::piece::BAND_UNIT
    )]
    NoSuchRows {
        /// The first, and the one behind the last.
        rows: [u32; 2],
        /// Rows of the frame.
        height: u32,
    },
    /// Layers of light of an integrator that cannot divide its light.
    #[error(
        "some of these layers of light, light groups and light path expressions are unsupported with the integrator {integrator}: \
         choose path; ir, bir and mir have emission, environment, direct, indirect, colours and shaders' outputs"
    )]
    LayersOfLight {
        /// Its name.
        integrator: &'static str,
    },
    /// Layers of light of interleaved pixels.
    #[error("interleaved pixels have no layers of light: choose one of the two")]
    InterleavedLayers,
    /// A light path expression that cannot be used.
    #[error(transparent)]
    Expression(ExpressionError),
    /// A pixel that the picture does not have.
    #[error("pixel {x},{y} is outside of the picture of {width}x{height} pixels")]
    NoSuchPixel {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
}
