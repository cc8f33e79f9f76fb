// SPDX-License-Identifier: GPL-3.0-or-later
//! Writing scenes: OBJ with MTL, PLY, STL.
//! Source: the formats' own specifications, see `io::{obj, ply, stl}`.
//! Every file appears whole or not at all; files that the main one refers to are written before it.
//! A feature that a format lacks is dropped with a warning. OBJ and PLY hold neither instances (they are
//! unfolded) nor cameras nor lights; PLY holds no materials, glTF no environment; animations are not written.
//! Tests: `tests/save.rs`.

pub(super) mod files;
pub(super) mod losses;
pub(super) mod obj;
pub(super) mod ply;
pub(super) mod png;
pub(super) mod round;
pub(super) mod stl;
mod world;
