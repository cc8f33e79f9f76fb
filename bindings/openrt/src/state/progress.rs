// SPDX-License-Identifier: GPL-3.0-or-later
//! The contents of a progressive frame, so that the next one can detect whether it continues it
//! (rtProgressive).
//! Invariant: samples of two frames are only added if all inputs of the picture are equal.
//! Tests: tests/c/frames.c.

use gnurt::scene::edit::Cursor;

use super::camera::View;
use super::sampling::Limits;
use super::stacks::Entry;
use super::usage::Usage;
use super::value::ParameterValue;

/// Everything that a picture depends on.
#[derive(Clone, PartialEq)]
pub(crate) struct Recorded {
    pub(crate) scene: Cursor,
    pub(crate) shaders: Vec<(u32, Vec<ParameterValue>, Option<u64>)>,
    pub(crate) textures: u64,
    pub(crate) usage: Usage,
    pub(crate) view: View,
    pub(crate) projection: Entry,
    pub(crate) limits: Limits,
    pub(crate) size: [u32; 2],
}
