// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts of the context: types without references to the context, nor cyclic ones among each other.
//! Tests: in each file.

pub(crate) mod block;
pub(crate) mod camera;
pub(crate) mod class;
pub(crate) mod current;
pub(crate) mod enums;
pub(crate) mod error;
pub(crate) mod flight;
pub(crate) mod framebuffer;
pub(crate) mod geometry;
pub(crate) mod ids;
pub(crate) mod instance;
pub(crate) mod listener;
pub(crate) mod matrix;
pub(crate) mod object;
pub(crate) mod parameter;
pub(crate) mod primitives;
pub(crate) mod progress;
pub(crate) mod rendering_object;
pub(crate) mod report;
pub(crate) mod sampling;
pub(crate) mod script;
pub(crate) mod shader;
pub(crate) mod shader_class;
pub(crate) mod stacks;
pub(crate) mod texture;
pub(crate) mod usage;
pub(crate) mod value;
