// SPDX-License-Identifier: GPL-3.0-or-later
//! Writing scenes as layers: one text, which the library makes binary.
//! Objects that occur once are written where they are; others are prototypes of native instances. Textures lie beside the layer as NAME-K.png, those of
//! environments with values beyond 1 as NAME-K.exr. Space: metres, y up. Tests: `tests/save.rs`.

mod binary;
mod lights;
mod materials;
mod prims;
mod strands;
mod text;
mod transforms;
mod writer;

pub(crate) use writer::WRITER;
